"""Power of a study: the choices and raters that can show a preference of a given share.

The test is the exact binomial one. Choices of one rater are alike: with M choices each and an
intraclass correlation r, N raters give N M / (1 + (M - 1) r) independent choices (Kish 1965).
"""

from dataclasses import asdict, dataclass
from math import ceil, floor
from statistics import NormalDist
from typing import Any

import numpy as np

from lipsync_lang import LipsyncError
from lipsync_lang.base.arrays import Floats, Ints

POWER_FORMAT = "lipsync-lang study power 1"
MIN_CHANCE = 0.0001
"""Minimum power and level; smaller ones would need studies of any size."""

MIN_DISTANCE = 0.005
"""Minimum distance of a share from one half; 80 % power there needs 80,000 choices."""

MAX_CHOICES = 1_000_000
SEARCHED_SHARE, SEARCHED_CHOICES = 0.15, 60
"""Search range for the exact number around the normal approximation."""

PAIRS_SHOWN = (10, 20, 40)
"""Numbers of pairs per rater in a plan without given ones."""


@dataclass(frozen=True)
class PowerRow:
    """A design and its power."""

    pairs: int
    """Number of choices of each rater on one question."""
    raters: int
    choices: int
    """Number of choices of all raters."""
    effective: int
    """Equivalent number of independent choices."""
    power: float
    """Probability of a significant result."""


@dataclass(frozen=True)
class PowerQuestion:
    """Question about the size of a study, or the power of a design."""

    share: float
    """Assumed share of the choices for the preferred method, 0 to 1 without one half."""
    raters: int | None = None
    pairs: int | None = None
    """Number of pairs that each rater judges."""
    power: float = 0.8
    """Wanted probability of a significant result."""
    alpha: float = 0.05
    """Level of the two-sided test."""
    correlation: float = 0.1
    """Assumed correlation of two choices of one rater."""


@dataclass(frozen=True)
class PowerPlan:
    """Answer to a question of power."""

    question: PowerQuestion
    choices: int
    """Number of independent choices needed, from raters who judge one pair each."""
    rows: tuple[PowerRow, ...]
    """The given design if it has raters and pairs, else designs with the wanted power."""

    def to_dict(self) -> dict[str, Any]:
        """Return the plan as JSON data."""
        return {"format": POWER_FORMAT, **asdict(self)}


def plan_study(question: PowerQuestion) -> PowerPlan:
    """Plan a study of two methods; refuse numbers out of range, or that can never be enough."""
    _check(question)
    raters, pairs, correlation = question.raters, question.pairs, question.correlation
    needed = choices_needed(question.share, question.power, question.alpha)
    if raters and pairs:
        sizes = [(pairs, raters)]
    elif pairs:
        sizes = [(pairs, raters_for(needed, pairs, correlation))]
    elif raters:
        sizes = [(pairs_for(needed, raters, correlation), raters)]
    else:
        sizes = [(one, raters_for(needed, one, correlation)) for one in PAIRS_SHOWN]
    rows = []
    for each, number in sizes:
        effective = effective_choices(number, each, correlation)
        power = exact_power(effective, question.share, question.alpha)
        rows.append(PowerRow(each, number, number * each, effective, power))
    return PowerPlan(question, needed, tuple(rows))


def _check(question: PowerQuestion) -> None:
    share = question.share
    if not 0 < share < 1 or abs(share - 0.5) < MIN_DISTANCE:
        what = f"give a share between 0 and 1 that differs from 0.5 by at least {MIN_DISTANCE:g}"
        raise LipsyncError(f"`share={share:g}`: {what}")
    for name, value in (("power", question.power), ("alpha", question.alpha)):
        if not MIN_CHANCE <= value <= 1 - MIN_CHANCE:
            what = f"give a number from {MIN_CHANCE:g} to {1 - MIN_CHANCE:g}"
            raise LipsyncError(f"`{name}={value:g}`: {what}")
    if not 0 <= question.correlation <= 1:
        raise LipsyncError(f"`correlation={question.correlation:g}`: give a number from 0 to 1")
    for name, number in (("raters", question.raters), ("pairs", question.pairs)):
        if number is not None and number < 1:
            raise LipsyncError(f"`{name}={number}`: give a number of at least 1")
    if (question.raters or 1) * (question.pairs or 1) > MAX_CHOICES:
        what = f"more than {MAX_CHOICES:,} choices are too many"
        raise LipsyncError(f"{what}; give fewer raters or pairs")


