"""Events of a CereProc voice, as the examples of its SDK print them.

``INFO: phoneme: 0.100 0.180 hh``: the start and the end in seconds, and the phone. Words and
markers have lines of the same form, and a word stands above its phones. The voice speaks long texts
in parts, and the times of each part start at zero.
"""

import re
from collections.abc import Iterator

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of

VOICE_EVENT = re.compile(
    r"\s*INFO: (phoneme|word|marker):\s+(\S+)\s+(\S+)(?:\s+(.*?))?\s*", re.ASCII
)


def sniff(source: TimingFile) -> bool:
    """Return True if one of the first lines is an event with a phoneme or a word."""
    if "INFO: " not in source.head:
        return False
    found = (VOICE_EVENT.fullmatch(line) for line in source.head.split("\n"))
    return any(one is not None and one[1] != "marker" for one in found)


@reader("cereproc", ".txt", sniff=sniff)
def read_cereproc(source: TimingFile) -> Schedule:
    """Events of phonemes and words that the examples of CereProc's SDK print."""
    phones: list[LabelRow] = []
    words: list[LabelRow] = []
    waiting: list[LabelRow] = []  # words above their first phone
    before = part = 0.0
    for kind, row in _events(source):
        if kind == "word":
            waiting.append(row)
            continue
        if phones and row.start < before:
            part = phones[-1].end
        before = row.start
        words += [_later(word, part) for word in waiting]
        phones.append(_later(row, part))
        waiting = []
    return schedule_of(source, phones, words=[*words, *(_later(word, part) for word in waiting)])


def _events(source: TimingFile) -> Iterator[tuple[str, LabelRow]]:
    """Yield the kind and the row of each phoneme and word; other lines are no timings."""
    for number, line in source.lines:
        found = VOICE_EVENT.fullmatch(line)
        if found is not None and found[1] != "marker":
            start, end = source.time(found[2], number), source.time(found[3], number)
            yield found[1], LabelRow(found[4] or "", start, end, number)


def _later(row: LabelRow, seconds: float) -> LabelRow:
    return row._replace(start=row.start + seconds, end=row.end + seconds)
