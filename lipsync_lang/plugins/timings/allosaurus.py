"""Allosaurus: a start, a duration and a phone on each line, with its option `--timestamp`.

The duration is the same for all phones: the program finds where a phone is, but not how long it
lasts. Therefore a phone lasts until the next, and a longer gap is a pause. Of several phones with
their probabilities (`--topk`), the first is the likeliest.
"""

import re
from itertools import pairwise
from operator import attrgetter

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of

ALLOSAURUS_ROW = re.compile(r"\s*(\d+\.\d+)\s+(\d*\.\d+)\s+(\S+)(?:\s+\(\S.*)?\s*")
NEXT_PHONE_SECONDS = 0.3
"""Distance of two phones above which there is a pause between them."""


def sniff(source: TimingFile) -> bool:
    """Return True if the second number of all first lines is the same, and no end."""
    lines = (
        source.head.split("\n")[:-1]
        if len(source.head) < len(source.content)
        else [*filter(str.strip, source.head.split("\n"))]
    )
    # Of a longer file the last line of the head is cut, and fits nothing.
    found = None
    for line in filter(str.strip, lines):
        length = found and found[2]
        found = ALLOSAURUS_ROW.fullmatch(line)
        if found is None or length not in (None, found[2]):
            return False
    # A second number that is an end is later than all starts, so it is no length.
    return found is not None and float(found[1]) >= float(found[2])


@reader("allosaurus", ".txt", sniff=sniff)
def read_allosaurus(source: TimingFile) -> Schedule:
    """Phones that Allosaurus has recognised (`--timestamp=True`)."""
    form = "a phone; write START, DURATION and PHONE"
    rows = [
        LabelRow(found[3], start, start + source.time(found[2], number), number)
        for number, found in source.matches(ALLOSAURUS_ROW, form)
        for start in [source.time(found[1], number)]
    ]
    rows.sort(key=attrgetter("start"))
    rate = source.rate or 1.0
    for at, (one, after) in enumerate(pairwise(rows)):
        near = after.start - one.start <= NEXT_PHONE_SECONDS * rate
        rows[at] = one._replace(end=after.start if near else one.end)
    return schedule_of(source, rows, notation="ipa")
