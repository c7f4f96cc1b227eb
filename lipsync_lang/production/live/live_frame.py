"""A frame of a live session, and what receives it."""

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

from lipsync_lang.base.arrays import Floats

FRAME_DECIMALS = 5
"""Decimal places of times and weights in text."""


class LiveFrame(NamedTuple):
    """A frame and its time."""

    seconds: float
    """Time since the start of the session."""
    weights: Floats
    """(P,) in [0, 1]."""


class Outlet(Protocol):
    """A receiver of frames."""

    def send(self, frame: LiveFrame) -> None:
        """Send a frame now."""

    def tell(self, event: Mapping[str, Any]) -> None:
        """Report the start of an utterance or an error, if the receiver reads text."""

    def close(self) -> None:
        """End the connection."""


def as_row(frame: LiveFrame) -> dict[str, Any]:
    """Return a frame as JSON data."""
    weights = [round(weight, FRAME_DECIMALS) for weight in frame.weights.tolist()]
    return {"time": round(frame.seconds, FRAME_DECIMALS), "weights": weights}
