"""Amazon Polly's speech marks: a JSON object on every line, or one list of them.

``{"time": 6, "type": "viseme", "value": "p"}``: a mark has a start only, in milliseconds from the
start of the sound. Words have marks of their own; their `start` and `end` are offsets in the text.
"""

import re
from bisect import bisect_right

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader
from lipsync_lang.schedules.rows import MILLISECONDS_PER_SECOND, Start, shapes_of, until_next

POLLY_NOTATION = "polly"

POLLY_REST = "sil"

SPEECH_MARK = re.compile(r"""\s*\[?\s*\{[^{}]*"type"\s*:\s*"(viseme|word|sentence|ssml)"[^{}]*\}""")
"""The first mark, with its time before or after its type."""


def sniff(source: TimingFile) -> bool:
    """Return True if the file starts with a speech mark."""
    found = SPEECH_MARK.match(source.head)
    return found is not None and '"time"' in found[0]


@reader(POLLY_NOTATION, ".marks", ".jsonl", sniff=sniff)
def read_polly(source: TimingFile) -> Schedule:
    """Speech marks of Amazon Polly with visemes; words where they were asked for."""
    marks: dict[str, list[Start]] = {"viseme": [], "word": []}
    for line, mark in source.events:
        if not isinstance(mark, dict) or not isinstance(mark.get("value"), str):
            raise source.fault("a speech mark needs time, type and value", line)
        start = mark["value"], source.number(mark.get("time"), line), line
        marks.setdefault(str(mark.get("type")), []).append(start)
    if not marks["viseme"]:
        raise source.fault("has no visemes; request them from Polly (--speech-mark-types)")
    rate = MILLISECONDS_PER_SECOND
    rows, told = until_next(source, marks["viseme"], rest=POLLY_REST, rate=rate)
    # A word ends at the start of the next word or rest.
    rests = [row.start for row in rows if row.label == POLLY_REST]
    stops = sorted([start for _, start, _ in marks["word"]] + rests)
    stops.append(max((row.end for row in rows), default=0.0))
    words = [
        LabelRow(text, start, stops[bisect_right(stops, start, hi=len(stops) - 1)], line)
        for text, start, line in marks["word"]
    ]
    return shapes_of(source, rows, notation=POLLY_NOTATION, words=words, rate=rate, remarks=told)
