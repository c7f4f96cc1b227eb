"""MBROLA's `.pho`: a phoneme and its duration in milliseconds on each line.

Pairs of a position and a pitch may follow, and are not used. Lines that begin with a semicolon are
comments. eSpeak writes the format, too (``--pho``).
"""

import re

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of
from lipsync_lang.schedules.rows import MILLISECONDS_PER_SECOND

MBROLA_NUMBER = r"\d+(?:\.\d*)?"

MBROLA_LINE = re.compile(
    rf"\s*(?!{MBROLA_NUMBER}\s)(\S+)\s+({MBROLA_NUMBER})"
    rf"((?:\s+\(?{MBROLA_NUMBER}[ ,]+{MBROLA_NUMBER}\)?)*)\s*",
    re.ASCII,
)
"""A phoneme, which is not a number, its duration, and pairs of position and pitch."""

MBROLA_COMMENTS = (";", "#")
"""Starts of comments, and of ``#`` alone, which flushes the voice."""


def sniff(source: TimingFile) -> bool:
    """Return True if the first two lines that are not comments have a phoneme and a duration."""
    lines = (line for line in source.head.split("\n") if line.strip())
    rows = [line for line in lines if not line.startswith(MBROLA_COMMENTS)]
    return len(rows) > 1 and all(MBROLA_LINE.fullmatch(row) for row in rows[:2])


@reader("mbrola", ".pho", sniff=sniff)
def read_mbrola(source: TimingFile) -> Schedule:
    """MBROLA's .pho: phonemes with their durations in milliseconds."""
    rows: list[LabelRow] = []
    at = 0.0
    form = "a phoneme and a duration"
    for number, found in source.matches(MBROLA_LINE, form, comments=MBROLA_COMMENTS):
        end = at + source.time(found[2], number)
        if end > at:  # a phoneme of no length only shapes the pitch
            rows.append(LabelRow(found[1], at, end, number))
        at = end
    return schedule_of(source, rows, rate=MILLISECONDS_PER_SECOND)
