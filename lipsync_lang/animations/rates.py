"""Frame rates and timecode.

In film and television, 23.976 and 29.97 stand for 24000/1001 and 30000/1001. The exact fractions
are used, because the rounded rates drift by a frame or more per hour.
"""

import re
from math import isfinite

from lipsync_lang.base.errors import LipsyncError

USUAL_FPS = 60.0
"""Default frame rate in frames per second."""

NTSC = 1000 / 1001
"""Ratio of NTSC rates to their nominal whole rates."""

RATE_TOLERANCE = 0.006
"""Tolerance in frames per second; wide enough for 23.98 as 24000/1001."""

TIMECODE = re.compile(r"(\d{1,2}):([0-5]?\d):([0-5]?\d)([:;])(\d{1,3})")
"""Hours, minutes, seconds and frames; a semicolon before the frames marks drop-frame."""

FASTEST = 1000.0
"""Maximum frame rate in frames per second; larger values are mistakes."""

DAY = 86_486.4
"""Maximum timeline length in seconds: 24 hours of NTSC timecode."""


def exact(fps: float) -> float:
    """Return the exact rate: a fraction for 23.976, 29.97 or 59.94."""
    if not isfinite(fps) or fps == int(fps):
        return float(fps)
    # The nearest whole rate by 1000/1001: 23.976 and 23.98 both mean 24000/1001.
    meant = round(fps / NTSC) * 1000 / 1001
    odd = abs(fps - round(fps)) > RATE_TOLERANCE
    return meant if odd and abs(fps - meant) <= RATE_TOLERANCE else float(fps)


def checked_rate(fps: float) -> float:
    """Return the exact rate; refuse one out of range."""
    if not 1 <= fps <= FASTEST:
        raise LipsyncError(f"{fps} frames per second: give a number from 1 to {FASTEST:g}")
    return exact(fps)


def parse_rate(text: str) -> float:
    """Parse ``60``, ``23.976`` or ``24000/1001``."""
    from fractions import Fraction

    try:
        # `Fraction` would turn a decimal with a large exponent into a huge number.
        return exact(float(Fraction(text) if "/" in text else text))
    except (ValueError, ZeroDivisionError, OverflowError):
        what = "write a number of frames per second, or a fraction such as 24000/1001"
        raise LipsyncError(f"--fps {text}: {what}") from None


def timecode(frame: int, fps: float) -> str:
    """Format a frame as ``HH:MM:SS:FF``, in whole frames without drop-frame."""
    rate = round(fps)
    seconds, frames = divmod(frame, rate)
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}:{frames:02d}"


def parse_offset(text: str, fps: float) -> float:
    """Parse an offset in seconds or timecode, and return seconds."""
    found = TIMECODE.fullmatch(text)
    try:
        seconds = float(text) if found is None else 0.0
    except ValueError:
        what = "write seconds (--offset 1.5) or a timecode (--offset 01:00:00:00)"
        raise LipsyncError(f"--offset {text}: {what}") from None
    if found is not None:
        rate = round(fps)
        hours, minutes, whole, frames = (int(found[at]) for at in (1, 2, 3, 5))
        if frames >= rate:
            raise LipsyncError(f"--offset {text}: a second has frames 0 to {rate - 1} here")
        if found[4] == ";":
            what = "a semicolon means drop-frame, and every frame is counted here"
            raise LipsyncError(f"--offset {text}: {what}; write the seconds")
        seconds = (((hours * 60 + minutes) * 60 + whole) * rate + frames) / fps
    if not abs(seconds) <= DAY:
        what = "a timeline lasts at most one day; give an earlier time"
        raise LipsyncError(f"--offset {text}: {what}")
    return seconds
