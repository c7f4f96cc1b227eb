"""Tables of phonemes: CSV and TSV of your own, the Montreal Forced Aligner's, and SPPAS's.

A row is a phoneme. The first row names the columns; without names there are three, and either
the first or the last is the label, as their numbers tell, or four: the type of the row, its start,
end and label. What parts cells is told by the first
row: of tab, comma, semicolon and bar the one that makes the most of them. Decimals may have a
comma. In other columns there may be

- the word a phoneme is part of; rows that follow each other with the same word are one,
- what a row is, a phone or a word (`type`), and who speaks.
"""

import csv
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from io import StringIO
from itertools import chain

from lipsync_lang.schedules.rows import LabelRow
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.tiers import WORDS, Tier, read_tiers
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import reader

COLUMNS = {
    "label": ("phoneme", "phone", "label"),
    "start": ("start", "begin", "xmin"),
    "end": ("end", "stop", "xmax"),
    "duration": ("duration",),
    "word": ("word",),
    "type": ("type",),
    "speaker": ("speaker",),
}
"""What a column is, and the names it may have, likeliest first."""

UNNAMED: Mapping[tuple[bool, ...], Mapping[str, int]] = {
    (False, True, True): {"label": 0, "start": 1, "end": 2},
    (True, True, False): {"start": 0, "end": 1, "label": 2},
    (False, True, True, False): {"type": 0, "start": 1, "end": 2, "label": 3},
}
"""By which cells of the first row are numbers, what the columns are."""

DELIMITERS = "\t,;|"
NUMBER = re.compile(r"\s*-?\d+(?:[.,]\d*)?(?:[eE][-+]?\d+)?\s*")


def sniff(source: TimingFile) -> bool:
    """Tell whether the first row names a label and times, or has them."""
    first = source.head.lstrip().split("\n", 1)[0]
    try:
        return bool(_columns(next(csv.reader([first], delimiter=_delimiter(first)), [])))
    except csv.Error:
        return False


@reader("table", ".csv", ".tsv", sniff=sniff, tiers=True)
def read_table(source: TimingFile) -> Schedule:
    """Tables (CSV, TSV) of phonemes with start and end, and maybe words, types and speakers."""
    return read_tiers(source, _tiers(source), guess=True)


def _tiers(source: TimingFile) -> list[Tier]:
    """Return a tier of phones, and maybe one of words, of every speaker."""
    rows = _rows(source)
    line, first = next(rows, (1, []))
    columns = _columns(first)
    if not columns:
        raise source.fault("the first row names the columns; let it be: label,start,end", line)
    if NUMBER.fullmatch(first[columns["start"]]):
        rows = chain([(line, first)], rows)
    tiers: dict[str, list[LabelRow]] = defaultdict(list)
    for line, cells in rows:
        row = _row(source, columns, line, cells)
        kind = _cell(cells, columns, "type") or "phones"
        who = [name] if (name := _cell(cells, columns, "speaker")) else []
        tiers[" - ".join([*who, kind])].append(row)
        if "word" in columns and not WORDS.fullmatch(kind):
            word = row._replace(label=_cell(cells, columns, "word"))
            _join(tiers[" - ".join([*who, "words"])], word)
    return [Tier(name, tuple(found)) for name, found in tiers.items()]


def _join(words: list[LabelRow], row: LabelRow) -> None:
    """Add a phoneme to the word it goes on with, or as the first of another."""
    if words and words[-1].label == row.label:
        row = row._replace(start=words.pop().start)
    words.append(row)


def _row(
    source: TimingFile, columns: Mapping[str, int], line: int, cells: Sequence[str]
) -> LabelRow:
    if len(cells) <= max(columns[what] for what in columns.keys() & {"label", "start", "end"}):
        raise source.fault(f"has {len(cells)} cells, too few for the columns; add the others", line)
    start, end, length = (
        source.time(_cell(cells, columns, what).replace(",", "."), line) if what in columns else 0.0
        for what in ("start", "end", "duration")
    )
    return LabelRow(
        cells[columns["label"]], start, end if "end" in columns else start + length, line
    )


def _cell(cells: Sequence[str], columns: Mapping[str, int], what: str) -> str:
    at = columns.get(what, len(cells))
    return cells[at].strip() if at < len(cells) else ""


def _rows(source: TimingFile) -> Iterator[tuple[int, list[str]]]:
    """Yield rows that are not blank with the number of the line where each starts."""
    first = source.lines[0][1] if source.lines else ""
    rows = csv.reader(StringIO(source.text), delimiter=_delimiter(first), strict=True)
    start = 1
    try:
        for row in rows:
            if any(cell.strip() for cell in row):
                yield start, row
            start = rows.line_num + 1
    except csv.Error as error:
        raise source.fault(f'{error}; is a " left open, or alone in a cell?', start) from None


def _delimiter(first: str) -> str:
    return max(DELIMITERS, key=first.count)


def _columns(first: Sequence[str]) -> Mapping[str, int]:
    """Return where what stands, by the names in the first row or its numbers; or nothing."""
    names = [cell.strip().casefold() for cell in first]
    found = {
        what: names.index(name)
        for what, known in COLUMNS.items()
        for name in reversed(known)
        if name in names
    }
    if found.keys() >= {"label", "start"} and not found.keys().isdisjoint({"end", "duration"}):
        return found
    return UNNAMED.get(tuple(bool(NUMBER.fullmatch(cell)) for cell in first), {})
