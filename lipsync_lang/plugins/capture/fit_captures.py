"""Fits of a pair to captures: targets, motion and bigrams, tested on held-out lines.

The poses of a pose set rest at 0. Captured shapes often rest higher, because the tracker has
another neutral face; the weights of a capture during silence are subtracted before a fit.

The confidence of an item comes from the fits that left out a part of the lines (jackknife). With
the change d of each of its numbers and that change's standard error s over the parts::

    confidence = sum d^2 / (sum d^2 + sum s^2)

A confidence of 1 is a change in every part of the lines; 0.5 is a change as large as its error.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lipsync_lang import LipsyncError, Performer
from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.base.grouping import grouped
from lipsync_lang.packs.banks.draft import TIMES
from lipsync_lang.plugins.capture.fit_file import (
    VALUE_DECIMALS,
    FitFold,
    FitItem,
    FitProposal,
    FitVerdict,
    SetAside,
)
from lipsync_lang.plugins.capture.fit_folds import (
    FitShares,
    FitTask,
    Fold,
    choose,
    errors,
    folds,
    run_fits,
)
from lipsync_lang.plugins.capture.fit_lines import CapturedLine, ShownLine, fit_rate, lay_lines
from lipsync_lang.plugins.capture.fit_values import FitFace, FitValues
from lipsync_lang.plugins.capture.judging import outlying_lines
from lipsync_lang.resolver.retouch import OpenPair

AWAY_SECONDS = 0.15
"""Seconds around sounds that do not count as rest."""

ENOUGH_SECONDS = 0.5
"""Minimum seconds of rest for its level; otherwise the lowest weights of speech determine it."""

LOWEST_SHARE = 0.05
"""Quantile of the weights of speech that is the rest level if there are no pauses."""

LEAST_LEVEL, MOST_LEVEL = 0.02, 0.4
"""Range of subtracted levels; lower levels are noise, and higher ones are expressions."""

WHOLE_CHANGE = FitShares(1.0, 0.0)
"""Shares of a refused fit in the report: the full change, without bigrams."""

ONE_SPEAKER = "all lines are of one speaker, so the fit was not tested on another speaker"

Progress = Callable[[str], None]

ITEM_DECIMALS = 3
"""Decimals of fitted values in a proposal."""

LEAST_WEIGHT, LEAST_DOMINANCE, LEAST_SECONDS, LEAST_SPEED_CHANGE = 0.005, 0.05, 0.0005, 0.1
"""Minimum changes of weights, of the logarithm of a dominance, of times and of the speed limit;
smaller changes are discarded."""

BIGRAM_GAIN = 0.98
"""Maximum ratio of the errors with and without fitted curves of a bigram."""

FAINTEST = 0.01
"""Minimum weight of a moving pose in a target; a target of 0 would oppose an early start."""


def without_rest(performer: Performer, captured: Sequence[CapturedLine]) -> list[CapturedLine]:
    """Return lines with rest levels subtracted, and remarks on them.

    All lines of a speaker have the same levels. Signals without a scale are unchanged.
    """
    resting, speaking = defaultdict(list), defaultdict(list)
    read = performer.labels.read([line.schedule for line in captured]) if captured else []
    for line, sounds in zip(captured, read, strict=True):
        spoken = sounds.ids != performer.compiled.tables.silence
        starts, ends = sounds.times[:-1][spoken], sounds.times[1:][spoken]
        at = line.times[:, None]
        rest = ~((at > starts - AWAY_SECONDS) & (at < ends + AWAY_SECONDS)).any(axis=1)
        for name, values in zip(line.signals, line.values.T, strict=True):
            known = np.isfinite(values)
            resting[line.speaker, name].append(values[known & rest])
            speaking[line.speaker, name].append(values[known & ~rest])
    # The fastest capture: half a second of it is enough in samples for all others.
    fps = max(((len(one.times) - 1) / np.ptp(one.times) for one in captured), default=1.0)
    levels = {}
    for key, parts in resting.items():
        at_rest, speech = np.concatenate(parts), np.concatenate(speaking[key])
        level = 0.0
        if len(at_rest) >= ENOUGH_SECONDS * float(fps):
            level = float(np.median(at_rest))
        elif len(speech):
            level = float(np.quantile(speech, LOWEST_SHARE))
        levels[key] = level if LEAST_LEVEL <= level <= MOST_LEVEL else 0.0
    out = []
    for line in captured:
        own = np.array([levels[line.speaker, name] for name in line.signals])
        if line.free or not own.any():
            out.append(line)
            continue
        each = zip(line.signals, own, strict=True)
        named = ", ".join(f"{name} {level:.2f}" for name, level in each if level)
        who = f" of {line.speaker}" if line.speaker else ""
        told = f"weights at rest{who} were subtracted ({named})"
        out.append(replace(line, values=line.values - own, remarks=(*line.remarks, told)))
    return out


@dataclass(frozen=True, eq=False)
class CaptureFit:
    """The result of a fit."""

    proposal: FitProposal
    shown: tuple[ShownLine, ...]
    face: FitFace
    values: FitValues
    """The values of the proposal's items; for a refused fit, those of the full fit."""


