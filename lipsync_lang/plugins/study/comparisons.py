"""Comparisons of two methods: shares, strengths, tests and agreement.

Answers of one rater are not independent, and neither are answers about one line. The paper's
chi-square and the binomial test treat all choices as independent; the tests by raters and by lines
do not. Intervals of shares and strengths are by raters.

Conventions: tests are two-sided; a tail includes the observed value; degrees of freedom are whole.
"""

from collections import Counter, defaultdict
from collections.abc import Callable, Hashable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations
from math import sqrt
from statistics import NormalDist
from typing import NamedTuple

import numpy as np

CONFIDENCE_LEVEL = 0.95
"""Confidence of every interval."""

NORMAL_QUANTILE = NormalDist().inv_cdf((1 + CONFIDENCE_LEVEL) / 2)

ALL_CHARACTERS = ""
"""Character of a comparison over all characters."""


class Interval(NamedTuple):
    """Interval at the level `CONFIDENCE_LEVEL`."""

    low: float
    high: float


def chi_square_tail(statistic: float, freedom: int) -> float:
    """Return the probability of at least this chi-square."""
    from scipy import stats

    return float(stats.chi2.sf(statistic, freedom))


@cache
def t_quantile(freedom: int) -> float:
    """Return the t that bounds `CONFIDENCE_LEVEL` of Student's distribution on both sides."""
    from scipy import stats

    return float(stats.t.ppf((1 + CONFIDENCE_LEVEL) / 2, freedom))


def wilson(successes: float, trials: float, quantile: float = NORMAL_QUANTILE) -> Interval:
    """Return Wilson's score interval of a share; numbers may be fractions."""
    square = quantile**2
    middle = (successes + square / 2) / (trials + square)
    spread = successes * (trials - successes) / trials + square / 4
    half = quantile * sqrt(spread) / (trials + square)
    return Interval(max(0.0, middle - half), min(1.0, middle + half))


def even_odds(successes: int, trials: int) -> float:
    """Return the exact binomial probability that coin flips give a split at least as uneven."""
    from scipy import stats

    return float(stats.binomtest(successes, trials).pvalue)


def sign_flips(differences: Sequence[int]) -> float:
    """Return the exact probability that random signs give a total at least as far from 0.

    The differences are whole numbers: of each rater, the choices for one method less those for the
    other.
    """
    # All 2^R signs at once: rater by rater, the distribution of sums of subsets is convolved. A
    # sum s of the subset with a plus sign is a total of 2 s less the sum of all.
    chances = np.ones(1)
    for size in map(abs, differences):
        step = np.zeros(size + 1)
        step[[0, size]] = 0.5 if size else 1.0
        chances = np.convolve(chances, step)
    whole = len(chances) - 1
    totals = np.abs(2 * np.arange(whole + 1) - whole)
    return float(min(1.0, chances[totals >= abs(sum(differences))].sum()))


class Choice(NamedTuple):
    """A rater's choice between two methods on one question."""

    rater: str
    pair: str
    line: str
    character: str
    question: str
    chosen: str
    other: str
    strength: int
    """Strength of the preference, 1 to 5."""


class MeanStrength(NamedTuple):
    """Mean strength of the preferences for one method."""

    choices: int
    mean: float
    interval: Interval | None
    """Interval by raters; None with fewer than two raters."""


class Clustering(NamedTuple):
    """Dependence of choices that share a rater."""

    design_effect: float | None
    """Variance of the share relative to that of independent choices; None if not computable."""
    correlation: float | None
    """Correlation of two choices of a rater that explains this effect."""
    interval: Interval | None
    """Interval of the share; None with fewer than two raters."""


class Agreement(NamedTuple):
    """Agreement of raters who saw the same pairs."""

    pairs: int
    """Number of pairs with at least two raters."""
    percent: float
    """Percentage of agreeing judgements, over any two raters of a pair."""
    alpha: float | None
    """Krippendorff's alpha, nominal; None if all choices are the same."""


@dataclass(frozen=True)
class Comparison:
    """Choices between two methods on one question, for one or all characters."""

    character: str
    """Name of the character; empty for all characters together."""
    question: str
    first: str
    second: str
    choices: int
    for_first: int
    """Number of choices for the first method."""
    share: float
    """Share of the choices for the first method."""
    interval: Interval
    """Wilson's interval of the share, if all choices were independent."""
    difference: float
    """Share of the first method less that of the second: the paper's "stronger preference"."""
    strength_of_first: MeanStrength | None
    strength_of_second: MeanStrength | None
    """Strengths of the preferences for the methods; None without a choice for the method."""
    chi_square: float
    """Goodness of fit to an even split, 1 degree of freedom."""
    p_chi_square: float
    p_binomial: float
    """Exact binomial test, if all choices were independent."""
    raters: int
    p_raters: float
    """Exact sign-flip test over raters."""
    lines: int
    p_lines: float
    """Exact sign-flip test over lines."""
    clustering: Clustering
    agreement: Agreement | None
    """Agreement of the raters; None if no pair has two raters."""


def cells(choices: Sequence[Choice]) -> Iterator[tuple[str, str, list[Choice]]]:
    """Yield the choices of each question on each character, and on all if there are several."""
    characters = sorted({one.character for one in choices})
    for question in sorted({one.question for one in choices}):
        asked = [one for one in choices if one.question == question]
        for character in characters:
            yield question, character, [one for one in asked if one.character == character]
        # Of one character, all together would be the same figures again.
        if len(characters) > 1:
            yield question, ALL_CHARACTERS, asked


