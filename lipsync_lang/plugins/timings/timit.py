"""TIMIT's phones: a first sample, a last sample and a phone on each line, at 16 kHz.

The words are in a file of the same name with `.wrd` beside it.
"""

import re

from lipsync_lang.schedules import (
    LabelRow,
    TimingFile,
    Timings,
    reader,
    schedule_of,
    timed_words_of,
)

SAMPLES_PER_SECOND = 16_000.0

TIMIT_LINE = re.compile(r"\s*(\d+)\s+(\d+)\s+(\S+)\s*", re.ASCII)


def sniff(source: TimingFile) -> bool:
    """Return True if the file starts with two whole numbers and a label."""
    return TIMIT_LINE.fullmatch(source.first_line) is not None


@reader("timit", ".phn", ".wrd", sniff=sniff)
def read_timit(source: TimingFile) -> Timings:
    """TIMIT's .PHN, in samples at 16 kHz unless a rate is given; words from .WRD beside it."""
    if source.path.suffix.lower() == ".wrd":
        return timed_words_of(source, _rows(source), rate=SAMPLES_PER_SECOND)
    beside = source.beside(".wrd") if source.path.suffix.lower() == ".phn" else None
    words = _rows(beside) if beside is not None else []
    return schedule_of(source, _rows(source), words=words, rate=SAMPLES_PER_SECOND)


def _rows(source: TimingFile) -> list[LabelRow]:
    return [
        LabelRow(found[3], source.time(found[1], number), source.time(found[2], number), number)
        for number, found in source.matches(TIMIT_LINE, "two samples and a label")
    ]
