"""Options of the commands that resolve, validate, list and draft packs."""

import argparse
from pathlib import Path

from lipsync_lang.commands import packs, validate_packs
from lipsync_lang.commands.shared_options import Add, add_json, add_pair, add_path
from lipsync_lang.files import argument_path


def add_checking(add: Add) -> None:
    """Add `resolve`, `validate` and `schema`."""
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


def add_packs(add: Add) -> None:
    """Add `languages`, `posesets` and `characters`."""
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
