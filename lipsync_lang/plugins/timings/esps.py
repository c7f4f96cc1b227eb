"""ESPS (xwaves) labels: a header, a line with `#` alone, then a time, a colour and a label.

The time is the end of the label, in seconds; its start is the end of the label before. Festival
and the Edinburgh speech tools write segments in this format. The Buckeye corpus uses it too, with
a `.words` file beside each `.phones` file. After `;` a line has further fields.
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

HEADER_END = re.compile(r"^[ \t]*#[ \t]*\n+[ \t]*\d+(?:\.\d*)?[ \t]+-?\d+[ \t]", re.MULTILINE)
"""The end of the header, and the first label."""

ESPS_LINE = re.compile(r"\s*(\d+(?:\.\d*)?)\s+-?\d+(?:\s+([^;]*))?(?:;.*)?", re.ASCII)

BOUNDARY_NOTE = re.compile(r"\+\d+$")
"""A note on the boundary, which Buckeye appends to a phone: `ae+1`."""

MARKED = ("<", "{")
"""Starts of labels that are not words."""


def sniff(source: TimingFile) -> bool:
    """Return True if the header ends, followed by a time, a number and a label."""
    return HEADER_END.search(source.head) is not None


@reader("esps", ".phones", ".words", ".lab", ".segs", ".seg", sniff=sniff)
def read_esps(source: TimingFile) -> Timings:
    """Labels of Festival (segments), xwaves and the Buckeye corpus, with its .words beside it."""
    if source.path.suffix.lower() == ".words":
        return timed_words_of(source, _words(source))
    beside = source.beside(".words") if source.path.suffix.lower() == ".phones" else None
    return schedule_of(source, _rows(source), words=_words(beside) if beside is not None else ())


def _words(source: TimingFile) -> list[LabelRow]:
    return [row for row in _rows(source) if not row.label.startswith(MARKED)]


def _rows(source: TimingFile) -> list[LabelRow]:
    at = next((n for n, (_, line) in enumerate(source.lines) if line.strip() == "#"), None)
    if at is None:
        raise source.fault("has no line with `#` alone, which ends the header")
    rows: list[LabelRow] = []
    start = 0.0
    for number, found in source.matches(ESPS_LINE, "a time, a colour and a label", after=at + 1):
        end = source.time(found[1], number)
        rows.append(LabelRow(BOUNDARY_NOTE.sub("", (found[2] or "").strip()), start, end, number))
        start = end
    return rows
