"""Audacity's label track: a start, an end and a text in every line, with tabs between.

A line that begins with a backslash holds the frequencies of the label above, and is skipped.
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
from lipsync_lang.schedules.timed_words import are_words

LABEL = re.compile(r"(-?\d+(?:[.,]\d+)?)\t(-?\d+(?:[.,]\d+)?)(?:\t(.*))?")

LABELS = re.compile(r"^(-?\d{1,9}(?:[.,]\d+)?)\t(-?\d{1,9}(?:[.,]\d+)?)(?:\t(.*))?$", re.MULTILINE)
"""The same of all lines at once, for times that no other check refuses."""


def sniff(source: TimingFile) -> bool:
    """Return True if the first line is a label with two decimal times, as Audacity writes them."""
    found = LABEL.fullmatch(source.head.lstrip("\n").split("\n", 1)[0])
    return bool(found and not found[1].isdecimal() and not found[2].isdecimal())


@reader("audacity", ".txt", sniff=sniff)
def read_audacity(source: TimingFile) -> Timings:
    """Audacity label tracks of phonemes or words, exported as text."""
    rows = _at_once(source) or _line_by_line(source)
    if are_words(row.label for row in rows):
        return timed_words_of(source, rows, guess=True)
    return schedule_of(source, rows, guess=True)


def _at_once(source: TimingFile) -> list[LabelRow]:
    """Return the rows of a file that has labels alone; empty for any other."""
    found, text = LABELS.findall(source.text), source.text
    if len(found) != text.count("\n") + (not text.endswith("\n")):
        return []
    return [
        LabelRow(label, float(start.replace(",", ".")), float(end.replace(",", ".")), number)
        for number, (start, end, label) in enumerate(found, 1)
    ]


def _line_by_line(source: TimingFile) -> list[LabelRow]:
    """Return the rows of a file; the error for a line that is no label names it."""
    rows = []
    form = "a label; write START, END and TEXT, separated by tabs"
    for number, found in source.matches(LABEL, form, comments="\\"):
        start, end, label = found.groups("")
        # Audacity writes the decimal sign of the user's country.
        begin = source.time(start.replace(",", "."), number)
        stop = source.time(end.replace(",", "."), number)
        rows.append(LabelRow(label, begin, stop, number))
    return rows
