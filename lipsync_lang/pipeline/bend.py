"""Bend: keys of a line are added to its curves, before every stage that keeps a promise.

Conventions: times are seconds; (P, T) is poses by frames; weights are in [0, 1].

The paper has no edits of a line. A key moves a pose by an amount at one moment; the amount runs
smoothly from key to key, and fades before the first one and after the last.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats

FADE_SECONDS = 0.12
"""Seconds in which a bend fades at its ends."""


class Bend(NamedTuple):
    """Amounts that are added to one pose."""

    pose: int
    times: Floats
    """(K,) seconds of the keys, never falling."""
    amounts: Floats
    """(K,) in [-1, 1]."""

    def at(self, times: Floats) -> Floats:
        """Return the amount at (T,) times."""
        ends = self.times[[0, -1]] + np.array([-FADE_SECONDS, FADE_SECONDS])
        keys = np.concatenate((ends[:1], self.times, ends[1:]))
        amounts = np.concatenate(([0.0], self.amounts, [0.0]))
        place = np.interp(times, keys, np.arange(len(keys)))
        key = np.minimum(place.astype(np.intp), len(keys) - 2)
        share = place - key
        share = share * share * (3 - 2 * share)  # no corner at a key
        return amounts[key] + (amounts[key + 1] - amounts[key]) * share


def bend(curves: Floats, bends: Sequence[Bend], times: Floats) -> Floats:
    """Add bends to (P, T) curves, within the bounds of weights."""
    out = curves.copy()
    for one in bends:
        out[one.pose] = (out[one.pose] + one.at(times)).clip(0, 1)
    return out
