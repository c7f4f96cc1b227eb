"""Robust least squares through the pipeline, with a prior at the values before the fit.

A fit lowers::

    sum_o 2 s^2 (sqrt(1 + (e_o / s)^2) - 1)  +  |Q (x - x0)|^2

over recorded values o and parameters x. Errors e above s, which is `SCALE`, have a linear cost
instead of a quadratic one, so that unrelated movement of the face has little influence. The prior Q
keeps the values of rare phonemes near those before the fit.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from lipsync_lang.arrays import Floats

SCALE = 0.1
"""Minimum error of an outlier, in weight of a pose."""

MAX_LINEARISATIONS = 8
"""Maximum number of linearisations in a fit."""

ENOUGH_DECREASE = 1e-3
"""Minimum relative decrease of the cost per step; a smaller one ends the fit."""

EXACT = 1e-5
"""Tolerance of the linear least squares within a step."""

DAMPINGS = (0.0, 0.1, 1.0, 10.0, 100.0, 1000.0)
"""Damping factors of a step, in the order of trial until the cost decreases."""


def robust_cost(errors: Floats) -> float:
    """Return the cost of some errors."""
    return float(2 * SCALE**2 * (np.sqrt(1 + (errors / SCALE) ** 2) - 1).sum())


def solve(
    start: Floats,
    prior: Any,
    bounds: tuple[Floats, Floats],
    errors: Callable[[Floats], Floats],
    slopes: Callable[[Floats], Any],
) -> Floats:
    """Return the fitted parameters: (K,).

    Each step linearises the errors (Gauss-Newton) and is damped until the cost of the full pipeline
    decreases.

    Parameters
    ----------
    start : (K,) values before the fit, at the centre of the prior
    prior : sparse (L, K) matrix Q of the prior
    bounds : minimum and maximum of each value; a start outside is allowed
    errors : function from values to (O,) errors of the full pipeline
    slopes : function from values to the sparse (O, K) matrix of slopes
    """
    from scipy import sparse
    from scipy.sparse.linalg import lsmr

    low, high = np.minimum(bounds[0], start), np.maximum(bounds[1], start)
    now, found = start.copy(), errors(start)
    cost = robust_cost(found)
    for _ in range(MAX_LINEARISATIONS):
        before = cost
        share = (1 + (found / SCALE) ** 2) ** -0.25  # the root of each error's weight
        rows = sparse.vstack((sparse.diags(share) @ slopes(now), prior), format="csr")
        wanted = -np.concatenate((share * found, prior @ (now - start)))
        size = np.sqrt(np.asarray(rows.multiply(rows).sum(axis=0)).ravel())
        size[size == 0] = 1
        even = rows @ sparse.diags(1 / size)
        for damping in DAMPINGS:
            step = lsmr(even, wanted, damp=damping**0.5, atol=EXACT, btol=EXACT)[0] / size
            tried = np.clip(now + step, low, high)
            after = errors(tried)
            total = robust_cost(after) + float(((prior @ (tried - start)) ** 2).sum())
            if total < cost:
                now, found, cost = tried, after, total
                break
        if before - cost < ENOUGH_DECREASE * cost:
            break
    return now
