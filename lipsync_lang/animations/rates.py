"""Frame rates as programs mean them, and timecode.

Film and television write 23.976 and 29.97 for 24000/1001 and 30000/1001: over an hour the
difference is a frame or more, so the fraction is taken.
"""

import re
from fractions import Fraction
from math import isfinite

from lipsync_lang.errors import LipsyncError

NTSC = Fraction(1000, 1001)
"""How much slower the rates of television are than the whole numbers they are named after."""

NEAR = 0.006
"""Frames per second; 23.98 is as near to 24000/1001 as it is written."""

TIMECODE = re.compile(r"(\d{1,2}):([0-5]?\d):([0-5]?\d)([:;])(\d{1,3})")
"""Hours, minutes, seconds and frames; a semicolon before these means drop-frame."""

DAY = 86_486.4
"""Seconds; no timeline is longer than 24 hours of television's timecode."""


def exact(fps: float) -> float:
    """Return the rate that is meant: of 23.976, 29.97 or 59.94, the fraction."""
    if not isfinite(fps):
        return fps
    meant = float(round(fps / NTSC) * NTSC)
    odd = abs(fps - round(fps)) > NEAR
    return meant if odd and abs(fps - meant) <= NEAR else float(fps)


def parse_rate(text: str) -> float:
    """Read ``60``, ``23.976`` or ``24000/1001``."""
    try:
        return exact(float(Fraction(text) if "/" in text else text))
    except (ValueError, ZeroDivisionError, OverflowError):
        raise LipsyncError(
            f"--fps {text}: write a number of frames per second, or a fraction such as 24000/1001"
        ) from None


def timecode(frame: int, fps: float) -> str:
    """Return the frame's ``HH:MM:SS:FF``, counted in whole frames and without drop-frame."""
    rate = round(fps)
    seconds, frames = divmod(frame, rate)
    return f"{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}:{frames:02d}"


def parse_offset(text: str, fps: float) -> float:
    """Read seconds, or the timecode of a frame at a rate, as seconds."""
    found = TIMECODE.fullmatch(text)
    try:
        seconds = _frame(text, found, round(fps)) / fps if found else float(text)
    except ValueError:
        raise LipsyncError(
            f"--offset {text}: write seconds (--offset 1.5) or a timecode (--offset 01:00:00:00)"
        ) from None
    if not abs(seconds) <= DAY:
        raise LipsyncError(f"--offset {text}: a timeline has a day at most; give a time within it")
    return seconds


def _frame(text: str, found: re.Match[str], rate: int) -> int:
    """Return the number of a timecode's frame."""
    hours, minutes, seconds, frames = (int(found[at]) for at in (1, 2, 3, 5))
    if frames >= rate:
        raise LipsyncError(f"--offset {text}: a second has frames 0 to {rate - 1} here")
    if found[4] == ";":
        raise LipsyncError(
            f"--offset {text}: a semicolon means drop-frame, and every frame is counted here; "
            "write the seconds"
        )
    return ((hours * 60 + minutes) * 60 + seconds) * rate + frames
