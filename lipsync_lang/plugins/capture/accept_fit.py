"""Acceptance of fitted values: add items of a proposal to a character's file, or remove them.

Values that a person wrote are kept. A target is a person's unless it has `status: fitted`; a bigram
is a person's if any layer has it edited or approved; a number is a person's if it is stated and
differs from that in `fitted`. Only the lines that change are rewritten, in one atomic write;
comments and order stay.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from lipsync_lang import LipsyncError
from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import Character
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.splicing import ABSENT, Change, get, plain, put, rewrite
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.plugins.capture.fit_file import FitItem, FitProposal, rounded, split_item
from lipsync_lang.resolver.layers import FITTED, PairPacks

Data = Any
"""Plain data of a character's file."""

State = Literal["ready", "doubtful", "same", "stays", "refused"]

CONFIDENCE = 0.5
"""Confidence below which an item is accepted only by its name."""

MAX_SHOWN_FOLDS = 8


def fitted_items(model: Character) -> Iterator[str]:
    """Yield the names of fitted values that have not been changed since."""
    for label, steps in model.targets.items():
        if any(step.status == FITTED for step in steps):
            yield f"targets.{label}"
    for item, value in model.fitted.items():
        if model.scalar(item) == value:
            yield item
    for key, bigram in model.bigrams.items():
        if bigram.status == FITTED:
            yield f"bigrams.{key}"


def settings(item: FitItem, data: Data) -> list[Change]:
    """Return the changes that set an item in a character's file with some data."""
    loc, value = split_item(item.item), rounded(item.value)
    if item.kind == "targets":
        steps = value if isinstance(value, list) else [value]
        steps = [{key: one for key, one in step.items() if key != "status"} for step in steps]
        steps[0]["status"] = FITTED
        return [(loc, steps if len(steps) > 1 else steps[0])]
    if item.kind == "bigrams":
        old = get(data, loc)
        # Fitted control points are of the usual kind of curve, whatever the old ones were.
        kept = {} if old is ABSENT else {k: v for k, v in old.items() if k != "interpolation"}
        return [(loc, {**kept, "status": FITTED, **value})]
    return [(loc, value), (("fitted", item.item), value)]


def together(changes: Sequence[Change], data: Data) -> list[Change]:
    """Merge the changes of each missing field into one change of the whole field.

    A field that is too long for one line is written with one entry per line.
    """
    made: list[Change] = []
    fields: dict[str | int, dict[str | int, Data]] = {}
    for (field, name), value in changes:
        if field in data:
            made.append(((field, name), value))
        else:
            fields.setdefault(field, {})[name] = value
    return [*made, *(((field,), entries) for field, entries in fields.items())]


@dataclass(frozen=True)
class ReviewedItem:
    """An item of a fit with its state for one character."""

    item: FitItem
    state: State
    why: str = ""
    """The reason, unless the item is ready."""


def own_character(library: Library, name: str) -> Pack[Character]:
    """Return a character that is a file of the user; raise `LipsyncError` for any other."""
    pack = library.character(name)
    # The library makes a character of a bare pose set, whose file is shared by all faces.
    if pack.source.data.get("kind") != "character":
        raise LipsyncError(
            f"'{name}' is a pose set, and a fit is for one character; make one with lipsync-lang "
            f"characters new NAME --model FILE --poseset {name}, or write characters/NAME.yaml "
            f"with kind: character, format: 1, name: NAME and poseset: {name}"
        )
    origins = [root.origin for root in library.roots if pack.path.is_relative_to(root.path)]
    if origins and all(one == "built-in" or one.startswith("installed") for one in origins):
        raise LipsyncError(
            f"{shown(pack.path)} is installed; copy it into characters/ of your project"
        )
    return pack


def _reviewed(shelf: PairPacks, item: FitItem, confidence: float) -> ReviewedItem:
    known = {"phoneme": shelf.known, "pose": shelf.poses}
    regions = {pose.region for pose in shelf.poseset.model.poses.values() if pose.region}
    for what, name in _names(item):
        there = known.get(what, regions)
        if name not in there:
            told = f"unknown {what} '{name}'; {did_you_mean(name, there)}"
            return ReviewedItem(item, "refused", told)
    pack, loc = shelf.character, split_item(item.item)
    if item.kind == "bigrams":
        first, second = item.name.split("-")
        row = shelf.drawn_by_hand((first, second))
        if row is not None:
            told = f"a person drew it: {row.origin.status} in {row.place}"
            return ReviewedItem(item, "stays", told)
    elif pack.source.known(loc) == len(loc) and item.item not in fitted_items(pack.model):
        return ReviewedItem(item, "stays", f"a person wrote it: {pack.where(loc, key=True)}")
    data = pack.source.data
    if all(get(data, loc) == plain(value) for loc, value in settings(item, data)):
        return ReviewedItem(item, "same", "already accepted")
    if item.confidence < confidence:
        told = f"confidence {item.confidence:.2f} is below {confidence:g}; name it to accept it"
        return ReviewedItem(item, "doubtful", told)
    return ReviewedItem(item, "ready")


