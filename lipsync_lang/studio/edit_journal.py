"""Journal of unsaved edits, from which the studio restores them after a crash.

Each line is JSON. Each edit appends a line, so a crash loses at most the last line. A save writes
the journal before it puts its files in place: the texts of the files, and a last line that names
them. If the studio is killed in between, its next start completes the save.
"""

import json
import os
from collections.abc import Iterable, Mapping
from hashlib import sha256
from itertools import zip_longest
from pathlib import Path
from typing import Any

from lipsync_lang.errors import LipsyncError
from lipsync_lang.files import atomic
from lipsync_lang.files.renaming import replace_file
from lipsync_lang.json_object import Json
from lipsync_lang.packs.splicing import ABSENT, plain
from lipsync_lang.studio.sheets import EditedFile, PackEdit

JOURNAL_HEADER = {"journal": "lipsync-lang studio", "format": 1}
"""First line of a journal."""

MAX_JOURNAL_BYTES = 64 * 2**20
"""Maximum size of a journal."""

MAX_JOURNAL_LINES = 250
"""Lines after which a journal is rewritten with texts only; a line takes 10 ms to read."""


class JournalError(LipsyncError):
    """A journal is damaged, or belongs to another program."""


class JournalKeeper:
    """A journal that is open for edits.

    Parameters
    ----------
    path : the file
    lines : number of its lines
    opened : files whose content it has

    Attributes
    ----------
    stale : True if the disk has other content of a file than the journal
    """

    def __init__(self, path: Path, lines: int, opened: set[Path]) -> None:
        self.path = path
        self.stale = False
        self._lines = lines
        self._opened = opened
        self._last: tuple[Json, int] | None = None

    @property
    def full(self) -> bool:
        """True if the journal should be rewritten for the next edit."""
        return self.stale or self._lines >= MAX_JOURNAL_LINES

    def add(self, line: Json, sheets: Iterable[EditedFile]) -> None:
        """Append a line, after the contents of files that are new to the journal."""
        new = [sheet for sheet in sheets if sheet.path not in self._opened]
        self._opened |= {sheet.path for sheet in new}
        again = self._last is not None and not new and _states_again(self._last[0], line)
        self._lines += not again
        at = self._last[1] if self._last is not None and again else None
        self._last = line, append(self.path, [*map(base_line, new), line], at)

    def rewrite(self, edited: Iterable[EditedFile], *more: Json) -> None:
        """Rewrite the journal with only the texts of files, and some lines after them."""
        kept = [*edited]
        lines = [*(line for sheet in kept for line in whole(sheet)), *more]
        write_journal(self.path, lines)
        self._opened = {sheet.path for sheet in kept}
        self._lines, self.stale, self._last = len(lines), False, None


def read_journal(path: Path) -> list[Json]:
    """Return the lines of a journal without its header; a torn last line is cut off the file.

    Raises
    ------
    JournalError
        The file is not a journal, or is damaged before its last line.
    """
    try:
        with path.open("rb") as stream:
            content = stream.read(MAX_JOURNAL_BYTES + 1)
    except FileNotFoundError:
        return []
    except OSError as error:
        raise JournalError(f"cannot be read: {error.strerror or error}") from None
    if len(content) > MAX_JOURNAL_BYTES:
        raise JournalError(f"is larger than {MAX_JOURNAL_BYTES >> 20} MB")
    *rows, torn = content.split(b"\n")
    if not rows:
        raise JournalError("is damaged")
    try:
        header, *lines = map(json.loads, rows)
    except (ValueError, RecursionError):
        raise JournalError("is damaged") from None
    if header != JOURNAL_HEADER or not all(isinstance(line, dict) for line in lines):
        raise JournalError("is not a journal of the studio")
    if torn:
        write_journal(path, lines)
    return lines


def write_journal(path: Path, lines: Iterable[Json]) -> None:
    """Rewrite a journal; raise `OutputError` if that fails."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic(path, durable=True) as stream:
        for line in (JOURNAL_HEADER, *lines):
            stream.write(_row(line))


def append(path: Path, lines: Iterable[Json], at: int | None = None) -> int:
    """Append lines to a journal, and return the position of the last one.

    Parameters
    ----------
    at : start of the last line so far, if the new ones take its place
    """
    if not path.exists():
        write_journal(path, ())
    rows = [_row(line) for line in lines]
    with path.open("r+b") as stream:
        stream.seek(0, os.SEEK_END) if at is None else stream.truncate(stream.seek(at))
        stream.write(b"".join(rows))
        return stream.tell() - len(rows[-1])


def put_aside(path: Path) -> Path:
    """Rename a file that is not a valid journal, and return its new path."""
    names = (path.with_name(f"{path.name}.damaged{number or ''}") for number in range(10**6))
    free = next(name for name in names if not name.exists())
    replace_file(path, free)
    return free


def _row(line: Mapping[str, Any]) -> bytes:
    return json.dumps(line, ensure_ascii=False, separators=(",", ":")).encode() + b"\n"


def _states_again(last: Json, line: Json) -> bool:
    """Return True if a line replaces the one before it, as the next move of the same drag."""
    drag = "merge" in line and line["merge"] and not last.get("create", True)
    keys = ("change", "merge", "tab")
    return bool(drag) and all(
        [last[key] for key in keys] == [line[key] for key in keys]
        and (one["file"], one["at"]) == (other["file"], other["at"])
        for one, other in zip_longest(
            last["edits"], line["edits"], fillvalue={"file": "", "at": ()}
        )
    )


# Lines


def line_of(edit: PackEdit) -> Json:
    """Return an edit as JSON."""
    path, loc, value = edit
    stated = {} if value is ABSENT else {"value": plain(value)}
    return {"file": str(path), "at": list(loc), **stated}


def edit_of(line: Json) -> PackEdit:
    """Return the edit in a line."""
    return Path(line["file"]), tuple(line["at"]), line.get("value", ABSENT)


def save_line(before: Mapping[Path, bytes | None]) -> Json:
    """Return the line of a begun save: the digest of what each file holds until then."""
    return {"save": {str(path): digest(content) for path, content in before.items()}}


def digest(content: bytes | None) -> str:
    """Return the digest of a file's content; empty for no file."""
    return "" if content is None else sha256(content).hexdigest()


def whole(sheet: EditedFile) -> list[Json]:
    """Return the lines that restore a file: its saved content, and its content with edits."""
    text = sheet.text.content.decode()
    return [
        base_line(sheet),
        {"put": str(sheet.path), "text": text},
    ]


def base_line(sheet: EditedFile) -> Json:
    """Return the line with the saved content of a file."""
    return {"base": str(sheet.path), "text": None if sheet.base is None else sheet.base.decode()}
