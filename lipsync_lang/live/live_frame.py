"""A frame on its way to an engine."""

from typing import NamedTuple

from lipsync_lang.pipeline.arrays import Floats


class LiveFrame(NamedTuple):
    """A frame and its time."""

    seconds: float
    """Since the start of the session."""
    weights: Floats
    """(P,) in [0, 1]."""
