"""Anticipate: poses with anticipation begin before their sound.

Conventions: (P, T) is poses by frames. Look-ahead is in frames and need not be whole.

The paper has no such stage. Its bigrams see one neighbour only, but the lips of "stew" are round
from the "s" on.

A later peak raises the frames before it along a straight line that starts at 0, T frames earlier.
Opponents limit this rise: a constrained pose takes its share of the room, and a sound that forbids
the pose takes all of it. An opponent at one frame also hides every peak after that frame.
"""

from itertools import pairwise

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints


def falling(frames: Floats) -> Floats:
    """Return the shares of a weight that reach 0, 1, 2, ... frames back: (R, n), 0 past their end.

    Parameters
    ----------
    frames : (R,) look-ahead of each pose
    """
    # 1e-9: a look-ahead of whole frames must not gain one by rounding
    counts = np.maximum(np.ceil(frames - 1e-9), 1)[:, None]
    ahead = np.arange(int(counts.max(initial=1)))
    return np.where(ahead < counts, 1 - ahead / np.maximum(frames, 1.0)[:, None], 0.0)


def anticipate(curves: Floats, poses: Ints, left: Floats, room: Floats) -> Floats:
    """Raise poses towards their own later peaks.

    With the room r(t) that opponents leave, and over the frames s ahead::

        a(t) = max over s of min((1 - s / T) c(t + s), r(t), ..., r(t + s - 1))

    Parameters
    ----------
    curves : (P, T)
    poses : (R,) poses that look ahead
    left : (R, n) share that reaches s frames back, as from `falling`
    room : (R, T) in [0, 1]

    Returns
    -------
    (P, T); never below `curves`
    """
    out = curves.copy()
    own = curves[poses]
    far = left.shape[1] - 1
    if far:
        wanted = left.T[1:, :, None] * _ahead(own, far, 1)
        least = _ahead(room, far, 0).copy()
        for before, here in pairwise(least):  # `np.minimum.accumulate`, in half the time
            np.minimum(before, here, out=here)
        np.minimum(wanted, least, out=wanted)
        out[poses] = np.maximum(own, np.maximum.reduce(wanted))
    return out


def _ahead(rows: Floats, far: int, first: int) -> Floats:
    """Return (R, T) rows shifted by `first` and more frames: (far, R, T), 0 past their end."""
    count = rows.shape[1]
    longer = np.zeros((len(rows), count + far + first))
    longer[:, :count] = rows
    row, step = longer.strides
    # overlapping views of one buffer, not `far` copies of it
    return np.ndarray((far, len(rows), count), float, longer, first * step, (step, row, step))
