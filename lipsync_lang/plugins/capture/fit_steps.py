"""Steps of a fit: targets of phonemes, then motion, then curves of frequent bigrams.

A pose set states softness for a region or for a single pose; that of a single pose is constant. The
pipeline has one speed limit for all poses.

Conventions: N targets of at most M steps, P poses, K parameters. The first and the last control
value of a bigram are always at rest.

A fit has a prior at the values before it, and lowers::

    sum_o 2 s^2 (sqrt(1 + (e_o / s)^2) - 1)  +  |Q (x - x0)|^2

over recorded values o and parameters x. Errors e above s, which is `SCALE`, have a linear cost
instead of a quadratic one, so that unrelated movement of the face has little influence. The prior Q
keeps the values of rare phonemes near those before the fit.

Conventions: F frames of all lines in sequence, with rests between them; P poses, R drafted rows of
n control values, K parameters. Matrices are sparse.

A curve is the maximum of two bigrams, each a linear function of its control values; the stages of
motion follow. If these leave a curve unchanged, its slope is that of the larger bigram, smoothed
with the kernel of the pose. If a contact, a constraint, the speed limit or anticipation changes it,
the slope is 0, because the value carries no information about a target. The errors always come from
the full pipeline; slopes only direct the search.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from scipy import sparse
from scipy.optimize import minimize_scalar
from scipy.sparse.linalg import lsmr

from lipsync_lang import Motion
from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.packs.banks.draft import TIMES, Target, shape
from lipsync_lang.pipeline.motion import SLOW_SPEED
from lipsync_lang.pipeline.perform import Performance
from lipsync_lang.pipeline.tables import Tables
from lipsync_lang.plugins.capture.fit_lines import FitLine
from lipsync_lang.plugins.capture.fit_values import MOST_DOMINANCE, PASSIVE_LOG, FitFace, FitValues

SCALE = 0.1
"""Minimum error of an outlier, in weight of a pose."""

MAX_LINEARISATIONS = 8

ENOUGH_DECREASE = 1e-3
"""Minimum relative decrease of the cost per step; a smaller one ends the fit."""

EXACT = 1e-5
"""Tolerance of the linear least squares within a step."""

DAMPINGS = (0.0, 0.1, 1.0, 10.0, 100.0, 1000.0)
"""Damping factors of a step, in the order of trial until the cost decreases."""

Sparse = Any
"""A matrix of scipy.sparse."""

WEIGHT_STEP, DOMINANCE_STEP = 0.02, 0.05
"""Differences of a weight and of a dominance's logarithm for the slopes of drafts."""

BOUND = 0.02
"""Minimum difference between a channel and the sum of its poses at a bound of the rig."""

