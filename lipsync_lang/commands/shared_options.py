"""Options shared by several commands: speaker, text and delivery."""

import argparse
from argparse import Namespace, _ActionsContainer
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.animations.rates import parse_rate
from lipsync_lang.errors import LipsyncError
from lipsync_lang.files import argument_path

if TYPE_CHECKING:
    from lipsync_lang.lines.markup import Cleaning

Options = argparse._ActionsContainer  # noqa: SLF001 a command, or a group of its options


def add_words(made: argparse.ArgumentParser) -> None:
    """Add the verbosity options."""
    words = made.add_mutually_exclusive_group()
    words.add_argument("-q", "--quiet", action="store_true", help="print errors only")
    words.add_argument(
        "-v", "--verbose", action="store_true", help="print each step and its reason"
    )


def add_path(made: Options) -> None:
    """Add the pack search path; the project supplies the default."""
    made.set_defaults(in_project=True)
    made.add_argument(
        "--path", metavar="FOLDER", type=Path, action="append", default=[],
        help="search this folder for packs first; may be repeated",
    )  # fmt: skip


def add_json(made: Options) -> None:
    """Add the option for JSON output."""
    made.add_argument("--json", action="store_true", help="print JSON")


def add_json_form(made: Options) -> None:
    """Add the option for JSON output to commands with several `--format` values."""
    made.add_argument(
        "--json", action="store_const", const="json", dest="format",
        help="the same as --format json",
    )  # fmt: skip


def add_output(made: Options) -> None:
    """Add the option for the files to write instead of printing."""
    made.add_argument(
        "-o", "--output", metavar="FILE", type=argument_path, action="append", default=[],
        help="write to a file; - is standard output; may be repeated [print it]",
    )  # fmt: skip


def add_language(made: Options) -> None:
    """Add the option for the language; the project supplies the default."""
    made.add_argument(
        "-l", "--language", metavar="LANGUAGE", help="name or tag of a language [the project's]"
    )


def add_pair(made: Options, *, models: bool = False) -> None:
    """Add the language and character options; `models` if a model may stand for a character."""
    face = (
        "a character, a pose set or a model (.glb, .vrm, .gltf)"
        if models
        else "a character or a pose set"
    )
    add_language(made)
    made.add_argument("-c", "--character", metavar="CHARACTER", help=f"{face} [the project's]")
    add_path(made)


def add_line(made: argparse.ArgumentParser) -> None:
    """Add the options of a line: character, text and delivery."""
    made.add_argument("text", metavar="TEXT", nargs="?", help="the text to say")
    add_pair(made.add_argument_group("speaker"), models=True)
    said = made.add_argument_group("line")
    said.add_argument(
        "--audio", metavar="FILE", type=Path,
        help="a recording of the TEXT or of the --schedule; alone, its speech is recognised",
    )  # fmt: skip
    said.add_argument(
        "--audio-channel", metavar="N", type=int,
        help="channel of the recording, counted from 1 [all, mixed]",
    )  # fmt: skip
    said.add_argument(
        "--aligner", metavar="NAME[:MODEL]",
        help="aligner and its model [the language's]",
    )  # fmt: skip
    said.add_argument(
        "--recogniser", metavar="NAME[:MODEL]",
        help="recogniser and its model [the language's]",
    )  # fmt: skip
    said.add_argument(
        "--schedule", metavar="FILE", type=argument_path,
        help="timed phonemes instead of text; - is standard input",
    )  # fmt: skip
    said.add_argument(
        "--read-as", metavar="FORMAT", help="the schedule's format [by its suffix and content]"
    )
    said.add_argument(
        "--tier", metavar="NAME", help="the schedule's tier, speaker or channel, if it has several"
    )
    said.add_argument(
        "--rate", metavar="N", type=float,
        help="units per second of the schedule's times: 1000 for milliseconds, 16000 for samples",
    )  # fmt: skip
    said.add_argument("--encoding", metavar="NAME", help="the schedule's encoding [UTF-8]")
    said.add_argument("--notation", metavar="NAME", help="the notation of the schedule's labels")
    said.add_argument(
        "--line", metavar="NAME", help="the line whose edits in the character's file are applied"
    )
    said.add_argument(
        "--tts", metavar="ENGINE", help="speech engine; none estimates times [the language's]"
    )
    add_values(said)
    how = made.add_argument_group("performance")
    add_manner(how)
    how.add_argument(
        "--intensity", metavar="X", type=float, default=None,
        help="effect of loudness on the mouth: 0 for none, 1 as the pose set states, at most 2 [1 "
        "if there is sound]",
    )  # fmt: skip
    how.add_argument(
        "--gestures", metavar="NAME[:FACTOR],...",
        help="make these gestures of the pose set: all, none, or such as blink,accent:0.5 [the "
        "project's, or all in pages and videos alone]",
    )  # fmt: skip
    how.add_argument(
        "--idle", metavar="SECONDS", type=float,
        help="rest so long after the line, with gestures of silence [the project's, or 0]",
    )  # fmt: skip


def add_manner(how: Options) -> None:
    """Add the options of delivery that need no whole line."""
    how.add_argument(
        "--style", metavar="NAME:SHARE", action="append", default=[], dest="styles",
        help="blend in a style: --style angry:0.5; varying over seconds: --style angry:0@1,1@2.5",
    )  # fmt: skip
    how.add_argument(
        "--dial", metavar="REGION:LEVEL", action="append", default=[], dest="dials",
        help="scale the poses of a region, 0 to 2: --dial jaw:0.5 mumbles; may vary as in --style",
    )  # fmt: skip
    add_motion(how)
    how.add_argument(
        "--shades", action=argparse.BooleanOptionalAction, default=None,
        help="perform shades (finer sounds), or each as its parent phoneme [the project's, or "
        "yes; no "
        "with motion=paper]",
    )  # fmt: skip
    how.add_argument(
        "--gaps", choices=("error", "rest"), default="error",
        help="treatment of bigrams without data [error]",
    )  # fmt: skip
    how.add_argument(
        "--unknown", choices=("error", "rest", "nearest"), default="nearest",
        help="treatment of unmapped labels; nearest uses the features of IPA [nearest]",
    )  # fmt: skip


def add_motion(how: Options) -> None:
    """Add the frame rate and the settings of motion."""
    how.add_argument(
        "--fps", metavar="N", type=parse_rate, default=None,
        help="frames per second, such as 24, 23.976 or 24000/1001 [the project's, or 60]",
    )  # fmt: skip
    how.add_argument(
        "--set", metavar="motion.NAME=VALUE", action="append", default=[], dest="settings",
        help="change a motion setting, or use a preset: --set motion=paper",
    )  # fmt: skip


def add_values(made: _ActionsContainer) -> None:
    """Add the values of placeholders; the project supplies the default."""
    made.set_defaults(unspoken=())
    made.add_argument(
        "--value", metavar="NAME=TEXT", action="append", default=[], dest="values",
        help="speak this text for the placeholder [NAME], {NAME} or $NAME; may be repeated",
    )  # fmt: skip


def cleaning(options: Namespace) -> "Cleaning":
    """Return the values of placeholders, and the project's passages that are not spoken."""
    from lipsync_lang.lines.markup import Cleaning

    values: dict[str, str] = {}
    for one in options.values:
        name, equals, value = one.partition("=")
        if not (name.strip() and equals):
            raise LipsyncError(f"--value {one}: write NAME=TEXT (--value player=Ada)")
        values[name.strip()] = value
    return Cleaning(values, options.unspoken)
