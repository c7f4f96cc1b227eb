"""Bradley-Terry: strengths of more than two methods from choices between pairs of them.

A method of strength s beats one of strength t with probability 1 / (1 + exp(t - s)). Strengths are
natural logarithms of odds and add up to 0. There are no ties.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.plugins.study.comparisons import (
    ALL_CHARACTERS,
    Choice,
    Interval,
    cells,
    chi_square_tail,
    t_quantile,
)

FLIPS, FLIPS_AT_ONCE = 20_000, 1_000
"""Number of random sign vectors in the test over raters; their seed is fixed."""

MAX_NEWTON_STEPS = 200
GRADIENT_TOLERANCE = 1e-10
"""Gradient at which the fit ends, as a share of the number of choices."""


class MethodStrength(NamedTuple):
    """Strength of one method among several."""

    method: str
    wins: int
    """Number of choices for the method."""
    choices: int
    """Number of choices that included the method."""
    strength: float
    interval: Interval | None
    """Interval by raters; None with fewer than two raters."""
    beats_others: float
    """Mean probability of a choice for the method against each other method."""


@dataclass(frozen=True)
class Ranking:
    """Strengths of several methods on one question, for one or all characters."""

    character: str
    """Name of the character; empty for all characters together."""
    question: str
    methods: tuple[MethodStrength, ...]
    """Methods by strength, strongest first; empty if there are no finite strengths."""
    likelihood_ratio: float | None
    """Statistic against equal strengths of all methods."""
    freedom: int
    """Degrees of freedom of the statistic."""
    p_likelihood_ratio: float | None
    """Probability of the statistic if all choices were independent."""
    p_raters: float | None
    """Sign-flip test of equal strengths over raters, with random signs."""
    problem: str = ""
    """Sentence on the reason for missing strengths."""


def ranked(choices: Sequence[Choice], methods: Sequence[str]) -> list[Ranking]:
    """Rank the methods by question and character; two methods need no ranking."""
    if len(methods) <= 2:  # noqa: PLR2004 a pair
        return []
    return [
        ranking(given, methods, character=character, question=question)
        for question, character, given in cells(choices)
    ]


def ranking(
    choices: Sequence[Choice],
    methods: Sequence[str],
    *,
    character: str = ALL_CHARACTERS,
    question: str = "",
) -> Ranking:
    """Fit strengths to choices."""
    index = {method: number for number, method in enumerate(methods)}
    wins = win_matrix(choices, index)
    freedom = len(methods) - 1
    # Strengths are finite if choices connect all methods both ways (Ford 1957).
    problem = ""
    connected, beaten = _reachable((wins + wins.T) > 0), _reachable(wins > 0)
    weakest = next((row for row in beaten if not row.all()), None)
    if not connected.all():
        groups = dict.fromkeys(_named(methods, row) for row in connected)
        problem = f"no choice connects these groups of methods: {' | '.join(groups)}"
    elif weakest is not None:
        weak, strong = _named(methods, weakest), _named(methods, ~weakest)
        problem = f"no choice prefers {weak} to {strong}, so the strengths have no limit"
    if problem:
        return Ranking(character, question, (), None, freedom, None, None, problem)
    strengths = fitted_strengths(wins)
    ratio = 2 * (_log_likelihood(wins, strengths) - _log_likelihood(wins, np.zeros(len(methods))))
    given: dict[str, list[Choice]] = defaultdict(list)
    for one in choices:
        given[one.rater].append(one)
    by_rater = [win_matrix(own, index) for own in given.values()]
    described = _described(methods, wins, strengths, by_rater)
    found = sorted(described, key=lambda one: (-one.strength, one.method))
    tail, flips = chi_square_tail(ratio, freedom), flipped_raters(by_rater, wins)
    return Ranking(character, question, tuple(found), max(ratio, 0.0), freedom, tail, flips)


def flipped_raters(by_rater: Sequence[Floats], wins: Floats) -> float:
    """Return the probability of a score as far from equal strengths by random signs of raters.

    A rater's sign reverses all choices of the rater. The score statistic is g' H⁻ g, with the
    gradient g, a sum over raters, and the information H of equal strengths, which no sign changes.
    """
    gradients = np.array([(one - one.T).sum(axis=1) / 2 for one in by_rater])
    # The information is singular: adding one number to all strengths changes nothing.
    inverse = np.linalg.pinv(_information(wins, np.zeros(len(wins))))

    def scores(totals: Floats) -> Floats:
        return np.einsum("ni,ij,nj->n", totals, inverse, totals)

    observed = scores(gradients.sum(axis=0, keepdims=True))[0]
    chance = np.random.default_rng(0)
    # The observed signs are one of the vectors, so p is never 0 (Phipson and Smyth 2010).
    reached = 1
    for _ in range(FLIPS // FLIPS_AT_ONCE):
        # A part at a time: 20,000 vectors of a thousand raters would take 160 MB.
        signs = chance.choice((-1.0, 1.0), (FLIPS_AT_ONCE, len(gradients)))
        reached += int((scores(signs @ gradients) >= observed * (1 - GRADIENT_TOLERANCE)).sum())
    return reached / (FLIPS + 1)


def win_matrix(choices: Iterable[Choice], index: dict[str, int]) -> Floats:
    """Count the choices for each method (row) over each other (column)."""
    wins = np.zeros((len(index), len(index)))
    for one in choices:
        wins[index[one.chosen], index[one.other]] += 1
    return wins


def fitted_strengths(wins: Floats) -> Floats:
    """Return the maximum-likelihood strengths, by Newton's method with halved steps."""
    strengths = np.zeros(len(wins))
    for _ in range(MAX_NEWTON_STEPS):
        gradient = _gradient(wins, strengths)
        if np.abs(gradient).max() <= GRADIENT_TOLERANCE * wins.sum():
            break
        step = np.linalg.pinv(_information(wins, strengths)) @ gradient
        before = _log_likelihood(wins, strengths)
        while (
            _log_likelihood(wins, strengths + step) < before
            and np.abs(step).max() > GRADIENT_TOLERANCE
        ):
            step = step / 2
        strengths = strengths + step
        strengths -= strengths.mean()
    return strengths


