"""Acceptance of fitted values: add items of a proposal to a character's file, or remove them.

Only the lines that change are rewritten, in one atomic write; comments and order stay.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.capture.fit_review import (
    CONFIDENCE,
    ReviewedItem,
    open_character,
    own_character,
    review,
)
from lipsync_lang.capture.fitted_values import fitted_items, removals, settings, together
from lipsync_lang.errors import LipsyncError, did_you_mean
from lipsync_lang.files import atomic
from lipsync_lang.packs.splicing import Change, SplicedText
from lipsync_lang.packs.yaml.source import read_bytes

if TYPE_CHECKING:
    from lipsync_lang.capture.fit_file import FitProposal
    from lipsync_lang.packs.library import Library

MAX_SHOWN_FOLDS = 8
"""Maximum number of folds in a message."""


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
    library: "Library",
    proposal: "FitProposal",
    character: str,
    wanted: Sequence[str] = (),
    *,
    every: bool = False,
    confidence: float = CONFIDENCE,
    anyway: bool = False,
    write: bool = True,
) -> Acceptance:
    """Accept items of a fit for a character; without a selection, only review them.

    Parameters
    ----------
    wanted : names of items, accepted however low their confidence
    every : accept all items whose confidence is high enough
    confidence : minimum confidence of items that are not named
    anyway : accept items of a fit that does not generalise
    write : False changes no file

    Raises
    ------
    LipsyncError
        The character cannot hold the fit, a wanted item is not in it, or it does not generalise.
    """
    shelf = open_character(library, proposal, character)
    rows = review(shelf, proposal.items, confidence)
    if not wanted and not every:
        return Acceptance(shelf.character.path, rows)
    if not proposal.verdict.accepted and not anyway:
        raise LipsyncError(_refusal(proposal))
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


def _refusal(proposal: "FitProposal") -> str:
    """Return the message for a fit that does not generalise, with its numbers."""
    verdict = proposal.verdict
    folds = [
        f"\n  without {fold.by} {fold.held_out}: error {fold.before:.3f} before, "
        f"{fold.after:.3f} after the fit"
        for fold in verdict.folds[:MAX_SHOWN_FOLDS]
    ]
    more = len(verdict.folds) - len(folds)
    folds += [f"\n  and {more} more"] * (more > 0)
    why = f": {verdict.why}" if verdict.why else ""
    return (
        f"the fit does not generalise to held-out lines{why}{''.join(folds)}\n"
        "  capture more lines, or accept the fit with --anyway"
    )


def remove_fit(
    library: "Library", character: str, wanted: Sequence[str] = (), *, write: bool = True
) -> Acceptance:
    """Remove accepted items from a character; all of them by default.

    Raises
    ------
    LipsyncError
        The character is not a file of the project, or a wanted item was not written by a fit.
    """
    pack = own_character(library, character)
    there = list(fitted_items(pack.model))
    _refuse_unknown(wanted, there)
    gone = [item for item in there if not wanted or item in wanted]
    if write:
        _write(pack.path, removals(gone, pack.source.data))
    return Acceptance(pack.path, (), tuple(gone))


def _write(path: Path, made: Sequence[Change]) -> None:
    """Rewrite a character's file with some changes; leave it alone if there are none."""
    if made:
        content = SplicedText.read(path, read_bytes(path)).changed(made).content
        with atomic(path, durable=True) as stream:
            stream.write(content)
