"""Delivery: styles are blended in and regions of the face scaled, over time.

Conventions: times are seconds; (S,) is styles and (P, T) poses by frames.

The paper has neither. Its original implementation blends whole banks by a weight curve. JALI
(Edwards, Landreth, Fiume, Singh 2016) has two dials, jaw and lips; here any region of a pose set
has one. Both steps come before every stage that keeps a promise.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats


class Level(NamedTuple):
    """A number over time: linear between points, constant before and after them."""

    times: Floats
    """(K,) seconds, never falling."""
    values: Floats
    """(K,)"""

    def at(self, times: Floats) -> Floats:
        """Return the level at (T,) times."""
        return np.interp(times, self.times, self.values)


class Blend(NamedTuple):
    """A style and its share."""

    style: int
    """Index into the tables' styles."""
    share: Level
    """Share of the whole, in [0, 1]; the rest is neutral."""


class Dial(NamedTuple):
    """A factor for the poses of one region."""

    poses: Bools
    """(P,)"""
    level: Level
    """Factor: 0 for no movement, 1 for the usual one, 2 for twice as much."""
    name: str = "dial"
    """Its source, for explanations."""


def shares(blends: Sequence[Blend], times: Floats) -> Floats:
    """Return the share of each bank: (1 + S, T), neutral first; shares add up to 1.

    Styles that together ask for more than 1 are scaled down to it.
    """
    wanted = np.stack([blend.share.at(times) for blend in blends])
    whole = np.maximum(wanted.sum(axis=0), 1.0)
    styles = wanted / whole
    return np.concatenate((np.maximum(1 - styles.sum(axis=0, keepdims=True), 0), styles))


def scale(curves: Floats, dials: Sequence[Dial], times: Floats) -> Floats:
    """Scale (P, T) curves of each dial's poses, up to 1."""
    out = curves.copy()
    scaled = set()
    for dial in dials:
        level, poses = dial.level.at(times), dial.poses.nonzero()[0].tolist()
        scaled.update(poses)
        for pose in poses:
            out[pose] *= level
    # bounded after all dials: two that pull a pose both ways must not clip between
    for pose in scaled:
        np.minimum(out[pose], 1.0, out=out[pose])
    return out
