"""Formats of scripts, and the reading of files and folders."""

import os
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO, NamedTuple, Self

from lipsync_lang.base.errors import MAX_KNOWN, LipsyncError, ScheduleError, shortlist
from lipsync_lang.base.extensions import Format, Formats
from lipsync_lang.base.files import STANDARD_STREAM, argument_path
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.base.files.reading import MIB_BYTES, marked_encoding, read_blocks, read_input
from lipsync_lang.text.lines.cleaning import AS_WRITTEN, Cleaning
from lipsync_lang.text.lines.markup import spoken

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Schedule


MAX_PIPED_BYTES = 64 * MIB_BYTES
"""Maximum size of a script from a pipe, which is held in memory; files have no limit."""

SCHEDULE_FORMAT = "schedule"
"""Format of the lines that are files of timings."""

Remark = Callable[[str], None]
"""Receiver of remarks that are not faults."""


MAX_LINE_CHARS = 1_000_000
"""Maximum length of a line, in characters."""


OpenFile = Callable[[], BinaryIO]
"""Function that opens a file at its start; called more than once."""


def numbered(
    path: Path, opened: OpenFile, encoding: str | None = None
) -> Iterator[tuple[int, str]]:
    """Yield (number from 1, line without its end) for the lines of a file, one in memory at a time.

    The encoding is the one given, or that of the file's byte-order mark, or UTF-8; line ends may be
    mixed.
    `path` is for messages only. Raises LipsyncError if the file cannot be read, is not text, or is
    in another encoding.
    """
    try:
        with opened() as stream:
            chosen = encoding or marked_encoding(stream.read(4)) or "utf-8-sig"
        with opened() as stream, TextIOWrapper(stream, chosen, newline=None) as text:
            # A file without line ends must not fill the memory.
            lines = iter(partial(text.readline, MAX_LINE_CHARS), "")
            for number, line in enumerate(lines, 1):
                if "\0" in line:
                    raise LipsyncError(
                        f"{path}:{number}: has zero bytes, so it is not text; leave the file out, "
                        "or, if it is UTF-16 without its mark, state `encoding='utf-16-le'`"
                    )
                if len(line) == MAX_LINE_CHARS:
                    raise LipsyncError(
                        f"{path}:{number}: this line is longer than {MAX_LINE_CHARS:,} characters; "
                        "check that it is a script"
                    )
                yield number, line.removesuffix("\n")
    except UnicodeError as error:
        raise LipsyncError(_misread(path, opened, encoding, chosen, error)) from None
    except LookupError:
        raise LipsyncError(
            f"`encoding={encoding!r}`: unknown encoding; try utf-8, utf-16, cp1252 or shift_jis"
        ) from None
    # ValueError: a path with a zero byte.
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise LipsyncError(f"{path}: cannot be read: {why}; check the path") from None


def _misread(
    path: Path, opened: OpenFile, asked: str | None, chosen: str, error: UnicodeError
) -> str:
    where, number = str(path), 0
    if chosen == "utf-8-sig":  # the error tells of a chunk, not of the line
        with opened() as stream:
            for number, line in enumerate(stream, 1):  # noqa: B007 the last one, if none is faulty
                try:
                    line.decode()
                except UnicodeDecodeError:
                    break
        where = f"{path}:{number}"
    why = getattr(error, "reason", error)
    if asked:
        return f"{where}: is not {asked} ({why}); name another `encoding`, or save it as UTF-8"
    if chosen != "utf-8-sig":
        mark = f"starts with the mark of {chosen.upper()} but is not valid ({why})"
        return f"{where}: {mark}; save it as UTF-8"
    return (
        f"{where}: is not UTF-8 ({why}), and has no mark of UTF-16 or UTF-32 at its start; name "
        "its encoding (`encoding='cp1252'`), save it as UTF-8, or leave it out if it is not text"
    )


