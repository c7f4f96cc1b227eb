"""Viseme events of Microsoft's Azure speech, as programs that receive them write them down.

An event has the audio offset, in ticks of 100 ns, at which a viseme starts, and the viseme's
number, 0 to 21. Programs write these as JSON: in one list, or one on each line, under the names
of their SDK (`AudioOffset` and `VisemeId`, `audioOffset` and `visemeId`, `audio_offset` and
`viseme_id`, `privAudioOffset` and `privVisemeId`), some with offsets turned to milliseconds or
seconds, or as the service sends them, within
``{"Metadata": [{"Type": "Viseme", "Data": {"Offset": ..., "VisemeId": ...}}, ...]}``, where word
boundaries and the end of the session may stand beside them.
"""

import re
from collections.abc import Iterator
from itertools import pairwise
from math import inf

from lipsync_lang.base.json_object import Json
from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader
from lipsync_lang.schedules.rows import Start, shapes_of, until_next
from lipsync_lang.schedules.timing_file import plain_fields

AZURE_NOTATION = "azure"
TICKS_PER_SECOND = 1e7

UNITS = {"ticks": TICKS_PER_SECOND, "milliseconds": 1000.0, "seconds": 1.0}
"""Units per second of offsets, the smallest unit first."""

SHORT_SECONDS = 0.002
"""No text has visemes that are this close to each other in the median."""

LAST_VISEME = 21
"""The last viseme; the first, 0, is silence."""

PREFIXES = re.compile(r"^(?:priv)?(?:audio)?(?:(offset).*)?", re.DOTALL)
"""Parts of a field's name that depend on the program, and the unit of an offset."""

VISEME = re.compile(r'"(priv)?viseme_?id"\s*:', re.IGNORECASE)


def sniff(source: TimingFile) -> bool:
    """Return True for a JSON object or list with viseme numbers."""
    return source.head.lstrip()[:1] in ("{", "[") and VISEME.search(source.head) is not None


@reader(AZURE_NOTATION, ".json", ".jsonl", sniff=sniff)
def read_azure(source: TimingFile) -> Schedule:
    """Viseme events of Azure speech, in a JSON list or one on each line."""
    starts: list[Start] = []
    words: list[LabelRow] = []
    end = None
    for line, event in _events(source):
        at = source.number(event.get("offset"), line)
        if "visemeid" in event:
            starts.append((_number(source, event["visemeid"], line), at, line))
        elif event.get("type") == "SessionEnd":
            end = at
        elif isinstance(event.get("text"), dict) and event["text"].get("BoundaryType") == "Word":
            length = source.number(event.get("duration"), line)
            words.append(LabelRow(str(event["text"].get("Text")), at, at + length, line))
    from statistics import median

    offsets = sorted(at for _, at, _ in starts)
    steps = [after - before for before, after in pairwise(offsets) if after > before]
    usual = median(steps) if steps else inf
    # a smaller unit than the true one would put all visemes within milliseconds
    unit = next((u for u in UNITS if usual / UNITS[u] >= SHORT_SECONDS), "seconds")
    rate = UNITS[unit]
    rows, told = until_next(source, starts, rest="0", end=end, rate=rate)
    if rate != TICKS_PER_SECOND and source.rate is None:
        what = f"its offsets are read as {unit}; if they are not, state how many make a second"
        told.append(f"{source.path}: {what} (`rate={rate:g}`)")
    return shapes_of(source, rows, notation=AZURE_NOTATION, words=words, rate=rate, remarks=told)


def _events(source: TimingFile) -> Iterator[tuple[int | None, Json]]:
    """Yield (line, event); field names have one spelling for all SDKs."""
    for line, value in source.events:
        inner = value.get("Metadata") if isinstance(value, dict) else None
        for one in inner if isinstance(inner, list) else [value]:
            if not isinstance(one, dict):
                raise source.fault("an event needs an audio offset and a viseme ID", line)
            data = one.get("Data")
            flat = {**one, **data} if isinstance(data, dict) else one
            named = plain_fields(flat).items()
            yield line, {PREFIXES.sub(r"\1", name): field for name, field in named}


def _number(source: TimingFile, value: object, line: int | None) -> str:
    """Return the label of a viseme."""
    if isinstance(value, str) and value.isdecimal() and len(value) <= len(str(LAST_VISEME)):
        value = int(value)
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= LAST_VISEME:
        return str(value)
    what = f"{str(value)[:20]!r} is not a viseme; visemes are numbered 0 to {LAST_VISEME}"
    raise source.fault(what, line)
