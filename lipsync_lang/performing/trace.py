"""Trace: explains the pose weights at one time, stage by stage.

A performance records no trace. The explanation recomputes the stages for the frames near the time.
"""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.explanation import BigramAt, Explanation, PoseAt, StageAt, StyleAt
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.played_pair import PlayedPair
from lipsync_lang.pipeline.levels import shares
from lipsync_lang.pipeline.perform import Performance
from lipsync_lang.pipeline.warp import locate
from lipsync_lang.schedules.schedule import Schedule

VISIBLE = 5e-4
"""Minimum change of weight for an explanation."""

STAGE_WORDS: dict[str, dict[str, str]] = json.loads(
    Path(__file__).with_name("stages.json").read_text("utf-8")
)
"""Label, colour and effect of each stage; a stage without an effect explains each value."""


def explain(
    pair: PlayedPair, settings: Mapping[str, Any], animation: Animation, seconds: float
) -> Explanation:
    """Explain the frame nearest to a time in seconds, given the options of its `perform`.

    Raises LipsyncError if the time is outside the animation.
    """
    first, last = float(animation.times[0]), float(animation.times[-1])
    half = 0.5 / animation.fps
    if not first - half <= seconds <= last + half:
        raise LipsyncError(
            f"{seconds:g} s is outside the animation, which runs from {first:.3f} to {last:.3f} s"
        )
    performance = pair.repeated(settings, animation.schedule, animation.fps)
    frame = int(np.abs(performance.frames.times() - seconds).argmin())
    found = _TracedFrame(pair, performance, frame).explained(animation.schedule)
    if not settings.get("gestures"):
        return found
    from lipsync_lang.performing.gesturing import explained

    whole = replace(animation, times=performance.frames.times())  # a cut one has fewer frames
    moved = explained(pair, settings, whole, frame)
    return replace(found, poses=(*found.poses, *moved))


