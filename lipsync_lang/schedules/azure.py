"""Viseme events of Microsoft's Azure speech, as programs that receive them write them down.

An event has the audio offset, in ticks of 100 ns, at which a viseme starts, and the viseme's
number, 0 to 21. Programs write these as JSON: in one list, or one on each line, under the names
of their SDK (`AudioOffset` and `VisemeId`, `audioOffset` and `visemeId`, `audio_offset` and
`viseme_id`, `privAudioOffset` and `privVisemeId`), or as the service sends them, within
``{"Metadata": [{"Type": "Viseme", "Data": {"Offset": ..., "VisemeId": ...}}, ...]}``, where word
boundaries and the end of the session may stand beside them.
"""

import re
from collections.abc import Iterator
from typing import Any

from lipsync_lang.schedules.mouth_shapes import Start, shapes_of, until_next
from lipsync_lang.schedules.rows import LabelRow
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import reader

NOTATION = "azure"

TICKS_PER_SECOND = 1e7
"""Ticks per second."""

LAST_VISEME = 21
"""The last viseme; the first, 0, is silence."""

VISEME = re.compile(r'"(priv)?viseme_?id"\s*:', re.IGNORECASE)

Event = dict[str, Any]


def sniff(source: TimingFile) -> bool:
    """Return True for a JSON object or list with viseme numbers."""
    return source.head.lstrip()[:1] in ("{", "[") and VISEME.search(source.head) is not None


@reader(NOTATION, ".json", ".jsonl", sniff=sniff)
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
    rows, told = until_next(source, starts, rest="0", end=end, rate=TICKS_PER_SECOND)
    return shapes_of(
        source, rows, notation=NOTATION, words=words, rate=TICKS_PER_SECOND, remarks=told
    )


def _events(source: TimingFile) -> Iterator[tuple[int | None, Event]]:
    """Yield (line, event); field names have one spelling for all SDKs."""
    for line, value in source.events:
        inner = value.get("Metadata") if isinstance(value, dict) else None
        for one in inner if isinstance(inner, list) else [value]:
            if not isinstance(one, dict):
                raise source.fault("an event needs an audio offset and a viseme ID", line)
            data = one.get("Data")
            flat = {**one, **data} if isinstance(data, dict) else one
            yield line, {_plain(name): value for name, value in flat.items()}


def _plain(name: str) -> str:
    """Return the name of a field without the prefixes and the case of its SDK."""
    return re.sub(r"^(priv)?(audio)?", "", name.replace("_", "").lower())


def _number(source: TimingFile, value: object, line: int | None) -> str:
    """Return the label of a viseme."""
    if isinstance(value, int) and not isinstance(value, bool) and 0 <= value <= LAST_VISEME:
        return str(value)
    raise source.fault(
        f"{str(value)[:20]!r} is no viseme; they are numbered 0 to {LAST_VISEME}", line
    )
