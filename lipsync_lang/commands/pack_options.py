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
        "show the layer of each part of a language-character pair, and its gaps",
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
        help="skip the tests in language packs (built-in languages are tested only if named)",
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
    schema_.add_argument(
        "kind", metavar="KIND", nargs="?", help="the kind of pack; without it, list the kinds"
    )
    add_json(schema_)


def add_packs(add: Add) -> None:
    """Add `languages`, `posesets` and `characters`."""
    for kind, title, actions, parts in (
        (
            "languages",
            "list language packs, show one, check one, or draft a new one",
            ("list", "show", "check", "new"),
            (_add_language_check, _add_new_language),
        ),
        (
            "posesets",
            "list pose sets, show one, or draft a new one",
            ("list", "show", "new"),
            (_add_new_poseset,),
        ),
        (
            "characters",
            "list characters, show one, or draft one from a model",
            ("list", "show", "new"),
            (_add_new_character,),
        ),
    ):
        packs_ = add(kind, packs.packs, title, f"{kind} list")
        packs_.set_defaults(kind=kind[:-1])
        packs_.add_argument("action", choices=actions, nargs="?", default="list")
        packs_.add_argument("name", metavar="NAME", nargs="?", help="the pack to show or to create")
        for add_part in parts:
            add_part(packs_)
        add_path(packs_)
        add_json(packs_)


def _add_language_check(made: argparse.ArgumentParser) -> None:
    made.set_defaults(choosing=True)  # a character is welcome, but not needed
    check = made.add_argument_group("how a language is checked")
    check.add_argument(
        "-c", "--character", metavar="CHARACTER",
        help="show the mouth of each sound on a character or a pose set",
    )  # fmt: skip
    check.add_argument(
        "--picture", metavar="FILE", type=argument_path,
        help="draw the mouths of the character on its model, as PNG",
    )  # fmt: skip


def _add_new_language(made: argparse.ArgumentParser) -> None:
    new = made.add_argument_group("sources of a new language")
    new.add_argument("--voice", metavar="VOICE", help="an eSpeak NG voice, such as sw")
    new.add_argument("--epitran", metavar="CODE", help="an Epitran code, such as xho-Latn")
    new.add_argument(
        "--lexicon", metavar="FILE", type=Path,
        help="words and their IPA phonemes: word, tab, phonemes separated by spaces",
    )  # fmt: skip
    new.add_argument(
        "--inventory", metavar="FILE", type=Path,
        help="the PHOIBLE table, or IPA phonemes separated by spaces",
    )  # fmt: skip
    new.add_argument(
        "--inventory-id",
        metavar="ID",
        help="PHOIBLE inventory number, or an ISO 639-3 code or name",
    )
    new.add_argument(
        "--text",
        metavar="FILE",
        type=argument_path,
        help="sample lines to collect sounds from; - is standard input",
    )
    new.add_argument("--tag", metavar="TAG", help="the BCP 47 tag of the language")
    new.add_argument("--title", metavar="TITLE", help="the full name of the language")


def _add_new_poseset(made: argparse.ArgumentParser) -> None:
    new = made.add_argument_group("sources of a new pose set")
    new.add_argument("poses", metavar="POSE", nargs="*", help="the names of its poses")
    new.add_argument(
        "--model", metavar="FILE", type=Path,
        help="a model (.glb); its shapes are the poses unless you name some",
    )  # fmt: skip
    new.add_argument(
        "--like", metavar="POSESET",
        help="copy the motion of known poses from this pose set [the best match]",
    )  # fmt: skip
    new.add_argument(
        "--guess", action="store_true",
        help="assign sounds to unknown poses by a first guess",
    )  # fmt: skip
    new.add_argument("--title", metavar="TITLE", help="its title in lists")


def _add_new_character(made: argparse.ArgumentParser) -> None:
    new = made.add_argument_group("sources of a new character")
    new.add_argument("--model", metavar="FILE", type=Path, help="the model of the face (.glb)")
    new.add_argument("--poseset", metavar="POSESET", help="its pose set [the best match]")
    new.add_argument("--rig", metavar="RIG", help="a rig of the pose set [the best match]")
    new.add_argument("--title", metavar="TITLE", help="its title in lists")
