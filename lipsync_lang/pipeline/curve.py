"""Bank curves: control points in normalised time, and the smooth curve they control.

The paper's l(t) is the control polygon, c(t) the B-spline (3.1.2). c is the clamped uniform
B-spline of degree min(3, n - 1) in (t(u), v(u)), and 0 outside its points.

Evaluation goes span by span. On each span the curve is a polynomial in a local w in [0, 1]:
t(w) = x is solved for w, then v(w) is read. Local polynomials need no library, so the same
arithmetic in another language gives the same values to 1e-9.
"""

from functools import cache

import numpy as np

from lipsync_lang.pipeline.arrays import Floats

STEPS = 40
"""Most iterations to invert t(w); bracketed Newton steps converge in about six."""

ENOUGH = 1e-13
"""Smallest change of w that continues the iteration."""


@cache
def span_basis(count: int) -> Floats:
    """Return the basis polynomials of `count` control points.

    Returns
    -------
    (S, d + 1, d + 1): on span s, the weight of control point s + i is
    ``sum_k basis[s, k, i] w**k``, by the Cox-de Boor recurrence on knots
    0, ..., 0, 1, 2, ..., S, ..., S.
    """
    degree = min(3, count - 1)
    spans = count - degree
    knots = np.clip(np.arange(count + degree + 1) - degree, 0, spans).astype(float)
    basis = np.zeros((spans, degree + 1, degree + 1))
    for span in range(spans):
        here = {span + degree: np.array([1.0])}
        for p in range(1, degree + 1):
            raised = {}
            for i in range(span + degree - p, span + degree + 1):
                terms = np.zeros(p + 1)
                if i in here:
                    width = knots[i + p] - knots[i]
                    terms += _times(here[i], (span - knots[i]) / width, 1 / width)
                if i + 1 in here:
                    width = knots[i + p + 1] - knots[i + 1]
                    terms += _times(here[i + 1], (knots[i + p + 1] - span) / width, -1 / width)
                raised[i] = terms
            here = raised
        for i, polynomial in here.items():
            basis[span, :, i - span] = polynomial
    basis.setflags(write=False)
    return basis


def _times(polynomial: Floats, constant: float, slope: float) -> Floats:
    """Multiply a polynomial in w, lowest power first, by ``constant + slope w``."""
    out = np.zeros(len(polynomial) + 1)
    out[:-1] += constant * polynomial
    out[1:] += slope * polynomial
    return out


def bspline(points: Floats, at: Floats) -> Floats:
    """Evaluate smooth curves at normalised times.

    Parameters
    ----------
    points : (C, n, 2) control points (t, v), n >= 2, t never falling
    at : (K,) times

    Returns
    -------
    (C, K)
    """
    curves, count, _ = points.shape
    basis = span_basis(count)
    spans, order, _ = basis.shape
    windows = np.arange(spans)[:, None] + np.arange(order)
    power = np.einsum("ski,csix->cskx", basis, points[:, windows])
    starts = power[:, 1:, 0, 0]
    span = (starts[:, None, :] <= at[None, :, None]).sum(-1)
    local = power[np.arange(curves)[:, None], span]
    w = _invert(local[..., 0], np.broadcast_to(at, span.shape))
    values = _horner(local[..., 1], w)
    inside = (at >= points[:, :1, 0]) & (at <= points[:, -1:, 0])
    return np.where(inside, values, 0.0)


def polyline(points: Floats, at: Floats) -> Floats:
    """Evaluate control polygons, the paper's l(t); shapes as in `bspline`."""
    return np.array(
        [np.interp(at, line[:, 0], line[:, 1], left=0.0, right=0.0) for line in points]
    ).reshape(len(points), len(at))


def _horner(coefficients: Floats, w: Floats) -> Floats:
    value: Floats = coefficients[..., -1]
    for k in range(coefficients.shape[-1] - 2, -1, -1):
        value = value * w + coefficients[..., k]
    return value


def _invert(t: Floats, x: Floats) -> Floats:
    """Solve t(w) = x for w in [0, 1], t rising: Newton's step where it stays in the bracket."""
    slope = t[..., 1:] * np.arange(1, t.shape[-1])
    low, high = np.zeros(x.shape), np.ones(x.shape)
    w = np.full(x.shape, 0.5)
    for _ in range(STEPS):
        error = _horner(t, w) - x
        low, high = np.where(error < 0, w, low), np.where(error < 0, high, w)
        steep = _horner(slope, w)
        step = w - error / np.where(steep > 0, steep, np.inf)
        wanted = np.where((step >= low) & (step <= high) & (steep > 0), step, (low + high) / 2)
        if np.abs(wanted - w).max(initial=0.0) < ENOUGH:
            break
        w = wanted
    return w
