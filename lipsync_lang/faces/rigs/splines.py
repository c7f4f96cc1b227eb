"""Piecewise cubic curves of keys with slopes, as in animation editors and glTF.

Between two keys at times a and b, with values p and q and slopes m and n per second, a curve is a
cubic Hermite polynomial::

    H(u) = (1 + 2u)(1 - u)^2 p + u (1 - u)^2 d m + u^2 (3 - 2u) q + u^2 (u - 1) d n
    d = b - a,   u = (t - a) / d

Conventions: (K, C) is keys by columns, and the columns share their keys.
"""

from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints


class Spline(NamedTuple):
    """Keys of a piecewise cubic curve."""

    frames: Ints
    """(K,) frame numbers, rising; the first and last frames are keys."""
    values: Floats
    """(K, C)"""
    arriving: Floats
    """(K, C) slopes before each key, per second; 0 before the first."""
    leaving: Floats
    """(K, C) slopes after each key, per second; 0 after the last."""


def hermite(u: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Return the weights of first value, first slope, last value and last slope: (T,) each."""
    return (1 + 2 * u) * (1 - u) ** 2, u * (1 - u) ** 2, u * u * (3 - 2 * u), u * u * (u - 1)


def sample(times: Floats, spline: Spline, at: Floats) -> Floats:
    """Return the values of a spline, (n, C); outside the keys, the nearest value is held."""
    if len(times) == 1:
        return np.repeat(spline.values, len(at), axis=0)
    at = np.clip(at, times[0], times[-1])
    key = np.clip(np.searchsorted(times, at, side="right") - 1, 0, len(times) - 2)
    length = times[key + 1] - times[key]
    p, m, q, n = (part[:, None] for part in hermite((at - times[key]) / length))
    seconds = length[:, None]
    return (
        p * spline.values[key]
        + m * seconds * spline.leaving[key]
        + q * spline.values[key + 1]
        + n * seconds * spline.arriving[key + 1]
    )
