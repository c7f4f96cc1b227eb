"""Merge two changes of a pack, entry by entry.

An entry is a field of the pack, or a key of a field that is a mapping: one bigram, one target.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Literal, NamedTuple

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.splicing import ABSENT, Change, SplicedText
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.packs.yaml.source import Data, Loc

MergeSide = Literal["mine", "theirs"]

Choices = Mapping[tuple[Path, Loc], MergeSide]
"""Side to keep for an entry that changed on both; () is a file that was deleted or is faulty."""


class MergeConflict(NamedTuple):
    """An entry that changed on both sides, to two values; `ABSENT` for none."""

    path: Path
    loc: Loc
    mine: Data
    theirs: Data


class EditConflict(LipsyncError):  # noqa: N818 named as the answer that a page gets
    """Another tab has changed a location."""


class SaveConflict(LipsyncError):  # noqa: N818 as above
    """Entries changed both here and on the disk."""

    def __init__(self, conflicts: Sequence[MergeConflict]) -> None:
        self.conflicts = tuple(conflicts)
        listed = (
            f"  {shown(path)}: {(loc or ('the whole file',))[-1]}\n" for path, loc, *_ in conflicts
        )
        super().__init__(
            "these entries changed on the disk as well as here, so nothing was saved:\n"
            f"{''.join(listed)}choose the side to keep for each: mine or theirs"
        )


def differences(before: Data, after: Data, depth: int = 2) -> list[Change]:
    """Return the entries that differ, with their new values; an entry has `depth` keys at most.

    >>> differences({"style": "sad"}, {"style": "sad", "bigrams": {"l-ow": 1}})
    [(('bigrams', 'l-ow'), 1)]
    """
    one, two = (data if isinstance(data, dict) else {} for data in (before, after))
    found: list[Change] = []
    for key in {**one, **two}:
        old, new = one.get(key, ABSENT), two.get(key, ABSENT)
        # A new mapping is compared by its entries, or new bigrams of two tabs would conflict.
        inner = [{} if value in (ABSENT, None) else value for value in (old, new)]
        mappings = any(inner) and all(isinstance(value, dict) for value in inner)
        if old != new and depth > 1 and mappings and new is not ABSENT:
            found += [((key, *loc), one) for loc, one in differences(inner[0], inner[1], depth - 1)]
        elif old != new:
            found.append(((key,), new))
    return found


def merged(
    base: SplicedText, mine: SplicedText, theirs: SplicedText, choices: Mapping[Loc, MergeSide]
) -> tuple[SplicedText, list[MergeConflict]]:
    """Apply the changes from `base` to `mine` to the text of `theirs`.

    `choices` has the side of an entry that both changed; a conflict without one is returned, and
    keeps theirs. Raises PackError if the text does not take the changes.
    """
    whole = choices.get(())
    if theirs is base or whole is not None:
        return (theirs if whole == "theirs" else mine), []
    if not mine.parts or not theirs.parts:
        values = (one.data if one.parts else ABSENT for one in (mine, theirs))
        return theirs, [MergeConflict(mine.path, (), *values)]
    other = differences(base.data, theirs.data)
    conflicts: list[MergeConflict] = []
    kept: list[Change] = []
    for loc, value in differences(base.data, mine.data):
        meant = any(overlap(loc, one) for one, _ in other)
        if not meant or choices.get(loc) == "mine" or theirs.at(loc) == value:
            kept.append((loc, value))
        elif loc not in choices:
            conflicts.append(MergeConflict(mine.path, loc, mine.at(loc), theirs.at(loc)))
    return theirs.changed(kept), conflicts


def overlap(one: Loc, other: Loc) -> bool:
    """Return True if two locations are equal, or one is within the other."""
    return all(a == b for a, b in zip(one, other, strict=False))
