"""Merge edits of a pack with changes of its file on the disk, entry by entry.

An entry is a field of the pack, or a key of a field that is a mapping: one bigram, one target.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from lipsync_lang.errors import LipsyncError
from lipsync_lang.packs.splicing import ABSENT, Change, SplicedText, get
from lipsync_lang.packs.yaml.faults import shown
from lipsync_lang.packs.yaml.source import Data, Loc

MergeSide = Literal["mine", "theirs"]

Choices = Mapping[tuple[Path, Loc], MergeSide]
"""Side to keep for an entry that edits and the disk both changed; () is the whole file."""

WHOLE_FILE: Loc = ()
"""Location of a conflict about a whole file, which was deleted or is faulty."""


@dataclass(frozen=True)
class MergeConflict:
    """An entry that changed both here and on the disk; `ABSENT` for a missing value."""

    path: Path
    loc: Loc
    base: Data
    """Value before both changes."""
    mine: Data
    theirs: Data

    def __str__(self) -> str:
        what = "-".join(map(str, self.loc[-1:])) or "the whole file"
        return f"{shown(self.path)}: {what}"


class EditConflict(LipsyncError):  # noqa: N818 named as the answer that a page gets
    """Another tab has changed a location."""


class SaveConflict(LipsyncError):  # noqa: N818 as above
    """Entries changed both here and on the disk.

    Parameters
    ----------
    conflicts : every entry that changed on both sides
    """

    def __init__(self, conflicts: Sequence[MergeConflict]) -> None:
        self.conflicts = tuple(conflicts)
        listed = "\n".join(f"  {conflict}" for conflict in conflicts)
        super().__init__(
            f"these entries changed on the disk as well as here, so nothing was saved:\n{listed}\n"
            "choose the side to keep for each: mine or theirs"
        )


def differences(before: Data, after: Data) -> list[Change]:
    """Return the entries that differ, with their new values.

    Example
    -------
    >>> differences({"style": "sad"}, {"style": "sad", "bigrams": {"l-ow": 1}})
    [(('bigrams', 'l-ow'), 1)]
    """
    return list(_differences(before or {}, after or {}))


def _differences(before: Mapping[str, Data], after: Mapping[str, Data]) -> Iterator[Change]:
    for key in {**before, **after}:
        old, new = before.get(key, ABSENT), after.get(key, ABSENT)
        if old == new:
            continue
        inner = [{} if one in (ABSENT, None) else one for one in (old, new)]
        if new is ABSENT or not all(isinstance(one, dict) for one in inner) or not any(inner):
            yield (key,), new
            continue
        for name in {**inner[0], **inner[1]}:
            one, other = (some.get(name, ABSENT) for some in inner)
            if one != other:
                yield (key, name), other


def merged(
    path: Path, base: Data, mine: SplicedText, theirs: SplicedText, choices: Choices
) -> tuple[SplicedText, SplicedText, list[MergeConflict], list[Loc]]:
    """Apply edits to the changed text of a file.

    Returns
    -------
    The text with both changes, the text of the disk, the open conflicts, and the locations whose
    edits are dropped
    """
    own, other = differences(base, mine.data), differences(base, theirs.data)
    conflicts: list[MergeConflict] = []
    kept, dropped = [], []
    for loc, value in own:
        meant = [one for one, _ in other if overlap(loc, one)]
        side = choices.get((path, loc))
        if not meant or side == "mine" or get(theirs.data, loc) == value:
            kept.append((loc, value))
        elif side == "theirs":
            dropped.append(loc)
        else:
            found = (get(data, loc) for data in (base or {}, mine.data, theirs.data))
            conflicts.append(MergeConflict(path, loc, *found))
    return theirs if conflicts else theirs.changed(kept), theirs, conflicts, dropped


def overlap(one: Loc, other: Loc) -> bool:
    """Return True if two locations are equal, or one is within the other."""
    return all(a == b for a, b in zip(one, other, strict=False))


def told(before: Any, after: Any) -> str:
    """Name the kind of change of an entry."""
    return "added" if before is ABSENT else "deleted" if after is ABSENT else "changed"
