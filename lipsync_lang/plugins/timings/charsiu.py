"""Charsiu: lists of start, end and label, as JSON.

The aligner returns a list of phones or, for a text, a list of phones and a list of words; scripts
write them down as they are. Times are seconds. Its tables and TextGrids are read as such.
"""

from collections.abc import Sequence

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of
from lipsync_lang.schedules.timing_file import first_item

CHARSIU_FORM = '[[[0.0, 0.1, "[SIL]"], [0.1, 0.19, "M"], ...], [[0.1, 0.62, "maps"], ...]]'


def sniff(source: TimingFile) -> bool:
    """Return True if the JSON starts with a list of two times and a label, or a list of those."""
    first = first_item(source.document)
    return _is_row(first) or _is_row(first_item(first))


def _is_row(value: object) -> bool:
    """Return True for a list of start, end and label."""
    return isinstance(value, list) and len(value) == 3 and isinstance(value[2], str)  # noqa: PLR2004


@reader("charsiu", ".json", sniff=sniff)
def read_charsiu(source: TimingFile) -> Schedule:
    """Phones of Charsiu as lists of start, end and label; words in a second list."""
    whole = source.json
    if not isinstance(whole, list) or not whole:
        raise source.fault(f"has no lists of sounds; the form is {CHARSIU_FORM}")
    phones, words, *_ = [whole, []] if _is_row(whole[0]) else [*whole, []]
    # `[SIL]` and `[UNK]` are no words
    spoken = [row for row in _rows(source, words) if not row.label.startswith("[")]
    return schedule_of(source, _rows(source, phones), words=spoken)


def _rows(source: TimingFile, rows: object) -> Sequence[LabelRow]:
    if not isinstance(rows, list) or not all(_is_row(row) for row in rows):
        raise source.fault(f"needs lists of start, end and label; the form is {CHARSIU_FORM}")
    return [LabelRow(row[2], source.number(row[0]), source.number(row[1])) for row in rows]