PASSED = 1e-3
"""Maximum change of a value by stages that leave the curve unchanged."""

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
    decreases. The (K,) values before the fit, `start`, are the centre of the prior, whose matrix Q
    is sparse, (L, K). They may be outside the bounds, the minimum and maximum of each value. Of
    values, `errors` returns the (O,) errors of the full pipeline, and `slopes` the sparse (O, K)
    matrix of slopes.
    """
    low, high = np.minimum(bounds[0], start), np.maximum(bounds[1], start)
    now, found = start.copy(), errors(start)
    cost = robust_cost(found)
    for _ in range(MAX_LINEARISATIONS):
        before = cost
        share = (1 + (found / SCALE) ** 2) ** -0.25  # the root of each error's weight
        # One least squares for both: the prior is further rows, whose errors are never outliers.
        rows = sparse.vstack((sparse.diags(share) @ slopes(now), prior), format="csr")
        wanted = -np.concatenate((share * found, prior @ (now - start)))
        # Columns of equal size let LSMR converge: weights and logarithms differ by orders.
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


def control_slopes(face: FitFace, values: FitValues, lines: Sequence[FitLine]) -> Sparse:
    """Return slopes against control values at the current values: (O, R P n).

    Rows include lost values, in the order of lines, frames and signals.
    """
    tables, motion = face.tables_with(values), face.motion(values)
    parts = [_line_slopes(face, tables, motion, line) for line in lines]
    return sparse.vstack(parts, format="csr")


def _line_slopes(face: FitFace, tables: Tables, motion: Motion, line: FitLine) -> Sparse:
    made = line.perform(tables, motion)
    stages = {stage.name: stage.curves.T for stage in made.stages(0, line.made.frames.count)}
    stitched = stages["stitch"]
    dialled = stages.get("dial", stages.get("overlay", stitched))
    level = np.where(stitched > PASSED, dialled / np.maximum(stitched, PASSED), 1.0)
    ahead = stages.get("anticipate", dialled)
    eased = stages.get("ease", ahead)
    last = stages.get("limit", eased)
    # The paper's order of stages constrains last.
    if list(stages).index("constrain") > list(stages).index("limit"):
        last = stages["constrain"]
    same = (np.abs(ahead - dialled) < PASSED) & (np.abs(last - eased) < PASSED)
    raw = _raw_slopes(face, made, level)
    if made.prepared.wide:
        raw = _kernel_matrix(made.prepared.wide, len(tables.priority), line.made.frames.count) @ raw
    out = sparse.diags(same.ravel().astype(float)) @ raw
    if made.prepared.shared:
        kernel = _kernel_matrix(made.prepared.shared, len(tables.priority), line.made.frames.count)
        out = kernel @ out
    observed = sparse.kron(sparse.identity(line.made.frames.count), sparse.csr_matrix(line.gains))
    if line.driven is not None:
        # A channel at a bound of the rig does not follow the poses: its slopes are 0.
        weights = made.weights()
        apart = np.abs(line.signals(weights, motion) - weights @ line.gains.T)
        observed = sparse.diags((apart < BOUND).ravel().astype(float)) @ observed
    return sparse.csr_matrix(observed @ out)


def _raw_slopes(face: FitFace, made: Performance, level: Floats) -> Sparse:
    """Return slopes of stitched curves against control values: (T P, R P n)."""
    tables = made.tables
    row, position = made.places()
    count, poses, points = made.frames.count, len(tables.priority), len(TIMES)
    where = np.full(len(tables.curves), -1)
    where[face.rows] = np.arange(len(face.rows))
    drafted = where[row]
    steps = tables.curves.shape[1] - 1
    # Only to learn which bigram wins at a frame; its slope uses the exact position.
    nearest = np.rint(position.clip(0, 1) * steps).astype(np.intp)
    values = tables.curves[row, nearest].astype(float)
    larger = values[0] >= values[1]
    frame, pose = np.indices((count, poses))
    entries: list[tuple[Any, Any, Any]] = []
    for side, wins in enumerate((larger, ~larger)):
        basis = shape(position[side].clip(0, 1)).T
        some = wins & (drafted[side] >= 0)[:, None] & (values[side] > 0)
        at, of = frame[some], pose[some]
        first = (drafted[side][at] * poses + of) * points
        share = basis[at] * level[at, of][:, None]
        rows = np.repeat(at * poses + of, points)
        columns = (first[:, None] + np.arange(points)).ravel()
        entries.append((share.ravel(), rows, columns))
    data, rows, columns = map(np.concatenate, zip(*entries, strict=True))
    size = count * poses, len(face.rows) * poses * points
    return sparse.csr_matrix((data, (rows, columns)), shape=size)


def _kernel_matrix(blurs: Any, poses: int, count: int) -> Sparse:
    """Return the matrix that smooths (T P,) curves."""
    reach = max(len(blur.kernel) // 2 for blur in blurs)
    taps = np.zeros((2 * reach + 1, poses))
    taps[reach] = 1
    for blur in blurs:
        own = len(blur.kernel) // 2
        taps[:, blur.poses] = 0
        taps[reach - own : reach + own + 1, blur.poses] = blur.kernel[:, None]
    offsets = (np.arange(2 * reach + 1) - reach) * poses
    diagonals = [np.tile(tap, count) for tap in taps]
    size = count * poses
    kept = [n for n, offset in enumerate(offsets) if abs(offset) < size]
    return sparse.diags(
        [diagonals[n][: size - abs(int(offsets[n]))] for n in kept],
        offsets=[int(offsets[n]) for n in kept],
        shape=(size, size),
        format="csr",
    )


def draft_slopes(face: FitFace, values: FitValues) -> Sparse:
    """Return slopes of control values against weights, then dominances: (R P n, N M P + N P).

    They are differences of drafts. A pose of a row depends only on that pose of its two targets.
    Each step of either target therefore needs one draft of all poses and rows.
    """
    targets = face.targets(values)
    now = face.drafted(targets, targets)
    rows, poses, points = now.shape
    most = values.weights.shape[1]
    weights = values.weights.size
    index = np.arange(rows * poses * points)
    row, pose = index // (poses * points), index // points % poses
    parts: list[tuple[Floats, Ints, Ints]] = []
    for ends, side in ((face.first, 0), (face.second, 1)):
        trials: list[tuple[list[Target], Floats, Ints]] = []
        for step in range(most):
            moved, changes = [], []
            for target in targets:
                tried, change = target.weights.copy(), np.ones(poses)
                if step < len(tried):  # towards the middle
                    change = np.where(tried[step] > 0.5, -WEIGHT_STEP, WEIGHT_STEP)  # noqa: PLR2004 half
                    tried[step] += change
                moved.append(Target(tried, target.dominance))
                changes.append(change)
            columns = (ends[row] * most + step) * poses + pose
            trials.append((moved, np.array(changes)[ends], columns))
        moved = [Target(t.weights, t.dominance * np.exp(DOMINANCE_STEP)) for t in targets]
        columns = weights + ends[row] * poses + pose
        trials.append((moved, np.full((rows, poses), DOMINANCE_STEP), columns))
        for moved, size, columns in trials:
            drafts = face.drafted(*((targets, moved) if side else (moved, targets)))
            parts.append((((drafts - now) / size[..., None]).ravel(), index, columns))
    data, at, columns = map(np.concatenate, zip(*parts, strict=True))
    # Most differences are 0, since a pose of a row depends only on its own targets.
    kept = data != 0
    shape_ = rows * poses * points, weights + values.dominance.size
    return sparse.csr_matrix((data[kept], (at[kept], columns[kept])), shape=shape_)


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
        # Without slopes, which `control_slopes` knows for control values alone.
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
