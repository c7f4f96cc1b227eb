"""Steps of a fit: targets of phonemes, then motion, then curves of frequent bigrams.

A pose set states softness for a region or for a single pose; that of a single pose is constant. The
pipeline has one speed limit for all poses.

Conventions: N targets of at most M steps, P poses, K parameters. The first and the last control
value of a bigram are always at rest.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from scipy import sparse
from scipy.optimize import minimize_scalar

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.packs.banks.draft import TIMES
from lipsync_lang.pipeline.motion import SLOW_SPEED
from lipsync_lang.plugins.capture.fit_lines import FitLine
from lipsync_lang.plugins.capture.fit_slopes import control_slopes, draft_slopes, robust_cost, solve
from lipsync_lang.plugins.capture.fit_values import MOST_DOMINANCE, PASSIVE_LOG, FitFace, FitValues

PRIOR_OCCURRENCES = 2.0
"""Number of occurrences of a phoneme with the same weight as its target before the fit."""

FREE_PRIOR_OCCURRENCES = 8.0
"""The same number for signals without a scale, which are noisier sums of several poses."""

OCCURRENCE_SECONDS = 0.04
"""Seconds of an occurrence that only its own target determines."""

DOMINANCE_SHARE = 0.03
"""Strength of the prior of a dominance's logarithm, relative to that of a weight."""

HEIGHT_SHARE = 0.1
"""Strength of the prior of a pose's height, relative to that of a weight."""

MOST_HEIGHT = 4.0
"""Maximum height of a pose, which is a factor of all its weights."""

ENOUGH_OCCURRENCES = 10
"""Minimum number of occurrences of a bigram with fitted curves."""

BIGRAM_PRIOR_OCCURRENCES = 10.0
"""Number of occurrences with the same weight as the draft."""

MOST_SOFTNESS, MOST_ANTICIPATION, MOST_SPEED = 0.12, 0.4, 40.0
"""Maximum fitted values: seconds, seconds, and weight per second."""

TRIALS = 9
"""Number of performances of all lines for each value."""

WORTH = 0.01
"""Minimum reduction of the cost by a change of motion, as a share; smaller ones are noise."""


@dataclass(frozen=True, eq=False)
class TargetParameters:
    """Heights of poses, free weights and dominances of a face, as one vector.

    A height is a factor of all weights of a pose. The prior measures each weight relative to it, so
    a capture with wider jaw openings also changes the jaw of rare phonemes.
    """

    face: FitFace
    heights: Ints
    """Poses with a free weight."""
    weights: Bools
    """(N, M, P) True for free weights."""
    dominance: Bools
    """(N, P) True for free dominances."""

    @classmethod
    def of(cls, face: FitFace, base: FitValues, seen: Bools) -> Self:
        """Return the free parameters: named weights of poses with a signal; `seen` is (P,)."""
        weights: Bools = face.free(base) & seen
        dominance = np.asarray(weights.any(axis=1))
        return cls(face, np.flatnonzero(dominance.any(axis=0)), weights, dominance)

    @property
    def free(self) -> Ints:
        """Columns of `draft_slopes` for the free values, which follow the heights in the vector."""
        return np.flatnonzero(np.concatenate((self.weights.ravel(), self.dominance.ravel())))

    def vector(self, values: FitValues) -> Floats:
        """Return heights of 1, and the free values: (K,)."""
        free = values.weights[self.weights], values.dominance[self.dominance]
        return np.concatenate((np.ones(len(self.heights)), *free))

    def values(self, vector: Floats, base: FitValues) -> FitValues:
        """Return values with the free ones replaced from a vector."""
        weights, dominance = base.weights.copy(), base.dominance.copy()
        vector = vector[len(self.heights) :]
        count = int(self.weights.sum())
        weights[self.weights] = vector[:count]
        dominance[self.dominance] = vector[count:]
        return replace(base, weights=weights, dominance=dominance)

    def parts(self, of_heights: float, of_weights: float, of_dominance: float) -> Floats:
        """Return a number for each height, weight and dominance: (K,)."""
        counts = len(self.heights), int(self.weights.sum()), int(self.dominance.sum())
        return np.repeat([of_heights, of_weights, of_dominance], counts)

    def prior(self, strength: float, before: FitValues) -> Any:
        """Return the matrix of the prior for `solve`; `strength` is the strength for a weight."""
        shares = self.parts(HEIGHT_SHARE, 1.0, DOMINANCE_SHARE)
        out = sparse.diags(np.sqrt(strength * shares)).tolil()
        poses = np.nonzero(self.weights)[2]
        first = len(self.heights)
        start = before.weights[self.weights]
        for number, (pose, weight) in enumerate(zip(poses, start, strict=True)):
            column = int(np.searchsorted(self.heights, pose))
            out[first + number, column] = -np.sqrt(strength) * weight
        return out.tocsr()


