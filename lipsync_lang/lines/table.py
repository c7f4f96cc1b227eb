"""Tables: a row is a line, and one column its text.

The first row names the columns. The delimiter is the one of tab, comma, semicolon and bar that
gives this row the most cells.
"""

import csv
from collections.abc import Collection, Iterator, Sequence

from lipsync_lang.errors import LipsyncError, did_you_mean
from lipsync_lang.lines.line import Line
from lipsync_lang.lines.line_readers import LineFile, Table, reader

DELIMITERS = "\t,;|"

TEXTS = ("text", "line", "dialogue", "dialog", "subtitle", "message", "source", "string")
NAMES = ("id", "line_id", "lineid", "key", "name", "identifier")
SPEAKERS = ("speaker", "character", "who", "actor", "role")
"""Names of columns, in small letters, most likely first."""

MAX_CELL_LINES = 100
"""Most lines of the file in one cell; a longer cell has lost its closing quote."""


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
    """Yield the rows that have a text as lines."""
    head = table.head
    text = _likeliest(source, head) if source.column is None else column(source, head)
    name, speaker = (first_column(head, known, [text]) for known in (NAMES, SPEAKERS))
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
                    f'a cell goes on for more than {MAX_CELL_LINES} lines; is a " left open?',
                )
            yield line + "\n"

    rows = csv.reader(counted(), delimiter=delimiter)
    try:
        for row in rows:
            yield start + 1, row
            start = last
    except csv.Error as error:
        raise source.fault(start + 1, f'{error}; is a " left open?') from None


def column(source: LineFile, head: Sequence[str]) -> int:
    """Return the index of the column that is asked for, by name or by number from 1."""
    asked = source.column or ""
    folded = [name.casefold() for name in head]
    if asked in head:
        return head.index(asked)
    if asked.casefold() in folded:
        return folded.index(asked.casefold())
    if asked.isdecimal() and 1 <= int(asked) <= len(head):
        return int(asked) - 1
    raise lacking(source, head, f"has no column '{asked}'; {did_you_mean(asked, head)}")


def _likeliest(source: LineFile, head: Sequence[str]) -> int:
    found = text_column(head)
    if found < 0:
        raise lacking(source, head, "which column is the text? Say `column='NAME'`")
    return found


def text_column(head: Sequence[str]) -> int:
    """Return the index of the column that is most likely the text, or -1."""
    known = first_column(head, TEXTS)
    if known >= 0:
        return known
    other = [i for i, name in enumerate(head) if name.casefold() not in (*NAMES, *SPEAKERS)]
    return other[0] if len(other) == 1 else -1


def lacking(source: LineFile, head: Sequence[str], what: str) -> LipsyncError:
    """Return an error that lists the columns."""
    return source.fault(1, f"{what}. Its columns: {', '.join(head)}")


def first_column(head: Sequence[str], known: Sequence[str], taken: Collection[int] = ()) -> int:
    """Return the index of the column with the first known name, or -1."""
    found = [(name, at) for at, name in enumerate(head) if at not in taken]
    folded = {name.casefold(): at for name, at in reversed(found)}
    return next((folded[name] for name in known if name in folded), -1)
