"""Tables: each row is a line, and one column is its text.

The first row names the columns; titles above it are left out. The delimiter is the one of tab,
comma, semicolon and bar that gives this row the most cells.
"""

import csv
from collections import deque
from collections.abc import Generator, Iterator, Sequence
from contextlib import closing, suppress
from itertools import chain, islice

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.text.lines.columns import (
    MAX_TITLE_ROWS,
    NAME_COLUMNS,
    SPEAKER_COLUMNS,
    first_column,
    head_row,
    known_column,
    lacking,
    language_column,
    stated_column,
    text_column,
)
from lipsync_lang.text.lines.line_readers import Line, LineFile, Table, reader

DELIMITERS = "\t,;|"

NO_HEAD = "has no row of column names; write one, such as id,speaker,text"

MAX_CELL_LINES = 100
"""Maximum number of lines of the file in one cell; a longer cell has no closing quote."""

MAX_CELL_EXAMPLE_CHARS = 60
"""Maximum length of a text in a message."""

MAX_FAULTS = 12
"""Number of faulty rows after which the reading of a table ends."""


def open_table(source: LineFile) -> Table:
    """Read the head of a table; its rows follow one by one.

    The rows raise an error with the faults of all rows after the last one.
    """
    lines = source.numbered()
    stated = source.layout.header_row
    top = list(islice(lines, (stated or 1) - 1, stated or 1))
    if not top or not top[0][1].strip():
        raise source.fault(stated or 1, NO_HEAD)
    if not stated and first_column(_cells(top[0][1], _delimiter(top[0][1])), NAME_COLUMNS) < 0:
        top += islice(lines, MAX_TITLE_ROWS - 1)
    start = 0 if stated else head_row([_cells(line, _delimiter(line)) for _, line in top])
    if start:
        source.remark(below_title(source, start + 1))
    rows = _rows(source, _RowLines(chain(top[start:], lines)), _delimiter(top[start][1]))
    _, head = next(rows)
    return Table([name.strip() for name in head], rows)


def below_title(source: LineFile, number: int) -> str:
    """Say that rows above the names of the columns are left out."""
    return f"{source.path}:{number}: names the columns; the rows above are left out"


def _delimiter(line: str) -> str:
    """Return the delimiter that gives a line the most cells."""
    return max(DELIMITERS, key=lambda one: len(_cells(line, one)))


@reader("table", suffixes=[".csv", ".tsv"], table=open_table)
def read(source: LineFile) -> Iterator[Line]:
    """Tables, whose first row names the columns; `--column` says which of them is the text."""
    return lines_of(source, open_table(source))


def lines_of(source: LineFile, table: Table) -> Iterator[Line]:
    """Yield the rows that have a text as lines.

    The text is the stated column, else the language's own, else the most likely one.
    """
    head = table.head
    with closing(table.rows):  # a spreadsheet is open until its rows end
        if source.column is not None:
            text = stated_column(source, head, source.column)
        elif (text := language_column(head, source.names)) < 0 and (text := text_column(head)) < 0:
            whose = f" in {source.names[0]}" if source.names else ""
            raise lacking(source, head, f"which column is the text{whose}? Say `column='NAME'`.")
        name = first_column(head, NAME_COLUMNS, [text])
        speaker = known_column(source, head, source.speaker, SPEAKER_COLUMNS, [text, name])
        for number, row in table.rows:
            if text < len(row) and row[text].strip():
                named = {"name": cell(row, name), "speaker": cell(row, speaker)}
                yield source.line(number, row[text], **named)


def cell(row: Sequence[str], at: int) -> str:
    """Return a cell of a row; empty for a short row, and for the column -1."""
    return row[at].strip() if 0 <= at < len(row) else ""


class _RowLines(Iterator[str]):
    """Lines of a file for `csv`; those of the current row can be read again."""

    def __init__(self, lines: Iterator[tuple[int, str]]) -> None:
        self.row: list[tuple[int, str]] = []
        self._lines = lines
        self._again: deque[tuple[int, str]] = deque()

    def __next__(self) -> str:
        if len(self.row) > MAX_CELL_LINES:
            # As for a quote without its end, but before the whole file is read for one.
            raise csv.Error
        self.row.append(self._again.popleft() if self._again else next(self._lines))
        return f"{self.row[-1][1]}\n"

    def repeat(self) -> None:
        """Read the lines after the first one of the row again."""
        self._again.extendleft(reversed(self.row[1:]))


def _rows(
    source: LineFile, lines: _RowLines, delimiter: str
) -> Generator[tuple[int | str, Sequence[str]]]:
    """Yield (first line, cells) for each sound row, with the head as the first.

    Faulty rows raise a LipsyncError after the last row, or after `MAX_FAULTS` of them; a faulty
    head raises it at once.
    """
    rows = csv.reader(lines, delimiter=delimiter, strict=True)
    head: Sequence[str] = ()
    faults: list[str] = []
    while len(faults) < (MAX_FAULTS if head else 1):
        lines.row.clear()
        try:
            row, wrong = next(rows, None), ""
        except csv.Error:
            # Quotes within quotes, such as `"a "b" c"`; the line's end is kept only if one is open.
            cells = _cells(lines.row[0][1], delimiter) if len(lines.row) == 1 else []
            row = cells if cells and not cells[-1].endswith("\n") else None
            wrong = "" if row else _open_quote(lines)
        if row is None and not wrong:
            break
        number = lines.row[0][0]
        if row and head:
            wrong = _swallowed(lines.row, len(head), delimiter) or _surplus(row, head, delimiter)
        if wrong:
            faults.append(str(source.fault(number, wrong)))
        elif row is not None:
            head = head or row
            yield number, row
    if faults:
        raise LipsyncError("\n".join(faults))


def _cells(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line, however it is quoted; none if one of them is too long."""
    with suppress(csv.Error):
        return next(csv.reader([f"{line}\n"], delimiter=delimiter))
    return []


def _open_quote(lines: _RowLines) -> str:
    """Describe a quote without its end, and continue in the line after it."""
    lines.repeat()
    first, most = lines.row[0][1], csv.field_size_limit()
    if '"' not in first or len(first) > most:
        return f"a cell has more than {most:,} characters; shorten it, and close its quotes"
    return (
        'a cell begins with a quote (") that is not closed; close it at the end of the cell, and '
        'write quotes within the cell twice ("")'
    )


def _swallowed(row: Sequence[tuple[int, str]], width: int, delimiter: str) -> str:
    """Describe a line within a cell that looks like a row; in prose, a space follows a comma."""
    for number, line in row[1:]:
        first, *others = line.split(delimiter)[:width]
        if (
            len(others) == width - 1 > 0
            and any(others)
            and first.split() == [first]
            and not any(one.startswith(" ") for one in others)
        ):
            return (
                f'a cell goes on in line {number}, which looks like a row; close its quote (") '
                f"before, or begin line {number} with a space if it is text of the cell"
            )
    return ""


def _surplus(row: Sequence[str], head: Sequence[str], delimiter: str) -> str:
    """Describe cells without a column, such as those of a text with a delimiter."""
    if not any(one.strip() for one in row[len(head) :]):
        return ""
    # In prose a space follows a comma: there the text was cut.
    cut = next((at for at, one in enumerate(row) if at and one.startswith(" ")), len(head))
    whole = delimiter.join(row[cut - 1 : cut + 1])[:MAX_CELL_EXAMPLE_CHARS]
    shown = "tab" if delimiter == "\t" else delimiter
    return (
        f"has {len(row)} cells, and the head {len(head)} columns; put a text that contains a "
        f"'{shown}' into quotes, such as \"{whole}\""
    )
