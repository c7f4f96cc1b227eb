"""Our own JSON: phonemes and words with start and end in seconds."""

from dataclasses import replace
from typing import Any

from lipsync_lang.schedules.schedule import Schedule, words_from_spans
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import reader

TIMINGS_FORM = (
    '{"phonemes": [{"label": "HH", "start": 0.0, "end": 0.08}, ...], "words": [{"text": ...}]}'
)


def sniff(source: TimingFile) -> bool:
    """Return True if the JSON has phonemes, or rows with a label, a start and an end."""
    if isinstance(source.document, list):
        first = source.document[0] if source.document else None
        return isinstance(first, dict) and first.keys() >= {"label", "start", "end"}
    return source.holds("phonemes")


@reader("json", ".json", sniff=sniff)
def read_json(source: TimingFile) -> Schedule:
    """Phonemes and words with their label or text, start and end in seconds."""
    document = source.json
    rows = document.get("phonemes") if isinstance(document, dict) else document
    if not isinstance(rows, list):
        raise source.fault(f"has no list of phonemes; the form is {TIMINGS_FORM}")
    stresses = [row.get("stress") if isinstance(row, dict) else None for row in rows]
    stated = any(one is not None for one in stresses)
    schedule = Schedule.from_intervals(
        [_row(source, "phoneme", "label", n, row) for n, row in enumerate(rows)],
        source=str(source.path),
        notation=_text(document, "notation"),
        language=_text(document, "language"),
        stress=tuple(stresses) if stated else (),
    )
    words = document.get("words") if isinstance(document, dict) else None
    return schedule if words is None else _with_words(source, schedule, words)


def _text(document: object, key: str) -> str | None:
    value = document.get(key) if isinstance(document, dict) else None
    return value if isinstance(value, str) else None


def _row(
    source: TimingFile, what: str, name: str, number: int, row: object
) -> tuple[str, float, float]:
    if isinstance(row, dict) and isinstance(row.get(name), str) and {"start", "end"} <= row.keys():
        return row[name], _seconds(source, row["start"]), _seconds(source, row["end"])
    raise source.fault(f"{what} {number} needs {name}, start and end; the form is {TIMINGS_FORM}")


def _seconds(source: TimingFile, value: Any) -> Any:
    """Return a time in seconds; without a rate, `Schedule` refuses non-numbers."""
    return source.number(value) / source.rate if source.rate else value


def _with_words(source: TimingFile, schedule: Schedule, rows: object) -> Schedule:
    if not isinstance(rows, list):
        raise source.fault(f"words must be a list; the form is {TIMINGS_FORM}")
    spans = [_row(source, "word", "text", n, row) for n, row in enumerate(rows)]
    stated = [row.get("emphasis", 0) if isinstance(row, dict) else 0 for row in rows]
    emphasis = [float(one) if isinstance(one, bool) else one for one in stated]
    sure = [_probability(row) for row in rows]
    return replace(schedule, words=words_from_spans(schedule, spans, emphasis, sure))


def _probability(row: object) -> float | None:
    """Return the confidence of a word; None if it states none from 0 to 1."""
    value = row.get("confidence") if isinstance(row, dict) else None
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not 0 <= value <= 1:
        return None
    return float(value)
