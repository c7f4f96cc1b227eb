"""Warp bigrams to the frames, and stitch those that overlap into one curve per pose (paper 3.2.1).

Conventions: times are seconds, places in a bigram normalised to [0, 1]; (T, P) is frames by poses.
The paper stretches a bigram evenly; by default, its own phoneme boundary is pinned to the spoken
one here. The paper stitches by ``max`` only (figure 7); ``crossfade`` is an addition.
"""

from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.pipeline.tables import RESOLUTION, Bank
from lipsync_lang.pipeline.track import Track

TOUCH = 1e-7
"""Seconds within which a frame lies on a boundary: rounding must not choose its phoneme."""


class FramePlace(NamedTuple):
    """Each frame's phoneme and the passed share of that phoneme."""

    phoneme: Ints
    """(T,) index into the track."""
    coming: Floats
    """(T,) share of the phoneme passed, as the second of a bigram; past 1 the bigram is over."""
    going: Floats
    """(T,) share passed as the first of the next bigram; below 0 that has not begun."""


def locate(track: Track, times: Floats) -> FramePlace:
    """Find the phoneme and shares of each frame. A silence has a share for its exit and its entry.

    A long sound is entered and left at the pace of one of `Motion.sound_reach`, and stays half
    passed in between.
    """
    phoneme = track.bounds[1:-1].searchsorted(times + TOUCH, side="right")
    reach = track.reach[phoneme]
    passed, left = times - track.bounds[phoneme], track.bounds[1:][phoneme] - times
    if (track.moving < track.reach).any():
        moving = track.moving[phoneme]
        long = moving < reach
        passed = np.where(long, np.minimum(passed, np.maximum(moving / 2, moving - left)), passed)
        left = np.where(long, moving - passed, left)
        reach = moving
    # exactly 1 or 0 on a boundary, so that rounding never opens a bigram that is over
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
    if not len(track.rows):  # nothing but silence
        still = np.zeros((len(place.phoneme), bank.curves.shape[-1]))
        return still, still
    rows, position = positions(bank, track, place)
    steps = np.minimum(np.maximum(position * RESOLUTION, 0), RESOLUTION - 1e-9)
    low = steps.astype(np.intp)
    # `take` on flat rows is faster than an index of two arrays
    flat = bank.curves.reshape(-1, bank.curves.shape[-1])
    index = rows * (RESOLUTION + 1) + low
    under, over = flat.take(index, axis=0), flat.take(index + 1, axis=0)
    over -= under
    out = over.astype(np.float64)  # in place from here: half the time of new arrays
    out *= (steps - low)[..., None]
    out += under
    return out[0], out[1]


def positions(bank: Bank, track: Track, place: FramePlace) -> tuple[Ints, Floats]:
    """Return the table rows of the two bigrams that cover each frame, and the place in each.

    Returns
    -------
    (2, T) rows, 0 for rest, and (2, T) normalised times; the bigram that ends comes first
    """
    last = len(track.rows)
    # before the first phoneme and after the last there is rest, row 0
    rows, boundary = np.zeros(last + 2, np.intp), np.zeros(last + 2)
    rows[1:-1], boundary[1:-1] = track.rows, track.boundary(bank)
    both = place.phoneme + np.array([[0], [1]])
    row, position = rows[both], boundary[both]
    row[0] *= place.coming <= 1
    row[1] *= place.going >= 0
    position[0] += (1 - position[0]) * place.coming
    position[1] *= place.going
    return row, position


def stitch(ending: Floats, beginning: Floats, place: FramePlace, how: str) -> Floats:
    """Join the two bigrams that cover each frame.

    ``max`` keeps the larger, so that peaks survive: c(t) = max(c_i(t), c_i+1(t)).
    ``crossfade`` passes from the ending to the beginning one over the phoneme they share.

    Parameters
    ----------
    ending, beginning : (T, P) as from `warp`

    Returns
    -------
    (P, T), as all later stages have it
    """
    if how == "max":
        joined = np.maximum(ending, beginning)
    else:
        share = place.going.clip(0, 1)[:, None]
        joined = ending * (1 - share) + beginning * share
    return np.ascontiguousarray(joined.T, dtype=np.float64)