def fit_targets(face: FitFace, base: FitValues, lines: Sequence[FitLine]) -> FitValues:
    """Fit the targets of a face; `base` has motion, bigrams, and poses added to targets."""
    parameters = TargetParameters.of(face, base, seen_poses(lines))
    known = face.start.mentioned
    before = replace(
        base,
        weights=np.where(known[:, None], face.start.weights, base.weights),
        dominance=np.where(known, face.start.dominance, base.dominance),
    )
    free_signals = any(line.captured.free for line in lines)
    prior_occurrences = FREE_PRIOR_OCCURRENCES if free_signals else PRIOR_OCCURRENCES
    strength = prior_occurrences * OCCURRENCE_SECONDS * lines[0].made.frames.fps
    free = parameters.free

    def errors(vector: Floats) -> Floats:
        return face.errors(parameters.values(vector, base), lines)

    def slopes(vector: Floats) -> Any:
        values = parameters.values(vector, base)
        drafts = draft_slopes(face, values)[:, free]
        found = seen_rows(lines, control_slopes(face, values, lines) @ drafts)
        none = sparse.csr_matrix((found.shape[0], len(parameters.heights)))
        return sparse.hstack((none, found), format="csr")

    solved = solve(
        parameters.vector(before),
        parameters.prior(strength, before),
        (
            parameters.parts(0.0, 0.0, PASSIVE_LOG),
            parameters.parts(MOST_HEIGHT, 1.0, float(np.log(MOST_DOMINANCE))),
        ),
        errors,
        slopes,
    )
    return parameters.values(solved, base)


def fit_motion(
    face: FitFace,
    base: FitValues,
    lines: Sequence[FitLine],
    soft: Iterable[Ints],
    ahead: Iterable[Ints],
) -> FitValues:
    """Return values with the motion of the lowest error on some lines.

    `soft` and `ahead` are groups of poses with one softness, and with anticipation.
    """
    seen = seen_poses(lines)
    changes = [
        *(("softness", poses, 0.0, MOST_SOFTNESS) for poses in soft if seen[poses].any()),
        *(("anticipate", poses, 0.0, MOST_ANTICIPATION) for poses in ahead if seen[poses].any()),
        ("speed", np.arange(0), SLOW_SPEED, MOST_SPEED),
    ]
    now, cost = base, robust_cost(face.errors(base, lines))
    for name, poses, *bounds in changes:

        def cost_of(
            value: float, name: str = name, poses: Ints = poses, now: FitValues = now
        ) -> float:
            return robust_cost(face.errors(_changed(now, name, poses, value), lines))

        options = {"maxiter": TRIALS}
        found = minimize_scalar(cost_of, bounds=bounds, method="bounded", options=options)
        if found.fun < cost * (1 - WORTH):
            now, cost = _changed(now, name, poses, float(found.x)), float(found.fun)
    return now


def _changed(values: FitValues, name: str, poses: Ints, value: float) -> FitValues:
    """Return values with another speed limit, or another softness or anticipation of poses."""
    if name == "speed":
        return replace(values, speed=value)
    changed: Floats = getattr(values, name).copy()
    changed[poses] = value
    return replace(values, **{name: changed})  # type: ignore[arg-type]  # a field by name


def fit_bigrams(face: FitFace, base: FitValues, lines: Sequence[FitLine]) -> FitValues:
    """Return values with fitted curves for bigrams with enough occurrences."""
    spoken = np.concatenate([line.made.track.rows for line in lines])
    counts = np.bincount(spoken, minlength=len(face.tables.curves))
    often = counts[face.rows] >= ENOUGH_OCCURRENCES
    rows = np.flatnonzero(often)
    if not rows.size:
        return base
    drafts = face.controls(replace(base, bigrams={}))[rows]
    free = np.zeros(drafts.shape, bool)
    free[:, seen_poses(lines), 1:-1] = True
    strength = BIGRAM_PRIOR_OCCURRENCES * OCCURRENCE_SECONDS * lines[0].made.frames.fps / len(TIMES)
    start = np.zeros(int(free.sum()))
    every = np.zeros((len(often), *free.shape[1:]), bool)
    every[rows] = free
    columns = np.flatnonzero(every)  # of the slopes

    def values(vector: Floats) -> FitValues:
        changes = np.zeros(drafts.shape)
        changes[free] = vector
        return replace(base, bigrams=dict(zip(face.rows[rows].tolist(), changes, strict=True)))

    def errors(vector: Floats) -> Floats:
        return face.errors(values(vector), lines)

    def slopes(vector: Floats) -> Any:
        return seen_rows(lines, control_slopes(face, values(vector), lines)[:, columns])

    bounds = -drafts[free], 1 - drafts[free]
    prior = sparse.identity(len(start), format="csr") * np.sqrt(strength)
    return values(solve(start, prior, bounds, errors, slopes))


def seen_poses(lines: Sequence[FitLine]) -> Bools:
    """Return True for poses with an effect on a recorded signal: (P,)."""
    return np.any(
        [np.any(line.gains[line.seen.any(axis=0)] != 0, axis=0) for line in lines], axis=0
    )


def seen_rows(lines: Sequence[FitLine], matrix: Any) -> Any:
    """Return slopes with rows of 0 for lost values."""
    seen = np.concatenate([line.seen.ravel() for line in lines]).astype(float)
    return sparse.diags(seen) @ matrix
