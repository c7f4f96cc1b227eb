"""What can be typed: every command, its arguments and an example of each."""

import argparse
from collections.abc import Callable
from pathlib import Path

from lipsync_lang import __version__
from lipsync_lang.commands import banks, checking, listing, packs, performing

Command = Callable[[argparse.Namespace], int]
"""Options in, exit code out."""

Add = Callable[[str, Command, str, str], argparse.ArgumentParser]
"""Add a command by its name, what it does, its title, and an example of its arguments."""


def parser() -> argparse.ArgumentParser:
    """Describe every command; `docs/reference/commands.md` is printed from this."""
    top = argparse.ArgumentParser(
        prog="lipsync-lang",
        description="Lip sync for any language and any character, from data you can edit.",
        epilog="Try: lipsync-lang run 'Hello, world' -l english -c facefx -o hello.csv",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    top.add_argument("--version", action="version", version=f"lipsync-lang {__version__}")
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

    _add_performing(add)
    _add_checking(add)
    _add_packs(add)
    _add_bank(add)
    voices_ = add("voices", listing.voices, "list the voices that speak text", "voices")
    voices_.add_argument(
        "engine", metavar="ENGINE", nargs="?", default="espeak", help="a speech engine [espeak]"
    )
    _add_json(voices_)
    formats_ = add("formats", listing.formats, "list what can be read and written", "formats")
    _add_json(formats_)
    return top


def _add_performing(add: Add) -> None:
    run_ = add(
        "run",
        performing.run,
        "animate text or timed phonemes",
        "run 'Hello, world' -l english -c facefx -o hello.csv -o hello.wav --plot hello.png",
    )
    _add_line(run_)
    run_.add_argument(
        "-o", "--output", metavar="FILE", type=Path, action="append", default=[],
        help="write the animation; the suffix names the format, and -o may be repeated",
    )  # fmt: skip
    run_.add_argument("--plot", metavar="FILE", type=Path, help="draw every stage to a picture")
    run_.add_argument("--cut", action="store_true", help="leave out lead-in and tail")

    transcribe_ = add(
        "transcribe",
        performing.transcribe,
        "show the phonemes and common phonemes that text becomes",
        "transcribe 'Hello, world' -l english",
    )
    transcribe_.add_argument("text", metavar="TEXT", nargs="?", help="what to read")
    transcribe_.add_argument(
        "--file", metavar="FILE", type=Path, help="read its lines, instead of a TEXT"
    )
    transcribe_.add_argument(
        "-l", "--language", metavar="LANGUAGE", required=True, help="name or tag of a language"
    )
    _add_path(transcribe_)
    _add_json(transcribe_)

    explain_ = add(
        "explain",
        performing.explain,
        "say why each pose stands where it stands at a time",
        "explain 'Hello, world' -l english -c facefx --at 0.42",
    )
    _add_line(explain_)
    explain_.add_argument(
        "--at", metavar="SECONDS", type=float, required=True, help="the time asked about"
    )
    _add_json(explain_)


def _add_checking(add: Add) -> None:
    resolve_ = add(
        "resolve",
        checking.resolve,
        "show what of a language-character pair comes from which layer, and its gaps",
        "resolve -l english -c facefx",
    )
    _add_pair(resolve_)
    _add_json(resolve_)

    validate_ = add(
        "validate",
        checking.validate,
        "list every fault of every pack found, or of the files given",
        "validate languages/finnish.yaml",
    )
    validate_.add_argument("paths", metavar="PATH", type=Path, nargs="*", help="a file or a folder")
    validate_.add_argument(
        "--no-tests",
        action="store_true",
        help="leave out the languages' own tests (those of built-in ones run when they are named)",
    )
    _add_path(validate_)
    _add_json(validate_)

    schema_ = add(
        "schema",
        checking.schema,
        "print the JSON Schema of a kind of pack",
        "schema language > language.json",
    )
    schema_.add_argument("kind", metavar="KIND", nargs="?", help="without it, the kinds are listed")


def _add_packs(add: Add) -> None:
    for kind, title in (
        ("languages", "list language packs, show one, or draft a new one"),
        ("posesets", "list pose sets, or show one"),
        ("characters", "list characters, or show one"),
    ):
        packs_ = add(kind, packs.packs, title, f"{kind} list")
        packs_.set_defaults(kind=kind[:-1])
        actions = ("list", "show", "new") if kind == "languages" else ("list", "show")
        packs_.add_argument("action", choices=actions, nargs="?", default="list")
        packs_.add_argument("name", metavar="NAME", nargs="?", help="the pack to show or to make")
        if kind == "languages":
            _add_new_language(packs_)
        _add_path(packs_)
        _add_json(packs_)


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
        "--text", metavar="FILE", type=Path, help="sample lines, whose sounds are looked at"
    )
    new.add_argument("--tag", metavar="TAG", help="the language as BCP 47 writes it")
    new.add_argument("--title", metavar="TITLE", help="the language's name for people")


