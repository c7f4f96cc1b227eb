"""Bank curves: control points in normalised time, and their smooth curves.

The paper's l(t) is the control polygon, c(t) the B-spline (3.1.2). c is the clamped uniform
B-spline of degree min(3, n - 1) in (t(u), v(u)), and 0 outside its points.

Evaluation goes span by span. On each span the curve is a polynomial in a local w in [0, 1]:
t(w) = x is solved for w, then v(w) is read. Local polynomials need no library, so the same
arithmetic in another language gives the same values to 1e-9.
"""

from functools import cache

import numpy as np

from lipsync_lang.base.arrays import Floats

STEPS = 40
"""Maximum number of iterations to invert t(w); bracketed Newton steps converge in about six."""

ENOUGH = 1e-13
"""Minimum change of w that continues the iteration."""

BLOCK_CURVES = 32
"""Number of curves in a block; its intermediate values fit into the processor's cache."""


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
    # repeated knots at both ends clamp the curve to its first and last points
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
    """Evaluate smooth curves at normalised times: (C, K).

    Parameters
    ----------
    points : (C, n, 2) control points (t, v), n >= 2, t never falling
    at : (K,) times
    """
    # curves of one bigram share their control times: t(w) = x is solved once for all of them
    times, own = np.unique(points[..., 0], axis=0, return_inverse=True)
    own = own.reshape(-1)  # numpy 2.0 gives it another shape
    out = np.empty((len(points), len(at)))
    if not len(times):
        return out
    solved = []
    for first in range(0, len(times), BLOCK_CURVES):
        power = _powers(times[first : first + BLOCK_CURVES])
        # span s begins at the value of its polynomial at w = 0
        span = (power[:, 1:, 0][:, None, :] <= at[None, :, None]).sum(-1)
        local = power[np.arange(len(power))[:, None], span]
        solved.append((span, _invert(local, np.broadcast_to(at, span.shape))))
    span, w = (np.concatenate(parts) for parts in zip(*solved, strict=True))
    for first in range(0, len(points), BLOCK_CURVES):
        some = slice(first, first + BLOCK_CURVES)
        number = own[some]
        power = _powers(points[some, :, 1])
        local = power[np.arange(len(number))[:, None], span[number]]
        out[some] = _horner(local, w[number])
    inside = (at >= points[:, :1, 0]) & (at <= points[:, -1:, 0])
    return np.where(inside, out, 0.0)


def _powers(values: Floats) -> Floats:
    """Return the polynomial of control values (C, n) on each span: (C, S, d + 1), by power of w.

    The terms are added one after the other, so no curve depends on which others are evaluated.
    """
    basis = span_basis(values.shape[1])
    spans, order, _ = basis.shape
    return sum(
        (basis[None, :, :, i] * values[:, i : i + spans, None] for i in range(1, order)),
        basis[None, :, :, 0] * values[:, :spans, None],
    )


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
    shape, found = x.shape, np.empty(x.size)
    left = np.arange(x.size)
    t, x = t.reshape(x.size, t.shape[-1]), x.reshape(-1)
    low, high, w = np.zeros(x.size), np.ones(x.size), np.full(x.size, 0.5)
    for _ in range(STEPS):
        error = _horner(t, w) - x
        # t rises, so the sign of the error tells the side on which the solution lies
        low, high = np.where(error < 0, w, low), np.where(error < 0, high, w)
        # the derivative, by the power rule
        steep = _horner(t[:, 1:] * np.arange(1, t.shape[1]), w)
        step = w - error / np.where(steep > 0, steep, np.inf)
        wanted = np.where((step >= low) & (step <= high) & (steep > 0), step, (low + high) / 2)
        moves = np.abs(wanted - w) >= ENOUGH
        found[left] = w
        if not moves.any():
            break
        # solved curves leave the arrays; most of the time goes to a few steep ones
        left, t, x, low, high, w = (one[moves] for one in (left, t, x, low, high, wanted))
    else:
        found[left] = w
    return found.reshape(shape)