def fit_captures(  # noqa: PLR0913 the pair, its captures and options
    pair: OpenPair,
    performer: Performer,
    captured: Sequence[CapturedLine],
    *,
    workers: int = 1,
    progress: Progress = lambda _: None,
    set_aside: Sequence[SetAside] = (),
) -> CaptureFit:
    """Fit the targets, motion and bigrams of a pair to captured lines.

    The performer is of the same pair. In a script, more than one worker process requires
    `if __name__ == "__main__":`. `progress` is called with a phrase for each step;
    `set_aside` are lines that were left out before. Raises LipsyncError if there are no lines, or
    none of their signals shows a pose.
    """
    progress("fitting all lines")
    task, full, strays = _without_strays(pair, performer, captured, set_aside)
    parts = folds(task.lines)
    fits = []
    for number, fit in enumerate(run_fits(task, [part.kept for part in parts], workers), 1):
        progress(f"cross-validation {number} of {len(parts)}")
        fits.append(fit)
    shares = choose(task, parts, fits) if parts else FitShares(0.0, 0.0)
    verdict = _verdict(task, parts, fits, shares)
    start, shown = task.face.start, shares if verdict.accepted else WHOLE_CHANGE
    values = start.towards(full, *shown)
    others = [
        start.towards(fit, *shown)
        for part, fit in zip(parts, fits, strict=True)
        if part.by == "line"
    ]
    # Folds by speaker are no jackknife of lines, so `others` are the folds by line alone.
    items = tuple(fit_items(pair, task, values, others))
    proposal = _proposal(pair, task, verdict, items, (*set_aside, *strays))
    before, after = (task.face.performed(one, task.lines) for one in (start, values))
    pages = tuple(map(ShownLine.of, task.lines, before, after))
    return CaptureFit(proposal, pages, task.face, values)


def _proposal(
    pair: OpenPair,
    task: FitTask,
    verdict: FitVerdict,
    items: tuple[FitItem, ...],
    set_aside: tuple[SetAside, ...],
) -> FitProposal:
    captured = [line.captured for line in task.lines]
    remarks = [*_remarks(captured)]
    if len({line.speaker for line in captured}) == 1:
        remarks.append(ONE_SPEAKER)
    return FitProposal(
        language=pair.compiled.language,
        character=pair.compiled.character,
        poseset=pair.compiled.poseset,
        lines=len(captured),
        seconds=round(
            sum(float(line.seen.any(axis=1).sum()) / line.made.frames.fps for line in task.lines), 3
        ),
        speakers=tuple(sorted({line.speaker for line in captured} - {""})),
        verdict=verdict,
        items=items,
        remarks=tuple(remarks),
        set_aside=set_aside,
    )


def _remarks(lines: Iterable[CapturedLine]) -> Iterator[str]:
    """Yield each remark once, with the first of the files that it is about."""
    cut = (remark.partition(": ") for line in lines for remark in line.remarks)
    for told, files in grouped((told or file, file * bool(told)) for file, _, told in cut).items():
        more = f" and {len(files) - 1} more" if len(files) > 1 else ""
        yield f"{files[0]}{more}: {told}" if files[0] else told


