"""Warp: each frame's place in its bigrams, and the curves' values there (paper 3.2.1).

Conventions: times are seconds, places in a bigram normalised to [0, 1]; (T, P) is frames by poses.
The paper stretches a bigram evenly; by default, its own phoneme boundary is pinned to the spoken
one here.
"""

from dataclasses import dataclass

import numpy as np

from lipsync_lang.pipeline.arrays import Floats, Ints, Singles
from lipsync_lang.pipeline.tables import RESOLUTION, Bank
from lipsync_lang.pipeline.track import Track

TOUCH = 1e-7
"""Seconds within which a frame lies on a boundary: rounding must not choose its phoneme."""


@dataclass(frozen=True, eq=False)
class FramePlace:
    """Each frame's phoneme and the passed share of that phoneme."""

    phoneme: Ints
    """(T,) index into the track."""
    coming: Floats
    """(T,) share of the phoneme passed, as the second of a bigram; past 1 the bigram is over."""
    going: Floats
    """(T,) share passed as the first of the next bigram; below 0 that has not begun."""


def locate(track: Track, times: Floats) -> FramePlace:
    """Find each frame's phoneme. A sound has one share; a silence is left, then entered anew.

    A long sound is entered and left at the pace of one of `Motion.sound_reach`, and stays half
    passed in between.
    """
    phoneme = np.searchsorted(track.bounds, times + TOUCH, side="right") - 1
    phoneme = np.minimum(np.maximum(phoneme, 0), len(track.ids) - 1)
    reach, moving = track.reach[phoneme], track.moving[phoneme]
    passed, left = times - track.bounds[phoneme], track.bounds[phoneme + 1] - times
    long = moving < reach
    if long.any():
        passed = np.where(long, np.minimum(passed, np.maximum(moving / 2, moving - left)), passed)
        left = np.where(long, moving - passed, left)
        reach = moving
    coming = np.where(np.abs(passed - reach) <= TOUCH, 1.0, np.maximum(passed, 0) / reach)
    going = np.where(np.abs(left - reach) <= TOUCH, 0.0, 1 - left / reach)
    return FramePlace(phoneme, coming, going)


def warp(bank: Bank, track: Track, place: FramePlace) -> tuple[Floats, Floats]:
    """Read the two bigrams that cover each frame.

    The bank's boundary is pinned onto the spoken one, so time is stretched by one factor
    on each side of it. The paper stretches evenly over the whole span: then `boundary` is
    where the spoken one falls, and the factors are equal.

    Returns
    -------
    (T, P), (T, P): the bigram that ends with the frame's phoneme, and the one that begins with it
    """
    last = len(track.rows)
    if last == 0:  # nothing but silence
        still = np.zeros((len(place.phoneme), bank.curves.shape[-1]))
        return still, still
    before, after = place.phoneme - 1, np.minimum(place.phoneme, last - 1)
    ends = (before >= 0) & (place.coming <= 1)
    begins = (place.phoneme < last) & (place.going >= 0)
    boundary = track.boundary(bank)
    pin = boundary[before]
    rows = np.empty((2, len(before)), np.intp)
    position = np.empty((2, len(before)))
    np.multiply(track.rows[before], ends, out=rows[0])
    np.multiply(track.rows[after], begins, out=rows[1])
    position[0] = pin + (1 - pin) * place.coming
    position[1] = boundary[after] * place.going
    ending, beginning = _read(bank.curves, rows, position)
    return ending, beginning


def _read(curves: Singles, rows: Ints, position: Floats) -> Floats:
    """Interpolate table rows at normalised positions: (2, T), (2, T) -> (2, T, P)."""
    steps = np.minimum(np.maximum(position * RESOLUTION, 0), RESOLUTION - 1e-9)
    low = steps.astype(np.intp)
    part = (steps - low)[..., None]
    flat = curves.reshape(-1, curves.shape[-1])
    index = rows * (RESOLUTION + 1) + low
    under = flat.take(index, axis=0)
    over = flat.take(index + 1, axis=0)
    over -= under
    return under + over * part
