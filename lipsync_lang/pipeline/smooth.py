"""Smooth: fill the valley between close peaks (paper 3.2.1, figure 8).

Conventions: (P, T) is poses by frames; windows are in frames.

The paper joins two local maxima that share a window by a chord; `chord` does so. That method is
discontinuous: a maximum that appears by 1e-6 changes the curve by the depth of a valley. Its result
also depends on the order in which maxima are paired. `closing` instead fills every valley narrower
than the window up to the lower of its sides. Closing is idempotent, local, and never magnifies a
change.
"""

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats


def closing(curves: Floats, frames: int) -> Floats:
    """Close (P, T) curves morphologically with a flat window of some frames; rest is outside."""
    if frames <= 1:
        return curves
    rows, count = curves.shape
    padded = np.zeros((rows, count + 2 * (frames - 1)))
    padded[:, frames - 1 : frames - 1 + count] = curves
    return _running(np.minimum, _running(np.maximum, padded, frames), frames)


def _running(take: np.ufunc, curves: Floats, frames: int) -> Floats:
    """Fold every window of `frames`: windows double up to the size, then two overlap."""
    width = 1
    while 2 * width <= frames:
        curves = take(curves[:, :-width], curves[:, width:])
        width *= 2
    if width < frames:
        rest = frames - width
        curves = take(curves[:, :-rest], curves[:, rest:])
    return curves


def closing_within(curves: Floats, inside: Bools, frames: int) -> Floats:
    """Close (R, T) curves only where `inside`, (R, T), each run of frames there by itself.

    Contact poses are smoothed within one run of the phonemes that demand them. A valley between
    two runs is a vowel, which must stay open; plain closing would fill it.
    """
    out = curves.copy()
    flat = np.flatnonzero(inside)
    # one call for all runs: laid end to end, so far apart that no window touches two of them
    if frames > 1 and flat.size:
        fresh = (flat[1:] - flat[:-1] != 1) | (flat[1:] % curves.shape[1] == 0)
        apart = np.arange(flat.size)
        apart[1:] += np.cumsum(fresh) * (frames - 1)
        row = np.zeros((1, apart[-1] + 1))
        row[0, apart] = out.ravel()[flat]
        out.ravel()[flat] = closing(row, frames)[0, apart]
    return out


def chord(curves: Floats, frames: float) -> Floats:
    """Join neighbouring local maxima at most `frames` apart by a straight line (the paper's way).

    One pass over the maxima of the given curves; a flat top counts by its two ends.
    """
    out = curves.copy()
    for row, curve in zip(out, curves, strict=True):
        first = np.concatenate(([0], np.flatnonzero(np.diff(curve)) + 1))
        last = np.append(first[1:] - 1, len(curve) - 1)
        # below any weight, so that a curve may have its maximum at an end
        level = np.concatenate(([-1.0], curve[first], [-1.0]))
        top = (level[1:-1] > level[:-2]) & (level[1:-1] > level[2:])
        peaks = np.union1d(first[top], last[top])
        near = np.diff(peaks) <= frames
        for a, b in zip(peaks[:-1][near], peaks[1:][near], strict=True):
            row[a : b + 1] = np.linspace(curve[a], curve[b], b - a + 1)
    return out
