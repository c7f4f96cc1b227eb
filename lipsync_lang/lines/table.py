"""Tables: each row is a line, and one column is its text.

The first row names the columns. The delimiter is the one of tab, comma, semicolon and bar that
gives this row the most cells.
"""

import csv
from collections.abc import Iterator, Sequence

from lipsync_lang.lines.columns import (
    NAME_COLUMNS,
    SPEAKER_COLUMNS,
    first_column,
    known_column,
    lacking,
    language_column,
    stated_column,
    text_column,
)
from lipsync_lang.lines.line import Line
from lipsync_lang.lines.line_readers import LineFile, Table, reader

DELIMITERS = "\t,;|"

MAX_CELL_LINES = 100
"""Maximum number of lines of the file in one cell; a longer cell has no closing quote."""


def open_table(source: LineFile) -> Table:
    """Read the head of a table; its rows follow one by one."""
    lines = source.numbered()
    _, first = next(lines, (1, ""))
    if not first.strip():
        raise source.fault(1, "has no row of column names; write one, such as id,speaker,text")
    delimiter = max(DELIMITERS, key=lambda d: len(_cells(first, d)))
    head = [name.strip() for name in _cells(first, delimiter)]
    return Table(head, _rows(source, lines, delimiter))


@reader("table", suffixes=[".csv", ".tsv"], table=open_table)
def read(source: LineFile) -> Iterator[Line]:
    """Tables, whose first row names the columns; `--column` says which of them is the text."""
    return lines_of(source, open_table(source))


def lines_of(source: LineFile, table: Table) -> Iterator[Line]:
    """Yield the rows that have a text as lines.

    The text is the stated column, else the language's own, else the most likely one.
    """
    head = table.head
    if source.column is not None:
        text = stated_column(source, head, source.column)
    elif (text := language_column(head, source.names)) < 0 and (text := text_column(head)) < 0:
        whose = f" in {source.names[0]}" if source.names else ""
        raise lacking(source, head, f"which column is the text{whose}? Say `column='NAME'`.")
    name = first_column(head, NAME_COLUMNS, [text])
    speaker = known_column(source, head, source.speaker, SPEAKER_COLUMNS, [text, name])
    for number, row in table.rows:
        if text < len(row) and row[text].strip():
            yield source.line(number, row[text], name=cell(row, name), speaker=cell(row, speaker))


def _cells(line: str, delimiter: str) -> list[str]:
    return next(csv.reader([line], delimiter=delimiter), [])


def cell(row: Sequence[str], at: int) -> str:
    """Return a cell of a row; empty for a short row, and for the column -1."""
    return row[at].strip() if 0 <= at < len(row) else ""


def _rows(
    source: LineFile, lines: Iterator[tuple[int, str]], delimiter: str
) -> Iterator[tuple[int | str, Sequence[str]]]:
    """Yield (first line, cells) for each row."""
    last = start = 1

    def counted() -> Iterator[str]:
        nonlocal last
        for last, line in lines:
            if last - start > MAX_CELL_LINES:
                raise source.fault(
                    start + 1,
                    f'a cell goes on for more than {MAX_CELL_LINES} lines; check for an open "',
                )
            yield line + "\n"

    rows = csv.reader(counted(), delimiter=delimiter)
    try:
        for row in rows:
            yield start + 1, row
            start = last
    except csv.Error as error:
        raise source.fault(start + 1, f'{error}; check for an open "') from None
