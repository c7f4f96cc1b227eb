"""Overlay: an artist's curves for one word or phoneme replace the stitched ones.

Conventions: times are seconds; (P, T) is poses by frames; weights are in [0, 1].

Characters of the paper replace bigrams only. Overlays pass through every later stage, so they keep
every promise.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.pipeline.warp import TOUCH


class Overlay(NamedTuple):
    """A pose's curve over a stretch of time."""

    start: float
    """Seconds."""
    end: float
    pose: int
    values: Floats
    """(K,) weights, evenly spread from start to end."""


def lay_over(curves: Floats, overlays: Sequence[Overlay], times: Floats) -> Floats:
    """Replace spans of (P, T) curves with overlays; later overlays take precedence.

    Parameters
    ----------
    times : (T,) seconds of the frames, rising
    """
    out = curves.copy()
    for start, end, pose, values in overlays:
        # half open, so that of two neighbouring overlays one alone has the frame between
        first, stop = np.searchsorted(times, (start - TOUCH, end - TOUCH))
        here = (times[first:stop] - start) / (end - start)
        out[pose, first:stop] = np.interp(here, np.linspace(0, 1, len(values)), values)
    return out
