"""Plain methods of lip sync with the same targets, for comparison with a performance.

Each method returns an animation over the frames of the performer's own.

Conventions: P poses, T frames, m targets of a phoneme; times are in seconds.
"""

from collections.abc import Mapping

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Floats
from lipsync_lang.packs.banks.draft import PASSIVE
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models.pose_models import PhonemeTarget
from lipsync_lang.performing.performer import Performer
from lipsync_lang.pipeline.constrain import FREE
from lipsync_lang.reports.quality.check_animation import Limits, check
from lipsync_lang.reports.quality.figures import Quality
from lipsync_lang.schedules.schedule import Schedule

FALL_PER_SECOND = 50.0
"""Decay of a target's dominance with distance; of the values from 10 to 80, this one fits three
recordings of real mouths best."""

HOLD_SECONDS = 2 / 24
"""Minimum hold of a shape in `held`: drawings last two frames of film."""


def keyframes(
    performer: Performer, schedule: Schedule, fps: float = 60, library: Library | None = None
) -> Animation:
    """Animate with one key at the centre of each phoneme, and straight lines between keys.

    Most viseme tables work this way. A phoneme with several targets has a key for each, evenly
    spaced over its time. Bigrams are drafted from the same targets.
    """
    targets = _targets(performer, library)
    ids, bounds, _ = performer.common_phonemes(schedule)
    times, keys = [], []
    for number, start, end in zip(ids, bounds, bounds[1:], strict=False):
        rows = _weights(targets.get(performer.compiled.phonemes[number], ()), performer)
        for step, row in enumerate(rows):
            times.append(start + (end - start) * (step + 0.5) / len(rows))
            keys.append(row)
    frames = performer.performance(schedule, fps).frames.times()
    columns = zip(*keys, strict=True)
    weights = np.column_stack([np.interp(frames, times, column) for column in columns])
    return Animation(frames, performer.poses, weights, fps, schedule)


def dominance(
    performer: Performer, schedule: Schedule, fps: float = 60, library: Library | None = None
) -> Animation:
    """Animate with a weighted mean of all targets in every frame; weights decay with distance.

    Drafts of bigrams use the same model. Here it covers a whole utterance, without pairs,
    stitching, smoothing, holds or limits::

        f(t) = sum_i D_i(t) T_i / sum_i D_i(t),   D_i(t) = dominance_i exp(-c |t - m_i|)

    with c `FALL_PER_SECOND` and m the middle of each target, or of the near part of a silence.
    After Cohen and Massaro, "Modeling coarticulation in synthetic visual speech", in Models and
    Techniques in Computer Animation, 1993.
    """
    targets = _targets(performer, library)
    performance = performer.performance(schedule, fps)
    track, frames = performance.track, performance.frames.times()
    wishes, strengths, away = [], [], []
    spans = zip(track.ids, track.bounds, track.bounds[1:], track.reach, strict=False)
    for number, start, end, reach in spans:
        steps = targets.get(performer.compiled.phonemes[number], ())
        rows, strength = _dominances(steps, performer)
        for step, row in enumerate(rows):
            share = (step + 0.5) / len(rows)
            early, late = start + reach * share, end - reach * (1 - share)
            wishes.append(row)
            strengths.append(strength)
            away.append(np.maximum(0, np.maximum(early - frames, frames - late)))
    far = np.array(away)
    # relative to the nearest target, so that no frame underflows to 0 / 0
    fall = np.exp(FALL_PER_SECOND * (far.min(axis=0) - far))
    pull = fall.T @ np.array(strengths)
    weights = fall.T @ (np.array(strengths) * np.array(wishes)) / pull
    return Animation(frames, performer.poses, weights, fps, schedule)


def _targets(
    performer: Performer, library: Library | None
) -> Mapping[str, tuple[PhonemeTarget, ...]]:
    """Return the targets of the performer's character, from the performer's own paths.

    A shade without a target has the target of its parent.
    """
    packs = library or Library(performer.paths)
    who = packs.character(performer.compiled.character).model
    targets = who.own_face(packs.poseset(who.poseset).model).targets
    parents = performer.compiled.shades.items()
    return {shade: targets.get(parent, ()) for shade, parent in parents} | targets


def _weights(steps: tuple[PhonemeTarget, ...], performer: Performer) -> Floats:
    """Return the poses at each step of a phoneme, or a single row of rest: (m, P)."""
    rows = [[step.weights.get(pose, 0.0) for pose in performer.poses] for step in steps]
    return np.array(rows or [[0.0] * len(performer.poses)])


def _dominances(steps: tuple[PhonemeTarget, ...], performer: Performer) -> tuple[Floats, Floats]:
    """Return the poses at each step of a phoneme, (m, P), and the dominance of each pose, (P,).

    As in drafts, poses without a target are passive, unless a constraint opposes them to one with a
    target.
    """
    rows = _weights(steps, performer)
    if not steps:
        return rows, np.ones(len(performer.poses))
    named = [any(pose in step.weights for step in steps) for pose in performer.poses]
    against = (performer.compiled.tables.thresholds < FREE) @ rows.any(axis=0)
    usual = np.where(np.array(named) | against, 1.0, PASSIVE)
    for step in steps:
        if step.overall is not None:
            usual = np.where(against, usual, step.overall)
        both = zip(performer.poses, usual, strict=True)
        usual = np.array([step.dominance.get(pose, own) for pose, own in both])
    return rows, np.maximum(usual, 1e-6)


def held(
    performer: Performer, schedule: Schedule, fps: float = 60, library: Library | None = None
) -> Animation:
    """Animate with one held shape at a time, like programs for drawn mouths.

    The shape of a target is its strongest pose, at its weight; the targets of a phoneme are evenly
    spaced over its time. Every shape is held for at least `HOLD_SECONDS` and delays the next one; a
    shape whose time has passed is dropped. There is no blending and no limit.
    """
    targets = _targets(performer, library)
    ids, bounds, _ = performer.common_phonemes(schedule)
    starts: list[float] = [-np.inf]
    shapes = [np.zeros(len(performer.poses))]
    for number, start, end in zip(ids, bounds, bounds[1:], strict=False):
        weights = _weights(targets.get(performer.compiled.phonemes[number], ()), performer)
        strongest = np.arange(len(performer.poses)) == weights.argmax(axis=1)[:, None]
        for step, shape in enumerate(np.where(strongest, weights, 0.0)):
            edges = start + (end - start) * np.array([step, step + 1]) / len(weights)
            begin = max(edges[0], starts[-1] + HOLD_SECONDS)
            if begin < edges[1]:
                starts.append(begin)
                shapes.append(shape)
    starts.append(max(bounds[-1], starts[-1] + HOLD_SECONDS))
    shapes.append(np.zeros(len(performer.poses)))
    frames = performer.performance(schedule, fps).frames.times()
    shown = np.searchsorted(starts, frames + 1e-9, side="right") - 1
    return Animation(frames, performer.poses, np.array(shapes)[shown], fps, schedule)


BASELINES = {"keyframes": keyframes, "dominance": dominance, "held": held}
"""Plain methods by name."""


def compare(
    performer: Performer, schedule: Schedule, fps: float = 60, *, limits: Limits | None = None
) -> dict[str, Quality]:
    """Judge a performance (`performed`), and the methods of `BASELINES` on the same line."""
    library = Library(performer.paths)
    performed = {"performed": performer.perform(schedule, fps)}
    plain = {name: make(performer, schedule, fps, library) for name, make in BASELINES.items()}
    return {
        name: check(animation, performer=performer, limits=limits)
        for name, animation in (performed | plain).items()
    }
