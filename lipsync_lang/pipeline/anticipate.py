"""Anticipate: poses that look ahead begin before their sound.

Not in the paper, whose bigrams see one neighbour: the lips of "stew" are round from the "s" on.
Conventions: (P, T) is poses by frames; how far a pose looks ahead is in frames, and need not be
whole. A pose takes the highest of what is to come, falling in a straight line to nothing T frames
before it. It stops where something opposes it: a pose it is constrained with takes its share of
the room, and a sound that forbids it takes all. What opposes at one time also hides what comes
after.
"""

import numpy as np

from lipsync_lang.pipeline.arrays import Floats, Ints


def falling(frames: float) -> Floats:
    """Return what is left of a weight 0, 1, 2, ... frames ahead of it: (n,), all above 0."""
    ahead = np.arange(max(1, int(np.ceil(frames - 1e-9))))
    out: Floats = 1 - ahead / max(frames, 1.0)
    return out


def anticipate(curves: Floats, poses: Ints, left: Floats, room: Floats) -> Floats:
    """Raise poses to what is to come of them.

    With the room r(t) that opponents leave, and over the frames s ahead::

        a(t) = max over s of min((1 - s / T) c(t + s), r(t), ..., r(t + s - 1))

    Parameters
    ----------
    curves : (P, T)
    poses : (R,) those that look ahead
    left : (R, n) share that is left s frames ahead, as from `falling`; 0 past its end
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
        np.minimum(wanted, np.minimum.accumulate(_ahead(room, far, 0), axis=0), out=wanted)
        out[poses] = np.maximum(own, wanted.max(axis=0))
    return out


def _ahead(rows: Floats, far: int, first: int) -> Floats:
    """Return (R, T) rows 0, 1, ... frames after the first: (far, R, T), past their end at 0."""
    count = rows.shape[1]
    longer = np.zeros((len(rows), count + far + first))
    longer[:, :count] = rows
    row, step = longer.strides
    return np.ndarray((far, len(rows), count), float, longer, first * step, (step, row, step))
