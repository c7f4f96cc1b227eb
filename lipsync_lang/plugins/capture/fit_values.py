"""Fitted values: targets, motion and bigrams, with the tables that depend on them.

Conventions: N targets of at most M steps, P poses, R drafted rows of n control values, O
occurrences. Weights are in [0, 1], dominance is kept as its natural logarithm.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np

from lipsync_lang import Motion
from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.packs.banks.draft import PASSIVE, TIMES, Target, draft, shape
from lipsync_lang.pipeline.tables import Tables
from lipsync_lang.plugins.capture.fit_lines import FitLine
from lipsync_lang.resolver.layers import PairPacks
from lipsync_lang.resolver.retouch import OpenPair

MOST_DOMINANCE = 12.0
"""Maximum fitted dominance; a neighbour's share is then invisible."""

PASSIVE_LOG = float(np.log(PASSIVE))
"""Logarithm of the minimum fitted dominance, which is that of an unnamed pose."""

ENOUGH_SHOWN = 8
"""Minimum number of occurrences for an added pose."""

LEAST_SHOWN_WEIGHT = 0.06
"""Minimum mean weight above the curves for an added pose."""

SURE_SPREADS = 5.0
"""Minimum ratio of the mean weight and its standard error."""


@dataclass(frozen=True, eq=False)
class FitValues:
    """Values of targets, motion and bigrams, before a fit or after it."""

    weights: Floats
    """(N, M, P)"""
    dominance: Floats
    """(N, P) logarithms."""
    mentioned: Bools
    """(N, P) True for poses that a target names."""
    softness: Floats
    """(P,) seconds."""
    anticipate: Floats
    """(P,) seconds."""
    speed: float
    """Highest speed of a pose, in weight per second."""
    bigrams: Mapping[int, Floats]
    """Changes of the control values of some rows relative to their drafts, (P, n) each."""

    def towards(self, fitted: "FitValues", share: float, of_bigrams: float) -> "FitValues":
        """Return values with a share of the fitted changes, and another share for bigrams."""

        def between(start: Any, end: Any) -> Any:
            return start + share * (end - start)

        return FitValues(
            between(self.weights, fitted.weights),
            between(self.dominance, fitted.dominance),
            fitted.mentioned if share else self.mentioned,
            between(self.softness, fitted.softness),
            between(self.anticipate, fitted.anticipate),
            between(self.speed, fitted.speed),
            {row: of_bigrams * change for row, change in fitted.bigrams.items()}
            if of_bigrams
            else {},
        )