class _TracedFrame:
    """A frame of a performance, with its place in the line, its bigrams and its styles."""

    def __init__(self, performer: PlayedPair, performance: Performance, frame: int) -> None:
        self.performer, self.performance, self.frame = performer, performance, frame
        self.compiled, self.track = performer.compiled, performance.track
        self.now = performance.frames.times(frame, frame + 1)
        self.place = locate(self.track, self.now)
        self.values = [v[0] for v in performance.bigrams(self.place, self.now)]
        # the halo is the whole line where a frame may depend on any other frame
        halo = performance.halo()
        begin, stop = max(0, frame - halo), min(performance.frames.count, frame + halo + 1)
        self.stages = {
            name: curves[:, frame - begin] for name, curves in performance.stages(begin, stop)
        }
        self.styles: dict[str, float] = {}
        if performance.blends:
            parts = shares(performance.blends, self.now)[1:, 0].tolist()
            both = zip(performance.blends, parts, strict=True)
            names = self.compiled.style_names
            self.styles = {names[blend.style]: part for blend, part in both if part > 0}
        self.covering = self._bigrams()

    def explained(self, schedule: Schedule) -> Explanation:
        """Explain the poses of speech."""
        at, track = int(self.place.phoneme[0]), self.track
        index = int(track.source[at])
        word = schedule.word_at(index) if index >= 0 else None
        common = self.compiled.phonemes[int(track.ids[at])]
        channels = self.performer.shown_channels(self.performance.tables)
        return Explanation(
            seconds=float(self.now[0]), frame=self.frame, common=common,
            phoneme=schedule.labels[index] if index >= 0 else self.compiled.phonemes[0],
            index=index if index >= 0 else None, word=word.text if word else None,
            start=float(track.bounds[at]), end=float(track.bounds[at + 1]),
            bigrams=tuple(b for b in self.covering if b is not None),
            poses=tuple(self._pose(number, one.name) for number, one in enumerate(channels)),
            shade_of=self.compiled.shades.get(common),
            likely=schedule.likely[index] if schedule.likely and index >= 0 else (),
        )  # fmt: skip

    def _bigrams(self) -> tuple[BigramAt | None, BigramAt | None]:
        """Return the bigrams that end and begin with the phoneme of the frame.

        In the middle of a trigram, both are its halves, and only the second is returned.
        """
        at, track, place = int(self.place.phoneme[0]), self.track, self.place
        before = after = None
        boundary = track.boundary(self.compiled.tables.neutral)
        if at > 0 and place.coming[0] <= 1:
            pin = boundary[at - 1]
            before = self._bigram(at - 1, float(pin + (1 - pin) * place.coming[0]))
        if at < len(track.rows) and place.going[0] >= 0:
            after = self._bigram(at, float(boundary[at] * place.going[0]))
        return None if after is not None and at - 1 in track.trigrams else before, after

    def _bigram(self, number: int, position: float) -> BigramAt:
        compiled, track = self.compiled, self.track
        origin = compiled.origins[int(track.rows[number])]
        first, count = number, 2
        if origin.triple is not None:
            first, count = number - (number not in track.trigrams), 3
            position = self._in_trigram(first, position, later=first < number)
        names = tuple(compiled.phonemes[int(i)] for i in track.ids[first : first + count])
        styles = []
        for style, share in self.styles.items():
            own = compiled.style_origins.get(style, {}).get(str(track.rows[number]))
            draft = compiled.style_drafts.get(style)
            if own is not None:
                styles.append(StyleAt(style, share, own.layer, own.status, own.places))
            elif draft is not None:  # without a draft, the style plays the neutral row
                styles.append(StyleAt(style, share, "draft", "drafted", (draft["place"],)))
        drawn = origin.triple or origin.pair
        finer = drawn != names and origin.layer != "gap"
        told = origin.layer, origin.status, origin.places, origin.word
        return BigramAt(names, position, *told, tuple(styles), drawn if finer else None)

    def _in_trigram(self, first: int, position: float, *, later: bool) -> float:
        """Return the normalised time in a trigram of a position in one of its halves."""
        rows = self.track.rows[first : first + 2]
        before, after = (float(one) for one in self.compiled.tables.boundary[rows])
        # solves the two boundaries of the halves for the boundaries of the whole trigram
        end = after / (1 - before + before * after)  # of its second phoneme
        start = before * end
        return start + (1 - start) * position if later else end * position

    def _pose(self, pose: int, name: str) -> PoseAt:
        steps: list[StageAt] = []
        for stage, weights in self.stages.items():
            weight, before = float(weights[pose]), steps[-1].weight if steps else 0.0
            visible = abs(weight - before) > VISIBLE
            why = self._reason(stage, pose, weight - before) if visible else ""
            steps.append(StageAt(stage, weight, why))
        pairs = zip(self.values, self.covering, strict=True)
        own = tuple(float(value[pose]) for value, bigram in pairs if bigram is not None)
        return PoseAt(name, steps[-1].weight, own, tuple(steps))

    def _reason(self, stage: str, pose: int, change: float) -> str:
        """Return why a stage changed the weight of a pose."""
        if stage == "stitch":
            both = zip(self.covering, self.values, strict=True)
            played = [(one.pair, value[pose]) for one, value in both if one is not None]
            given = [f"{'-'.join(pair)} gives {weight:.3f}" for pair, weight in played]
            if self.performance.others:
                given = ["the mean of the likely sounds"]
            drafts = self.compiled.style_drafts
            styles = [(one, share) for one, share in self.styles.items() if one in drafts]
            added = [(one, share * drafts[one]["posture"][pose]) for one, share in styles]
            given += [f"the posture of {one} adds {more:.3f}" for one, more in added if more]
            return ", ".join(given)
        if stage == "dial":
            dials = [one for one in self.performance.dials if one.poses[pose : pose + 1].any()]
            factors = [(one.name, float(one.level.at(self.now)[0])) for one in dials]
            moved = (f"{n} x {f:.2f}" for n, f in factors if abs(f - 1) > VISIBLE)
            return f"scaled by {', '.join(moved)}"
        if stage == "bend":
            return f"the line's own keys add {change:+.3f}"
        if stage == "hold":
            return held_reason(self.performer, self.performance, pose, self.frame)
        if stage == "constrain":
            return constraint_reason(self.performer, self.performance, pose, self.stages[stage])
        return STAGE_WORDS.get(stage, {}).get("effect", "")


def held_reason(performer: PlayedPair, performance: Performance, pose: int, frame: int) -> str:
    """Describe the contacts that limit a pose at a frame: its own, and those that it outranks."""
    names = performer.compiled.contact_names
    reasons = []
    held = zip(names, performance.tables.contacts, performance.held, strict=True)
    for name, contact, (_, frames) in held:
        if frames[frame] and contact.floor[pose] > 0:
            reasons.append(f"contact '{name}' holds it at {contact.floor[pose]:g} or more")
        if frames[frame] and contact.ceiling[pose] < 1:
            reasons.append(f"contact '{name}' keeps it at {contact.ceiling[pose]:g} or less")
    top = float(performance.prepared.tops[pose])
    if not reasons and top < 1:
        reasons.append(f"it leaves room for the contacts that it outranks: at most {top:.2f}")
    return ", ".join(reasons)


def constraint_reason(
    performer: PlayedPair, performance: Performance, pose: int, weights: Floats
) -> str:
    """Describe the tightest constraint of a pose among (P,) constrained weights."""
    tables, poses = performance.tables, performer.poses
    rooms = [
        (most - float(weights[high]), high, most) for low, high, most in tables.caps if low == pose
    ]
    others = [other for low, other in tables.at_most if low == pose]
    bounds = [(float(weights[other]), f"never above {poses[other]}") for other in others]
    if rooms:
        room, high, threshold = min(rooms)
        bounds.append((room, f"{poses[high]} outranks it: together at most {threshold:g}"))
    return min(bounds)[1] if bounds else ""
