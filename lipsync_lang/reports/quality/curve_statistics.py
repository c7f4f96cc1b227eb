"""Statistics of one curve, for measures of motion and for benchmarks.

Conventions: a curve is (T,), in evenly spaced frames; shares are from 0 to 1.
"""

import sys
from functools import lru_cache

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats

HIGH_HERTZ = 8.0
"""Frequency above which a captured jaw has hardly any power."""

STILL_STEP = 0.015
"""Minimum movement from frame to frame, as a share of the curve's peak."""

SHUT_SHARE = 0.1
"""Maximum level of a shut jaw, as a share of the curve's peak."""

TURN_SHARE = 0.02
"""Minimum size of a visible turn, as a share of the curve's peak."""


def peak(curve: Floats) -> float:
    """Return the 99th percentile of a curve: its highest level except for single frames."""
    return percentile(curve, 99) if curve.size else 0.0


def percentile(values: Floats, per_cent: float) -> float:
    """Return the result of `numpy.percentile`, to the last bit, in a tenth of its time."""
    place = (len(values) - 1) * (per_cent / 100)
    below = int(place)
    above, share = min(below + 1, len(values) - 1), place - below
    ordered = np.sort(values)
    low, high = ordered.item(below), ordered.item(above)
    # two forms of one line, as numpy has them: each rounds well near its own end
    wide = high - low
    return high - wide * (1 - share) if share >= 0.5 else low + wide * share  # noqa: PLR2004


def derivative(curve: Floats, fps: float, order: int) -> Floats:
    """Return the size of a derivative: (T - order,), per second to the power of `order`."""
    return np.abs(np.diff(curve, order)) * fps**order


def high_share(curve: Floats, fps: float) -> float:
    """Return the share of a curve's power above `HIGH_HERTZ`, without its mean."""
    window, first = _spectrum(len(curve), fps)
    power = np.abs(np.fft.rfft((curve - curve.sum() / len(curve)) * window)) ** 2
    return float(power[first:].sum() / max(power.sum(), sys.float_info.min))


@lru_cache(maxsize=512)  # the lengths of the lines of a script
def _spectrum(count: int, fps: float) -> tuple[Floats, int]:
    """Return the window for some frames, and the start of the spectrum above `HIGH_HERTZ`."""
    return np.hanning(count), int(np.fft.rfftfreq(count, 1 / fps).searchsorted(HIGH_HERTZ, "right"))


def turns(curve: Floats) -> int:
    """Count the extrema that differ from the last one by `TURN_SHARE` or more."""
    count, way = 0, 0
    last = float(curve[0])
    # of a stretch that only rises or falls, its end alone can turn
    step = curve[1:] - curve[:-1]
    ends = curve[1:-1][step[1:] * step[:-1] <= 0].tolist()
    for value in (*ends, float(curve[-1])):
        if way >= 0 and value < last - TURN_SHARE:
            count, last, way = count + 1, value, -1
        elif way <= 0 and value > last + TURN_SHARE:
            count, last, way = count + 1, value, 1
        elif way != 0 and (value > last) == (way >= 0):
            last = value
    return count


def open_frames(curve: Floats) -> tuple[Bools, Bools]:
    """Return masks of the frames with the jaw open, and of the still frames among them: (T,) each.

    A frame is still if it hardly differs from the frames on both sides, so a plateau is still and
    a peak is not. The first and the last frame are in neither mask.
    """
    opened, still = np.zeros((2, len(curve)), bool)
    steps = np.abs(curve[1:] - curve[:-1])
    opened[1:-1] = curve[1:-1] > SHUT_SHARE
    still[1:-1] = opened[1:-1] & (np.maximum(steps[1:], steps[:-1]) < STILL_STEP)
    return opened, still


def rise(curve: Floats, start: int, stop: int, share: float) -> int | None:
    """Return the frame at which a curve starts to rise for a sound.

    Parameters
    ----------
    start, stop : first frame of the sound, and the frame past its last
    share : of the sound's own peak, at which the rise starts

    Returns
    -------
    The first frame from which the curve stays above `share` of its peak until its peak in the
    sound; None if the curve is always 0
    """
    top = curve[start:stop].max(initial=0.0)
    if top <= 0:
        return None
    reached = start + int(np.flatnonzero(curve[start:stop] >= share * top)[0])
    below = np.flatnonzero(curve[:reached] < share * top)
    return int(below[-1]) + 1 if below.size else 0
