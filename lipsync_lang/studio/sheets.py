"""Files with unsaved edits and their steps, and the merge of both with a changed disk."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lipsync_lang.packs.splicing import ABSENT, Change, SplicedText, TextPart
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.packs.yaml.source import Loc, read_bytes
from lipsync_lang.studio.merging import (
    WHOLE_FILE,
    Choices,
    MergeConflict,
    differences,
    merged,
    overlap,
)

TextParts = tuple[TextPart, ...]
"""A text in parts; empty for a file that does not exist."""

PackEdit = tuple[Path, Loc, Any]
"""File, location and new value (`ABSENT` deletes the entry)."""


@dataclass
class EditedFile:
    """A file that can have unsaved edits."""

    path: Path
    base: bytes | None
    """Content of the file when it was last read or saved; None if it did not exist."""
    saved: SplicedText
    """Saved content in parts."""
    text: SplicedText
    """Text with all edits."""

    @property
    def edited(self) -> bool:
        """True if the text differs from that on the disk."""
        return self.text.parts is not self.saved.parts and self.text.content != self.saved.content


@dataclass
class Step:
    """Edits that are undone together."""

    title: str
    merge: str
    tab: str
    locs: list[tuple[Path, Loc]]
    before: dict[Path, TextParts] = field(default_factory=dict)
    after: dict[Path, TextParts] = field(default_factory=dict)
    journaled: bool = True
    """False for a step that the journal contains only as part of a text."""


@dataclass
class Plan:
    """Text to write into a file, and its origin."""

    text: SplicedText
    theirs: SplicedText
    """Text on the disk."""
    conflicts: Sequence[MergeConflict] = ()
    dropped: Sequence[Loc] = ()


def planned(sheet: EditedFile, disk: bytes | None, keep: Choices) -> Plan:
    """Merge a file's edits with the content on the disk."""
    mine, whole = sheet.text, keep.get((sheet.path, WHOLE_FILE))
    if disk == sheet.base:
        return Plan(mine, sheet.saved)
    try:
        theirs = in_parts(sheet.path, disk)
    except PackFaults:
        if whole == "mine":
            return Plan(mine, sheet.saved)
        raise
    if whole is not None or not mine.parts:
        return Plan(mine if whole == "mine" else theirs, theirs)
    if not theirs.parts:
        lost = MergeConflict(sheet.path, WHOLE_FILE, sheet.saved.data, mine.data, ABSENT)
        return Plan(mine, theirs, [lost])
    return Plan(*merged(sheet.path, sheet.saved.data, mine, theirs, keep))


def rebase(
    steps: Iterable[Step],
    sheet: EditedFile,
    theirs: SplicedText,
    now: SplicedText,
    dropped: Sequence[Loc],
) -> None:
    """Repeat steps in order on the text on the disk.

    Parameters
    ----------
    steps : from the first done to the last undone; their texts of this file are replaced
    sheet : the file before
    theirs : the text of the disk
    now : the new text of the present state
    dropped : locations whose edits were dropped

    Raises
    ------
    PackError
        A step cannot be repeated on the text of the disk.
    """
    made = {id(sheet.saved.parts): theirs.parts, id(sheet.text.parts): now.parts}
    old, new = sheet.saved, theirs
    for side in (side for step in steps for side in (step.before, step.after)):
        if not side.get(sheet.path):
            continue  # not touched, or a file that did not exist
        before, old = old, SplicedText(sheet.path, side[sheet.path])
        if id(old.parts) not in made:
            changes = differences(before.data, old.data)
            kept = [one for one in changes if not any(overlap(one[0], loc) for loc in dropped)]
            made[id(old.parts)] = new.changed(kept).parts
        new = SplicedText(sheet.path, made[id(old.parts)])
        side[sheet.path] = new.parts


def on_disk(path: Path) -> bytes | None:
    """Return the content of a file; None if there is none."""
    return read_bytes(path) if path.exists() else None


def in_parts(path: Path, content: bytes | None) -> SplicedText:
    """Split the content of a file into parts; a missing file has none."""
    return SplicedText(path, ()) if content is None else SplicedText.read(path, content)


def by_file(edits: Sequence[PackEdit]) -> dict[Path, list[Change]]:
    """Group edits by their file."""
    changes: dict[Path, list[Change]] = {}
    for path, loc, value in edits:
        changes.setdefault(path, []).append((tuple(loc), value))
    return changes
