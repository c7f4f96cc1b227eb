"""Live Link Face takes: a timecode, a count, and one column per shape or head rotation.

Timecodes are `HH:MM:SS:FF.mmm`, with thousandths of a frame. The file does not store the frame
rate; it is estimated from the timecodes.
"""

import csv
import re
from pathlib import Path

import numpy as np

from lipsync_lang import AnimationError
from lipsync_lang.animations.animation_readers import Recording, fail, reader
from lipsync_lang.base.files.reading import utf8_text

TIMECODE_CELL = re.compile(r"(\d{1,6}):(\d{1,6}):(\d{1,6})[:;](\d{1,6}(?:\.\d+)?)")

RATES = (24, 25, 30, 48, 50, 60, 90, 100, 120, 240)
"""Common frame rates of cameras and timecode, in frames per second."""

DEFAULT_FPS = 60
"""Default frame rate for takes too short for an estimate, in frames per second."""

LEADING_COLUMNS = 2
"""Number of columns before the curves: timecode and count."""


def fits(content: bytes) -> bool:
    """Test for the header of a Live Link Face take."""
    first = content[:200].lower().lstrip(b"\xef\xbb\xbf")
    return first.replace(b" ", b"").startswith(b"timecode,blendshapecount")


@reader("live-link-face", suffix=".csv", fits=fits)
def read_live_link(path: Path, content: bytes) -> Recording:
    """Live Link Face: `Timecode,BlendShapeCount`, then a column for each shape; time from 0."""
    rows = list(csv.reader(utf8_text(path, content, AnimationError).splitlines()))
    head, takes = [name.strip() for name in rows[0]], [row for row in rows[1:] if any(row)]
    codes = [_code(path, line, row, len(head)) for line, row in enumerate(takes, 2)]
    if not codes:
        fail(path, "has no frames", "export the whole take")
    seconds, frames = np.array(codes).T
    # Seconds are whole; a short take shows only its largest frame number.
    most = int(frames.max()) + 1
    least = max(most, DEFAULT_FPS) if seconds[-1] - seconds[0] < LEADING_COLUMNS else most
    rate = next((rate for rate in RATES if rate >= least), most)
    times = seconds + frames / rate
    weights = []
    for line, row in enumerate(takes, 2):
        try:
            weights.append([float(value or 0) for value in row[LEADING_COLUMNS:]])
        except ValueError as error:
            why = f"has text in the place of a number ({error})"
            fail(f"{path}:{line}", why, "export it again")
    values = np.array(weights)
    kept = np.append(True, np.diff(times) > 0)  # stalled cameras repeat a timecode
    lost = int((~kept).sum())
    remarks = [f"{path}: {rate} frames a second, judging by its timecodes"]
    if lost:
        remarks.append(f"{path}: {lost} frames repeat a timecode and are left out")
    # The app writes `JawOpen` for the shape that ARKit calls `jawOpen`.
    names = tuple(name[:1].lower() + name[1:] for name in head[LEADING_COLUMNS:])
    return Recording(str(path), times[kept] - times[0], names, values[kept], remarks=tuple(remarks))


def _code(path: Path, line: int, row: list[str], count: int) -> tuple[float, float]:
    """Return the whole seconds and the frames of a timecode."""
    if len(row) != count:
        fail(f"{path}:{line}", f"has {len(row)} values for {count} columns", "export it again")
    found = TIMECODE_CELL.fullmatch(row[0].strip())
    if found is None:
        what = f"'{row[0][:20]}' is not a timecode"
        fail(f"{path}:{line}", what, "write hours:minutes:seconds:frames")
    hours, minutes, seconds, frames = map(float, found.groups())
    return hours * 3600 + minutes * 60 + seconds, frames