@dataclass(frozen=True)
class Line:
    """A line of a script.

    Parameters
    ----------
    text : the spoken text, without markup and placeholders
    place : `file:line`
    name : the line's own name in its file; may be empty
    speaker : the speaker's name; empty if unknown
    schedule : its timed phonemes, if the file has some
    dropped : markup and placeholders that are not spoken, in order
    gaps : offsets in the text, in order, of speech that the file does not contain
    original : the text that this one translates; empty if the file does not have it
    """

    text: str
    place: str
    name: str = ""
    speaker: str = ""
    schedule: "Schedule | None" = None
    dropped: tuple[str, ...] = ()
    gaps: tuple[int, ...] = ()
    original: str = ""

    @property
    def file(self) -> str:
        """The file in its place."""
        return self.place.rpartition(":")[0]


class TableLayout(NamedTuple):
    """Start of a table, if its form does not tell."""

    sheet: str | None = None
    """Title of the only sheet of a spreadsheet that is read."""
    header_row: int | None = None
    """Number of the row that names the columns; rows above are left out."""


AS_FOUND = TableLayout()


@dataclass(frozen=True)
class LineFile:
    """A file that is read into lines, with the settings of `read_lines`.

    `content` is that of standard input or a pipe, which can be read only once; None for a file.
    """

    path: Path
    remark: Remark
    column: str | None = None
    encoding: str | None = None
    content: bytes | None = None
    cleaning: Cleaning = AS_WRITTEN
    names: tuple[str, ...] = ()
    speaker: str | None = None
    layout: TableLayout = AS_FOUND

    def at(self, path: Path) -> Self:
        """Return a file with these settings; a pipe is read now, since it can be read only once."""
        piped = path == STANDARD_STREAM or not path.is_file()
        mend = "put the script into a file"
        content = read_input(path, MAX_PIPED_BYTES, mend=mend) if piped else None
        return replace(self, path=path, content=content)

    def open(self) -> BinaryIO:
        """Return its bytes from the start."""
        return self.path.open("rb") if self.content is None else BytesIO(self.content)

    def numbered(self) -> Iterator[tuple[int, str]]:
        """Yield the lines of its text with their numbers."""
        return numbered(self.path, self.open, self.encoding)

    def line(
        self, number: int | str, text: str, *, name: str = "", speaker: str = "", original: str = ""
    ) -> Line:
        """Return the spoken text, markup removed."""
        said, dropped, gaps, remarks = spoken(text, self.cleaning)
        place = f"{self.path}:{number}"
        for remark in remarks:
            self.remark(f"{place}: {remark}")
        return Line(said, place, name, speaker, dropped=dropped, gaps=gaps, original=original)

    def fault(self, number: int | str, what: str) -> LipsyncError:
        """Return an error with the place."""
        return LipsyncError(f"{self.path}:{number}: {what}")


ReadLines = Callable[[LineFile], Iterable[Line]]


class Table(NamedTuple):
    """A table: the names of its columns, and each row with its line in the file."""

    head: list[str]
    rows: Generator[tuple[int | str, Sequence[str]]]


OpenTable = Callable[[LineFile], Table]


@dataclass(frozen=True)
class LineReader(Format):
    """A script format and its reader."""

    read: ReadLines
    table: OpenTable | None = None
    """Function that opens a table, whose text is in `column`; None for files without columns."""


@dataclass(frozen=True)
class StatedScript(ABC):
    """A format of scripts, stated as data; several names or paths have bars between them."""

    name: str
    title: str
    suffixes: Sequence[str] = ()
    text: str = ""
    """Path of the text in an entry; in JSON empty for trees, where every text is an entry."""
    original: str = ""
    id: str = ""
    """Path of the identifier; in JSON the keys on the way by default."""
    speaker: str = ""
    note: str = ""
    state: str = ""
    unready: Sequence[str] = ()
    """States of an entry that is not translated."""

    def reader(self) -> LineReader:
        """Return the reader of the format."""
        return LineReader(self.name, (*self.suffixes,), self.title, self.read)

    @abstractmethod
    def read(self, source: LineFile) -> Iterator[Line]:
        """Yield the lines of a file."""


