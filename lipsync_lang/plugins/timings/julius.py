"""Julius: the log of an alignment of phonemes (`-palign`), and of words (`-walign`).

Rows between ``begin forced alignment`` and ``end forced alignment`` have the first and the last
frame, a score and the unit. A frame lasts 10 ms, and stands for the middle of a window of 25 ms:
as in Julius's own kit for segmentation, all times but the first 0 are half a window later. A unit
of three phones, ``k-a+N``, is the one in the middle. Each recording of a log is a tier.
"""

import re
from collections.abc import Iterator
from typing import NamedTuple

from lipsync_lang import ScheduleError
from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader, schedule_of
from lipsync_lang.schedules.tiers import Tier, only

FRAME_SECONDS, HALF_WINDOW_SECONDS = 0.01, 0.0125

BEGIN, END = "begin forced alignment", "end forced alignment"
KIND = re.compile(r"--+ (\w+) alignment --+")
FRAMES = re.compile(r"\[ *(\d{1,9}) +(\d{1,9})\] *-?[\d.]+ +(\S.*)")
UNIT = re.compile(r"(?:[^-\s]+-)?([^-+\s]+)(?:\+\S*)?.*")
ALIGNED_WORD = re.compile(r"(\S+)(?:\s+\[(.*)\])?.*")
KIT_WORD = re.compile(r"w_\d+|<?/?s>?|sil[BE]|")
"""Words without a text: those that the kit numbers, and the ends of a sentence."""


class Alignment(NamedTuple):
    """Rows of one alignment: its kind and its first line."""

    kind: str
    line: int
    rows: list[LabelRow]


def sniff(source: TimingFile) -> bool:
    """Return True if the start of the file names an alignment of Julius."""
    return BEGIN in source.head


@reader("julius", ".log", ".txt", sniff=sniff, tiers=True)
def read_julius(source: TimingFile) -> Schedule:
    """Alignments of phonemes in the log of Julius, of one of its recordings."""
    found = list(_alignments(source))
    phones = [one for one in found if one.kind == "phoneme"]
    if not phones:
        what = f"has no alignment of phonemes; run julius with -palign (rows after '{BEGIN}')"
        raise source.fault(what)
    tiers = [Tier(str(at), tuple(one.rows), one.line) for at, one in enumerate(phones, 1)]
    chosen = only(source, tiers, "recordings")
    at = int(chosen.name) - 1
    # The words of a recording stand before or after its phonemes, one alignment of each.
    words = [one.rows for one in found if one.kind == "word"]
    return schedule_of(
        source, chosen.rows, words=words[at] if len(words) == len(phones) else (), rate=1.0
    )


def _alignments(source: TimingFile) -> Iterator[Alignment]:
    within = False
    rows: list[LabelRow] = []
    kind, first = "phoneme", 1
    for number, line in source.lines:
        if BEGIN in line:
            within, rows, kind, first = True, [], "phoneme", number
        elif END in line and within:
            within = False
            yield Alignment(kind, first, rows)
        elif stated := KIND.search(line):
            kind = stated[1]
        elif within and line.startswith("["):
            rows.append(_row(source, number, line, kind))
    if within:
        raise source.fault(f"ends before '{END}'; give the whole log", first)


def _row(source: TimingFile, number: int, line: str, kind: str) -> LabelRow:
    found = FRAMES.match(line)
    if found is None:
        raise _no_row(source, number, line)
    start, end = int(found[1]) * FRAME_SECONDS, (int(found[2]) + 1) * FRAME_SECONDS
    start += HALF_WINDOW_SECONDS if start else 0.0
    unit = (UNIT if kind == "phoneme" else ALIGNED_WORD).match(found[3])
    label = unit[unit.lastindex or 1] if unit else found[3]
    if kind == "word" and KIT_WORD.fullmatch(label):
        label = ""
    return LabelRow(label, start, end + HALF_WINDOW_SECONDS, number)


def _no_row(source: TimingFile, number: int, line: str) -> ScheduleError:
    what = f"{line.strip()[:40]!r} is not a row; the form is [ FIRST LAST] SCORE UNIT"
    return source.fault(what, number)
