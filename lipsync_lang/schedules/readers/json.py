"""Our own JSON: phonemes and words with start and end in seconds."""

from dataclasses import replace
from typing import Any

from lipsync_lang.schedules.rows import is_pause
from lipsync_lang.schedules.schedule import Schedule, words_from_spans
from lipsync_lang.schedules.timing_file import TimingFile, first_item
from lipsync_lang.schedules.timing_readers import reader

TIMINGS_FORM = (
    '{"phonemes": [{"label": "HH", "start": 0.0, "end": 0.08}, ...], "words": [{"text": ...}]}'
)


def sniff(source: TimingFile) -> bool:
    """Return True if the JSON has phonemes, or rows with a label, a start and an end."""
    if isinstance(source.document, list):
        first = first_item(source.document)
        return isinstance(first, dict) and first.keys() >= {"label", "start", "end"}
    # Others list symbols there, without times.
    return source.holds("phonemes") and not isinstance(first_item(source.json["phonemes"]), str)


@reader("json", ".json", sniff=sniff)
def read_json(source: TimingFile) -> Schedule:
    """Phonemes and words with their label or text, start and end in seconds."""
    whole = source.json if isinstance(source.json, dict) else {"phonemes": source.json}
    rows, words = whole.get("phonemes"), whole.get("words")
    if not isinstance(rows, list):
        raise source.fault(f"has no list of phonemes; the form is {TIMINGS_FORM}")
    spans = _spans(source, rows, "phoneme", "label")
    # a pause without length is no phoneme
    heard = [
        at for at, (label, start, end) in enumerate(spans) if start != end or not is_pause(label)
    ]
    stresses = tuple(rows[at].get("stress") for at in heard)
    notation, language = whole.get("notation"), whole.get("language")
    schedule = Schedule.from_intervals(
        [spans[at] for at in heard],
        source=str(source.path),
        notation=notation if isinstance(notation, str) else None,
        language=language if isinstance(language, str) else None,
        stress=stresses if any(one is not None for one in stresses) else (),
    )
    if words is None:
        return schedule
    if not isinstance(words, list):
        raise source.fault(f"words must be a list; the form is {TIMINGS_FORM}")
    spans = _spans(source, words, "word", "text")
    return replace(schedule, words=words_from_spans(schedule, spans, list(map(_facts, words))))


def _facts(word: dict[str, Any]) -> dict[str, Any]:
    """Return the emphasis, confidence and mark of a word; `Schedule` refuses other emphasis."""
    level = word.get("emphasis", 0)
    return {
        "emphasis": float(level) if isinstance(level, bool) else level,
        "confidence": _probability(word.get("confidence")),
        "relabelled": word.get("relabelled") is True,
    }


def _spans(
    source: TimingFile, rows: list[Any], what: str, name: str
) -> list[tuple[str, float, float]]:
    """Return (label, start, end) of rows, in seconds; `Schedule` refuses times of other types."""
    for number, row in enumerate(rows):
        known = isinstance(row, dict) and {"start", "end"} <= row.keys()
        if not known or not isinstance(row.get(name), str):
            needs = f"{what} {number} needs {name}, start and end"
            raise source.fault(f"{needs}; the form is {TIMINGS_FORM}")
    spans = [(row[name], row["start"], row["end"]) for row in rows]
    if source.rate is None:
        return spans
    read, rate = source.number, source.rate
    return [(label, read(start) / rate, read(end) / rate) for label, start, end in spans]


def _probability(value: object) -> float | None:
    """Return the confidence of a word; None for anything but a number from 0 to 1."""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value <= 1:
        return None
    return float(value)