JSON_SUFFIX = ".json"

LINE_READERS: Formats[LineReader] = Formats("line_readers", "format", package=__package__)


def reader(
    name: str, *, suffixes: Sequence[str], table: OpenTable | None = None
) -> Callable[[ReadLines], ReadLines]:
    """Register a function ``(source) -> lines`` as the reader of a format."""
    return LINE_READERS.adding(
        lambda title, read: LineReader(name, tuple(suffixes), title, read, table)
    )


@cache
def by_suffix() -> dict[str, LineReader]:
    """Return the reader of each suffix, tables first; text formats win over timed phonemes."""
    known: dict[str, LineReader] = {}
    order = sorted(LINE_READERS.values(), key=lambda one: one.table is None)
    for one in sorted(order, key=lambda one: one.name == SCHEDULE_FORMAT):
        for suffix in one.suffixes:
            known.setdefault(suffix, one)
    return known


def _warn(remark: str) -> None:
    warnings.warn(remark, stacklevel=3)


def read_lines(  # noqa: PLR0913 the files, and options by keyword
    paths: str | Path | Iterable[str | Path],
    *,
    column: str | None = None,
    encoding: str | None = None,
    remark: Remark = _warn,
    cleaning: Cleaning = AS_WRITTEN,
    names: Sequence[str] = (),
    speaker: str | None = None,
    layout: TableLayout = AS_FOUND,
    elsewhere: Sequence[str] = (),
) -> Iterator[Line]:
    """Read the lines of files, and of folders with all below them in order of name.

    Raises LipsyncError if a path is missing or of no known format (at once), or a file cannot be
    read (when it is its turn). Files of a folder that are of no known format are left out with a
    remark.

    Parameters
    ----------
    paths : files and folders, one or several; a file twice is read once. ``-`` is standard input:
        plain text, or a table where a `column` is named
    column : of tables, the text's, by name or number from 1; None for the likeliest
    encoding : of all files; None for UTF-8, or what a file's own mark says
    remark : where to say what was left out; as warnings where nothing is given
    cleaning : values of placeholders, and what is not spoken
    names : of the language: its name, title, tag and aliases; a column with one of them is the text
    speaker : column of the speakers, by name or number from 1; None for the likeliest
    layout : of tables, the sheet and the row that names the columns
    elsewhere : suffixes of files in folders that the caller reads itself, without a remark
    """
    found = line_files(paths, remark, elsewhere=elsewhere)
    tables = (file == STANDARD_STREAM or _format_of(file).table is not None for file, _ in found)
    if column is not None and not any(tables):
        remark(f"`column={column!r}`: not used, because no file is a table")
    stated = LineFile(Path(), remark, column, encoding, None, cleaning, (*names,), speaker, layout)
    return _read(found, stated)


def line_files(
    paths: str | Path | Iterable[str | Path],
    remark: Remark = _warn,
    *,
    project: Path | None = None,
    elsewhere: Sequence[str] = (),
) -> list[tuple[Path, bool]]:
    """List the files that lines are read from, each once, with True for those found in a folder.

    Files of a `project` must not be links out of its folder. Raises LipsyncError if a path is
    missing or of no known format.
    """
    found: dict[str, tuple[Path, bool]] = {}
    for path in map(argument_path, [paths] if isinstance(paths, (str, Path)) else paths):
        known = path == STANDARD_STREAM or path.suffix.lower() in by_suffix()
        if project is not None:
            refuse_outside(path, project)
        if path != STANDARD_STREAM and not path.exists():
            raise LipsyncError(f"{path}: no such file or folder; check the path")
        if not known and not path.is_dir():
            what = f"no reader of lines for '{path.suffix}'" if path.suffix else "has no suffix"
            raise LipsyncError(f"{path}: {what}; known: {', '.join(sorted(by_suffix()))}")
        for file in _below(path, remark, elsewhere) if path.is_dir() else [path]:
            if project is not None and file.is_symlink():
                refuse_outside(file, project)
            found.setdefault(os.path.realpath(file), (file, path.is_dir()))
    return list(found.values())


