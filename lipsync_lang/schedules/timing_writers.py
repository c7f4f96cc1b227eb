"""Writers of timings: schedules as files that the readers read back.

JSON keeps all that a schedule has but its sound. A TextGrid, an ELAN document and a table have
phonemes, words and their confidence; a label track has phonemes alone. Stress and emphasis have no
place there. All but JSON leave out times before zero.
"""

import csv
import json
from collections.abc import Callable, Iterable, Iterator
from io import StringIO
from pathlib import Path

from lipsync_lang.errors import OutputError
from lipsync_lang.files import argument_path, atomic
from lipsync_lang.files.xml_text import xml_text
from lipsync_lang.schedules.elan_document import elan_document
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.schedules.tiers import CONFIDENCE

DIGITS = 6
"""Decimals of a time in seconds: microseconds."""

CONFIDENCE_DIGITS = 2
"""Decimals of a confidence."""

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
    times = [_seconds(time) for time in schedule.times]
    phonemes = [
        {"label": label, "start": start, "end": end}
        | ({} if stress is None else {"stress": stress})
        for label, start, end, stress in zip(
            schedule.labels, times, times[1:], stresses, strict=False
        )
    ]
    words = [
        {"text": word.text, "start": times[word.first], "end": times[word.stop]}
        | ({"emphasis": word.emphasis} if word.emphasis else {})
        | (
            {}
            if word.confidence is None
            else {"confidence": round(word.confidence, CONFIDENCE_DIGITS)}
        )
        for word in schedule.words
    ]
    stated = {"notation": schedule.notation, "language": schedule.language}
    head = [f'  "{key}": {json.dumps(value)},\n' for key, value in stated.items() if value]
    rows = f'  "phonemes": {_rows(phonemes)},\n  "words": {_rows(words)}\n'
    return f"{{\n{''.join(head)}{rows}}}"


def textgrid_text(schedule: Schedule) -> str:
    """Return a schedule as a TextGrid with tiers of words and phones, as long as its sound.

    Silence is an interval without text. Confidences, if any, are a third tier.

    Examples
    --------
    >>> from lipsync_lang.schedules.timing_writers import textgrid_text
    >>> text = textgrid_text(ll.Schedule(("M", "_"), [0, 0.1, 0.3]))
    >>> [line.strip() for line in text.splitlines() if "text =" in line]
    ['text = "M"', 'text = ""']
    """
    heard = 0.0 if schedule.audio is None else schedule.audio.seconds
    end = max(_seconds(schedule.end), _seconds(heard))
    tiers = tiers_of(schedule)
    lines = [
        'File type = "ooTextFile"', 'Object class = "TextGrid"', "",
        "xmin = 0.0", f"xmax = {end}", "tiers? <exists>", f"size = {len(tiers)}", "item []:",
    ]  # fmt: skip
    for number, (name, spans) in enumerate(tiers.items(), 1):
        lines += _tier(number, name, list(_filled(spans, end)))
    return "\n".join(lines) + "\n"


def elan_text(schedule: Schedule) -> str:
    """Return a schedule as an ELAN document with tiers of words and phones, in milliseconds.

    Silence is left out, but for that at the end. Confidences, if any, are a tier that refers to the
    words.
    """
    tiers = tiers_of(schedule)
    phones = tiers["phones"]
    sounds = [one for one in phones[:-1] if one[0] != SILENCE] + phones[-1:]
    return elan_document(
        {"words": tiers["words"], "phones": sounds}, refers={CONFIDENCE: tiers.get(CONFIDENCE, [])}
    )


def table_text(schedule: Schedule) -> str:
    """Return a schedule as a CSV table: begin, end, label and type of each word and phone."""
    out = StringIO()
    tiers = tiers_of(schedule)
    sure = tiers.pop(CONFIDENCE, [])
    rated = {start: label for label, start, _ in sure}
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(["Begin", "End", "Label", "Type", *(["Confidence"] if sure else [])])
    for kind, spans in tiers.items():
        for label, start, end in spans:
            rate = rated.get(start, "") if kind == "words" else ""
            rows.writerow([start, end, label, kind, *([rate] if sure else [])])
    return out.getvalue()


def label_track_text(schedule: Schedule) -> str:
    """Return the phonemes of a schedule as a label track for Audacity; its words are left out."""
    spans = tiers_of(schedule)["phones"]
    return "".join(
        f"{start:.{DIGITS}f}\t{end:.{DIGITS}f}\t{label}\n" for label, start, end in spans
    )


TIMING_WRITERS: dict[str, Callable[[Schedule], str]] = {
    "json": json_text,
    "TextGrid": textgrid_text,
    "eaf": elan_text,
    "csv": table_text,
    "txt": label_track_text,
}
"""Functions by the suffix of their file, without the dot."""


def save_timings(schedule: Schedule, path: str | Path) -> None:
    """Write a schedule to a file, all at once; see `Schedule.save`."""
    target = argument_path(path)
    write = {f".{suffix.lower()}": one for suffix, one in TIMING_WRITERS.items()}
    found = write.get(target.suffix.lower())
    if found is None:
        raise OutputError(
            f"{target}: timings cannot be written as '{target.suffix}'; use the suffix "
            f"{', '.join(write)}"
        )
    with atomic(target) as stream:
        stream.write(found(schedule).encode("utf-8"))


def tiers_of(schedule: Schedule) -> dict[str, list[LabelSpan]]:
    """Return the tiers of a schedule from time zero on: words, phones and maybe confidences.

    Texts have single spaces and no line breaks. Times have `DIGITS` decimals.
    """
    times = [_seconds(time) for time in schedule.times]
    words = [(word, times[word.first], times[word.stop]) for word in schedule.words]
    sure = [
        (f"{word.confidence:.{CONFIDENCE_DIGITS}f}", start, end)
        for word, start, end in words
        if word.confidence is not None
    ]
    tiers = {
        "words": _late((word.text, start, end) for word, start, end in words),
        "phones": _late(zip(schedule.labels, times, times[1:], strict=False)),
        CONFIDENCE: _late(sure),
    }
    return {name: spans for name, spans in tiers.items() if spans or name != CONFIDENCE}


def _late(spans: Iterable[LabelSpan]) -> list[LabelSpan]:
    """Return spans from time zero on, with texts of one line, of characters that readers take."""
    return [
        (" ".join(xml_text(label).split()) or SILENCE, max(start, 0.0), end)
        for label, start, end in spans
        if end > 0
    ]


def _seconds(value: float) -> float:
    return round(float(value), DIGITS)


def _rows(rows: list[dict[str, object]]) -> str:
    """Write a list with one row in each line."""
    told = [f"    {json.dumps(row, ensure_ascii=False)}" for row in rows]
    return "[\n" + ",\n".join(told) + "\n  ]" if told else "[]"


def _filled(spans: Iterable[LabelSpan], end: float) -> Iterator[LabelSpan]:
    """Yield spans with silence in the gaps: Praat needs a tier without gaps."""
    at = 0.0
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
        text = "" if label == SILENCE else label.replace('"', '""')
        yield f"        intervals [{at}]:"
        yield f"            xmin = {begin}"
        yield f"            xmax = {stop}"
        yield f'            text = "{text}"'
