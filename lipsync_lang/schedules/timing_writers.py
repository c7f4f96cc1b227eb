"""Writers of timings: schedules as files that the readers read back.

JSON keeps all that a schedule has but its sound; a TextGrid has phonemes and words, for Praat.
"""

import json
from collections.abc import Callable, Iterator

from lipsync_lang.schedules.schedule import SILENCE, Schedule

DIGITS = 6
"""Decimals of a time in seconds: microseconds."""

LabelSpan = tuple[str, float, float]
"""Label, start and end in seconds."""


def json_text(schedule: Schedule) -> str:
    """Return a schedule as JSON: phonemes with stress, words with emphasis and confidence.

    Examples
    --------
    >>> from lipsync_lang.schedules.timing_writers import json_text
    >>> print(json_text(ll.Schedule(("M",), [0, 0.1])))
    {
      "phonemes": [
        {"label": "M", "start": 0.0, "end": 0.1}
      ],
      "words": []
    }
    """
    stresses = schedule.stress or (None,) * len(schedule)
    phonemes = [
        {"label": label, "start": start, "end": end}
        | ({} if stress is None else {"stress": stress})
        for (label, start, end), stress in zip(_phonemes(schedule), stresses, strict=True)
    ]
    words = [
        {"text": text, "start": start, "end": end}
        | ({"emphasis": word.emphasis} if word.emphasis else {})
        | ({} if word.confidence is None else {"confidence": round(word.confidence, 2)})
        for (text, start, end), word in zip(_words(schedule), schedule.words, strict=True)
    ]
    stated = {"notation": schedule.notation, "language": schedule.language}
    head = [f'  "{key}": {json.dumps(value)},\n' for key, value in stated.items() if value]
    rows = f'  "phonemes": {_rows(phonemes)},\n  "words": {_rows(words)}\n'
    return f"{{\n{''.join(head)}{rows}}}"


def textgrid_text(schedule: Schedule) -> str:
    """Return a schedule as a TextGrid with tiers of words and phones, as long as its sound.

    Silence is an interval without text. Stress and emphasis have no place in a TextGrid.

    Examples
    --------
    >>> from lipsync_lang.schedules.timing_writers import textgrid_text
    >>> text = textgrid_text(ll.Schedule(("M", "_"), [0, 0.1, 0.3]))
    >>> [line.strip() for line in text.splitlines() if "text =" in line]
    ['text = "M"', 'text = ""']
    """
    heard = 0.0 if schedule.audio is None else schedule.audio.seconds
    start = min(0.0, _seconds(schedule.start))
    end = max(_seconds(schedule.end), _seconds(heard))
    tiers = {"words": _words(schedule), "phones": _phonemes(schedule)}
    lines = [
        'File type = "ooTextFile"', 'Object class = "TextGrid"', "",
        f"xmin = {start}", f"xmax = {end}", "tiers? <exists>", f"size = {len(tiers)}", "item []:",
    ]  # fmt: skip
    for number, (name, spans) in enumerate(tiers.items(), 1):
        lines += _tier(number, name, list(_filled(spans, start, end)))
    return "\n".join(lines) + "\n"


TIMING_WRITERS: dict[str, Callable[[Schedule], str]] = {
    "json": json_text,
    "TextGrid": textgrid_text,
}
"""Functions by the suffix of their file, without the dot."""


def _seconds(value: float) -> float:
    return round(float(value), DIGITS)


def _phonemes(schedule: Schedule) -> Iterator[LabelSpan]:
    times = [_seconds(time) for time in schedule.times]
    yield from zip(schedule.labels, times, times[1:], strict=False)


def _words(schedule: Schedule) -> Iterator[LabelSpan]:
    times = schedule.times
    for word in schedule.words:
        yield word.text, _seconds(times[word.first]), _seconds(times[word.stop])


def _rows(rows: list[dict[str, object]]) -> str:
    """Write a list with one row in each line."""
    told = [f"    {json.dumps(row, ensure_ascii=False)}" for row in rows]
    return "[\n" + ",\n".join(told) + "\n  ]" if told else "[]"


def _filled(spans: Iterator[LabelSpan], start: float, end: float) -> Iterator[LabelSpan]:
    """Yield spans with silence in the gaps: Praat wants a tier without any."""
    at = start
    for label, begin, stop in spans:
        if begin > at:
            yield SILENCE, at, begin
        yield label, begin, stop
        at = stop
    if at < end:
        yield SILENCE, at, end


def _tier(number: int, name: str, spans: list[LabelSpan]) -> Iterator[str]:
    yield f"    item [{number}]:"
    yield '        class = "IntervalTier"'
    yield f'        name = "{name}"'
    yield f"        xmin = {spans[0][1]}"
    yield f"        xmax = {spans[-1][2]}"
    yield f"        intervals: size = {len(spans)}"
    for at, (label, begin, stop) in enumerate(spans, 1):
        text = "" if label == SILENCE else label.replace('"', '""').replace("\n", " ")
        yield f"        intervals [{at}]:"
        yield f"            xmin = {begin}"
        yield f"            xmax = {stop}"
        yield f'            text = "{text}"'