def heads(
    paths: str | Path | Iterable[str | Path],
    encoding: str | None = None,
    layout: TableLayout = AS_FOUND,
) -> dict[Path, list[str]]:
    """Return the names of the columns of each table among some files.

    Standard input, which can be read only once, is left out.
    """
    found: dict[Path, list[str]] = {}
    for path, _ in line_files(paths, lambda _: None):
        opens = None if path == STANDARD_STREAM else _format_of(path).table
        if opens is not None and path.is_file():
            source = LineFile(path, lambda _: None, encoding=encoding, layout=layout)
            if not is_timed(source):
                found[path] = opens(source).head
    return found


def is_timed(source: LineFile, *, unreadable: bool = False) -> bool:
    """Test whether a file begins like a format of timed phonemes with its suffix.

    JSON is read as a whole, because its start alone is not JSON. The result is `unreadable` for a
    file that cannot be read and for damaged JSON, which may be timings or something else.
    """
    from lipsync_lang.schedules.timing_file import HEAD_BYTES, MAX_TIMINGS_BYTES, TimingFile
    from lipsync_lang.schedules.timing_readers import TIMING_READERS

    # Subtitles have times as well, but each of their cues is a line.
    kinds = [one for one in TIMING_READERS.ending(source.path) if not one.script]
    if not kinds:
        return False
    try:
        with source.open() as stream:
            begins = TimingFile(source.path, stream.read(HEAD_BYTES))
            is_json = begins.head.lstrip()[:1] in {"{", "["}
            if is_json:
                rest = b"".join(read_blocks(stream, MAX_TIMINGS_BYTES))
                begins = TimingFile(source.path, begins.content + rest)
    except OSError:
        return unreadable
    damaged = is_json and begins.document is None and source.path.suffix.lower() == JSON_SUFFIX
    return any(one.sniff(begins) for one in kinds) or (damaged and unreadable)


def _format_of(path: Path) -> LineReader:
    return by_suffix()[path.suffix.lower()]


def _below(folder: Path, remark: Remark, elsewhere: Sequence[str]) -> Iterator[Path]:
    """Yield the readable files of a folder, and report the others by suffix."""
    others: dict[str, list[Path]] = {}

    def refused(error: OSError) -> None:
        remark(f"{error.filename}: left out: {error.strerror}")

    for here, folders, files in os.walk(folder, onerror=refused):
        hidden = [name for name in (*folders, *files) if name.startswith(".")]
        if hidden:
            remark(f"{here}: hidden files are left out: {shortlist(sorted(hidden), MAX_KNOWN)}")
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(set(files) - set(hidden)):
            path = Path(here, name)
            if path.suffix.lower() in by_suffix():
                yield path
            elif path.suffix.lower() not in elsewhere:
                others.setdefault(path.suffix.lower(), []).append(path)
    for suffix, left in sorted(others.items()):
        what = f"'{suffix}'" if suffix else "files without a suffix"
        more = f" and {len(left) - 1} more" if len(left) > 1 else ""
        remark(f"{left[0]}{more}: left out: no reader for {what}")


def _read(files: Iterable[tuple[Path, bool]], stated: LineFile) -> Iterator[Line]:
    """Yield the lines of files, read by their suffix, or as timings if they begin like them."""
    for path, among_others in files:
        source = stated.at(path)
        try:
            if path == STANDARD_STREAM:
                form = LINE_READERS["text" if source.column is None else "table"]
            else:
                timed = source.column is None and is_timed(source)
                form = LINE_READERS[SCHEDULE_FORMAT] if timed else _format_of(path)
            yield from form.read(source)
        except ScheduleError as error:
            # A file that was named must be sound; one of a folder may be something else.
            if not among_others:
                raise
            what = str(error).split("\n", 1)[0].removesuffix(":")
            stated.remark(f"{what}; left out")
