"""Captured lines: recorded motion of a face with its spoken phonemes.

Conventions: T samples, S signals, P poses; times are seconds on the schedule's clock.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.arrays import Floats

GAP_SHARE = 1e-6
"""Minimum share of a lost value between two samples; a smaller one is rounding."""

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


def resampled(times: Floats, old: Floats, values: Floats) -> Floats:
    """Return signals at other times, (T, S); NaN within a gap.

    Beyond the ends, the first and the last known values are held.

    Parameters
    ----------
    times : (T,) seconds of the result
    old : (N,) seconds of the values, rising
    values : (N, S) values; NaN for a lost sensor
    """
    out = np.full((len(times), values.shape[1]), np.nan)
    for number, signal in enumerate(values.T):
        known = np.isfinite(signal)
        if known.any():
            lost = np.interp(times, old, (~known).astype(float)) > GAP_SHARE
            filled = np.interp(times, old[known], signal[known])
            out[:, number] = np.where(lost, np.nan, filled)
    return out
