"""JSON of our own: the plainest schedule."""

import json
from pathlib import Path

from lipsync_lang.errors import ScheduleError
from lipsync_lang.schedules.registry import reader
from lipsync_lang.schedules.schedule import Schedule, words_from_spans

SHAPE = '{"phonemes": [{"label": "HH", "start": 0.0, "end": 0.08}, ...], "words": [{"text": ...}]}'


@reader("json", ".json")
def read_json(path: Path, content: bytes) -> Schedule:
    """Phonemes and words with their label or text, start and end in seconds."""
    try:
        document = json.loads(content.decode("utf-8-sig"), parse_int=float)
    except UnicodeDecodeError as error:
        raise ScheduleError(
            f"{path}: is not UTF-8 text (byte {error.start}); save it as UTF-8"
        ) from None
    except json.JSONDecodeError as error:
        raise ScheduleError(
            f"{path}:{error.lineno}:{error.colno}: not JSON: {error.msg}; the form is {SHAPE}"
        ) from None
    except RecursionError:
        raise ScheduleError(
            f"{path}: is nested too deep for a schedule; the form is {SHAPE}"
        ) from None
    rows = document.get("phonemes") if isinstance(document, dict) else document
    if not isinstance(rows, list):
        raise ScheduleError(f"{path}: has no list of phonemes; the form is {SHAPE}")
    schedule = Schedule.from_intervals(
        [_row(path, "phoneme", "label", n, row) for n, row in enumerate(rows)],
        source=str(path),
        notation=_text(document, "notation"),
        language=_text(document, "language"),
    )
    words = document.get("words") if isinstance(document, dict) else None
    return schedule if words is None else _with_words(path, schedule, words)


def _text(document: object, key: str) -> str | None:
    value = document.get(key) if isinstance(document, dict) else None
    return value if isinstance(value, str) else None


def _row(path: Path, what: str, name: str, number: int, row: object) -> tuple[str, float, float]:
    if isinstance(row, dict) and isinstance(row.get(name), str) and {"start", "end"} <= row.keys():
        return row[name], row["start"], row["end"]
    raise ScheduleError(f"{path}: {what} {number} needs {name}, start and end; the form is {SHAPE}")


def _with_words(path: Path, schedule: Schedule, rows: object) -> Schedule:
    if not isinstance(rows, list):
        raise ScheduleError(f"{path}: words must be a list; the form is {SHAPE}")
    from dataclasses import replace

    spans = [_row(path, "word", "text", n, row) for n, row in enumerate(rows)]
    return replace(schedule, words=words_from_spans(schedule, spans))
