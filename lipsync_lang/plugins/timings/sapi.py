"""Events of Microsoft's speech interface (SAPI 5, System.Speech), written down as JSON.

An event of `VisemeReached` or `PhonemeReached` has the `AudioPosition` at which it starts, the
`Duration` that it lasts, and its number under `Viseme`, 0 to 21, or its IPA under `Phoneme`.
Positions and durations are spans of time as .NET writes them: "00:00:01.2340000", or an object
whose `Ticks` count 100 ns. An event `Phoneme` of the automation object SpVoice has a
`CurrentPhoneId`, a number in the table of its language, and a `Duration` in milliseconds; one
follows the other. Its `StreamPosition` counts bytes of a sound that it does not describe, and is
not read. The numbers 1 to 9 and their symbols are marks: the pause is silence, stress belongs to
the phoneme before it, and boundaries have no sound. The events are in one list, or one on each
line. If a file has phonemes, they are read, and its visemes are not.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace

from lipsync_lang.base.json_object import Json
from lipsync_lang.plugins.timings.azure import LAST_VISEME, TICKS_PER_SECOND
from lipsync_lang.schedules import SILENCE, LabelRow, Schedule, TimingFile, reader, schedule_of
from lipsync_lang.schedules.rows import MILLISECONDS_PER_SECOND, shapes_of

SAPI_NOTATION = "sapi-visemes"

SAPI_IDS = "sapi-ids"

SAPI_SPAN = re.compile(r"(?:(\d{1,4})\.)?(\d\d):(\d\d):(\d\d(?:\.\d{1,9})?)", re.ASCII)
"""Days, hours, minutes and seconds."""

SILENT_ID = 7

STRESS_IDS = {8: 1, 9: 2}
"""Level of each mark of stress."""

LAST_MARK = 9

SAPI_MARKS = {symbol: number for number, symbol in enumerate("-!&,.?_12", 1)}
"""Number of each mark that a program may write as a symbol."""

STRESS_BIT = 1
"""The bit of `Feature` and `Emphasis` for a stressed phoneme."""

LAST_ID = 0xFFFF

Numbered = tuple[int | None, Json]
"""A line of the file and an event."""


def sniff(source: TimingFile) -> bool:
    """Return True for a JSON object or list with visemes or phonemes of this interface."""
    named = '"CurrentPhoneId"' in source.head or (
        '"AudioPosition"' in source.head
        and any(f'"{name}"' in source.head for name in ("Viseme", "Phoneme"))
    )
    return named and source.head.lstrip()[:1] in ("{", "[")


@reader("sapi", ".json", ".jsonl", sniff=sniff)
def read_sapi(source: TimingFile) -> Schedule:
    """Viseme or phoneme events of Windows speech (SAPI), in a JSON list or one on each line."""
    events: list[Numbered] = []
    for line, event in source.events:
        if not isinstance(event, dict):
            raise source.fault(
                "an event must be an object; it has AudioPosition and Duration", line
            )
        events.append((line, event))
    numbered = [one for one in events if "CurrentPhoneId" in one[1]]
    if numbered:
        return _phonemes(source, numbered, _numbered_rows(source, numbered), SAPI_IDS)
    spelled = [one for one in events if "Phoneme" in one[1]]
    if spelled:
        return _phonemes(source, spelled, _rows(source, spelled, _symbol), None)
    rows = [row for row in _rows(source, events, _viseme) if row.end > row.start]
    return shapes_of(source, rows, notation=SAPI_NOTATION)


def _rows(
    source: TimingFile,
    events: Sequence[Numbered],
    label: Callable[[TimingFile, Json, int | None], str],
) -> list[LabelRow]:
    """Return the rows of events that state their position."""
    rows: list[LabelRow] = []
    for line, event in events:
        text = label(source, event, line)
        start = _seconds(source, event.get("AudioPosition"), line)
        length = _length(source, _seconds(source, event.get("Duration"), line), line)
        rows.append(LabelRow(text, start, start + length, line))
    return rows


def _viseme(source: TimingFile, event: Json, line: int | None) -> str:
    if event.get("Viseme") not in range(LAST_VISEME + 1):
        what = f"an event needs AudioPosition, Duration and a Viseme from 0 to {LAST_VISEME}"
        raise source.fault(what, line)
    return str(int(event["Viseme"]))


def _symbol(source: TimingFile, event: Json, line: int | None) -> str:
    if not isinstance(event["Phoneme"], str):
        raise source.fault(f"{event['Phoneme']!r} is not a phoneme; write its IPA as text", line)
    return str(event["Phoneme"]).strip()


def _numbered_rows(source: TimingFile, events: Sequence[Numbered]) -> list[LabelRow]:
    """Return the rows of events that follow each other."""
    rows: list[LabelRow] = []
    start = 0.0
    for line, event in events:
        number = event["CurrentPhoneId"]
        # In Python, True is in a range from 0, and so is 3.0.
        if isinstance(number, bool) or number not in range(LAST_ID + 1):
            what = f"{number!r} is not the number of a phoneme; they are 0 to {LAST_ID}"
            raise source.fault(what, line)
        length = _length(source, source.number(event.get("Duration"), line), line)
        rate = source.rate or MILLISECONDS_PER_SECOND
        rows.append(LabelRow(str(int(number)), start, start + length / rate, line))
        start = rows[-1].end
    return rows


def _phonemes(
    source: TimingFile, events: Sequence[Numbered], rows: Sequence[LabelRow], notation: str | None
) -> Schedule:
    """Return the schedule of phonemes, each with the stress that marks it."""
    sounds: list[LabelRow] = []
    levels: list[int | None] = []
    for (_, event), row in zip(events, rows, strict=True):
        mark = int(row.label) if notation else SAPI_MARKS.get(row.label, LAST_MARK + 1)
        if mark == SILENT_ID or not row.label:
            sounds.append(row._replace(label=SILENCE))
            levels.append(None)
        elif 0 < mark <= LAST_MARK:
            if sounds and mark in STRESS_IDS:
                levels[-1] = STRESS_IDS[mark]
        elif row.end > row.start:
            sounds.append(row)
            levels.append(1 if _has_stress(event) else None)
    # the durations of numbered events have their rate already
    found = schedule_of(
        replace(source, rate=None) if notation else source, sounds, notation=notation
    )
    if not any(levels):
        return found
    spoken = (level for row, level in zip(sounds, levels, strict=True) if row.label != SILENCE)
    stress = tuple(None if label == SILENCE else next(spoken) for label in found.labels)
    return replace(found, stress=stress)


def _has_stress(event: Json) -> bool:
    flags = event.get("Feature", event.get("Emphasis", 0))
    return isinstance(flags, int) and bool(flags & STRESS_BIT)


def _length(source: TimingFile, length: float, line: int | None) -> float:
    """Return a duration; one below 0 would move the sounds after it."""
    if length < 0:
        raise source.fault(f"a Duration of {length:g} is below 0; write 0 or more", line)
    return length


def _seconds(source: TimingFile, value: object, line: int | None) -> float:
    if isinstance(value, dict):
        return source.number(value.get("Ticks"), line) / TICKS_PER_SECOND
    found = SAPI_SPAN.fullmatch(value) if isinstance(value, str) else None
    if found is None:
        shown = repr(value)[:40]
        raise source.fault(f"{shown} is not a span of time such as '00:00:01.2340000'", line)
    days, hours, minutes, seconds = found.groups(default="0")
    return ((int(days) * 24 + int(hours)) * 60 + int(minutes)) * 60 + float(seconds)
