"""A frame of a live session."""

from typing import Any, NamedTuple

from lipsync_lang.arrays import Floats

FRAME_DECIMALS = 5
"""Decimal places of times and weights in text."""


class LiveFrame(NamedTuple):
    """A frame and its time."""

    seconds: float
    """Time since the start of the session."""
    weights: Floats
    """(P,) in [0, 1]."""


def as_row(frame: LiveFrame) -> dict[str, Any]:
    """Return a frame as JSON data."""
    weights = [round(weight, FRAME_DECIMALS) for weight in frame.weights.tolist()]
    return {"time": round(frame.seconds, FRAME_DECIMALS), "weights": weights}
