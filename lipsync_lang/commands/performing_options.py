"""Options of the commands that perform a line: run, transcribe, explain, stills and check."""

from pathlib import Path

from lipsync_lang.commands import performing, stills
from lipsync_lang.commands import quality as check
from lipsync_lang.commands.script_options import add_values
from lipsync_lang.commands.shared_options import (
    Add,
    Options,
    add_json,
    add_json_form,
    add_language,
    add_line,
    add_path,
)
from lipsync_lang.files import argument_path


def add_run(add: Add) -> None:
    """Add `run`."""
    run_ = add(
        "run",
        performing.run,
        "animate text or timed phonemes",
        'run "Hello, world" -l english -c facefx -o hello.csv -o hello.wav --plot hello.png',
    )
    add_line(run_)
    _add_written(run_.add_argument_group("output"))


def _add_written(written: Options) -> None:
    """Add the options of `run` for its outputs."""
    written.add_argument(
        "-o", "--output", metavar="FILE", action="append", default=[],
        help="write the animation in the format of the suffix, or as FORMAT:FILE; csv:- is "
        "standard "
        "output; may be repeated",
    )  # fmt: skip
    written.add_argument(
        "--plot",
        metavar="FILE",
        type=argument_path,
        help="draw every stage in a picture; - is standard output, as PNG",
    )
    written.add_argument(
        "--model", metavar="GLB", type=Path,
        help="the model for -o line.glb, instead of the character's own",
    )  # fmt: skip
    written.add_argument(
        "--poses", action="store_true", help="write poses even if the character has a rig"
    )
    written.add_argument(
        "--beside", metavar="CHARACTER", action="append", default=[],
        help="draw this character below the first one instead of the stages; may be repeated",
    )  # fmt: skip
    written.add_argument(
        "--against", metavar="OTHER", action="append", default=[],
        help="show a comparison on the page -o line.html: an animation file, a plain method "
        "(keyframes, dominance, held), or another character; may be repeated",
    )  # fmt: skip
    written.add_argument("--cut", action="store_true", help="leave out lead-in and tail")
    written.add_argument(
        "--offset", metavar="TIME", default=None,
        help="start of the sound in the files: seconds, or a timecode 01:00:00:00 [the "
        "project's, or 0]",
    )  # fmt: skip
    written.add_argument(
        "--keys", metavar="[lines:]ERROR",
        help="store few keys with tangents, with at most this error, such as 0.01; lines:ERROR "
        "stores "
        "straight lines instead, as formats without tangents do; lines:0 keeps every frame that is "
        "not on a line [lines:0.005 in formats that are edited by hand, else every frame]",
    )  # fmt: skip
    written.add_argument(
        "--check", action="store_true", help="check the animation's poses as well, as `check` does"
    )


def add_transcribe(add: Add) -> None:
    """Add `transcribe`."""
    transcribe_ = add(
        "transcribe",
        performing.transcribe,
        "show the phonemes and common phonemes of a text",
        'transcribe "Hello, world" -l english',
    )
    transcribe_.add_argument("text", metavar="TEXT", nargs="?", help="the text to read")
    transcribe_.add_argument(
        "--file",
        metavar="FILE",
        type=argument_path,
        help="read the lines of this file instead of a TEXT; - is standard input",
    )
    add_language(transcribe_)
    add_values(transcribe_)
    add_path(transcribe_)
    add_json(transcribe_)


def add_explain(add: Add) -> None:
    """Add `explain`."""
    explain_ = add(
        "explain",
        performing.explain,
        "explain the weight of each pose at a time",
        'explain "Hello, world" -l english -c facefx --at 0.42',
    )
    add_line(explain_)
    explain_.add_argument(
        "--at", metavar="SECONDS", type=float, required=True, help="the time to explain"
    )
    add_json(explain_)


def add_stills(add: Add) -> None:
    """Add `stills`."""
    stills_ = add(
        "stills",
        stills.stills,
        "draw the model at given times, always from the same camera",
        'stills "Hello, world" -l english -c facefx --at 0.12,0.42 --close -o hello.png',
    )
    add_line(stills_)
    stills_.add_argument(
        "--at", metavar="SECONDS", required=True, help="times of the schedule, separated by commas"
    )
    stills_.add_argument("--close", action="store_true", help="draw only the mouth")
    stills_.add_argument(
        "--model", metavar="GLB", type=Path, help="draw this model instead of the character's own"
    )
    stills_.add_argument(
        "-o", "--output", metavar="FILE", type=argument_path, required=True,
        help="write the sheet, as PNG; - is standard output",
    )  # fmt: skip


def add_check(add: Add) -> None:
    """Add `check`."""
    check_ = add(
        "check",
        check.check,
        "measure the quality of an animation, and compare it with limits",
        'check "Hello, world" -l english -c facefx --baseline',
    )
    add_line(check_)
    check_.add_argument(
        "--animation", metavar="FILE", type=Path,
        help="check this animation file, from any program, instead of performing the line",
    )  # fmt: skip
    check_.add_argument(
        "--channels", action="store_true", help="check the channels of the character's rig"
    )
    check_.add_argument(
        "--baseline", action="store_true", help="measure plain methods on the same line as well"
    )
    check_.add_argument(
        "--limit", metavar="NAME=NUMBER", action="append", default=[], dest="limits",
        help="largest value allowed for a measure: --limit jitter=2; may be repeated",
    )  # fmt: skip
    check_.add_argument(
        "--format", choices=("text", "json", "junit", "html"),
        help="output format; html is a page that plays the line and shows the findings [by the "
        "suffix of -o, else text]",
    )  # fmt: skip
    add_json_form(check_)
    check_.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=argument_path,
        help="write to a file; - is standard output [print it]",
    )
