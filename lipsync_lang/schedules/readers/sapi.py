"""Viseme events of Microsoft's speech interface (SAPI 5, System.Speech), written down as JSON.

An event of `VisemeReached` has the `AudioPosition` at which a viseme starts, the `Duration` that
it lasts, and its number under `Viseme`, 0 to 21. Positions and durations are spans of time as .NET
writes them: "00:00:01.2340000", or an object whose `Ticks` count 100 ns. The events are in one
list, or one on each line.
"""

import re

from lipsync_lang.schedules import LabelRow, Schedule, TimingFile, reader
from lipsync_lang.schedules.readers.azure import LAST_VISEME, TICKS_PER_SECOND
from lipsync_lang.schedules.rows import shapes_of

SAPI_NOTATION = "sapi-visemes"

SAPI_SPAN = re.compile(r"(?:(\d{1,4})\.)?(\d\d):(\d\d):(\d\d(?:\.\d{1,9})?)", re.ASCII)
"""Days, hours, minutes and seconds."""


def sniff(source: TimingFile) -> bool:
    """Return True for a JSON object or list with visemes at audio positions."""
    named = all(f'"{name}"' in source.head for name in ("AudioPosition", "Viseme"))
    return named and source.head.lstrip()[:1] in ("{", "[")


@reader("sapi", ".json", ".jsonl", sniff=sniff)
def read_sapi(source: TimingFile) -> Schedule:
    """Viseme events of Windows speech (SAPI), in a JSON list or one on each line."""
    rows: list[LabelRow] = []
    for line, event in source.events:
        if not isinstance(event, dict) or event.get("Viseme") not in range(LAST_VISEME + 1):
            what = f"an event needs AudioPosition, Duration and a Viseme from 0 to {LAST_VISEME}"
            raise source.fault(what, line)
        start = _seconds(source, event.get("AudioPosition"), line)
        length = _seconds(source, event.get("Duration"), line)
        rows.append(LabelRow(str(int(event["Viseme"])), start, start + length, line))
    return shapes_of(source, [row for row in rows if row.end > row.start], notation=SAPI_NOTATION)


def _seconds(source: TimingFile, value: object, line: int | None) -> float:
    if isinstance(value, dict):
        return source.number(value.get("Ticks"), line) / TICKS_PER_SECOND
    found = SAPI_SPAN.fullmatch(value) if isinstance(value, str) else None
    if found is None:
        shown = repr(value)[:40]
        raise source.fault(f"{shown} is not a span of time such as '00:00:01.2340000'", line)
    days, hours, minutes, seconds = found.groups(default="0")
    return ((int(days) * 24 + int(hours)) * 60 + int(minutes)) * 60 + float(seconds)
