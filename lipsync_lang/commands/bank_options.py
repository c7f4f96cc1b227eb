"""Options of `bank` and its actions."""

from pathlib import Path

from lipsync_lang.commands import bank_fitting, banks, fit_acceptance
from lipsync_lang.commands.shared_options import Add, add_json, add_pair, add_path, adder
from lipsync_lang.files import argument_path


def add_bank(add: Add) -> None:
    """Add `bank`."""
    bank_ = add(
        "bank",
        banks.draft,
        "draft bigrams, import them, accept fitted ones, or see what a bank changes",
        "bank draft -l english -c facefx",
    )
    actions = bank_.add_subparsers(title="actions", metavar="ACTION", required=True)
    action = adder(actions)
    for add_action in (_add_draft, _add_import, _add_fit, _add_diff, _add_accept):
        add_action(action)


def _add_draft(action: Add) -> None:
    made = action(
        "draft",
        banks.draft,
        "draft bigrams from a pose set's targets",
        "bank draft -l english -c facefx --write l-ow h-eh",
        more=", as YAML to look at or to edit",
    )
    made.add_argument("bigrams", metavar="BIGRAM", nargs="*", help="such as l-ow; none means all")
    add_pair(made)
    made.add_argument(
        "--write", action="store_true", help="write them to a bank; its own bigrams stay"
    )
    made.add_argument(
        "--to", metavar="FILE", type=Path,
        help="the bank to write to [posesets/NAME/banks/common.yaml of this folder]",
    )  # fmt: skip


def _add_import(action: Add) -> None:
    made = action(
        "import",
        banks.import_,
        "import the phone-bigram banks of SmartBody",
        "bank import init-diphoneDefault.py -c facefx",
        more=", its Python scripts (which are read, never run) or its text exports",
    )
    made.add_argument("files", metavar="FILE", type=Path, nargs="+", help="a script or text export")
    made.add_argument(
        "-c", "--character", metavar="POSESET",
        help="the pose set whose poses the bank moves, or a character of it [the project's]",
    )  # fmt: skip
    made.add_argument(
        "--to", metavar="FILE", type=Path,
        help="the bank to write to; its own bigrams stay "
        "[posesets/NAME/banks/ of this folder, by the first file's name]",
    )  # fmt: skip
    made.add_argument(
        "--style", metavar="NAME",
        help="the manner of speaking: picks one of several sets, or renames the only one",
    )  # fmt: skip
    made.add_argument(
        "--interpolation", choices=("bspline", "linear"), default="linear",
        help="the kind of curve: linear curves pass through the keys, as the artist saw "
        "them; bspline curves are smooth and stay below them [linear]",
    )  # fmt: skip
    made.add_argument(
        "--map", metavar="THEIRS=OURS", action="append", default=[],
        help="a phoneme or pose for a name in the file, such as z=s; may be repeated",
    )  # fmt: skip
    add_path(made)
    add_json(made)


def _add_accept(action: Add) -> None:
    made = action(
        "accept",
        fit_acceptance.accept,
        "accept what a fit to captures proposes for a character",
        "bank accept fit.json targets.ow softness.jaw -c anna",
        more=": all of it, or item by item; without --all and items, list it. Values that a person "
        "wrote or drew stay",
    )
    made.add_argument(
        "items", metavar="FIT.json ITEM", nargs="*",
        help="the file of the fit, and items of it, such as targets.ow or bigrams.l-ow",
    )  # fmt: skip
    made.add_argument(
        "-c", "--character", metavar="CHARACTER",
        help="the character that receives the items [the project's]",
    )  # fmt: skip
    made.add_argument("--all", action="store_true", help="take every item that may be accepted")
    made.add_argument(
        "--confidence", metavar="X", type=float, default=0.5,
        help="lowest confidence of items that --all accepts, from 0 to 1 [0.5]",
    )  # fmt: skip
    made.add_argument(
        "--anyway", action="store_true",
        help="accept items although the fit does not generalise to held-out lines",
    )  # fmt: skip
    made.add_argument(
        "--remove", action="store_true",
        help="remove accepted items: those named, or --all; needs no FIT.json",
    )  # fmt: skip
    made.add_argument("--dry-run", action="store_true", help="change no file")
    add_path(made)
    add_json(made)


def _add_fit(action: Add) -> None:
    made = action(
        "fit",
        bank_fitting.fit,
        "fit targets, motion and bigrams to captures of a face",
        "bank fit captures/ -l english -c facefx -o fit.json",
        more=", and test them on held-out lines",
    )
    made.add_argument(
        "captures", metavar="CAPTURE", type=Path, nargs="+",
        help="a capture, a list of captures, or a folder to search; each capture needs timings, or "
        "text and sound, beside it",
    )  # fmt: skip
    add_pair(made)
    made.add_argument(
        "--readout", metavar="FILE", type=Path,
        help="the measures that a table of sensors shows [readout.yaml of its folder]",
    )  # fmt: skip
    made.add_argument(
        "--speaker", metavar="PATTERN",
        help="the place of the speaker in file names, such as '{speaker}_*' [the first folder]",
    )  # fmt: skip
    made.add_argument("--notation", metavar="NAME", help="the notation of the timings' labels")
    made.add_argument(
        "--aligner", metavar="NAME[:MODEL]",
        help="another aligner than the language's, for captures with text and sound",
    )  # fmt: skip
    made.add_argument(
        "-o", "--output", metavar="FILE", type=argument_path,
        help="write the proposal, for `bank accept`; - is standard output",
    )  # fmt: skip
    made.add_argument(
        "--page", metavar="FILE", type=argument_path,
        help="write an HTML page of captures beside curves, and of all values found",
    )  # fmt: skip
    made.add_argument(
        "--workers", metavar="N", type=int, default=None, help="number of processes [one per core]"
    )
    add_json(made)


def _add_diff(action: Add) -> None:
    made = action(
        "diff",
        banks.diff,
        "show which bigrams a character's layers change, and by how much",
        "bank diff -l english -c facefx --plot changes.png",
        more="; without --against, a pose set's banks are compared with its drafts",
    )
    made.add_argument("bigrams", metavar="BIGRAM", nargs="*", help="such as l-ow; none means all")
    add_pair(made)
    made.add_argument(
        "--against", metavar="CHARACTER",
        help="another character of the pose set, or the bare pose set [the layers below]",
    )  # fmt: skip
    made.add_argument(
        "--plot",
        metavar="FILE",
        type=argument_path,
        help="draw the bigrams that differ most; - is standard output, as PNG",
    )
    made.add_argument("--all", action="store_true", help="list every bigram that differs")
    add_json(made)