def _chances(strengths: Floats) -> Floats:
    """Return the probability that each method (row) beats each other (column)."""
    return 1 / (1 + np.exp(strengths[None, :] - strengths[:, None]))


def _log_likelihood(wins: Floats, strengths: Floats) -> float:
    return float(-(wins * np.logaddexp(0, strengths[None, :] - strengths[:, None])).sum())


def _gradient(wins: Floats, strengths: Floats) -> Floats:
    return (wins - (wins + wins.T) * _chances(strengths)).sum(axis=1)


def _information(wins: Floats, strengths: Floats) -> Floats:
    chances = _chances(strengths)
    weights = (wins + wins.T) * chances * chances.T
    return np.diag(weights.sum(axis=1)) - weights


def _described(
    methods: Sequence[str], wins: Floats, strengths: Floats, by_rater: Sequence[Floats]
) -> list[MethodStrength]:
    """Describe each method, with intervals by raters if there are several raters.

    The standard errors are a sandwich of the information around the gradients of raters, and no
    smaller than those of independent choices.
    """
    raters = len(by_rater)
    intervals: list[Interval | None] = [None] * len(methods)
    if raters > 1:
        inverse = np.linalg.pinv(_information(wins, strengths))
        gradients = np.array([_gradient(one, strengths) for one in by_rater])
        clustered = inverse @ (gradients.T @ gradients) @ inverse * (raters / (raters - 1))
        errors = np.sqrt(np.maximum(np.diag(clustered), np.diag(inverse)))
        half = t_quantile(raters - 1) * errors
        ends = zip((strengths - half).tolist(), (strengths + half).tolist(), strict=True)
        intervals = [Interval(*both) for both in ends]
    others = (_chances(strengths).sum(axis=1) - 0.5) / (len(methods) - 1)
    won, lost = wins.sum(axis=1).astype(int), wins.sum(axis=0).astype(int)
    figures = won.tolist(), (won + lost).tolist(), strengths.tolist()
    return list(map(MethodStrength, methods, *figures, intervals, others.tolist()))


def _named(methods: Sequence[str], among: Bools) -> str:
    return ", ".join(method for method, one in zip(methods, among, strict=True) if one)


def _reachable(edges: Bools) -> Bools:
    """Return the nodes that each node reaches along edges, including itself."""
    return np.linalg.matrix_power(edges | np.eye(len(edges), dtype=bool), len(edges))