def _names(item: FitItem) -> Iterator[tuple[str, str]]:
    """Yield the names in an item: phonemes, poses and regions."""
    if item.kind == "targets":
        yield "phoneme", item.name
        for step in item.typed:
            yield from (("pose", pose) for pose in (*step.weights, *step.dominance))
    elif item.kind == "bigrams":
        yield from (("phoneme", one) for one in item.name.split("-"))
        yield from (("pose", pose) for pose in item.typed.curves)
    elif item.kind == "anticipate":
        yield "pose", item.name
    elif item.kind == "softness":
        yield "region", item.name


@dataclass(frozen=True)
class Acceptance:
    """The items of a fit for one character, and those that were accepted."""

    path: Path
    """The character's file."""
    rows: tuple[ReviewedItem, ...]
    """Every item with its state before."""
    taken: tuple[str, ...] = ()
    """The items that were accepted."""
    left: tuple[ReviewedItem, ...] = ()
    """The items that were asked for and were not accepted."""


def accept_fit(  # noqa: PLR0913 the items, the character and options
    library: Library,
    proposal: FitProposal,
    character: str,
    wanted: Sequence[str] = (),
    *,
    every: bool = False,
    confidence: float = CONFIDENCE,
    anyway: bool = False,
    write: bool = True,
) -> Acceptance:
    """Accept items of a fit for a character; without a selection, only review them.

    Items that `wanted` names are accepted however low their confidence; `every` accepts all whose
    confidence is high enough. `anyway` accepts items of a fit that does not generalise, and
    `write=False` changes no file. Raises LipsyncError if the character cannot hold the fit, a
    wanted item is not in it, or it does not generalise.
    """
    moved = own_character(library, character).model.poseset
    if moved != proposal.poseset:
        raise LipsyncError(
            f"the fit is for pose set '{proposal.poseset}', but '{character}' moves the poses of "
            f"'{moved}'; name a character of {proposal.poseset}, or fit again"
        )
    shelf = PairPacks.open(library, proposal.language, character)
    rows = tuple(_reviewed(shelf, item, confidence) for item in proposal.items)
    if not wanted and not every:
        return Acceptance(shelf.character.path, rows)
    if not proposal.verdict.accepted and not anyway:
        verdict = proposal.verdict
        folds = [
            f"\n  without {fold.by} {fold.held_out}: error {fold.before:.3f} before, "
            f"{fold.after:.3f} after the fit"
            for fold in verdict.folds[:MAX_SHOWN_FOLDS]
        ]
        more = len(verdict.folds) - len(folds)
        folds += [f"\n  and {more} more"] * (more > 0)
        why = f": {verdict.why}" if verdict.why else ""
        raise LipsyncError(
            f"the fit does not generalise to held-out lines{why}{''.join(folds)}\n"
            "  capture more lines, or accept the fit with --anyway"
        )
    _refuse_unknown(wanted, [row.item.item for row in rows])
    asked = [row for row in rows if every or row.item.item in wanted]
    taken = [
        row
        for row in asked
        if row.state == "ready" or (row.state == "doubtful" and row.item.item in wanted)
    ]
    data = shelf.character.source.data
    if write:
        made = [one for row in taken for one in settings(row.item, data)]
        _write(shelf.character.path, together(made, data))
    names = tuple(row.item.item for row in taken)
    left = tuple(row for row in asked if row.item.item not in names)
    return Acceptance(shelf.character.path, rows, names, left)


def _refuse_unknown(wanted: Sequence[str], known: Sequence[str]) -> None:
    for name in wanted:
        if name not in known:
            raise LipsyncError(f"unknown item '{name}' in this fit; {did_you_mean(name, known)}")


def remove_fit(
    library: Library, character: str, wanted: Sequence[str] = (), *, write: bool = True
) -> Acceptance:
    """Remove accepted items from a character, by default all; refuse others."""
    pack = own_character(library, character)
    there = list(fitted_items(pack.model))
    _refuse_unknown(wanted, there)
    gone = [item for item in there if not wanted or item in wanted]
    data, made = pack.source.data, []
    for loc in (loc for item in gone for loc in (split_item(item), ("fitted", item))):
        if get(data, loc) is not ABSENT:
            # Kept up to date, so that the last item of a field takes the field along.
            data = put(data, loc, ABSENT)
            made.append((loc if data[loc[0]] else loc[:1], ABSENT))  # a field that is empty goes
    if write:
        _write(pack.path, made)
    return Acceptance(pack.path, (), tuple(gone))


def _write(path: Path, made: Sequence[Change]) -> None:
    """Rewrite a character's file with some changes; leave it alone if there are none."""
    if made:
        rewrite(path, made)
