"""Records of builds with outputs, inputs and needs: an SQLite file beside the project.

A record is written before its outputs are renamed into place, and keeps the digest of the output
that was there before. So a build killed at any moment can tell its own files from edited ones.
"""

import json
import os
import sqlite3
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from functools import lru_cache
from pathlib import Path
from sys import intern
from typing import Any, NamedTuple, Self

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError, OutputError
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.base.files.writing import cannot_write
from lipsync_lang.production.builds.planned_line import JudgedFigure, Verdict
from lipsync_lang.production.builds.unchanged import FOLDER, RECORDS_FILE

RECORD_CURE = "copy the project to another folder, since a build keeps its record there"

ROWS = 200
"""Number of rows to read at once."""

RECORDS_VERSION = 3
"""Form of the tables; a record of another form is put aside."""

Key = tuple[str, str, str]
"""Language, character and name of a line."""

NEED = np.dtype([("number", "<u4"), ("digest", "<u8")])
"""A need of a line: its number in the record, and the digest of its value."""

TABLES = """
CREATE TABLE IF NOT EXISTS need (number INTEGER PRIMARY KEY, name TEXT NOT NULL UNIQUE);
CREATE TABLE IF NOT EXISTS line (
  language TEXT NOT NULL, character TEXT NOT NULL, name TEXT NOT NULL,
  at INTEGER NOT NULL, inputs TEXT NOT NULL, contents TEXT NOT NULL, needs BLOB NOT NULL,
  outputs TEXT NOT NULL, verdict TEXT NOT NULL, confidence REAL,
  heading TEXT NOT NULL, figures BLOB NOT NULL, result TEXT NOT NULL,
  PRIMARY KEY (language, character, name)
) WITHOUT ROWID;
"""

SELECT_RESULT = "SELECT result FROM line WHERE language = ? AND character = ? AND name = ?"

SELECT_LACKING = (
    "SELECT language, character, name FROM line "
    "WHERE json_valid(result) AND json_array_length(result, '$[4]') > 0"
)

SELECT_OUTPUTS = SELECT_RESULT.replace("result", "outputs")

DELETE_LINE = "DELETE FROM line WHERE language = ? AND character = ? AND name = ?"

_ENCODER = json.JSONEncoder(ensure_ascii=False, separators=(",", ":"))


class OutputRecord(NamedTuple):
    """An output as a build left it."""

    size: int
    changed: int
    """Time of its last change in nanoseconds; the CRC of a member of an archive."""
    digest: str
    before: str = ""
    """Digest of the file that it replaced; empty for none."""


class LineRecord(NamedTuple):
    """Inputs of a line as it was made, and its outcome.

    Parameters
    ----------
    inputs : statements of the project on the line, and sizes and times of its files; JSON
    contents : digest of each file that it was made from, by path; JSON
    needs : bytes of (n,) `NEED`: needs with their digests
    outputs : by path from the project's folder
    heading, figures : figures of quality, as `packed_figures` has them
    result : the rest of a `BuiltLine` as JSON; words that the recording lacks are its fifth part
    at : time of its making in nanoseconds
    """

    inputs: str
    contents: str
    needs: bytes
    outputs: Mapping[str, OutputRecord]
    verdict: Verdict
    confidence: float | None
    heading: str
    figures: bytes
    result: str = ""
    at: int = 0


