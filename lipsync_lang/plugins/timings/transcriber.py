"""Transcriber: turns of speakers with the times of their parts, in XML (`.trs`).

A part of a turn is what stands between two `Sync` elements. Where speakers talk at once, `Who` says
which of the turn's speakers the text after it is of. Noises are events, which are not spoken.
"""

from collections import defaultdict
from collections.abc import Iterator
from operator import methodcaller
from typing import TYPE_CHECKING

from lipsync_lang.schedules import LabelRow, TimingFile, Timings, reader
from lipsync_lang.schedules.tiers import read_speakers

if TYPE_CHECKING:
    from xml.etree.ElementTree import Element

TRANSCRIBER_ROOT = "Trans"


@reader("transcriber", ".trs", sniff=methodcaller("has_root", TRANSCRIBER_ROOT), tiers=True)
def read_transcriber(source: TimingFile) -> Timings:
    """Turns of Transcriber's .trs, of one speaker; each part is timed as a whole."""
    document = source.xml
    names = {one.get("id", ""): one.get("name") or "" for one in document.iter("Speaker")}
    said: defaultdict[str, list[LabelRow]] = defaultdict(list)
    for turn in document.iter("Turn"):
        speakers = turn.get("speaker", "").split()
        for who, row in _parts(source, turn):
            key = speakers[who] if who < len(speakers) else ""
            said[names.get(key) or key].append(row)
    noises = sorted({one.get("desc") or "?" for one in document.iter("Event")})
    told = f"{source.path}: noises and other events are left out: {', '.join(noises[:8])}"
    return read_speakers(source, said, [told] if noises else ())


def _parts(source: TimingFile, turn: "Element") -> Iterator[tuple[int, LabelRow]]:
    """Yield the words of a turn with their times, and the number of their speaker."""
    spoken = defaultdict(list, {0: [turn.text or ""]})
    start, who = source.time(turn.get("startTime")), 0
    for element in turn:
        if element.tag == "Sync":
            end = source.time(element.get("time"))
            yield from _rows(spoken, start, end)
            spoken, start, who = defaultdict(list), end, 0
        elif element.tag == "Who":
            # Speakers are counted from 1 here, but their names stand in a list.
            who = max(round(source.time(element.get("nb"))) - 1, 0)
        inside = "" if element.tag == "Event" else element.text or ""
        spoken[who] += [inside, element.tail or ""]
    yield from _rows(spoken, start, source.time(turn.get("endTime")))


def _rows(spoken: dict[int, list[str]], start: float, end: float) -> Iterator[tuple[int, LabelRow]]:
    for who, texts in spoken.items():
        if label := " ".join(" ".join(texts).split()):
            yield who, LabelRow(label, start, end)
