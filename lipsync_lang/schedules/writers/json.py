"""Timings as JSON, which keeps all that a schedule has but its sound."""

import json

from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.tiers import CONFIDENCE_DIGITS, TIME_DIGITS


def json_text(schedule: Schedule) -> str:
    """Return a schedule as JSON: phonemes with stress, words with emphasis and confidence.

    Examples
    --------
    >>> from lipsync_lang.schedules.writers.json import json_text
    >>> print(json_text(ll.Schedule(("M",), [0, 0.1])))
    {
      "phonemes": [
        {"label": "M", "start": 0.0, "end": 0.1}
      ],
      "words": []
    }
    """
    stresses = schedule.stress or (None,) * len(schedule)
    times = [round(float(time), TIME_DIGITS) for time in schedule.times]
    sounds = zip(schedule.labels, times, times[1:], stresses, strict=False)
    phonemes = [
        {"label": label, "start": start, "end": end}
        | ({} if stress is None else {"stress": stress})
        for label, start, end, stress in sounds
    ]
    words = [
        {"text": word.text, "start": times[word.first], "end": times[word.stop]}
        | ({"emphasis": word.emphasis} if word.emphasis else {})
        | ({} if sure is None else {"confidence": round(sure, CONFIDENCE_DIGITS)})
        | ({"relabelled": True} if word.relabelled else {})
        for word, sure in ((word, word.confidence) for word in schedule.words)
    ]
    stated = {"notation": schedule.notation, "language": schedule.language}
    head = [f'  "{key}": {json.dumps(value)},\n' for key, value in stated.items() if value]
    rows = f'  "phonemes": {_rows(phonemes)},\n  "words": {_rows(words)}\n'
    return f"{{\n{''.join(head)}{rows}}}"


def _rows(rows: list[dict[str, object]]) -> str:
    """Write a list with one row in each line."""
    lines = [f"    {json.dumps(row, ensure_ascii=False)}" for row in rows]
    return "[\n" + ",\n".join(lines) + "\n  ]" if lines else "[]"
