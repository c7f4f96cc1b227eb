"""Review of a fit: for each item, whether a character may take it, or why not.

Values that a person wrote are kept. A target is a person's unless it has `status: fitted`; a bigram
is a person's if any layer has it edited or approved; a number is a person's if it is stated and
differs from that in `fitted`.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from lipsync_lang.capture.fit_file import FitItem, split_item
from lipsync_lang.capture.fitted_values import fitted_items, settings
from lipsync_lang.errors import LipsyncError, did_you_mean
from lipsync_lang.packs.splicing import get, plain
from lipsync_lang.packs.yaml.faults import shown
from lipsync_lang.resolver.layers import DRAFTED, FITTED, NEUTRAL, PairPacks

if TYPE_CHECKING:
    from lipsync_lang.capture.fit_file import FitProposal
    from lipsync_lang.packs.library import Library, Pack
    from lipsync_lang.packs.models import Character

State = Literal["ready", "doubtful", "same", "stays", "refused"]

CONFIDENCE = 0.5
"""Confidence below which an item is accepted only by its name."""


@dataclass(frozen=True)
class ReviewedItem:
    """An item of a fit with its state for one character."""

    item: FitItem
    state: State
    why: str = ""
    """The reason, unless the item is ready."""


def open_character(library: "Library", proposal: "FitProposal", name: str) -> PairPacks:
    """Open the character that a fit is accepted for, with the packs of the fit's language.

    Raises
    ------
    LipsyncError
        The character cannot hold the fit: it is a bare pose set, is not a file of the project, or
        moves other poses.
    """
    pack = own_character(library, name)
    if pack.model.poseset != proposal.poseset:
        raise LipsyncError(
            f"the fit is for pose set '{proposal.poseset}', but '{name}' moves the poses of "
            f"'{pack.model.poseset}'; name a character of {proposal.poseset}, or fit again"
        )
    return PairPacks.open(library, proposal.language, name)


def own_character(library: "Library", name: str) -> "Pack[Character]":
    """Return a character that is a file of the user; raise `LipsyncError` for any other."""
    pack = library.character(name)
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


def review(
    shelf: PairPacks, items: Sequence[FitItem], confidence: float = CONFIDENCE
) -> tuple[ReviewedItem, ...]:
    """Return each item with its state for the shelf's character."""
    return tuple(_reviewed(shelf, item, confidence) for item in items)


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
        files = (file.rows.get((first, second)) for file in shelf.drawn if file.style == NEUTRAL)
        for row in (*files, shelf.authored((first, second))):
            if row is not None and row.origin.status not in {DRAFTED, FITTED}:
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
