"""Constrain: opposed poses make room for each other by priority (paper 3.2.2, figure 9).

Conventions: (P, T) is poses by frames; weights are in [0, 1] and thresholds in (0, 2].
The paper's formula has its sign reversed; `constrain` uses the corrected one.
"""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints

FREE = 2.0
"""Threshold of a constraint without effect, which no two weights exceed in sum."""


class Cap(NamedTuple):
    """Pose `low` yields to pose `high`; their sum is at most `threshold`."""

    low: int
    high: int
    threshold: float


class Bound(NamedTuple):
    """Pose `low` yields to each pose of `high`; each sum is at most `threshold`."""

    low: int
    high: Ints
    """(H,)"""
    threshold: float


def caps(thresholds: Floats, priority: Floats) -> tuple[Cap, ...]:
    """List the pairs that can bind, from the highest yielding pose down.

    Parameters
    ----------
    thresholds : (P, P) symmetric, in (0, 2]
    priority : (P,) larger wins; ties leave both alone

    Notes
    -----
    A pose is final before any below it is lowered, so one pass satisfies all pairs at once.
    """
    order = np.argsort(-priority, kind="stable")
    return tuple(
        Cap(int(low), int(high), float(thresholds[low, high]))
        for low in order
        for high in order
        if priority[high] > priority[low] and thresholds[low, high] < FREE
    )


def together(pairs: Iterable[Cap]) -> tuple[Bound, ...]:
    """Join the pairs of `caps` with the same yielding pose and the same threshold."""
    highs: dict[tuple[int, float], list[int]] = {}
    for low, high, threshold in pairs:
        highs.setdefault((low, threshold), []).append(high)
    return tuple(Bound(low, np.array(high), threshold) for (low, threshold), high in highs.items())


def constrain(
    weights: Floats, binding: Sequence[Bound], at_most: Sequence[tuple[int, int]] = ()
) -> Floats:
    """Lower each pose until no pair exceeds its threshold.

    From the highest priority down, for every pose b and the poses a above it::

        c_b = min(c_b, max(0, C[a, b] - c_a))

    The paper prints c_b - (C - c_a - c_b), with the sign reversed. Finally each pose of an
    `at_most` pair is lowered to the other.

    Parameters
    ----------
    weights : (P, T) in [0, 1]
    binding : as from `together`
    at_most : (pose, other) pairs, each other final before it is used

    Returns
    -------
    (P, T); the input stays unchanged
    """
    out = weights.copy()
    for low, high, threshold in binding:
        # the strongest of the poses above leaves the least room, for rounding never turns it round
        row, room = out[low], threshold - np.maximum.reduce(out[high])
        np.minimum(row, np.maximum(room, 0, out=room), out=row)
    for pose, other in at_most:
        np.minimum(out[pose], out[other], out=out[pose])
    return out
