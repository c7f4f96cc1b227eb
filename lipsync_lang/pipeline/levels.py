"""Delivery: how a line is spoken, styles blended in and regions of the face scaled.

Not in the paper. Its original implementation blends whole banks by a weight curve; the two dials,
jaw and lips, are those of JALI (Edwards, Landreth, Fiume, Singh 2016), here for any region that a
pose set names. Both come before every stage that keeps a promise.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.pipeline.arrays import Bools, Floats


class Level(NamedTuple):
    """A number over time: straight lines between points, level before and after them."""

    times: Floats
    """(K,) seconds, never falling."""
    values: Floats
    """(K,)"""

    def at(self, times: Floats) -> Floats:
        """Return the level at (T,) times."""
        values: Floats = np.interp(times, self.times, self.values)
        return values


class Blend(NamedTuple):
    """One style, and how much of it is heard."""

    style: int
    """Its place in the tables' styles."""
    share: Level
    """Of the whole, in [0, 1]; the rest is neutral."""


class Dial(NamedTuple):
    """How far the poses of one region move."""

    poses: Bools
    """(P,)"""
    level: Level
    """0 not at all, 1 as usual, 2 twice as far."""


def shares(blends: Sequence[Blend], times: Floats) -> Floats:
    """Return how much of each bank is heard: (1 + S, T), neutral first; they add up to 1.

    Where styles ask for more than the whole, each gets its part of it.
    """
    wanted = np.stack([blend.share.at(times) for blend in blends])
    whole = np.maximum(wanted.sum(axis=0), 1.0)
    styles = wanted / whole
    return np.concatenate((np.maximum(1 - styles.sum(axis=0, keepdims=True), 0), styles))


def scale(curves: Floats, dials: Sequence[Dial], times: Floats) -> Floats:
    """Scale (P, T) curves of each dial's poses, up to 1."""
    out = curves.copy()
    for dial in dials:
        out[dial.poses] *= dial.level.at(times)
    return np.minimum(out, 1.0, out=out)
