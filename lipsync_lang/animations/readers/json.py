"""JSON files of this program: curves, phonemes and words."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from lipsync_lang.animations.animation_readers import Recording, fail, reader
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import AnimationError, ScheduleError
from lipsync_lang.base.files.reading import utf8_text
from lipsync_lang.schedules.schedule import Schedule

ANIMATION_MARK = "lipsync-lang animation "
ANIMATION_FORM = (
    f'it is {{"format": "{ANIMATION_MARK}1", "fps": ..., "start": ..., "poses": [...], '
    '"frames": [...]}'
)


@reader("json", suffix=".json")
def read_json(path: Path, content: bytes) -> Recording:
    """The JSON that `-o line.json` writes, with the phonemes and words performed."""
    try:
        document = json.loads(utf8_text(path, content, AnimationError))
    except json.JSONDecodeError as error:
        fail(f"{path}:{error.lineno}:{error.colno}", f"not JSON: {error.msg}", ANIMATION_FORM)
    except ValueError:  # a number with thousands of digits
        fail(path, "has a number that an animation cannot have", ANIMATION_FORM)
    except RecursionError:
        fail(path, "is nested too deep for an animation", ANIMATION_FORM)
    if not isinstance(document, dict) or not str(document.get("format")).startswith(ANIMATION_MARK):
        fail(path, "is JSON, but not an animation of this program", ANIMATION_FORM)
    names = document.get("poses")
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        fail(path, "its poses are not a list of names", ANIMATION_FORM)
    # the names are checked: frames are counted by them
    frames = _frames(path, document)
    fps, start = (_number(path, document, key) for key in ("fps", "start"))
    if fps <= 0:
        fail(path, f"has {fps:g} frames per second", "give a number above 0")
    with np.errstate(over="ignore"):  # of infinite times, the caller says so
        times = start + np.arange(len(frames)) / fps
    return Recording(str(path), times, tuple(names), frames, _schedule(path, document))


def _number(path: Path, document: dict[str, Any], key: str) -> float:
    value = document.get(key)
    if not isinstance(value, (int, float)) or isinstance(value, bool):
        fail(path, f"its `{key}` is not a number", ANIMATION_FORM)
    try:
        return float(value)
    except OverflowError:
        fail(path, f"its `{key}` is larger than any number of an animation", ANIMATION_FORM)


def _frames(path: Path, document: dict[str, Any]) -> Floats:
    rows, count = document.get("frames"), len(document["poses"])
    if not isinstance(rows, list):
        fail(path, "its frames are not a list", ANIMATION_FORM)
    for number, row in enumerate(rows):
        good = isinstance(row, list) and len(row) == count
        if not good or not all(isinstance(v, (int, float)) for v in row):
            fail(path, f"frame {number} is not a list of {count} numbers", ANIMATION_FORM)
    try:
        return np.array(rows, float).reshape(len(rows), count)
    except OverflowError:
        fail(path, "a value of its frames is larger than any weight", ANIMATION_FORM)


def _schedule(path: Path, document: dict[str, Any]) -> Schedule | None:
    """Return the schedule of a file, if present."""
    rows = document.get("phonemes")
    if not isinstance(rows, list) or not rows:
        return None
    try:
        spans = [(row["label"], row["start"], row["end"]) for row in rows]
        stated = {name: document.get(name) for name in ("notation", "language")}
        return Schedule.from_intervals(spans, source=str(path), **stated)
    except (KeyError, TypeError, ScheduleError) as error:
        fail(path, f"its phonemes are invalid ({error})", "each needs label, start and end")