class Records:
    """The record of a project's builds."""

    def __init__(self, path: Path, connection: sqlite3.Connection) -> None:
        self.path = path
        self._base = connection
        self.numbers: dict[str, int] = dict(
            connection.execute("SELECT name, number FROM need").fetchall()
        )
        self.names: dict[int, str] = {number: name for name, number in self.numbers.items()}
        self._new: list[tuple[int, str]] = []
        """Needs that are written with the next lines."""

    @classmethod
    @contextmanager
    def open(cls, folder: Path, *, write: bool = True, part: str = "") -> Iterator[Self]:
        """Open the record of a project's folder; without one, or only to read, one in memory.

        A `part` of the project, such as a shard, has a record of its own.
        """
        path = record_folder(folder) / part / RECORDS_FILE
        with ExitStack() as stack:
            try:
                if write:
                    path.parent.mkdir(parents=True, exist_ok=True)
                    ignore = path.with_name(".gitignore")
                    if not ignore.exists():
                        ignore.write_text("*\n", encoding="utf-8")
                kept = write or path.is_file()
                fixed = not write and _fixed(path)
                where = f"{path.absolute().as_uri()}?immutable=1" if fixed else path
                connection = sqlite3.connect(where if kept else ":memory:", timeout=60, uri=fixed)
                stack.enter_context(closing(connection))
                if write:
                    # Readers, such as a dry run, do not wait for a build that writes.
                    connection.execute("PRAGMA journal_mode = WAL")
                    connection.execute("PRAGMA synchronous = FULL")
                elif kept:
                    # The database may be a stranger's: no statement of it may write.
                    connection.execute("PRAGMA query_only = ON")
                _check_form(path, connection)
                if write or not kept:
                    connection.executescript(TABLES)
                    connection.execute(f"PRAGMA user_version = {RECORDS_VERSION}")
                    connection.commit()
            except sqlite3.DatabaseError as error:
                raise _damaged(path, error) from None
            except OSError as error:
                raise cannot_write(path, error, RECORD_CURE) from None
            try:
                yield cls(path, connection)
            except sqlite3.DatabaseError as error:
                raise _damaged(path, error) from None

    def blocks(self) -> Iterator[list[tuple[Key, LineRecord]]]:
        """Yield every record without its result, some at a time."""
        cursor = self._base.execute(
            "SELECT language, character, name, outputs, at, inputs, contents, needs, verdict, "
            "confidence, heading, figures FROM line"
        )
        try:
            while rows := cursor.fetchmany(ROWS):
                found: list[tuple[Key, LineRecord]] = []
                # Many outputs at once take half the time.
                outputs = json.loads(f"[{','.join([row[3] for row in rows])}]")
                for row, written in zip(rows, outputs, strict=True):
                    at, inputs, contents, needs, verdict, confidence, heading, figures = row[4:]
                    # SQLite keeps any type in any column, and a bool would pass `isinstance`.
                    types = type(at), type(figures), type(needs), type(confidence or 0.0)
                    if types != (int, bytes, bytes, float) or len(needs) % NEED.itemsize:
                        raise unusable()
                    paths = {path: OutputRecord(*one) for path, one in written.items()}
                    known = inputs, contents, needs, paths, verdict, confidence
                    found.append((row[:3], LineRecord(*known, intern(heading), figures, "", at)))
                yield found
        except (ValueError, TypeError, AttributeError, RecursionError):
            raise unusable() from None

    def result(self, key: Key) -> Any:
        """Return the result of a line."""
        row = self._base.execute(SELECT_RESULT, key).fetchone()
        return from_json(row and row[0], list)

    def lacking(self) -> set[Key]:
        """Return the lines whose recordings lack words of their texts."""
        return {*self._base.execute(SELECT_LACKING)}

    def outputs(self, key: Key) -> dict[str, OutputRecord]:
        """Return the outputs of a line by path, as the last build left them."""
        (text,) = self._base.execute(SELECT_OUTPUTS, key).fetchone() or ("{}",)
        return {path: OutputRecord(*one) for path, one in from_json(text).items()}

    def name(self, number: int) -> str:
        """Return the name of a need."""
        if number not in self.names:
            raise unusable()
        return self.names[number]

    def packed(self, needs: Mapping[str, bytes]) -> bytes:
        """Number the needs that are new, and return all as bytes of `NEED`."""
        for name in [name for name in needs if name not in self.numbers]:
            number = len(self.numbers)
            self.numbers[name], self.names[number] = number, name
            self._new.append((number, name))
        out = np.empty(len(needs), NEED)
        out["number"] = [self.numbers[name] for name in needs]
        out["digest"] = np.frombuffer(b"".join(needs.values()), "<u8")
        return out.tobytes()

    def put(self, records: Iterable[tuple[Key, LineRecord]]) -> None:
        """Write records in one transaction, safe from a loss of power."""
        now = time.time_ns()
        self._base.executemany("INSERT INTO need (number, name) VALUES (?, ?)", self._new)
        self._new.clear()
        self._base.executemany(
            "INSERT OR REPLACE INTO line VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
            [
                (*key, now, one.inputs, one.contents, one.needs, as_json(one.outputs),
                 one.verdict, one.confidence, one.heading, one.figures, one.result)
                for key, one in records
            ],
        )  # fmt: skip
        self._base.commit()

    def forget(self, keys: Iterable[Key]) -> None:
        """Delete records."""
        self._base.executemany(DELETE_LINE, list(keys))
        self._base.commit()


