"""Tables: a row is a line, and one column its text.

The first row names the columns. The delimiter is the one of tab, comma, semicolon and bar that
gives this row the most cells.
"""

import csv
from collections.abc import Iterator, Sequence

from lipsync_lang.errors import LipsyncError, did_you_mean
from lipsync_lang.lines.line import Line
from lipsync_lang.lines.line_readers import LineFile, reader

DELIMITERS = "\t,;|"

TEXTS = ("text", "line", "dialogue", "dialog", "subtitle", "message", "source", "string")
NAMES = ("id", "line_id", "lineid", "key", "name", "identifier")
SPEAKERS = ("speaker", "character", "who", "actor", "role")
"""Names of columns, in small letters, most likely first."""

MAX_CELL_LINES = 100
"""Most lines of the file in one cell; a longer cell has lost its closing quote."""


@reader("table", suffixes=[".csv", ".tsv"])
def read(source: LineFile) -> Iterator[Line]:
    """Tables, whose first row names the columns; `--column` says which of them is the text."""
    lines = source.numbered()
    _, first = next(lines, (1, ""))
    if not first.strip():
        raise source.fault(1, "has no row of column names; write one, such as id,speaker,text")
    delimiter = max(DELIMITERS, key=lambda d: len(_cells(first, d)))
    head = [name.strip() for name in _cells(first, delimiter)]
    text = _text_column(source, head)
    name, speaker = (_first(head, known, text) for known in (NAMES, SPEAKERS))
    for number, row in _rows(source, lines, delimiter):
        if text < len(row) and row[text].strip():
            yield source.line(number, row[text], name=_cell(row, name), speaker=_cell(row, speaker))


def _cells(line: str, delimiter: str) -> list[str]:
    return next(csv.reader([line], delimiter=delimiter), [])


def _cell(row: Sequence[str], at: int) -> str:
    return row[at].strip() if 0 <= at < len(row) else ""


def _rows(
    source: LineFile, lines: Iterator[tuple[int, str]], delimiter: str
) -> Iterator[tuple[int, list[str]]]:
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


def _text_column(source: LineFile, head: Sequence[str]) -> int:
    """Return the index of the text column: the one asked for, or the most likely."""
    asked = source.column
    if asked is None:
        return _likeliest(source, head)
    folded = [name.casefold() for name in head]
    if asked in head:
        return head.index(asked)
    if asked.casefold() in folded:
        return folded.index(asked.casefold())
    if asked.isdecimal() and 1 <= int(asked) <= len(head):
        return int(asked) - 1
    raise _lacking(source, head, f"has no column '{asked}'; {did_you_mean(asked, head)}")


def _likeliest(source: LineFile, head: Sequence[str]) -> int:
    known = _first(head, TEXTS)
    if known >= 0:
        return known
    other = [i for i, name in enumerate(head) if name.casefold() not in (*NAMES, *SPEAKERS)]
    if len(other) == 1:
        return other[0]
    raise _lacking(source, head, "which column is the text? Say `column='NAME'`")


def _lacking(source: LineFile, head: Sequence[str], what: str) -> LipsyncError:
    return source.fault(1, f"{what}. Its columns: {', '.join(head)}")


def _first(head: Sequence[str], known: Sequence[str], taken: int = -1) -> int:
    """Return the index of the column with the first known name, or -1."""
    folded = {name.casefold(): at for at, name in reversed(list(enumerate(head))) if at != taken}
    return next((folded[name] for name in known if name in folded), -1)
