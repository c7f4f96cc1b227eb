"""Sheets of spreadsheets, as tables.

The first sheet whose columns have names of a script is read, else the first one with cells. So are
all others that have the same columns, such as a sheet for each scene; a remark names the rest.
Formulas count as the values that the program stored with them.
"""

from collections.abc import Generator, Iterator, Sequence
from contextlib import closing
from itertools import chain, dropwhile, islice
from typing import Any, NamedTuple
from zipfile import BadZipFile, ZipFile

from lipsync_lang.base.errors import MAX_KNOWN, LipsyncError, shortlist
from lipsync_lang.base.extras import needing
from lipsync_lang.base.files.reading import MIB_BYTES
from lipsync_lang.text.lines.columns import (
    MAX_TITLE_ROWS,
    NAME_COLUMNS,
    SPEAKER_COLUMNS,
    TEXT_COLUMNS,
    first_column,
    head_row,
)
from lipsync_lang.text.lines.line_readers import Line, LineFile, Table, reader
from lipsync_lang.text.lines.table import NO_HEAD, below_title, lines_of

KNOWN_COLUMNS = (*NAME_COLUMNS, *TEXT_COLUMNS, *SPEAKER_COLUMNS)
"""Names of columns that tell a sheet of a script from a cover."""

MAX_PART_BYTES = 512 * MIB_BYTES
"""Maximum unpacked size of a part of the file; a million rows have less."""

MAX_SHEET_ROWS = 1_048_576
"""Maximum number of rows of a sheet; no program stores more, so more rows are damage."""

MAX_COLUMNS = 1_024
"""Maximum number of columns; no script has more."""


def open_sheets(source: LineFile) -> Table:
    """Read the head of the first sheet of a script; the rows follow one by one."""
    before: list[str] = []
    wanted, number = source.layout
    sheets = (_below_titles(sheet, number) for sheet in _sheets(source))
    for sheet in sheets:
        if sheet.title == wanted and sheet.head:
            return Table(sheet.head, _rows(source, sheet, iter(()), []))
        if wanted is None and first_column(sheet.head, KNOWN_COLUMNS) >= 0:
            return _table(source, sheet, sheets, before)
        before += [sheet.title] if sheet.head else []
    if wanted is not None:
        known = shortlist(before, MAX_KNOWN)
        raise source.fault(1, f"has no sheet '{wanted}' with cells. Its sheets: {known}")
    # The sheets are read again, because a stream of a script of any size has no way back.
    sheets = (_below_titles(sheet, number) for sheet in _sheets(source))
    for sheet in sheets:
        if sheet.head:
            return _table(source, sheet, sheets, [])
    raise source.fault(number or 1, NO_HEAD)


@reader("xlsx", suffixes=[".xlsx"], table=open_sheets)
def read(source: LineFile) -> Iterator[Line]:
    """Spreadsheets, whose first row names the columns; `--column` says which is the text."""
    return lines_of(source, open_sheets(source))


SheetRow = tuple[int, list[str]]


class Sheet(NamedTuple):
    """A sheet from the row of its columns' names on."""

    title: str
    start: int
    """Number of the row of names."""
    head: list[str]
    """Names of the columns; none in a sheet without cells."""
    rows: Iterator[SheetRow]
    titled: bool
    """True if rows above the names are left out."""


def _table(source: LineFile, sheet: Sheet, others: Iterator[Sheet], before: list[str]) -> Table:
    if sheet.titled:
        source.remark(below_title(source, sheet.start))
    return Table(sheet.head, _rows(source, sheet, others, before))


def _rows(
    source: LineFile, sheet: Sheet, others: Iterator[Sheet], before: list[str]
) -> Generator[tuple[int | str, Sequence[str]]]:
    """Yield the rows of a sheet, and those of the others with its columns."""
    yield from sheet.rows
    left = [*before]
    for other in others:
        if other.head == sheet.head:
            yield from ((f"{other.title}!{number}", row) for number, row in other.rows)
        elif other.head:
            left.append(other.title)
    if left:
        names = shortlist(left, MAX_KNOWN)
        told = f"{source.path}: left out {names}: the columns differ from those of {sheet.title}"
        source.remark(told)


def _below_titles(sheet: tuple[str, Iterator[SheetRow]], stated: int | None) -> Sheet:
    title, rows = sheet
    if stated:
        rows = dropwhile(lambda row: row[0] < stated, rows)
    top = list(islice(rows, 1 if stated else MAX_TITLE_ROWS))
    at = head_row([row for _, row in top])
    number, names = top[at] if top else (1, [])
    head = [name.strip() for name in names]
    while head and not head[-1]:
        head.pop()
    return Sheet(title, number, head, chain(top[at + 1 :], rows), at > 0)


def _sheets(source: LineFile) -> Iterator[tuple[str, Iterator[SheetRow]]]:
    """Yield the title and the rows of each sheet, in order."""
    more = "; or save them as .csv"
    with needing(LipsyncError, "spreadsheets need openpyxl:", "tables", more):
        import openpyxl
    with source.open() as stream:
        try:
            # `zipfile` unpacks at most the size that a part states.
            with ZipFile(stream) as parts:
                largest = max((part.file_size for part in parts.infolist()), default=0)
        except (BadZipFile, OSError, ValueError, NotImplementedError) as error:
            raise _damaged(source, error) from None
        if largest > MAX_PART_BYTES:
            size = f"{largest // MIB_BYTES:,} MiB"
            raise source.fault(1, f"unpacks to {size}; save the script as a table (.csv)")
        stream.seek(0)
        try:
            book = openpyxl.load_workbook(stream, read_only=True, data_only=True, keep_links=False)
        except Exception as error:  # noqa: BLE001 damage shows anywhere in the library
            raise _damaged(source, error) from None
        with closing(book):
            for sheet in book.worksheets:
                yield sheet.title, _cells(source, sheet)


def _cells(source: LineFile, sheet: Any) -> Iterator[SheetRow]:
    """Yield (number, cells) of the rows that are not empty."""
    try:
        sheet.reset_dimensions()  # the size that a file states may be wrong
        for number, row in enumerate(islice(sheet.iter_rows(values_only=True), MAX_SHEET_ROWS), 1):
            # A cell is text as its program shows it, without formats.
            whole = (
                int(one) if isinstance(one, float) and one.is_integer() else one
                for one in row[:MAX_COLUMNS]
            )
            cells = ["" if one is None else str(one) for one in whole]
            if any(cells):
                yield number, cells
    except Exception as error:  # noqa: BLE001 damage shows anywhere in the library
        raise _damaged(source, error) from None


def _damaged(source: LineFile, error: Exception) -> LipsyncError:
    why = str(error).partition("\n")[0] or type(error).__name__
    return source.fault(1, f"the spreadsheet cannot be read ({why}); save it again as .xlsx")
