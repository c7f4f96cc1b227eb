"""Phonetic labels of the CSLU Toolkit and the corpora of its centre.

A header states the length of a frame, and ends in a line of its own. Each line below has the first
frame, the last frame and a label, in Worldbet as a rule: ``2 113 .pau``.
"""

import re

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of
from lipsync_lang.schedules.rows import MILLISECONDS_PER_SECOND

CSLU_HEADER = re.compile(r"MillisecondsPerFrame:\s*(\S+)\s*", re.IGNORECASE)

LAST_HEADER_LINE = "END OF HEADER"

CSLU_LINE = re.compile(r"\s*(-?\d+(?:\.\d*)?)\s+(-?\d+(?:\.\d*)?)\s+(\S+)\s*", re.ASCII)


def sniff(source: TimingFile) -> bool:
    """Return True if the file starts with the length of a frame."""
    return CSLU_HEADER.fullmatch(source.first_line) is not None


@reader("cslu", ".phn", sniff=sniff)
def read_cslu(source: TimingFile) -> Schedule:
    """Labels of the CSLU Toolkit, by frames whose length the header states."""
    end = next(
        (at for at, (_, line) in enumerate(source.lines, 1) if line.strip() == LAST_HEADER_LINE),
        None,
    )
    if end is None:
        raise source.fault(
            f"has no line {LAST_HEADER_LINE!r}; write it between the header and the labels"
        )
    frame = _frame_milliseconds(source, end)
    rows = [
        LabelRow(found[3], source.time(found[1], number), source.time(found[2], number), number)
        for number, found in source.matches(CSLU_LINE, "two frames and a label", after=end)
    ]
    return schedule_of(source, rows, rate=MILLISECONDS_PER_SECOND / frame)


def _frame_milliseconds(source: TimingFile, end: int) -> float:
    """Return the length of a frame that a header of `end` lines states."""
    for number, line in source.lines[:end]:
        found = CSLU_HEADER.fullmatch(line.strip())
        if found is not None:
            frame = source.time(found[1], number)
            if frame > 0:
                return frame
            raise source.fault(f"a frame lasts {found[1]} ms; give a number above 0", number)
    raise source.fault("does not state `MillisecondsPerFrame:` in its header; add the line", 1)