def _without_strays(
    pair: OpenPair,
    performer: Performer,
    captured: Sequence[CapturedLine],
    set_aside: Sequence[SetAside],
) -> tuple[FitTask, FitValues, tuple[SetAside, ...]]:
    """Fit all lines, and then again without the outliers."""
    if not captured:
        reasons = "".join(f"\n  {one.line}: {one.why}" for one in set_aside)
        raise LipsyncError(f"no capture can be used; {len(set_aside)} were set aside{reasons}")
    lines = lay_lines(performer, without_rest(performer, captured), fit_rate(captured))
    if not any(line.seen.any() for line in lines):
        raise LipsyncError(
            "the captures have no motion during the speech; check that the timings belong to them"
        )
    soft: dict[str, list[int]] = defaultdict(list)  # poses by region
    ahead: dict[str, list[int]] = defaultdict(list)
    for number, pose in enumerate(pair.shelf.face.poses.values()):
        if pose.region and pose.softness is None:
            soft[pose.region].append(number)
        if pair.compiled.tables.anticipate[number] > 0:
            ahead[pose.region].append(number)
    groups = ({region: np.array(one) for region, one in by.items()} for by in (soft, ahead))
    task = FitTask(FitFace.of(pair, lines), lines, *groups)
    full = task.fit(range(len(lines)))
    names = [line.captured.name for line in lines]
    # After a fit of all lines: before it, a line with unusual sounds errs as much as a wrong one.
    strays = outlying_lines({name: task.error(full, [n]) for n, name in enumerate(names)})
    if not strays:
        return task, full, ()
    aside = {one.line for one in strays}
    kept = tuple(line for line in lines if line.captured.name not in aside)
    task = replace(task, face=FitFace.of(pair, kept), lines=kept)
    return task, task.fit(range(len(kept))), strays


def _verdict(
    task: FitTask, parts: Sequence[Fold], fits: Sequence[FitValues], shares: FitShares
) -> FitVerdict:
    """Judge a fit by its error on held-out lines."""
    if not parts:
        return FitVerdict(
            accepted=False, why="a single line cannot show that a fit generalises; add lines"
        )
    accepted = shares.values > 0
    shown = shares if accepted else WHOLE_CHANGE
    before = [task.error(task.face.start, part.tested) for part in parts]
    after = errors(task, parts, fits, shown)
    told = tuple(
        FitFold(
            held_out=part.name,
            by=part.by,
            before=round(b, VALUE_DECIMALS),
            after=round(a, VALUE_DECIMALS),
        )
        for part, b, a in zip(parts, before, after, strict=True)
    )
    units = " and ".join(f"{by}s" for by in dict.fromkeys(part.by for part in parts))
    means = f"{np.mean(before):.4f} before, {np.mean(after):.4f} after"
    if not accepted:
        unseen = f"on held-out {units}"
        why = f"the fit does not generalise: {unseen}, the mean error is {means}"
    else:
        extent = f"; {shares.values:.0%} of the change gives the lowest error"
        extent = "" if shares.values == 1 else extent
        bigrams = "" if shares.bigrams else "; fitted bigrams do not lower it and are left out"
        why = f"on held-out {units}, the mean error is {means}{extent}{bigrams}"
    return FitVerdict(accepted=accepted, why=why, folds=told)


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
        for name, found in (("residual_before", self.before), ("residual_after", self.after)):
            parts = [
                (error[some & seen.any(axis=1)] ** 2).sum(axis=0)
                for error, some, seen in zip(found, chosen, every, strict=True)
            ]
            total = float(sum(part.sum() for part in parts))
            fields[name] = round((total / count) ** 0.5, VALUE_DECIMALS) if count else None
        return fields


def fit_items(
    pair: OpenPair, task: FitTask, values: FitValues, others: Sequence[FitValues]
) -> Iterator[FitItem]:
    """Yield an item for each changed value; `others` are of fits without a part of the lines."""
    face, lines = task.face, task.lines
    before, after = [
        [line.errors(w) for line, w in zip(lines, face.performed(one, lines), strict=True)]
        for one in (face.start, values)
    ]
    evidence = _Evidence(task, before, after)
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
    plain = face.performed(replace(values, bigrams={}), task.lines)
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
