"""Fits of targets: weights and dominance of each pose at each phoneme.

Conventions: N targets of at most M steps, P poses, K parameters.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from lipsync_lang.capture.fit_lines import FitLine
from lipsync_lang.capture.fit_slopes import control_slopes, draft_slopes
from lipsync_lang.capture.fit_solver import solve
from lipsync_lang.capture.fit_values import MOST_DOMINANCE, PASSIVE_LOG, FitFace, FitValues
from lipsync_lang.pipeline.arrays import Bools, Floats, Ints

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
        from scipy import sparse

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
    """Fit the targets of a face to lines.

    Parameters
    ----------
    base : values of motion and bigrams, and of poses added to targets
    """
    from scipy import sparse

    parameters = TargetParameters.of(face, base, seen_poses(lines))
    known = face.start.mentioned
    before = replace(
        base,
        weights=np.where(known[:, None], face.start.weights, base.weights),
        dominance=np.where(known, face.start.dominance, base.dominance),
    )
    free_signals = any(line.captured.free for line in lines)
    occurrences = FREE_PRIOR_OCCURRENCES if free_signals else PRIOR_OCCURRENCES
    strength = occurrences * OCCURRENCE_SECONDS * lines[0].frames.fps
    free = parameters.free

    def errors(vector: Floats) -> Floats:
        return face.errors(parameters.values(vector, base), lines)

    def slopes(vector: Floats) -> Any:
        values = parameters.values(vector, base)
        drafts = draft_slopes(face, values)[:, free]
        found = seen_rows(lines, control_slopes(face, values, lines).matrix @ drafts)
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


def seen_poses(lines: Sequence[FitLine]) -> Bools:
    """Return True for poses with an effect on a recorded signal: (P,)."""
    out: Bools = np.any(
        [np.any(line.gains[line.seen.any(axis=0)] != 0, axis=0) for line in lines], axis=0
    )
    return out


def seen_rows(lines: Sequence[FitLine], matrix: Any) -> Any:
    """Return slopes with rows of 0 for lost values."""
    from scipy import sparse

    seen = np.concatenate([line.seen.ravel() for line in lines]).astype(float)
    return sparse.diags(seen) @ matrix
