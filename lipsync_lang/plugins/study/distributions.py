"""Distributions of the tests and intervals of a study, in closed form.

Conventions: tests are two-sided; a tail includes the observed value; degrees of freedom are whole.
"""

from collections.abc import Sequence
from functools import cache
from math import cos, erfc, exp, lgamma, log, pi, sin, sqrt, tan
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats

CONFIDENCE_LEVEL = 0.95
"""Confidence of every interval."""

NORMAL_QUANTILE = NormalDist().inv_cdf((1 + CONFIDENCE_LEVEL) / 2)

MAX_SERIES_FREEDOM = 200
"""Degrees of freedom beyond which an expansion around the normal gives t to seven digits."""

BISECTIONS = 60


class Interval(NamedTuple):
    """Interval at the level `CONFIDENCE_LEVEL`."""

    low: float
    high: float


def chi_square_tail(statistic: float, freedom: int) -> float:
    """Return the probability of at least this chi-square.

    Abramowitz and Stegun, 26.4.4 and 26.4.5, with half the statistic h and Γ of halves::

        Q = [erfc(√h), odd only] + Σ exp(-h) h^o / Γ(o + 1),   o = 0, 1 ... or 1/2, 3/2 ...
    """
    half = statistic / 2
    if half <= 0:
        return 1.0
    odd = freedom % 2
    orders = (odd / 2 + step for step in range(freedom // 2))
    series = sum(exp(order * log(half) - half - lgamma(order + 1)) for order in orders)
    return min(1.0, series + (erfc(sqrt(half)) if odd else 0.0))


@cache
def t_quantile(freedom: int) -> float:
    """Return the t that bounds `CONFIDENCE_LEVEL` of Student's distribution on both sides.

    Abramowitz and Stegun, 26.7.3 and 26.7.4, give the probability of less than t = √freedom tan(θ).
    """
    z = NORMAL_QUANTILE
    if freedom > MAX_SERIES_FREEDOM:
        return z + (z**3 + z) / (4 * freedom) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * freedom**2)
    odd, low, high = freedom % 2, 0.0, pi / 2
    for _ in range(BISECTIONS):
        angle = (low + high) / 2
        term, total = (cos(angle) if odd else 1.0), 0.0
        for step in range(freedom // 2):
            total += term
            term *= cos(angle) ** 2 * (2 * step + 1 + odd) / (2 * step + 2 + odd)
        within = sin(angle) * total
        within = 2 / pi * (angle + within) if odd else within
        low, high = (angle, high) if within < CONFIDENCE_LEVEL else (low, angle)
    return tan(low) * sqrt(freedom)


def wilson(successes: float, trials: float, quantile: float = NORMAL_QUANTILE) -> Interval:
    """Return Wilson's score interval of a share; numbers may be fractions."""
    square = quantile**2
    middle = (successes + square / 2) / (trials + square)
    spread = successes * (trials - successes) / trials + square / 4
    half = quantile * sqrt(max(spread, 0.0)) / (trials + square)
    return Interval(max(0.0, middle - half), min(1.0, middle + half))


def binomial_masses(trials: int, share: float) -> Floats:
    """Return the probability of 0, 1 ... `trials` successes, for a share within (0, 1)."""
    counts = np.arange(trials)
    steps = np.log((trials - counts) / (counts + 1)) + log(share / (1 - share))
    logs = trials * np.log1p(-share) + np.concatenate(([0.0], np.cumsum(steps)))
    return np.exp(logs)


def even_odds(successes: int, trials: int) -> float:
    """Return the exact binomial probability that coin flips give a split at least as uneven."""
    most = max(successes, trials - successes)
    return float(min(1.0, 2 * binomial_masses(trials, 0.5)[most:].sum()))


def sign_flips(differences: Sequence[int]) -> float:
    """Return the exact probability that random signs give a total at least as far from 0.

    The distribution of all 2^R totals is built rater by rater, as the sums of subsets. The
    differences are whole numbers: of each rater, the choices for one method less those for the
    other.
    """
    sizes = [abs(one) for one in differences]
    whole = sum(sizes)
    chances = np.zeros(whole + 1)
    chances[0], reached = 1.0, 0
    for size in sizes:
        moved = chances[: reached + 1] / 2
        chances[: reached + 1] /= 2
        chances[size : size + reached + 1] += moved
        reached += size
    totals = np.abs(2 * np.arange(whole + 1) - whole)
    return float(min(1.0, chances[totals >= abs(sum(differences))].sum()))
