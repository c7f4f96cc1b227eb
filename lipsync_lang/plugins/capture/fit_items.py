"""Items of a proposal: each fitted value in the form of a pack, with the evidence for it.

The confidence of an item comes from the fits that left out a part of the lines (jackknife). With
the change d of each of its numbers and that change's standard error s over the parts::

    confidence = sum d^2 / (sum d^2 + sum s^2)

A confidence of 1 is a change in every part of the lines; 0.5 is a change as large as its error.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.packs.banks.draft import TIMES
from lipsync_lang.plugins.capture.fit_file import VALUE_DECIMALS, FitItem
from lipsync_lang.plugins.capture.fit_folds import FitTask
from lipsync_lang.plugins.capture.fit_values import FitFace, FitValues
from lipsync_lang.resolver.retouch import OpenPair

ITEM_DECIMALS = 3
"""Decimals of fitted values in a proposal."""

LEAST_WEIGHT, LEAST_DOMINANCE, LEAST_SECONDS, LEAST_SPEED_CHANGE = 0.005, 0.05, 0.0005, 0.1
"""Minimum changes of weights, of the logarithm of a dominance, of times and of the speed limit;
smaller changes are discarded."""

BIGRAM_GAIN = 0.98
"""Maximum ratio of the errors with and without fitted curves of a bigram."""

FAINTEST = 0.01
"""Minimum weight of a moving pose in a target; a target of 0 would oppose an early start."""


@dataclass(frozen=True, eq=False)
class _Evidence:
    """Errors before and after a fit, by phoneme."""

    task: FitTask
    before: list[Floats]
    """(T, S) errors of each line."""
    after: list[Floats]

    def of(self, chosen: Sequence[Bools], occurrences: int) -> dict[str, Any]:
        """Return fields of an item: the errors over some frames of each line; (T,) each."""
        every = [line.seen for line in self.task.lines]
        count = sum(int(seen[some].sum()) for some, seen in zip(chosen, every, strict=True))
        fields: dict[str, Any] = {"occurrences": occurrences}
        for name, errors in (("residual_before", self.before), ("residual_after", self.after)):
            parts = [
                (error[some & seen.any(axis=1)] ** 2).sum(axis=0)
                for error, some, seen in zip(errors, chosen, every, strict=True)
            ]
            total = float(sum(part.sum() for part in parts))
            fields[name] = round((total / count) ** 0.5, VALUE_DECIMALS) if count else None
        return fields


def fit_items(
    pair: OpenPair, task: FitTask, values: FitValues, others: Sequence[FitValues]
) -> Iterator[FitItem]:
    """Yield an item for each changed value; `others` are of fits without a part of the lines."""
    face, lines = task.face, task.lines
    errors = [
        [line.errors(w) for line, w in zip(lines, face.shown(one, lines), strict=True)]
        for one in (face.start, values)
    ]
    evidence = _Evidence(task, *errors)
    yield from _target_items(pair, evidence, values, others)
    yield from _motion_items(pair, evidence, values, others)
    yield from _bigram_items(pair, evidence, values, others)


def confidence(start: Floats, value: Floats, others: Sequence[Floats]) -> float:
    """Return the confidence of a change; 0 without a cross-validation."""
    count = len(others)
    if count < 2:  # noqa: PLR2004 an error needs two parts
        return 0.0
    change = float(((value - start) ** 2).sum())
    spread = np.stack(others) - np.mean(others, axis=0)
    noise = float((spread**2).sum()) * (count - 1) / count
    return round(change / (change + noise), 3) if change else 0.0


def _target_items(
    pair: OpenPair, evidence: _Evidence, values: FitValues, others: Sequence[FitValues]
) -> Iterator[FitItem]:
    face, start = evidence.task.face, evidence.task.face.start
    shelf = pair.shelf
    for number, name in enumerate(face.names):
        if not face.steps[number]:
            continue
        weight = np.abs(values.weights[number] - start.weights[number]).max()
        dominance = np.abs(values.dominance[number] - start.dominance[number]).max()
        if weight < LEAST_WEIGHT and dominance < LEAST_DOMINANCE:
            continue
        meant = {n for n, p in enumerate(shelf.numbered) if shelf.target_phoneme(p) == name}
        chosen, count = _frames(evidence.task, [meant])
        was = []
        for step in shelf.face.targets[name]:
            stated: Any = dict(step.dominance) or step.overall
            was.append({**step.weights, **({} if stated is None else {"dominance": stated})})
        yield FitItem(
            item=f"targets.{name}",
            value=_target(pair, face, number, values),
            was=was,
            confidence=confidence(
                start.weights[number].ravel(),
                values.weights[number].ravel(),
                [one.weights[number].ravel() for one in others],
            ),
            **evidence.of(chosen, count),
        )


def _target(pair: OpenPair, face: FitFace, number: int, values: FitValues) -> list[dict[str, Any]]:
    """Return a target in the form of a pack: poses by step, and unusual dominances."""
    poses, shelf = pair.shelf.poses, pair.shelf
    weights = values.weights[number][: face.steps[number]]
    before = face.start.weights[number][: face.steps[number]]
    stated = shelf.face.targets[face.names[number]]
    out: list[dict[str, Any]] = []
    for step, now, was in zip(stated, weights, before, strict=True):
        own: dict[str, Any] = {}
        for pose in step.weights:
            if pose not in poses:  # an optional pose, which this face has not
                own[pose] = step.weights[pose]
                continue
            weight, moved = float(now[poses.index(pose)]), was[poses.index(pose)] > 0
            # A pose that moved stays faintly there, and an unchanged 0 stays 0.
            faint = not moved and weight < FAINTEST
            own[pose] = 0.0 if faint else round(max(weight, FAINTEST), ITEM_DECIMALS)
        missing = values.mentioned[number] & (now >= FAINTEST)
        own |= {
            pose: round(float(now[n]), ITEM_DECIMALS)
            for n, pose in enumerate(poses)
            if missing[n] and pose not in own
        }
        out.append(own)
    usual = shelf.usual_dominance(out)
    fitted = np.exp(values.dominance[number])
    apart = np.abs(np.log(fitted / usual)) > LEAST_DOMINANCE
    dominance = {poses[n]: round(float(fitted[n]), ITEM_DECIMALS) for n in np.flatnonzero(apart)}
    if dominance:
        out[0]["dominance"] = dominance
    return out


def _frames(task: FitTask, meant: Sequence[set[int]]) -> tuple[list[Bools], int]:
    """Return the frames of a sequence of common phonemes, and its number of occurrences."""
    chosen, count = [], 0
    for line in task.lines:
        ids, bounds, times = line.made.track.ids, line.made.track.bounds, line.made.frames.times()
        fits = np.ones(len(ids) - len(meant) + 1, bool)
        for offset, some in enumerate(meant):
            fits &= np.isin(ids[offset : offset + len(fits)], list(some))
        frames = np.zeros(len(times), bool)
        for first in np.flatnonzero(fits):
            frames |= (times >= bounds[first]) & (times < bounds[first + len(meant)])
        chosen.append(frames)
        count += int(fits.sum())
    return chosen, count


def _motion_items(
    pair: OpenPair, evidence: _Evidence, values: FitValues, others: Sequence[FitValues]
) -> Iterator[FitItem]:
    task, start, poses = evidence.task, evidence.task.face.start, pair.shelf.poses
    every, least = (start, values, *others), LEAST_SECONDS
    changed = [
        (f"softness.{region}", [float(one.softness[some[0]]) for one in every], least)
        for region, some in task.softness.items()
    ]
    changed += [
        (f"anticipate.{poses[pose]}", [float(one.anticipate[pose]) for one in every], least)
        for some in task.anticipate.values()
        for pose in some.tolist()
    ]
    changed.append(("motion.speed_limit", [one.speed for one in every], LEAST_SPEED_CHANGE))
    everything = [np.ones(line.made.frames.count, bool) for line in task.lines]
    seen = evidence.of(everything, sum(len(line.made.track.ids) for line in task.lines))
    for name, (was, value, *rest), least in changed:
        if abs(value - was) >= least:
            yield FitItem(
                item=name,
                value=round(value, ITEM_DECIMALS),
                was=round(was, 6),
                confidence=confidence(
                    np.array([was]), np.array([value]), [np.array([one]) for one in rest]
                ),
                **seen,
            )


def _bigram_items(
    pair: OpenPair, evidence: _Evidence, values: FitValues, others: Sequence[FitValues]
) -> Iterator[FitItem]:
    task, face = evidence.task, evidence.task.face
    if not values.bigrams:
        return
    controls = dict(zip(face.rows.tolist(), face.controls(values), strict=True))
    plain = face.shown(replace(values, bigrams={}), task.lines)
    drafted = [line.errors(w) for line, w in zip(task.lines, plain, strict=True)]
    own = _Evidence(task, drafted, evidence.after)
    numbers = {phoneme: {n} for n, phoneme in enumerate(pair.shelf.numbered)}
    for row, change in sorted(values.bigrams.items()):
        first, second = pair.rows.every[row - 1].origin.pair
        chosen, count = _frames(task, [numbers[first], numbers[second]])
        seen = own.of(chosen, count)
        before, after = seen["residual_before"], seen["residual_after"]
        if before is None or after is None or after > BIGRAM_GAIN * before:
            continue
        still = np.zeros(change.shape)
        rest = [one.bigrams.get(row, still).ravel() for one in others]
        curves = {
            pose: [[float(t), float(v)] for t, v in zip(TIMES, line, strict=True)]
            for pose, line in zip(pair.shelf.poses, controls[row].round(ITEM_DECIMALS), strict=True)
            if line.any()
        }
        yield FitItem(
            item=f"bigrams.{first}-{second}",
            value={"boundary": 0.5, "curves": curves},
            confidence=confidence(still.ravel(), change.ravel(), rest),
            **seen,
        )
