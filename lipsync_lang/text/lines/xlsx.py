"""Sheets of spreadsheets, as tables.

The first sheet with cells is read, and all others that have the same columns, such as a sheet for
each scene; a remark names the rest. Formulas count as the values that the program stored with them.
"""

from collections.abc import Iterator, Sequence
from contextlib import closing
from itertools import islice
from typing import Any
from zipfile import BadZipFile, ZipFile

from lipsync_lang.base.errors import MAX_KNOWN, LipsyncError, shortlist
from lipsync_lang.base.extras import install_line
from lipsync_lang.base.files.reading import MIB_BYTES
from lipsync_lang.text.lines.line_readers import Line, LineFile, Table, reader
from lipsync_lang.text.lines.table import lines_of

MAX_PART_BYTES = 512 * MIB_BYTES
"""Maximum unpacked size of a part of the file; a million rows have less."""

MAX_SHEET_ROWS = 1_048_576
"""Maximum number of rows of a sheet; no program stores more, so more rows are damage."""

MAX_COLUMNS = 1_024
"""Maximum number of columns; no script has more."""


def open_sheets(source: LineFile) -> Table:
    """Read the head of the first sheet; the rows follow one by one."""
    sheets = _sheets(source)
    for title, rows in sheets:
        first = next(rows, None)
        if first is not None:
            return Table(_head(first[1]), _rows(source, title, first[1], rows, sheets))
    raise source.fault(1, "has no row of column names; write one, such as id,speaker,text")


@reader("xlsx", suffixes=[".xlsx"], table=open_sheets)
def read(source: LineFile) -> Iterator[Line]:
    """Spreadsheets, whose first row names the columns; `--column` says which is the text."""
    return lines_of(source, open_sheets(source))


SheetRow = tuple[int, list[str]]
NamedSheet = tuple[str, Iterator[SheetRow]]


def _rows(
    source: LineFile,
    title: str,
    first: list[str],
    rows: Iterator[SheetRow],
    others: Iterator[NamedSheet],
) -> Iterator[tuple[int | str, Sequence[str]]]:
    """Yield the rows of the first sheet, and those of the others with its columns."""
    yield from rows
    left = []
    for other, more in others:
        head = next(more, None)
        if head is not None and _head(head[1]) == _head(first):
            yield from ((f"{other}!{number}", row) for number, row in more)
        elif head is not None:
            left.append(other)
    if left:
        names = shortlist(left, MAX_KNOWN)
        source.remark(f"{source.path}: left out {names}: the columns differ from those of {title}")


def _head(row: Sequence[str]) -> list[str]:
    names = [name.strip() for name in row]
    while names and not names[-1]:
        names.pop()
    return names


def _sheets(source: LineFile) -> Iterator[NamedSheet]:
    """Yield the title and the rows of each sheet, in order."""
    try:
        import openpyxl
    except ImportError:
        raise LipsyncError(
            f"spreadsheets need openpyxl: {install_line('tables')}; or save them as .csv"
        ) from None
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