def _add_bank(add: Add) -> None:
    bank_ = add(
        "bank",
        banks.bank,
        "draft bigrams to look at or to edit",
        "bank draft -l english -c facefx",
    )
    actions = bank_.add_subparsers(title="actions", metavar="ACTION", required=True)
    draft_ = actions.add_parser(
        "draft",
        help="draft bigrams from a pose set's targets",
        description="Draft bigrams from a pose set's targets, as YAML to look at or to edit.",
        epilog="example:\n  lipsync-lang bank draft -l english -c facefx --write l-ow h-eh",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    draft_.add_argument("bigrams", metavar="BIGRAM", nargs="*", help="such as l-ow; none means all")
    _add_pair(draft_)
    draft_.add_argument(
        "--write", action="store_true", help="put them into a bank; what is there already stays"
    )
    draft_.add_argument(
        "--to", metavar="FILE", type=Path,
        help="the bank to write to [posesets/NAME/banks/common.yaml of this folder]",
    )  # fmt: skip


def _add_path(made: argparse.ArgumentParser) -> None:
    made.add_argument(
        "--path", metavar="FOLDER", type=Path, action="append", default=[],
        help="look for packs here first; may be repeated",
    )  # fmt: skip


def _add_json(made: argparse.ArgumentParser) -> None:
    made.add_argument("--json", action="store_true", help="print JSON")


def _add_pair(made: argparse.ArgumentParser) -> None:
    made.add_argument(
        "-l", "--language", metavar="LANGUAGE", required=True, help="name or tag of a language"
    )
    made.add_argument(
        "-c", "--character", metavar="CHARACTER", required=True, help="a character or a pose set"
    )
    _add_path(made)


def _add_line(made: argparse.ArgumentParser) -> None:
    made.add_argument("text", metavar="TEXT", nargs="?", help="what to say")
    _add_pair(made)
    made.add_argument(
        "--schedule", metavar="FILE", type=Path, help="timed phonemes, instead of text"
    )
    made.add_argument("--notation", metavar="NAME", help="the notation of the schedule's labels")
    made.add_argument("--line", metavar="NAME", help="the character's own edits of this line")
    made.add_argument(
        "--tts",
        metavar="ENGINE",
        help="another speech engine than the language's; none estimates times",
    )
    made.add_argument("--fps", metavar="N", type=float, default=60.0, help="frames per second [60]")
    made.add_argument(
        "--set", metavar="motion.NAME=VALUE", action="append", default=[], dest="settings",
        help="change a motion setting, or take a preset: --set motion=paper",
    )  # fmt: skip
    made.add_argument(
        "--gaps", choices=("error", "rest"), default="error",
        help="bigrams that nothing answers [error]",
    )  # fmt: skip
    made.add_argument(
        "--unknown", choices=("error", "rest", "nearest"), default="error",
        help="labels that no notation maps; nearest is for IPA, by its features [error]",
    )  # fmt: skip
