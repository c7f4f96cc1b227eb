"""The command that accepts items of a fit for a character, or takes them out again."""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang import LipsyncError
from lipsync_lang.base.errors import count
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.commands.output import FAULTS, SOUND, as_json
from lipsync_lang.commands.registry import Add, command
from lipsync_lang.commands.shared_options import add_options, flag, option

if TYPE_CHECKING:
    from lipsync_lang.plugins.capture.accept_fit import Acceptance, ReviewedItem
    from lipsync_lang.plugins.capture.fit_file import FitProposal

MAX_SHOWN_ITEMS = 12
"""Maximum number of items of each kind to name after a change."""

MAX_VALUE_CHARS = 44
"""Maximum length of a value in the table."""

HEAD = ("item", "was", "value", "seen", "error", "sure", "state")


@command("bank accept")
def _add_accept(action: Add) -> None:
    made = action(
        accept,
        "accept what a fit to captures proposes for a character",
        "bank accept fit.json targets.ow softness.jaw -c anna",
        more=": all of it, or item by item; without --all and items, list it. Values that a person "
        "wrote or drew stay",
    )
    made.add_argument(
        "items", metavar="FIT.json ITEM", nargs="*",
        help="the file of the fit, and items of it, such as targets.ow or bigrams.l-ow",
    )  # fmt: skip
    option(
        made, "-c, --character CHARACTER", "the character that receives the items [the project's]"
    )
    flag(made, "--all", "take every item that may be accepted")
    option(
        made, "--confidence X", "lowest confidence of items that --all accepts, from 0 to 1 [0.5]",
        type=float, default=0.5,
    )  # fmt: skip
    flag(made, "--anyway", "accept items although the fit does not generalise to held-out lines")
    flag(made, "--remove", "remove accepted items: those named, or --all; needs no FIT.json")
    flag(made, "--dry-run", "change no file")
    add_options(made, ["path", "json"])


def accept(options: Namespace) -> int:
    """List the items of a fit, accept some of them, or take accepted ones out again."""
    from lipsync_lang.packs.library import Library
    from lipsync_lang.plugins.capture.accept_fit import accept_fit
    from lipsync_lang.plugins.capture.fit_file import FITTED, read_fit, split_item

    names = list(options.items)
    if options.remove:  # the file of the fit may be named too, but is not needed
        return _remove(options, [name for name in names if split_item(name)[0] in FITTED])
    if not names:
        raise LipsyncError("name the file of a fit: bank accept FIT.json -c CHARACTER")
    proposal, wanted = read_fit(Path(names[0])), names[1:]
    done = accept_fit(
        Library(options.path), proposal, options.character, wanted,
        every=options.all, confidence=options.confidence, anyway=options.anyway,
        write=not options.dry_run,
    )  # fmt: skip
    if options.json:
        print(as_json(_document(options, proposal, done)))
    elif wanted or options.all:
        _tell(done, dry=options.dry_run)
    else:
        for line in columns([HEAD, *map(_cells, done.rows)], widest=MAX_VALUE_CHARS):
            print(line)
        if not proposal.verdict.accepted:
            told = f": {proposal.verdict.why}" if proposal.verdict.why else ""
            print(f"the fit does not generalise to held-out lines{told}", file=sys.stderr)
        ready = sum(row.state == "ready" for row in done.rows)
        items = count(len(done.rows), "item")
        print(f"{ready} of {items} can be accepted with --all", file=sys.stderr)
    missed = [row for row in done.left if row.item.item in wanted and row.state != "same"]
    return FAULTS if missed else SOUND


def _remove(options: Namespace, wanted: Sequence[str]) -> int:
    from lipsync_lang.packs.library import Library
    from lipsync_lang.plugins.capture.accept_fit import remove_fit

    if not wanted and not options.all:
        raise LipsyncError("name the items to take out, or give --all")
    done = remove_fit(
        Library(options.path), options.character, () if options.all else wanted,
        write=not options.dry_run,
    )  # fmt: skip
    if options.json:
        told = {"file": str(done.path), "removed": list(done.taken), "written": not options.dry_run}
        print(as_json(told))
        return SOUND
    from lipsync_lang.packs.yaml.pack_files import shown

    verb = "would be taken" if options.dry_run else "taken"
    _name(done.taken)
    print(f"{count(len(done.taken), 'item')} {verb} out of {shown(done.path)}", file=sys.stderr)
    return SOUND


def _cells(row: "ReviewedItem") -> tuple[str, ...]:
    item = row.item
    errors = (item.residual_before, item.residual_after)
    return (
        item.item,
        _short(item.was, item.kind),
        _short(item.value, item.kind),
        str(item.occurrences),
        " -> ".join("-" if one is None else f"{one:.3f}" for one in errors),
        f"{item.confidence:.2f}",
        f"{row.state}: {row.why}" if row.why else row.state,
    )


def _short(value: Any, kind: str) -> str:
    """Return a value in a few words: numbers, weights of poses, or peaks of curves."""
    if value is None:
        return "-"
    if kind == "targets":
        steps = value if isinstance(value, (list, tuple)) else [value]
        told = " > ".join(_weights(step.get("weights", step)) for step in steps)
    elif kind == "bigrams":
        told = _weights({p: max(v for _, v in points) for p, points in value["curves"].items()})
    else:
        told = f"{value:g}"
    return told if len(told) <= MAX_VALUE_CHARS else f"{told[: MAX_VALUE_CHARS - 3]}..."


def _weights(stated: dict[str, Any]) -> str:
    numbers = {pose: one for pose, one in stated.items() if isinstance(one, (int, float))}
    numbers.pop("dominance", None)
    return ", ".join(f"{pose} {one:.2g}" for pose, one in numbers.items()) or "rest"


def _tell(done: "Acceptance", *, dry: bool) -> None:
    """Name the accepted items, and the requested items that were left out."""
    from lipsync_lang.packs.yaml.pack_files import shown

    _name(done.taken)
    for row in done.left[:MAX_SHOWN_ITEMS]:
        print(f"{row.item.item}: {row.why}", file=sys.stderr)
    if len(done.left) > MAX_SHOWN_ITEMS:
        more = len(done.left) - MAX_SHOWN_ITEMS
        print(f"... and {more} more that are left (--json lists them)", file=sys.stderr)
    verb = "would go" if dry else "put"
    print(f"{count(len(done.taken), 'item')} {verb} into {shown(done.path)}", file=sys.stderr)


def _name(items: Sequence[str]) -> None:
    for item in items[:MAX_SHOWN_ITEMS]:
        print(item)
    if len(items) > MAX_SHOWN_ITEMS:
        print(f"... and {len(items) - MAX_SHOWN_ITEMS} more (--json lists them)")


def _document(options: Namespace, proposal: "FitProposal", done: "Acceptance") -> dict[str, Any]:
    return {
        "character": options.character,
        "file": str(done.path),
        "poseset": proposal.poseset,
        "verdict": proposal.verdict.model_dump(mode="json"),
        "written": bool(done.taken) and not options.dry_run,
        "items": [
            row.item.model_dump(mode="json")
            | {"state": row.state, "why": row.why, "accepted": row.item.item in done.taken}
            for row in done.rows
        ],
    }