def compared(choices: Sequence[Choice], methods: Sequence[str]) -> list[Comparison]:
    """Compare each pair of methods by question and character, and over several characters."""
    found = [
        _comparison(own, character, question, *pair)
        for question, character, given in cells(choices)
        for pair in combinations(methods, 2)
        if (own := [one for one in given if {one.chosen, one.other} == {*pair}])
    ]
    rank = {method: number for number, method in enumerate(methods)}
    return sorted(found, key=lambda one: (one.question, rank[one.first], rank[one.second]))


def _comparison(
    choices: Sequence[Choice], character: str, question: str, first: str, second: str
) -> Comparison:
    number, wins = len(choices), sum(one.chosen == first for one in choices)
    statistic = chi_square([wins, number - wins])
    raters = _differences(choices, first, lambda one: one.rater)
    lines = _differences(choices, first, lambda one: (one.character, one.line))
    return Comparison(
        character=character,
        question=question,
        first=first,
        second=second,
        choices=number,
        for_first=wins,
        share=wins / number,
        interval=wilson(wins, number),
        difference=(2 * wins - number) / number,
        strength_of_first=mean_strength(one for one in choices if one.chosen == first),
        strength_of_second=mean_strength(one for one in choices if one.chosen == second),
        chi_square=statistic,
        p_chi_square=chi_square_tail(statistic, 1),
        p_binomial=even_odds(wins, number),
        raters=len(raters),
        p_raters=sign_flips(raters),
        lines=len(lines),
        p_lines=sign_flips(lines),
        clustering=clustering(choices, first),
        agreement=agreement(choices),
    )


def chi_square(counts: Sequence[int]) -> float:
    """Return the goodness of fit of counts to equal shares, Σ (o - e)² / e."""
    expected = sum(counts) / len(counts)
    return sum((count - expected) ** 2 for count in counts) / expected


def _differences(
    choices: Iterable[Choice], first: str, cluster: Callable[[Choice], Hashable]
) -> list[int]:
    """Return the difference of choices for the first and the other method, by cluster."""
    found: Counter[Hashable] = Counter()
    for one in choices:
        found[cluster(one)] += 1 if one.chosen == first else -1
    return list(found.values())


def mean_strength(choices: Iterable[Choice]) -> MeanStrength | None:
    """Return the mean strength with an interval by raters; None without choices."""
    by_rater: dict[str, list[int]] = defaultdict(list)
    for one in choices:
        by_rater[one.rater].append(one.strength)
    number = sum(map(len, by_rater.values()))
    if not number:
        return None
    mean = sum(map(sum, by_rater.values())) / number
    if len(by_rater) == 1:
        return MeanStrength(number, mean, None)
    # Raters give different numbers of answers, so the mean is a ratio: residuals, not means, vary.
    off = _variance([sum(given) - mean * len(given) for given in by_rater.values()], number)
    half = t_quantile(len(by_rater) - 1) * sqrt(off)
    return MeanStrength(number, mean, Interval(mean - half, mean + half))


def clustering(choices: Sequence[Choice], first: str) -> Clustering:
    """Return the dependence of choices of the same rater.

    The interval is Wilson's with n / design effect choices and t of raters - 1 degrees of freedom.
    A design effect below 1 counts as 1. If all choices are the same, each rater counts once.
    """
    by_rater: dict[str, list[int]] = defaultdict(list)
    for one in choices:
        by_rater[one.rater].append(one.chosen == first)
    number, raters = len(choices), len(by_rater)
    share = sum(map(sum, by_rater.values())) / number
    if raters == 1:
        return Clustering(None, None, None)
    effect, correlation = None, None
    # If all choices are the same, the variance is 0 and tells nothing: each rater counts once.
    effective = float(raters)
    if 0 < share < 1:
        off = [sum(given) - share * len(given) for given in by_rater.values()]
        # Beside the variance of independent choices, share (1 - share) / number.
        effect = _variance(off, number) * number / (share * (1 - share))
        size = sum(len(given) ** 2 for given in by_rater.values()) / number
        correlation = (effect - 1) / (size - 1) if size > 1 else None
        effective = number / max(effect, 1.0)
    interval = wilson(share * effective, effective, t_quantile(raters - 1))
    return Clustering(effect, correlation, interval)


def _variance(residuals: Sequence[float], number: int) -> float:
    """Return the variance of a mean of `number` values from the residual sums of its clusters."""
    squares = sum(one**2 for one in residuals)
    return len(residuals) / (len(residuals) - 1) * squares / number**2


def agreement(choices: Iterable[Choice]) -> Agreement | None:
    """Return the agreement of raters over the pairs with at least two raters.

    Krippendorff's alpha for nominal data, with n_u judgements of pair u, n_uc of them for c::

        alpha = 1 - (n - 1) Σ_u (n_u² - Σ_c n_uc²) / (n_u - 1) / (n² - Σ_c n_c²)
    """
    units: dict[str, Counter[str]] = defaultdict(Counter)
    for one in choices:
        units[one.pair][one.chosen] += 1
    judged = [unit for unit in units.values() if unit.total() > 1]
    number = sum(unit.total() for unit in judged)
    if not number:
        return None
    apart = sum(
        (unit.total() ** 2 - sum(count**2 for count in unit.values())) / (unit.total() - 1)
        for unit in judged
    )
    totals: Counter[str] = sum(judged, Counter())
    chance = number**2 - sum(count**2 for count in totals.values())
    # If all choices are the same, chance agrees as well.
    alpha = 1 - (number - 1) * apart / chance if chance else None
    return Agreement(len(judged), 100 * (1 - apart / number), alpha)