def record_folder(project: Path) -> Path:
    """Return the folder of the records of a project; a link out of the project is refused."""
    found = project / FOLDER
    for path in (found, *found.glob("*")):
        refuse_outside(path, project)
    return found


def as_json(value: object) -> str:
    """Return a value as the record holds it."""
    return _ENCODER.encode(value)


def from_json(text: Any, kind: type = dict) -> Any:
    """Return a value from the JSON of `as_json`; a record may be damaged, or a stranger's."""
    try:
        value = json.loads(text)
    except (ValueError, TypeError, RecursionError):
        raise unusable() from None
    if not isinstance(value, kind):
        raise unusable()
    return value


def packed_figures(figures: Sequence[JudgedFigure]) -> tuple[str, bytes]:
    """Return name, unit and binding of figures as JSON, and bytes of their values and limits."""
    numbers = [one.value for one in figures], [one.limit for one in figures]
    heading = _heading(tuple([(one.name, one.unit, one.binding) for one in figures]))
    return heading, np.array(numbers, "<f8").tobytes()  # None is not a number


@lru_cache(64)
def _heading(heads: tuple[tuple[str, str, bool], ...]) -> str:
    return intern(as_json(heads))


def unpacked_figures(
    heading: str, figures: Sequence[bytes]
) -> tuple[Floats, Floats, list[tuple[str, str, bool]]]:
    """Return (L, F) values and limits of L lines with the same heading, and the heading."""
    try:
        heads = _heads(heading)
        numbers = np.frombuffer(b"".join(figures), "<f8").reshape(len(figures), 2, len(heads))
    except (ValueError, TypeError, RecursionError):
        raise unusable() from None
    return numbers[:, 0], numbers[:, 1], heads


@lru_cache(64)
def _heads(heading: str) -> list[tuple[str, str, bool]]:
    return [(str(name), str(unit), bool(own)) for name, unit, own in json.loads(heading)]


def unusable(
    why: object = "it is damaged", path: str | Path = f"{FOLDER}/{RECORDS_FILE}"
) -> LipsyncError:
    """Return the error for a record that is damaged or foreign."""
    return LipsyncError(
        f"{path}: the record of builds cannot be used ({why}); move it away: the next build "
        "compares the existing files with new ones, and keeps those that differ"
    )


def _fixed(path: Path) -> bool:
    """Return True if nobody changes a database: SQLite opens none in a folder without rights."""
    log = path.with_name(f"{path.name}-wal")
    return path.is_file() and not log.exists() and not os.access(path.parent, os.W_OK)


def _check_form(path: Path, connection: sqlite3.Connection) -> None:
    (form,) = connection.execute("PRAGMA user_version").fetchone()
    if form not in (0, RECORDS_VERSION):
        raise LipsyncError(
            f"{path}: was written by another version of this program (form {form}, known "
            f"{RECORDS_VERSION}); move it away: "
            "the next build compares the existing files with new ones"
        )


def _damaged(path: Path, error: sqlite3.DatabaseError) -> LipsyncError:
    if isinstance(error, sqlite3.OperationalError):  # a full disk, a folder without rights
        return OutputError(
            f"{path}: cannot be written: {error}; a build keeps its record there: make room, and "
            "make the folder writable"
        )
    return unusable(error, path)
