"""Trace: explains the pose weights at one time, stage by stage.

A performance records no trace. The explanation recomputes the stages for the frames near the time.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.animations.explanation import BigramAt, Explanation, PoseAt, StageAt, StyleAt
from lipsync_lang.arrays import Floats
from lipsync_lang.errors import LipsyncError
from lipsync_lang.pipeline.levels import shares
from lipsync_lang.pipeline.perform import Performance, Stage
from lipsync_lang.pipeline.warp import locate

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.performing.performed_line import PerformedLine
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.pipeline.track import Track
    from lipsync_lang.pipeline.warp import FramePlace
    from lipsync_lang.resolver.compiled import CompiledPair

VISIBLE = 5e-4
"""Minimum change of weight for an explanation."""

DONE = {
    "stitch": "the larger of the overlapping bigrams",
    "overlay": "the character's own curve of this word or line",
    "smooth": "a valley between two peaks is filled",
    "switch": "one pose at a time, each for a minimum time",
    "anticipate": "begins before its sound",
    "ease": "rounded off",
    "bend": "the line's own keys",
    "rest": "brought to rest at the ends",
    "limit": "held to the speed limit",
    "soften": "rounded off",
}
"""Effect of each stage on a changed value; the others have specific explanations."""


def explain(line: "PerformedLine", animation: "Animation", seconds: float) -> Explanation:
    """Explain the frame nearest to a time in seconds.

    Raises
    ------
    LipsyncError
        The time is outside the animation.
    """
    first, last = float(animation.times[0]), float(animation.times[-1])
    half = 0.5 / animation.fps
    if not first - half <= seconds <= last + half:
        raise LipsyncError(
            f"{seconds:g} s is outside the animation, which runs from {first:.3f} to {last:.3f} s"
        )
    performance = line.performance(animation)
    frame = int(np.abs(performance.frames.times() - seconds).argmin())
    found = _explain_frame(animation, line.performer, performance, frame)
    if not line.settings.get("gestures"):
        return found
    from lipsync_lang.performing.gesturing import explained

    whole = replace(animation, times=performance.frames.times())  # a cut one has fewer frames
    moved = explained(line, whole, frame)
    return replace(found, poses=(*found.poses, *moved))


def _explain_frame(
    animation: "Animation", performer: "Performer", performance: Performance, frame: int
) -> Explanation:
    track, schedule = performance.track, animation.schedule
    # the halo is the whole line where a frame may depend on any other frame
    halo = performance.halo()
    begin, stop = max(0, frame - halo), min(performance.frames.count, frame + halo + 1)
    now = performance.frames.times(frame, frame + 1)
    place = locate(track, now)
    values = [v[0] for v in performance.bigrams(place, now)]
    stages = [
        Stage(name, curves[:, frame - begin : frame - begin + 1])
        for name, curves in performance.stages(begin, stop)
    ]
    at = int(place.phoneme[0])
    index = int(track.source[at])
    word = schedule.word_at(index) if index >= 0 else None
    common = performer.compiled.phonemes[int(track.ids[at])]
    heard: dict[str, float] = {}
    if performance.blends:
        parts = shares(performance.blends, now)[1:, 0].tolist()
        names = performer.compiled.style_names
        both = zip(performance.blends, parts, strict=True)
        heard = {names[blend.style]: part for blend, part in both if part > 0}
    covering = _bigrams(performer, performance, place, heard)
    poses = [channel.name for channel in performer.shown_channels(performance.tables)]
    return Explanation(
        seconds=float(now[0]),
        frame=frame,
        phoneme=schedule.labels[index] if index >= 0 else performer.compiled.phonemes[0],
        index=index if index >= 0 else None,
        common=common,
        start=float(track.bounds[at]),
        end=float(track.bounds[at + 1]),
        word=word.text if word else None,
        bigrams=tuple(b for b in covering if b is not None),
        poses=tuple(
            _pose(
                performer,
                performance,
                (number, name, _postures(performer.compiled, heard, number)),
                frame,
                stages,
                values,
                covering,
            )
            for number, name in enumerate(poses)
        ),
        shade_of=performer.compiled.shades.get(common),
        likely=schedule.likely[index] if schedule.likely and index >= 0 else (),
    )


def _postures(compiled: "CompiledPair", heard: Mapping[str, float], pose: int) -> list[str]:
    """Return what the posture of each style adds to a pose, in words."""
    drafts = compiled.style_drafts
    added = {s: share * drafts[s]["posture"][pose] for s, share in heard.items() if s in drafts}
    return [f"the posture of {style} adds {one:.3f}" for style, one in added.items() if one]


def _bigrams(
    performer: "Performer",
    performance: Performance,
    place: "FramePlace",
    heard: Mapping[str, float],
) -> tuple[BigramAt | None, BigramAt | None]:
    """Return the bigrams that end and begin with the phoneme of the frame.

    In the middle of a trigram, both are its halves, and only the second is returned.
    """
    at, track = int(place.phoneme[0]), performance.track
    found: list[BigramAt | None] = [None, None]
    boundary = track.boundary(performer.compiled.tables.neutral)
    if at > 0 and place.coming[0] <= 1:
        pin = boundary[at - 1]
        found[0] = _bigram(
            performer, track, at - 1, float(pin + (1 - pin) * place.coming[0]), heard
        )
    if at < len(track.rows) and place.going[0] >= 0:
        found[1] = _bigram(performer, track, at, float(boundary[at] * place.going[0]), heard)
    if found[1] is not None and at - 1 in track.trigrams:
        found[0] = None
    return found[0], found[1]


def _bigram(
    performer: "Performer", track: "Track", number: int, position: float, heard: Mapping[str, float]
) -> BigramAt:
    compiled = performer.compiled
    origin = compiled.origins[int(track.rows[number])]
    first, count = number, 2
    if origin.triple is not None:
        first, count = number - (number not in track.trigrams), 3
        position = _in_trigram(compiled, track, first, position, later=first < number)
    names = tuple(compiled.phonemes[int(i)] for i in track.ids[first : first + count])
    styles = []
    for style, share in heard.items():
        own = compiled.style_origins.get(style, {}).get(str(track.rows[number]))
        draft = compiled.style_drafts.get(style)
        if own is not None:
            styles.append(StyleAt(style, share, own.layer, own.status, own.places))
        elif draft is not None:  # without a draft, the style plays the neutral row
            styles.append(StyleAt(style, share, "draft", "drafted", (draft["place"],)))
    drawn = origin.triple or origin.pair
    finer = drawn != names and origin.layer != "gap"
    return BigramAt(
        names,
        position,
        origin.layer,
        origin.status,
        origin.places,
        origin.word,
        tuple(styles),
        drawn if finer else None,
    )


def _in_trigram(
    compiled: "CompiledPair", track: "Track", first: int, position: float, *, later: bool
) -> float:
    """Return the normalised time in a trigram of a position in one of its halves."""
    rows = track.rows[first : first + 2]
    before, after = (float(one) for one in compiled.tables.boundary[rows])
    # solves the two boundaries of the halves for the boundaries of the whole trigram
    end = after / (1 - before + before * after)  # of its second phoneme
    start = before * end
    return start + (1 - start) * position if later else end * position


def _pose(  # noqa: PLR0913, PLR0917 the stages of a frame
    performer: "Performer",
    performance: Performance,
    which: tuple[int, str, list[str]],
    frame: int,
    stages: list[Stage],
    values: list[Floats],
    covering: tuple[BigramAt | None, BigramAt | None],
) -> PoseAt:
    pose, name, postures = which
    weights = [float(s.curves[pose, 0]) for s in stages]
    steps = []
    for number, (stage, weight) in enumerate(zip(stages, weights, strict=True)):
        before = weights[number - 1] if number else 0.0
        why = ""
        if abs(weight - before) > VISIBLE:
            why = DONE.get(stage.name, "")
            if stage.name == "stitch":
                given = [
                    f"{'-'.join(bigram.pair)} gives {value[pose]:.3f}"
                    for bigram, value in zip(covering, values, strict=True)
                    if bigram is not None
                ]
                why = ", ".join([*given, *postures])
            elif stage.name == "dial":
                now = performance.frames.times(frame, frame + 1)
                dials = [one for one in performance.dials if one.poses[pose : pose + 1].any()]
                factors = [(one.name, float(one.level.at(now)[0])) for one in dials]
                moved = (f"{n} x {f:.2f}" for n, f in factors if abs(f - 1) > VISIBLE)
                why = f"scaled by {', '.join(moved)}"
            elif stage.name == "bend":
                why = f"the line's own keys add {weight - before:+.3f}"
            elif stage.name == "hold":
                why = held_reason(performer, performance, pose, frame)
            elif stage.name == "constrain":
                why = constraint_reason(performer, performance, pose, stage.curves[:, 0])
        steps.append(StageAt(stage.name, weight, why))
    own = tuple(
        float(v[pose]) for v, bigram in zip(values, covering, strict=True) if bigram is not None
    )
    return PoseAt(name, weights[-1], own, tuple(steps))


def held_reason(performer: "Performer", performance: Performance, pose: int, frame: int) -> str:
    """Describe the contacts that limit a pose at a frame: its own, and those that it outranks."""
    names = performer.compiled.contact_names
    reasons = []
    for name, contact, (_, frames) in zip(
        names, performance.tables.contacts, performance.held, strict=True
    ):
        if frames[frame] and contact.floor[pose] > 0:
            reasons.append(f"contact '{name}' holds it at {contact.floor[pose]:g} or more")
        if frames[frame] and contact.ceiling[pose] < 1:
            reasons.append(f"contact '{name}' keeps it at {contact.ceiling[pose]:g} or less")
    top = float(performance.prepared.tops[pose])
    if not reasons and top < 1:
        reasons.append(f"it leaves room for the contacts that it outranks: at most {top:.2f}")
    return ", ".join(reasons)


def constraint_reason(
    performer: "Performer", performance: Performance, pose: int, weights: Floats
) -> str:
    """Describe the tightest constraint of a pose among (P,) constrained weights."""
    rooms = [
        (threshold - float(weights[high]), high, threshold)
        for low, high, threshold in performance.tables.caps
        if low == pose
    ]
    bounds = [
        (float(weights[other]), f"never above {performer.poses[other]}")
        for low, other in performance.tables.at_most
        if low == pose
    ]
    if rooms:
        room, high, threshold = min(rooms)
        name = performer.poses[high]
        bounds.append((room, f"{name} outranks it: together at most {threshold:g}"))
    return min(bounds)[1] if bounds else ""
