"""Lay over: curves that a person made for one word or phoneme, in place of what was stitched.

Not in the paper, whose characters replace bigrams alone. What is laid over is smoothed, held,
limited and constrained like all else, so it keeps every promise.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.pipeline.arrays import Floats
from lipsync_lang.pipeline.warp import TOUCH


class Overlay(NamedTuple):
    """One pose's curve over a stretch of time."""

    start: float
    """Seconds."""
    end: float
    pose: int
    values: Floats
    """(K,) weights, evenly spread from start to end."""


def lay_over(curves: Floats, overlays: Sequence[Overlay], times: Floats) -> Floats:
    """Put overlays in place of (P, T) curves, the later over the earlier.

    Parameters
    ----------
    times : (T,) seconds of the frames, rising
    """
    out = curves.copy()
    for start, end, pose, values in overlays:
        first, stop = np.searchsorted(times, (start - TOUCH, end - TOUCH))
        here = (times[first:stop] - start) / (end - start)
        out[pose, first:stop] = np.interp(here, np.linspace(0, 1, len(values)), values)
    return out