@dataclass(frozen=True, eq=False)
class FitFace:
    """A pair with drafted rows computed from targets; all other rows are constant."""

    tables: Tables
    plain: Motion
    """The motion before the fit."""
    names: tuple[str, ...]
    """(N,) phonemes with a target of their own."""
    steps: Ints
    """(N,) number of steps of each target; 0 for rest."""
    targeted: Ints
    """(common phonemes,) target of each; -1 for rest and for unused phonemes."""
    rows: Ints
    """(R,) table rows of the drafted bigrams in use."""
    first: Ints
    """(R,) target of the first phoneme of each."""
    second: Ints
    """(R,) target of the second."""
    start: FitValues
    """The values before the fit."""

    @classmethod
    def of(cls, pair: OpenPair, lines: Iterable[FitLine]) -> Self:
        """Find the targets and drafted rows that some lines use."""
        shelf, every, compiled = pair.shelf, pair.rows.every, pair.compiled
        tables = compiled.tables
        tables = tables.papers if compiled.motion.thresholds == "paper" else tables
        played = sorted({int(row) for line in lines for row in line.made.track.rows} - {0})
        drafted = [row for row in played if row <= len(every) and every[row - 1].drafted]
        ends = [every[row - 1].origin.pair for row in drafted]
        named = {p: shelf.target_phoneme(p) for p in sorted({p for pair in ends for p in pair})}
        known = {name: shelf.targets[phoneme][0] for phoneme, name in named.items()}
        order = {name: number for number, name in enumerate(known)}
        numbers = np.array([[order[named[p]] for p in pair] for pair in ends], np.intp)
        first, second = numbers.reshape(-1, 2).T
        start = _start_values(shelf, known, tables, compiled.motion)
        silence = shelf.common.model.silence
        steps = [0 if name == silence else len(t.weights) for name, t in known.items()]
        spoken = {phoneme: order[name] for phoneme, name in named.items() if phoneme != silence}
        targeted = np.array([spoken.get(phoneme, -1) for phoneme in shelf.numbered], np.intp)
        rows = np.array(drafted, np.intp)
        return cls(
            tables, compiled.motion, tuple(known), np.array(steps, np.intp), targeted, rows, first,
            second, start,
        )  # fmt: skip

    def free(self, values: FitValues) -> Bools:
        """Return True for weights that targets name, which a fit may change: (N, M, P)."""
        there = np.arange(values.weights.shape[1])[None, :] < self.steps[:, None]
        return there[:, :, None] & values.mentioned[:, None, :]

    def targets(self, values: FitValues) -> list[Target]:
        """Return the targets of some values."""
        return [
            Target(weights[: max(1, steps)], np.exp(dominance))
            for weights, dominance, steps in zip(
                values.weights, values.dominance, self.steps.tolist(), strict=True
            )
        ]

    def controls(self, values: FitValues) -> Floats:
        """Return the control values of every drafted row: (R, P, n)."""
        targets = self.targets(values)
        out = self.drafted(targets, targets)
        for number, row in enumerate(self.rows.tolist()):
            if row in values.bigrams:
                out[number] = (out[number] + values.bigrams[row]).clip(0, 1)
        return out

    def drafted(self, early: list[Target], late: list[Target]) -> Floats:
        """Draft every row from targets for its first phoneme and targets for its second."""
        if not len(self.rows):
            return np.zeros((0, self.start.weights.shape[2], len(TIMES)))
        first = [early[n] for n in self.first.tolist()]
        second = [late[n] for n in self.second.tolist()]
        return draft(first, second, exact=True)

    def tables_with(self, values: FitValues) -> Tables:
        """Return tables with curves and motion from some values."""
        # Arrays are compared by content here, since each trial of motion makes new ones.
        latest, motion = self._latest, (values.softness.tobytes(), values.anticipate.tobytes())
        if latest["motion"] != motion:
            base = replace(self.tables, softness=values.softness, anticipate=values.anticipate)
            latest |= {"motion": motion, "base": base}
        # The search for motion leaves the curves as they are.
        key = values.weights, values.dominance, values.bigrams
        if any(a is not b for a, b in zip(key, latest["values"], strict=True)):
            curves = self.tables.curves.copy()
            if len(self.rows):
                sampled = self.controls(values) @ shape(np.linspace(0, 1, curves.shape[1]))
                curves[self.rows] = sampled.swapaxes(1, 2).clip(0, 1)
            latest |= {"values": key, "curves": curves}
        made = replace(latest["base"], curves=latest["curves"])
        # Values that are derived from all else than the curves are kept.
        kept = ("prepared", "caps", "binding", "held", "floors", "blockers")
        vars(made).update({name: getattr(latest["base"], name) for name in kept})
        return made

    @cached_property
    def _latest(self) -> dict[str, Any]:
        """Cache of the latest tables by motion, and the latest curves by targets and bigrams."""
        return {"motion": None, "values": (None, None, None)}

    def motion(self, values: FitValues) -> Motion:
        """Return the pair's motion with the speed limit of some values."""
        return replace(self.plain, speed_limit=values.speed)

    def performed(self, values: FitValues, lines: Sequence[FitLine]) -> list[Floats]:
        """Perform lines with some values through every stage; return their signals, (T, S) each."""
        tables, motion = self.tables_with(values), self.motion(values)
        return [line.signals(line.perform(tables, motion).weights(), motion) for line in lines]

    def errors(self, values: FitValues, lines: Sequence[FitLine]) -> Floats:
        """Return performed minus recorded values of all lines in sequence: (O,)."""
        shown = self.performed(values, lines)
        return np.concatenate([one.errors(w).ravel() for one, w in zip(lines, shown, strict=True)])

    def __getstate__(self) -> dict[str, Any]:
        """Return only the fields, for pickling."""
        return {name: vars(self)[name] for name in self.__dataclass_fields__}


