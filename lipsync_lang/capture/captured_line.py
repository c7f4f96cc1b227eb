"""Captured lines: recorded motion of a face with its spoken phonemes.

Conventions: T samples, S signals, P poses; times are seconds on the schedule's clock.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from lipsync_lang.pipeline.arrays import Floats

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Schedule


@dataclass(frozen=True, eq=False)
class CapturedLine:
    """Recorded motion of one spoken line, as signals that are sums of poses."""

    name: str
    """The file's name without its suffix, unique among the lines of a fit."""
    schedule: "Schedule"
    """The spoken phonemes with their times."""
    times: Floats
    """(T,) seconds, rising evenly."""
    signals: tuple[str, ...]
    """Names of the S recorded signals: poses, rig channels, or measures of the pose set."""
    values: Floats
    """(T, S) recorded values; NaN for a lost sensor."""
    gains: Floats
    """(S, P) gains; a signal is the sum of gains times weights of poses."""
    free: bool = False
    """True if the signals have an unknown scale and offset, as positions in millimetres have."""
    rigged: bool = False
    """True if the signals are channels of the character's rig, which also limits them."""
    speaker: str = ""
    """The speaker's name; empty if unknown."""
    remarks: tuple[str, ...] = ()
    """Doubtful points of the file, as sentences."""
