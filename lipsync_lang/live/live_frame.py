"""A frame on its way to an engine."""

from typing import NamedTuple

from lipsync_lang.pipeline.arrays import Floats


class LiveFrame(NamedTuple):
    """A frame and its time."""

    seconds: float
    """Time since the start of the session."""
    weights: Floats
    """(P,) in [0, 1]."""
