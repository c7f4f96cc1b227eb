"""Soften: a kernel smooths the corners of each pose.

The paper has no such stage: its curves are polygons after the speed limit.

Conventions: (P, T) is poses by frames; half-widths are seconds; kernels are (2 J + 1,)
weights that add up to 1, the middle one for the frame itself; outside the frames all poses rest.

A convolution with such a kernel is a weighted mean of the curve at near times. So it keeps all
that a mean keeps: bounds, the speed limit, and every constraint that holds for the mean of two
faces when it holds for both (a convex one), where both poses have the same kernel. It bounds
acceleration: with the speed v and the half-width L of a raised cosine, whose peak is 1 / L, no
curve accelerates faster than the integral of v |k'|, which is 2 v / L. The kernel lowers contacts;
`lipsync_lang.pipeline.prepare` makes up for that beforehand.
"""

import math
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints

SURE = 1 - 2e-15
"""Kernels add up to a little less than 1, so that rounding never takes a curve past its bounds."""


class Blur(NamedTuple):
    """Poses that one kernel smooths."""

    poses: Ints
    """(R,)"""
    kernel: Floats
    """(2 J + 1,)"""


def kernel(half: float, fps: float) -> Floats:
    """Return a raised cosine over frames.

    It is integrated against the hat of a frame, as if the curve were straight between frames, so
    that half-widths need not be whole frames. With its second integral::

        K(x) = (x + L)^2 / 4 L - L (1 + cos(pi x / L)) / 2 pi^2     for |x| <= L
        k_j  = fps [K((j + 1) / fps) - 2 K(j / fps) + K((j - 1) / fps)]

    Parameters
    ----------
    half : seconds L; 0 gives back the curve itself

    Returns
    -------
    (2 J + 1,) where J = ceil(L fps)

    Examples
    --------
    >>> kernel(0.04, 25).round(3).tolist()
    [0.149, 0.703, 0.149]
    """
    reach = reach_of(half, fps)
    x = np.arange(-reach - 1, reach + 2) / fps
    twice = np.maximum(x, 0)
    if half > 0:
        inside = x.clip(-half, half)
        wave = half * (1 + np.cos(np.pi * inside / half)) / (2 * np.pi**2)
        twice = np.where(x > half, x, (inside + half) ** 2 / (4 * half) - wave)
    weights = np.maximum(fps * np.diff(twice, 2), 0)
    return weights * (SURE / weights.sum())


def reach_of(half: float, fps: float) -> int:
    """Return the number of frames on each side in a kernel of some half-width."""
    return math.ceil(half * fps - 1e-9)


def soften(curves: Floats, blurs: tuple[Blur, ...]) -> Floats:
    """Smooth (P, T) curves; poses without a blur are unchanged.

    The poses of a blur are laid end to end with rests between, for one convolution.
    """
    if len(blurs) == 1 and len(blurs[0].poses) == len(curves):
        return _round(curves, blurs[0].kernel)
    out = curves.copy()
    for poses, weights in blurs:
        out[poses] = _round(curves[poses], weights)
    return out


def _round(curves: Floats, weights: Floats) -> Floats:
    """Convolve each of (R, T) curves with a kernel."""
    rows, count = curves.shape
    reach = len(weights) // 2
    # zeros between the rows, so that no row reaches into the next
    rested = np.zeros((rows, count + reach))
    rested[:, :count] = curves
    mean = np.convolve(rested.ravel(), weights)[reach : reach + rested.size]
    return mean.reshape(rested.shape)[:, :count]
