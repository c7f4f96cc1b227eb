"""Takes of Live Link Face: a timecode, a count, and a column for each shape or turn of the head.

Timecodes are `HH:MM:SS:FF.mmm`: the fraction is of a frame. How many frames a second has, the file
does not say; the greatest number of a frame that it holds does.
"""

import csv
import re
from pathlib import Path

import numpy as np

from lipsync_lang.animations.readers.animation_readers import (
    Floats,
    Recording,
    fail,
    reader,
    text_of,
)

CODE = re.compile(r"(\d+):(\d+):(\d+)[:;](\d+(?:\.\d+)?)")

RATES = (24, 25, 30, 48, 50, 60, 90, 100, 120, 240)
"""Frames per second of cameras and timecodes."""

USUAL = 60
"""Frames per second where a take is too short to tell."""

LEADING = 2
"""Columns before those of curves: the timecode and the count."""


def fits(content: bytes) -> bool:
    """Tell whether a table begins as these takes do."""
    first = content[:200].lower().lstrip(b"\xef\xbb\xbf")
    return first.replace(b" ", b"").startswith(b"timecode,blendshapecount")


@reader("live-link-face", suffix=".csv", fits=fits)
def read_live_link(path: Path, content: bytes) -> Recording:
    """Live Link Face: `Timecode,BlendShapeCount`, then a column for each shape; time from 0."""
    rows = list(csv.reader(text_of(path, content).splitlines()))
    head, takes = [name.strip() for name in rows[0]], [row for row in rows[1:] if any(row)]
    codes = [_code(path, line, row, len(head)) for line, row in enumerate(takes, 2)]
    if not codes:
        fail(path, "has no frames", "export the whole take")
    seconds, frames = np.array(codes).T
    rate = _rate(seconds, frames)
    times = seconds + frames / rate
    values = np.array([_values(path, line, row) for line, row in enumerate(takes, 2)])
    kept = np.append(True, np.diff(times) > 0)  # a camera that stalls repeats itself
    lost = int((~kept).sum())
    remarks = [f"{path}: {rate} frames a second, judging by its timecodes"]
    if lost:
        remarks.append(f"{path}: {lost} frames repeat a timecode, and are left out")
    names = tuple(name[:1].lower() + name[1:] for name in head[LEADING:])
    return Recording(str(path), times[kept] - times[0], names, values[kept], remarks=tuple(remarks))


def _code(path: Path, line: int, row: list[str], count: int) -> tuple[float, float]:
    """Return the whole seconds of a timecode, and its frames."""
    if len(row) != count:
        fail(f"{path}:{line}", f"has {len(row)} values for {count} columns", "export it again")
    found = CODE.fullmatch(row[0].strip())
    if found is None:
        fail(
            f"{path}:{line}",
            f"'{row[0][:20]}' is no timecode",
            "it is hours:minutes:seconds:frames",
        )
    hours, minutes, seconds, frames = map(float, found.groups())
    return hours * 3600 + minutes * 60 + seconds, frames


def _values(path: Path, line: int, row: list[str]) -> list[float]:
    try:
        return [float(value or 0) for value in row[LEADING:]]
    except ValueError as error:
        fail(f"{path}:{line}", f"holds text where a number belongs ({error})", "export it again")


def _rate(seconds: Floats, frames: Floats) -> int:
    """Return how many frames a second has, judging by whole seconds or by the most there are."""
    most = int(frames.max()) + 1
    if seconds[-1] - seconds[0] < LEADING:
        return next((rate for rate in RATES if rate >= max(most, USUAL)), most)
    return next((rate for rate in RATES if rate >= most), most)