def _start_values(
    shelf: PairPacks, known: Mapping[str, Target], tables: Tables, motion: Motion
) -> FitValues:
    """Return the values of a pair with some targets by name."""
    targets, poses = list(known.values()), len(shelf.poses)
    most = max((len(target.weights) for target in targets), default=1)
    weights = np.zeros((len(targets), most, poses))
    for number, target in enumerate(targets):
        weights[number, : len(target.weights)] = target.weights
    dominance = np.array([target.dominance for target in targets]).reshape(len(targets), poses)
    stated = (
        {p for step in shelf.face.targets.get(one, ()) for p in step.weights} for one in known
    )
    mentioned = np.array([[pose in named for pose in shelf.poses] for named in stated], bool)
    return FitValues(
        weights, np.log(dominance), mentioned.reshape(len(targets), poses), tables.softness,
        tables.anticipate, motion.speed_limit, {},
    )  # fmt: skip


def with_mentions(face: FitFace, values: FitValues, lines: Sequence[FitLine]) -> FitValues:
    """Return values with the poses added that the lines show beyond the curves.

    Only signals of a single pose count, because a sum of poses does not identify one.
    """
    sums = np.zeros((3, len(face.names), values.weights.shape[2]))
    for numbers, poses, means in _occurrences(face, values, lines):
        known, filled = np.isfinite(means), np.nan_to_num(means)
        for kind, added in enumerate((known, filled, filled**2)):
            np.add.at(sums[kind], (numbers[:, None], poses), added)
    count, total, squares = sums
    mean = total / np.maximum(count, 1)
    error = np.sqrt(np.maximum(squares / np.maximum(count, 1) - mean**2, 0) / np.maximum(count, 1))
    new: Bools = (
        (count >= ENOUGH_SHOWN)
        & (mean >= LEAST_SHOWN_WEIGHT)
        & (mean >= SURE_SPREADS * error)
        & ~values.mentioned
        & (face.steps > 0)[:, None]
    )
    if not new.any():
        return values
    there = np.arange(values.weights.shape[1])[None, :, None] < face.steps[:, None, None]
    shown = (mean[:, None, :] * there).clip(0, 1)
    return replace(
        values,
        weights=np.where(new[:, None, :], shown, values.weights),
        # The logarithm of 1, the usual dominance of a named pose.
        dominance=np.where(new, 0.0, values.dominance),
        mentioned=values.mentioned | new,
    )


def _occurrences(
    face: FitFace, values: FitValues, lines: Sequence[FitLine]
) -> Iterator[tuple[Ints, Ints, Floats]]:
    """Yield targets (O,), poses (S,), and mean weights above the curves (O, S) of each line."""
    target = face.targeted
    for line, shown in zip(lines, face.performed(values, lines), strict=True):
        alone = np.flatnonzero((line.gains != 0).sum(axis=1) == 1)
        poses = (line.gains[alone] != 0).argmax(axis=1)
        gains = line.gains[alone, poses]
        beyond = (line.wanted[:, alone] - shown[:, alone]) / gains
        sounds = np.flatnonzero(target[line.made.track.ids] >= 0)
        middles = line.made.track.bounds[sounds] + np.diff(line.made.track.bounds)[sounds] / 2
        at = np.rint((middles - line.made.frames.times()[0]) * line.made.frames.fps).astype(int)
        kept = (at >= 0) & (at < len(beyond))
        yield target[line.made.track.ids[sounds[kept]]], poses, beyond[at[kept]]