def effective_choices(raters: int, pairs: int, correlation: float) -> int:
    """Return the number of independent choices equivalent to those of raters with several pairs."""
    return floor(raters * pairs / (1 + (pairs - 1) * correlation) + 1e-9)


def raters_for(choices: int, pairs: int, correlation: float) -> int:
    """Return the minimum number of raters, with some pairs each, for independent choices."""
    return ceil(choices * (1 + (pairs - 1) * correlation) / pairs - 1e-9)


def pairs_for(choices: int, raters: int, correlation: float) -> int:
    """Return the fewest pairs for each rater that give some independent choices, if any do."""
    room = raters - choices * correlation
    if room <= 0:
        least = floor(choices * correlation) + 1
        raise LipsyncError(
            f"`raters={raters}`: no number of pairs is enough, since choices of the same rater "
            f"are alike (correlation {correlation:g}); take at least {least} raters"
        )
    pairs = max(1, ceil(choices * (1 - correlation) / room - 1e-9))
    if raters * pairs > MAX_CHOICES:
        what = f"each rater would need {pairs:,} pairs; take more raters"
        raise LipsyncError(f"`raters={raters}`: {what}")
    return pairs


def exact_power(choices: int, share: float, alpha: float) -> float:
    """Return the power of the exact two-sided binomial test against an even split."""
    return float(_exact_powers(np.array([choices]), share, alpha)[0])


def _exact_powers(choices: Ints, share: float, alpha: float) -> Floats:
    """Return the power of each number of choices, (N,) each."""
    from scipy import stats

    most = stats.binom.ppf(alpha / 2, choices, 0.5)
    # `ppf` is the first count whose tail reaches the level; only a tail within it is significant
    most -= stats.binom.cdf(most, choices, 0.5) > alpha / 2
    tails = stats.binom.cdf(most, choices, share) + stats.binom.sf(
        choices - most - 1, choices, share
    )
    return np.where((choices > 0) & (most >= 0), np.minimum(tails, 1.0), 0.0)


def choices_needed(share: float, power: float, alpha: float) -> int:
    """Return the number of independent choices from which the power stays sufficient.

    The power of an exact test falls a little between steps, so a number with enough power may
    precede one with too little.
    """
    normal = NormalDist()
    z_alpha, z_power = normal.inv_cdf(1 - alpha / 2), normal.inv_cdf(power)
    spread = z_alpha * 0.5 + z_power * (share * (1 - share)) ** 0.5
    # The normal approximation of a low power at a low level may be below zero.
    near = max(1, ceil((spread / abs(share - 0.5)) ** 2)) if spread > 0 else 1
    low = max(1, floor(near * (1 - SEARCHED_SHARE)) - SEARCHED_CHOICES)
    high = ceil(near * (1 + SEARCHED_SHARE)) + SEARCHED_CHOICES
    if high > MAX_CHOICES:
        raise LipsyncError(f"more than {MAX_CHOICES:,} choices are needed; ask for less power")
    # A window instead of a number, because the power falls between its steps.
    while high - low > 2 * SEARCHED_CHOICES:
        middle = (low + high) // 2
        window = np.arange(middle, middle + SEARCHED_CHOICES)
        enough = (_exact_powers(window, share, alpha) >= power).all()
        low, high = (low, middle) if enough else (middle, high)
    short = np.flatnonzero(_exact_powers(np.arange(low, high + 1), share, alpha) < power)
    return low + (int(short[-1]) + 1 if short.size else 0)
