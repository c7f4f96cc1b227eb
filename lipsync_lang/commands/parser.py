"""Argument parser: every command with its arguments and an example."""

import argparse
from collections.abc import Callable
from pathlib import Path

from lipsync_lang.commands import (
    banks,
    build,
    coverage,
    listing,
    live,
    packs,
    performing,
    stills,
    studio,
    validate_packs,
)
from lipsync_lang.commands import quality as check
from lipsync_lang.commands.build_options import add_build
from lipsync_lang.commands.completion import SHELLS, completion, leaves
from lipsync_lang.commands.shared_options import (
    Options,
    add_json,
    add_json_form,
    add_line,
    add_manner,
    add_motion,
    add_pair,
    add_path,
    add_words,
)
from lipsync_lang.coverage.forms import FORMS
from lipsync_lang.files import argument_path
from lipsync_lang.pipeline import kernel
from lipsync_lang.version import __version__

Command = Callable[[argparse.Namespace], int]
"""A command handler: options in, exit code out."""

Add = Callable[[str, Command, str, str], argparse.ArgumentParser]
"""Register a command by name, handler, title and example arguments."""


def parser() -> argparse.ArgumentParser:
    """Build the parser; `docs/reference/commands.md` is generated from it."""
    top = argparse.ArgumentParser(
        prog="lipsync-lang",
        description="Lip sync for any language and any character, from data you can edit.",
        epilog="Try: lipsync-lang run 'Hello, world' -l english -c facefx -o hello.csv",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.color = False  # type: ignore[attr-defined] # Python 3.14 would colour what is spelled out
    version = f"lipsync-lang {__version__} ({kernel.summary()})"
    top.add_argument("--version", action="version", version=version)
    known = top.add_subparsers(title="commands", metavar="COMMAND", required=True)

    def add(name: str, command: Command, title: str, example: str) -> argparse.ArgumentParser:
        made = known.add_parser(
            name,
            help=title,
            description=f"{title[0].upper()}{title[1:]}.",
            epilog=f"example:\n  lipsync-lang {example}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        made.set_defaults(command=command)
        return made

    _add_run(add)
    _add_transcribe(add)
    _add_explain(add)
    _add_stills(add)
    _add_live(add)
    _add_studio(add)
    _add_checking(add)
    _add_coverage(add)
    _add_check(add)
    add_build(add, build.build)
    _add_packs(add)
    _add_bank(add)
    voices_ = add("voices", listing.voices, "list the voices that speak text", "voices")
    voices_.add_argument(
        "engine", metavar="ENGINE", nargs="?", default="espeak", help="a speech engine [espeak]"
    )
    add_json(voices_)
    formats_ = add("formats", listing.formats, "list what can be read and written", "formats")
    add_json(formats_)
    completion_ = add(
        "completion",
        completion,
        "print a script by which a shell completes commands, options and names",
        "completion bash > ~/.local/share/bash-completion/completions/lipsync-lang",
    )
    completion_.add_argument("shell", choices=SHELLS, help="the shell")
    for _, made in leaves(top):
        add_words(made)
    return top


def _add_run(add: Add) -> None:
    run_ = add(
        "run",
        performing.run,
        "animate text or timed phonemes",
        "run 'Hello, world' -l english -c facefx -o hello.csv -o hello.wav --plot hello.png",
    )
    add_line(run_)
    _add_written(run_.add_argument_group("what is written"))


def _add_live(add: Add) -> None:
    live_ = add(
        "live",
        live.live,
        "speak typed sentences, and send their frames to an engine in real time",
        "live 'Hello, world' -l english -c facefx --to vmc:127.0.0.1:39539",
    )
    live_.add_argument("text", metavar="TEXT", nargs="?", help="what to say [lines as they come]")
    add_pair(live_)
    live_.add_argument(
        "--to", metavar="RECEIVER", action="append", default=[],
        help="livelink:HOST:PORT (Unreal), vmc:HOST:PORT (VSeeFace, Unity), ws:HOST:PORT (serve "
        "WebSockets), or - for lines of JSON; may be repeated [-]",
    )  # fmt: skip
    live_.add_argument("--tts", metavar="ENGINE", help="another speech engine; none is silent")
    live_.add_argument(
        "--subject", metavar="NAME", default="lipsync", help="the Live Link subject [lipsync]"
    )
    live_.add_argument(
        "--rename", metavar="POSE=NAME", action="append", default=[],
        help="send a pose to vmc under another name; may be repeated",
    )  # fmt: skip
    add_manner(live_)


def _add_studio(add: Add) -> None:
    studio_ = add(
        "studio",
        studio.studio,
        "open the studio in a browser: hear a line, see it, ask why, and change it",
        "studio -l english -c facefx",
    )
    add_pair(studio_)
    studio_.set_defaults(choosing=True)
    studio_.add_argument("--tts", metavar="ENGINE", help="another speech engine; none is silent")
    add_motion(studio_)
    studio_.add_argument(
        "--port", metavar="N", type=int, default=0, help="the port of the address [a free one]"
    )
    studio_.add_argument(
        "--host", metavar="ADDRESS", default=studio.LOCAL,
        help="let other machines in by this address; needs --token [this machine alone]",
    )  # fmt: skip
    studio_.add_argument("--token", metavar="SECRET", help="the secret in the address [random]")
    studio_.add_argument(
        "--browser", action=argparse.BooleanOptionalAction, default=True,
        help="open the address in a browser [yes]",
    )  # fmt: skip


def _add_written(written: Options) -> None:
    """Add the options of `run` for its outputs."""
    written.add_argument(
        "-o", "--output", metavar="FILE", action="append", default=[],
        help="write the animation; the suffix names the format, or FORMAT:FILE does; csv:- is "
        "standard output; may be repeated",
    )  # fmt: skip
    written.add_argument(
        "--plot",
        metavar="FILE",
        type=argument_path,
        help="draw every stage to a picture; - is standard output, as PNG",
    )
    written.add_argument(
        "--model", metavar="GLB", type=Path,
        help="the model for -o line.glb, instead of the character's own",
    )  # fmt: skip
    written.add_argument(
        "--poses", action="store_true", help="write poses although the character has a rig"
    )
    written.add_argument(
        "--beside", metavar="CHARACTER", action="append", default=[],
        help="draw this character below the other instead of the stages; may be repeated",
    )  # fmt: skip
    written.add_argument(
        "--against", metavar="OTHER", action="append", default=[],
        help="compare with it on the page -o line.html: the file of an animation, a plain method "
        "(keyframes, dominance, held), or another character; may be repeated",
    )  # fmt: skip
    written.add_argument("--cut", action="store_true", help="leave out lead-in and tail")
    written.add_argument(
        "--offset", metavar="TIME", default="0",
        help="where the sound begins in the files: seconds, or a timecode 01:00:00:00 [0]",
    )  # fmt: skip
    written.add_argument(
        "--keys", metavar="[lines:]ERROR",
        help="store few keys with tangents; curves between them stray by this much at most, such "
        "as 0.01. Formats without tangents, and every format with lines:0.01, have straight lines; "
        "lines:0 keeps every frame off them [lines:0.005 in formats that are edited by hand, else "
        "every frame]",
    )  # fmt: skip
    written.add_argument(
        "--check", action="store_true", help="judge the animation's poses as well, as `check` does"
    )


def _add_transcribe(add: Add) -> None:
    transcribe_ = add(
        "transcribe",
        performing.transcribe,
        "show the phonemes and common phonemes that text becomes",
        "transcribe 'Hello, world' -l english",
    )
    transcribe_.add_argument("text", metavar="TEXT", nargs="?", help="what to read")
    transcribe_.add_argument(
        "--file",
        metavar="FILE",
        type=argument_path,
        help="read its lines, instead of a TEXT; - is standard input",
    )
    transcribe_.add_argument(
        "-l", "--language", metavar="LANGUAGE", help="name or tag of a language [the project's]"
    )
    add_path(transcribe_)
    add_json(transcribe_)


def _add_explain(add: Add) -> None:
    explain_ = add(
        "explain",
        performing.explain,
        "say why each pose stands where it stands at a time",
        "explain 'Hello, world' -l english -c facefx --at 0.42",
    )
    add_line(explain_)
    explain_.add_argument(
        "--at", metavar="SECONDS", type=float, required=True, help="the time asked about"
    )
    add_json(explain_)


def _add_stills(add: Add) -> None:
    stills_ = add(
        "stills",
        stills.stills,
        "draw the model at given times, from one place for all its lines",
        "stills 'Hello, world' -l english -c facefx --at 0.12,0.42 --close -o hello.png",
    )
    add_line(stills_)
    stills_.add_argument(
        "--at", metavar="SECONDS", required=True, help="times of the schedule, with commas"
    )
    stills_.add_argument("--close", action="store_true", help="draw the mouth alone")
    stills_.add_argument(
        "--model", metavar="GLB", type=Path, help="this model, instead of the character's own"
    )
    stills_.add_argument(
        "-o", "--output", metavar="FILE", type=argument_path, required=True,
        help="write the sheet, as PNG; - is standard output",
    )  # fmt: skip


def _add_checking(add: Add) -> None:
    resolve_ = add(
        "resolve",
        validate_packs.resolve,
        "show what of a language-character pair comes from which layer, and its gaps",
        "resolve -l english -c facefx",
    )
    add_pair(resolve_)
    add_json(resolve_)

    validate_ = add(
        "validate",
        validate_packs.validate,
        "list every fault of every pack found, or of the files given",
        "validate languages/finnish.yaml",
    )
    validate_.add_argument("paths", metavar="PATH", type=Path, nargs="*", help="a file or a folder")
    validate_.add_argument(
        "--no-tests",
        action="store_true",
        help="leave out the languages' own tests (those of built-in ones run when they are named)",
    )
    add_path(validate_)
    validate_.set_defaults(in_project=False)  # the project itself is validated
    add_json(validate_)

    schema_ = add(
        "schema",
        validate_packs.schema,
        "print the JSON Schema of a kind of pack",
        "schema language > language.json",
    )
    schema_.add_argument("kind", metavar="KIND", nargs="?", help="without it, the kinds are listed")
    add_json(schema_)


def _add_coverage(add: Add) -> None:
    coverage_ = add(
        "coverage",
        coverage.coverage,
        "show which bigrams a script needs, and what to author next",
        "coverage script.txt -l english -c facefx",
    )
    _add_corpus(coverage_)
    coverage_.add_argument(
        "--format",
        metavar="NAME",
        help=f"what to write: {', '.join(FORMS.modules)} [by the suffix of -o, else text]",
    )
    coverage_.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=argument_path,
        help="write to a file; - is standard output [print it]",
    )
    add_json_form(coverage_)
    coverage_.add_argument(
        "--column", metavar="NAME", action="append", default=[],
        help="the text's column in tables, by name or number; LANGUAGE=NAME for one language's, "
        "which may have several",
    )  # fmt: skip
    coverage_.add_argument("--encoding", metavar="NAME", help="the encoding of all files [UTF-8]")
    coverage_.add_argument(
        "--minutes", metavar="N", type=float, default=5.0, help="minutes to author a bigram [5]"
    )
    coverage_.add_argument(
        "--fail-under", metavar="PERCENT", type=float,
        help="exit with 1 where less of what is spoken is authored",
    )  # fmt: skip
    coverage_.add_argument(
        "--against", metavar="OLD.json", type=Path, help="tell what changed since an older JSON"
    )
    coverage_.add_argument("--all", action="store_true", help="list every bigram and line")
    add_path(coverage_)


def _add_corpus(made: argparse.ArgumentParser) -> None:
    """Add the texts, and the languages and characters that speak them."""
    made.add_argument(
        "corpus",
        metavar="CORPUS",
        type=argument_path,
        nargs="+",
        help="a file of lines, a folder, or - for standard input",
    )
    for short, name, what in (
        ("-l", "language", "name or tag of a language"),
        ("-c", "character", "a character or a pose set"),
    ):
        made.add_argument(
            short, f"--{name}", metavar=name.upper(), action="append", default=[],
            help=f"{what} [the project's]; may be repeated",
        )  # fmt: skip


def _add_check(add: Add) -> None:
    check_ = add(
        "check",
        check.check,
        "measure how good an animation is, and hold it against limits",
        "check 'Hello, world' -l english -c facefx --baseline",
    )
    add_line(check_)
    check_.add_argument(
        "--animation", metavar="FILE", type=Path,
        help="judge what this file holds, of any program, instead of performing the line",
    )  # fmt: skip
    check_.add_argument(
        "--channels", action="store_true", help="judge the channels of the character's rig"
    )
    check_.add_argument(
        "--baseline", action="store_true", help="measure plain methods on the same line beside it"
    )
    check_.add_argument(
        "--limit", metavar="NAME=NUMBER", action="append", default=[], dest="limits",
        help="the most of a measure that is sound: --limit jitter=2; may be repeated",
    )  # fmt: skip
    check_.add_argument(
        "--format", choices=("text", "json", "junit", "html"),
        help="how it is told; html is a page to hear and see the line, and the findings on it "
        "[by the suffix of -o, else text]",
    )  # fmt: skip
    add_json_form(check_)
    check_.add_argument(
        "-o",
        "--output",
        metavar="FILE",
        type=argument_path,
        help="write it to a file; - is standard output [print it]",
    )


def _add_packs(add: Add) -> None:
    for kind, title in (
        ("languages", "list language packs, show one, or draft a new one"),
        ("posesets", "list pose sets, show one, or draft a new one"),
        ("characters", "list characters, show one, or draft one from a model"),
    ):
        packs_ = add(kind, packs.packs, title, f"{kind} list")
        packs_.set_defaults(kind=kind[:-1])
        packs_.add_argument("action", choices=("list", "show", "new"), nargs="?", default="list")
        packs_.add_argument("name", metavar="NAME", nargs="?", help="the pack to show or to make")
        if kind == "languages":
            _add_new_language(packs_)
        if kind == "posesets":
            _add_new_poseset(packs_)
        if kind == "characters":
            _add_new_character(packs_)
        add_path(packs_)
        add_json(packs_)


def _add_new_language(made: argparse.ArgumentParser) -> None:
    new = made.add_argument_group("what a new language is made from")
    new.add_argument("--voice", metavar="VOICE", help="an eSpeak NG voice, such as sw")
    new.add_argument("--epitran", metavar="CODE", help="a code of Epitran, such as xho-Latn")
    new.add_argument(
        "--lexicon", metavar="FILE", type=Path,
        help="words and their phonemes in IPA: word, tab, phonemes with spaces",
    )  # fmt: skip
    new.add_argument(
        "--inventory", metavar="FILE", type=Path,
        help="PHOIBLE's table, or phonemes in IPA with spaces between them",
    )  # fmt: skip
    new.add_argument(
        "--inventory-id", metavar="ID", help="PHOIBLE's number, or an ISO 639-3 code or name"
    )
    new.add_argument(
        "--text",
        metavar="FILE",
        type=argument_path,
        help="sample lines, whose sounds are looked at; - is standard input",
    )
    new.add_argument("--tag", metavar="TAG", help="the language as BCP 47 writes it")
    new.add_argument("--title", metavar="TITLE", help="the language's name for people")


def _add_new_poseset(made: argparse.ArgumentParser) -> None:
    new = made.add_argument_group("what a new pose set is made from")
    new.add_argument("poses", metavar="POSE", nargs="*", help="the names of its poses")
    new.add_argument(
        "--model", metavar="FILE", type=Path,
        help="a model (.glb), whose shapes are the poses where none are named",
    )  # fmt: skip
    new.add_argument(
        "--like", metavar="POSESET",
        help="the pose set that says how known poses move, instead of the one that knows most",
    )  # fmt: skip
    new.add_argument(
        "--guess", action="store_true",
        help="deal the sounds out to poses that no pose set knows, for a first look",
    )  # fmt: skip
    new.add_argument("--title", metavar="TITLE", help="what to call it in lists")


def _add_new_character(made: argparse.ArgumentParser) -> None:
    new = made.add_argument_group("what a new character is made from")
    new.add_argument("--model", metavar="FILE", type=Path, help="a model (.glb), whose face speaks")
    new.add_argument(
        "--poseset", metavar="POSESET", help="its pose set, instead of the one that fits best"
    )
    new.add_argument("--rig", metavar="RIG", help="a rig of it, instead of the one that fits best")
    new.add_argument("--title", metavar="TITLE", help="what to call it in lists")


def _add_bank(add: Add) -> None:
    bank_ = add(
        "bank",
        banks.draft,
        "draft bigrams, import them, or see what a bank changes",
        "bank draft -l english -c facefx",
    )
    actions = bank_.add_subparsers(title="actions", metavar="ACTION", required=True)

    def action(
        name: str, command: Command, title: str, more: str, example: str
    ) -> argparse.ArgumentParser:
        made = actions.add_parser(
            name,
            help=title,
            description=f"{title[0].upper()}{title[1:]}{more}.",
            epilog=f"example:\n  lipsync-lang {example}",
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        made.set_defaults(command=command)
        return made

    _add_draft(
        action(
            "draft",
            banks.draft,
            "draft bigrams from a pose set's targets",
            ", as YAML to look at or to edit",
            "bank draft -l english -c facefx --write l-ow h-eh",
        )
    )
    _add_import(
        action(
            "import",
            banks.import_,
            "import the phone-bigram banks of SmartBody",
            ", its Python scripts (which are read, never run) or its text exports",
            "bank import init-diphoneDefault.py -c facefx",
        )
    )
    _add_diff(
        action(
            "diff",
            banks.diff,
            "show which bigrams a character's layers change, and by how much",
            "; without --against, a pose set's banks are compared with its drafts",
            "bank diff -l english -c facefx --plot changes.png",
        )
    )


def _add_draft(made: argparse.ArgumentParser) -> None:
    made.add_argument("bigrams", metavar="BIGRAM", nargs="*", help="such as l-ow; none means all")
    add_pair(made)
    made.add_argument(
        "--write", action="store_true", help="put them into a bank; what is there already stays"
    )
    made.add_argument(
        "--to", metavar="FILE", type=Path,
        help="the bank to write to [posesets/NAME/banks/common.yaml of this folder]",
    )  # fmt: skip


def _add_import(made: argparse.ArgumentParser) -> None:
    made.add_argument("files", metavar="FILE", type=Path, nargs="+", help="a script or text export")
    made.add_argument(
        "-c", "--character", metavar="POSESET",
        help="the pose set whose poses the bank moves, or a character of it [the project's]",
    )  # fmt: skip
    made.add_argument(
        "--to", metavar="FILE", type=Path,
        help="the bank to write to; what is there already stays "
        "[posesets/NAME/banks/ of this folder, by the first file's name]",
    )  # fmt: skip
    made.add_argument(
        "--style", metavar="NAME",
        help="the manner of speaking: picks one of several sets, or renames the only one",
    )  # fmt: skip
    made.add_argument(
        "--interpolation", choices=("bspline", "linear"), default="linear",
        help="the kind of curve: straight ones pass through the keys, as the artist saw them; "
        "smooth ones stay below [linear]",
    )  # fmt: skip
    made.add_argument(
        "--map", metavar="THEIRS=OURS", action="append", default=[],
        help="our phoneme or pose for a name of theirs; may be repeated",
    )  # fmt: skip
    add_path(made)
    add_json(made)


def _add_diff(made: argparse.ArgumentParser) -> None:
    made.add_argument("bigrams", metavar="BIGRAM", nargs="*", help="such as l-ow; none means all")
    add_pair(made)
    made.add_argument(
        "--against", metavar="CHARACTER",
        help="another character of the pose set, or the bare pose set [what lies beneath]",
    )  # fmt: skip
    made.add_argument(
        "--plot",
        metavar="FILE",
        type=argument_path,
        help="draw those that differ most to a picture; - is standard output, as PNG",
    )
    made.add_argument("--all", action="store_true", help="list every bigram that differs")
    add_json(made)
