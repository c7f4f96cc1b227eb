"""Tables of phonemes: CSV and TSV of your own, the Montreal Forced Aligner's, and SPPAS's.

A row is a phoneme. The first row names the columns. A table without names has three columns, the
label first or last, or four: type, start, end and label. The delimiter is the most frequent one of
tab, comma, semicolon and bar in the first row. Decimals may have a comma. Optional columns are

- `word`, the word of a phoneme; successive rows with the same word are one word. Without labels,
  the rows are words,
- `type`, phone or word, `speaker`, and `confidence` of a word.

An apostrophe before a formula, such as `'@`, is a spreadsheet's mark of text.
"""

import csv
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from io import StringIO
from itertools import chain

from lipsync_lang.base.files.quoting import plain_text
from lipsync_lang.schedules import LabelRow, TimingFile, Timings, reader
from lipsync_lang.schedules.tiers import CONFIDENCE_TIER, WORD_TIER_NAME, Tier, read_tiers

TABLE_COLUMNS = {
    "label": ("phoneme", "phone", "label"),
    "start": ("start", "begin", "xmin"),
    "end": ("end", "stop", "xmax"),
    "word": ("word", "text"),  # text: Whisper's .tsv, in milliseconds
    **{name: (name,) for name in ("duration", "type", "speaker", "confidence")},
}
"""Roles of columns, with their possible names, most likely first."""

UNNAMED: Mapping[tuple[bool, ...], Mapping[str, int]] = {
    (False, True, True): {"label": 0, "start": 1, "end": 2},
    (True, True, False): {"start": 0, "end": 1, "label": 2},
    (False, True, True, False): {"type": 0, "start": 1, "end": 2, "label": 3},
}
"""Column layouts for tables without a header, chosen by which cells are numeric."""

DELIMITERS = "\t,;|"
TABLE_NUMBER = re.compile(r"\s*-?\d+(?:[.,]\d*)?(?:[eE][-+]?\d+)?\s*")


def sniff(source: TimingFile) -> bool:
    """Return True if the first row names a label and times, or contains them."""
    first = source.first_line
    try:
        return bool(_columns(next(csv.reader([first], delimiter=_delimiter(first)), [])))
    except csv.Error:
        return False


@reader("table", ".csv", ".tsv", sniff=sniff, tiers=True)
def read_table(source: TimingFile) -> Timings:
    """Tables (CSV, TSV) of phonemes or words with start and end, and maybe types and speakers."""
    return read_tiers(source, _tiers(source), guess=True)


def _tiers(source: TimingFile) -> list[Tier]:
    """Return the phones of each speaker as a tier, and the words, if any, as another."""
    rows = _rows(source)
    line, first = next(rows, (1, []))
    # the first row is a header, or shows by its numbers what the columns are
    columns = _columns(first)
    if not columns:
        raise source.fault("the first row must name the columns: label,start,end", line)
    # without a header, the first row is a sound
    if TABLE_NUMBER.fullmatch(first[columns["start"]]):
        rows = chain([(line, first)], rows)
    only_words = columns["label"] == columns.get("word")
    tiers: dict[str, list[LabelRow]] = defaultdict(list)
    needed = max(columns[what] for what in columns.keys() & {"label", "start", "end"})
    for line, cells in rows:
        if len(cells) <= needed:
            what = f"has {len(cells)} cells, too few for the columns; add the missing ones"
            raise source.fault(what, line)
        start, end, length = (
            source.time(_cell(cells, columns, what).replace(",", "."), line)
            if what in columns
            else 0.0
            for what in ("start", "end", "duration")
        )
        end = end if "end" in columns else start + length
        row = LabelRow(plain_text(cells[columns["label"]]), start, end, line)
        kind = _cell(cells, columns, "type") or ("words" if only_words else "phones")
        who = [name] if (name := _cell(cells, columns, "speaker")) else []
        tiers[" - ".join([*who, kind])].append(row)
        if (sure := _cell(cells, columns, "confidence")) and WORD_TIER_NAME.fullmatch(kind):
            tiers[" - ".join([*who, CONFIDENCE_TIER])].append(row._replace(label=sure))
        if "word" in columns and not WORD_TIER_NAME.fullmatch(kind):
            words = tiers[" - ".join([*who, "words"])]
            word = row._replace(label=plain_text(_cell(cells, columns, "word")))
            if words and words[-1].label == word.label:  # another phoneme of the same word
                word = word._replace(start=words.pop().start)
            words.append(word)
    return [Tier(name, tuple(found)) for name, found in tiers.items()]


def _cell(cells: Sequence[str], columns: Mapping[str, int], what: str) -> str:
    at = columns.get(what, len(cells))
    return cells[at].strip() if at < len(cells) else ""


def _rows(source: TimingFile) -> Iterator[tuple[int, list[str]]]:
    """Yield (first line, cells) for each row that is not blank."""
    first = source.lines[0][1] if source.lines else ""
    rows = csv.reader(StringIO(source.text), delimiter=_delimiter(first), strict=True)
    start = 1
    try:
        for row in rows:
            if any(cell.strip() for cell in row):
                yield start, row
            start = rows.line_num + 1
    except csv.Error as error:
        what = f'{error}; check for a " that is open, or alone in a cell'
        raise source.fault(what, start) from None


def _delimiter(first: str) -> str:
    return max(DELIMITERS, key=first.count)


def _columns(first: Sequence[str]) -> Mapping[str, int]:
    """Map roles to column indices, by the names or numbers in the first row; may be empty."""
    names = [cell.strip().casefold() for cell in first]
    found = {
        what: names.index(name)
        for what, known in TABLE_COLUMNS.items()
        for name in reversed(known)
        if name in names
    }
    if "word" in found and "label" not in found:
        found["label"] = found["word"]
    if found.keys() >= {"label", "start"} and not found.keys().isdisjoint({"end", "duration"}):
        return found
    return UNNAMED.get(tuple(bool(TABLE_NUMBER.fullmatch(cell)) for cell in first), {})
