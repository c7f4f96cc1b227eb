"""Laying: placed gestures become curves over the frames of a line.

Conventions: (T, G) is frames by poses of gestures. Frames are those of the animation, all of them.

A gesture moves to a frame by at most half a frame, so that its peak is seen at any rate. Between
two points its curve is a rounded step, 3 x^2 - 2 x^3. So it accelerates by at most 6 times the step
over the square of its seconds, and has no corner. Gestures that move the same pose add up; where
that is too much or too fast, the sum is kept to the bounds and the speed of the pose. All poses
rest in the first and the last frame: a gesture beyond them moves inwards by at most
`SHIFT_SECONDS`, or is left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import ceil
from typing import Any, NamedTuple, Self

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.pipeline.gestures.placing import GestureShape, PlacedGesture

SHIFT_SECONDS = 0.25
"""Longest move of a gesture that would leave the frames of its line."""

ROUNDED_AMOUNT = 1e-9
"""Difference of two amounts that is rounding."""


class LaidCurve(NamedTuple):
    """A gesture at a frame rate."""

    peak: float
    """Seconds from its beginning to the middle of its peak."""
    before: int
    """Frames from the first sample to the peak."""
    block: Floats
    """(n, G) amounts."""


class LaidGesture(NamedTuple):
    """A gesture at its frames."""

    gesture: PlacedGesture
    first: int
    stop: int


@dataclass(frozen=True, eq=False)
class GestureSet:
    """The gestures of a pose set, and the poses that they move."""

    poses: tuple[str, ...]
    channels: tuple[dict[str, Any], ...]
    """Fields of the channel of each pose."""
    shapes: tuple[GestureShape, ...]
    low: Floats
    """(G,) least amount."""
    high: Floats
    """(G,) greatest amount."""
    speed: Floats
    """(G,) greatest speed, in amount per second."""
    words: dict[str, tuple[str, ...]]
    """Facts that each word of the language, in lower case, is."""
    _laid: dict[tuple[int, float], LaidCurve] = field(default_factory=dict)

    @classmethod
    def from_plain(cls, data: dict[str, Any]) -> Self:
        """Build the set from plain data, as a resolved pair stores it."""
        poses = data["poses"]
        number = {pose["name"]: n for n, pose in enumerate(poses)}
        high = np.array([pose["most"] for pose in poses], float)
        shapes = (
            GestureShape(
                **one
                | {
                    "curve": tuple((at, value) for at, value in one["curve"]),
                    "poses": tuple((number[pose], by) for pose, by in one["poses"].items()),
                    "rates": tuple(one["rates"]) if one["rates"] else None,
                    "at": tuple(one["at"]),
                    "on": tuple(one["on"]),
                }
            )
            for one in data["gestures"]
        )
        return cls(
            tuple(number),
            tuple(
                {k: tuple(v) if isinstance(v, list) else v for k, v in pose["channel"].items()}
                for pose in poses
            ),
            tuple(shapes),
            np.where([pose["channel"]["node"] is None for pose in poses], 0.0, -high),
            high,
            np.array([pose["speed_limit"] for pose in poses], float),
            {
                word: tuple(trigger for trigger, said in data["words"].items() if word in said)
                for said in data["words"].values()
                for word in said
            },
        )

    @cached_property
    def triggers(self) -> frozenset[str]:
        """The facts that any gesture asks for."""
        return frozenset(name for one in self.shapes for name in (*one.on, *one.at))

    @cached_property
    def by_pitch(self) -> bool:
        """True if the voice scales any gesture."""
        return any(one.by_pitch for one in self.shapes)

    def laid(self, number: int, fps: float) -> LaidCurve:
        """Return the curve of a gesture at a frame rate, with a frame on its peak."""
        kept = self._laid.get((number, fps))
        if kept is None:
            kept = self._laid[number, fps] = self._sampled(self.shapes[number], fps)
        return kept

    def _sampled(self, shape: GestureShape, fps: float) -> LaidCurve:
        times, values = np.array(shape.curve, float).T
        tops = times[values == values[np.abs(values).argmax()]]
        peak = float(tops[0] + tops[-1]) / 2
        # A frame on either end would be 0 in any case.
        before = ceil(peak * fps - 1e-9) - 1
        after = ceil((shape.seconds - peak) * fps - 1e-9) - 1
        at = peak + np.arange(-before, after + 1) / fps
        part = np.clip(times.searchsorted(at, "right") - 1, 0, len(times) - 2)
        share = np.clip((at - times[part]) / (times[part + 1] - times[part]), 0, 1)
        curve = values[part] + np.diff(values)[part] * share * share * (3 - 2 * share)
        block = np.zeros((len(at), len(self.poses)))
        for pose, amount in shape.poses:
            block[:, pose] = amount * curve
        return LaidCurve(peak, before, block)

    def lay(
        self, placed: Sequence[PlacedGesture], start: float, count: int, fps: float
    ) -> tuple[Floats, list[LaidGesture]]:
        """Return the curves of all poses, (T, G), and the frames of the gestures that fit.

        Parameters
        ----------
        start : seconds of the first frame
        count : number of frames
        """
        out = np.zeros((count, len(self.poses)))
        spans = ((self.fitted(gesture, start, count, fps), gesture) for gesture in placed)
        laid = [LaidGesture(gesture, *span) for span, gesture in spans if span]
        laid.sort(key=lambda one: one.first)
        guarded: set[int] = set()
        past = [-1] * len(self.poses)  # the latest end of a gesture of each pose
        for (number, _, height, *_), first, stop in laid:
            for pose, _ in self.shapes[number].poses:
                if height > 1 or first <= past[pose]:
                    guarded.add(pose)
                past[pose] = max(past[pose], stop)
            block = self.laid(number, fps).block
            out[first:stop] += block if height == 1 else height * block
        if guarded:
            self.guard(out, sorted(guarded), fps, (0, 0))
        return out, laid

    def fitted(
        self, gesture: PlacedGesture, start: float, count: int, fps: float
    ) -> tuple[int, int] | None:
        """Return the first frame of a gesture and the one after its last; None if it is left out.

        The parameters are those of `lay`.
        """
        peak, before, block = self.laid(gesture.number, fps)
        asked = round((gesture.begin + peak - start) * fps) - before
        first = min(max(asked, 1), count - 1 - len(block))
        fits = first >= 1 and abs(first - asked) <= SHIFT_SECONDS * fps
        return (first, first + len(block)) if fits else None

    def guard(self, curves: Floats, poses: list[int], fps: float, beyond: tuple[int, int]) -> None:
        """Keep sums of gestures, (T, G), to the bounds and the speed of some of their poses.

        The mean of the smallest slow curve above and the largest below is slow, and is the curve
        itself where that is slow. So is the middle one of it and two ramps from rest.

        Parameters
        ----------
        beyond : frames from rest to the first of these, and from the last one to rest
        """
        summed = curves.T[poses]  # rows of a pose are contiguous
        low, high, step = (one[poses][:, None] for one in (self.low, self.high, self.speed / fps))
        bound = np.clip(summed, low, high)
        slope = np.arange(len(curves)) * step
        slow = (_below(bound, slope) - _below(-bound, slope)) / 2
        ramp = np.minimum(slope + beyond[0] * step, slope[:, ::-1] + beyond[1] * step)
        kept = np.clip(slow, np.maximum(-ramp, low), np.minimum(ramp, high))
        # a frame that is slow anyway keeps its bits, whatever comes later
        curves.T[poses] = np.where(np.abs(kept - summed) < ROUNDED_AMOUNT, summed, kept)


def _below(curves: Floats, slope: Floats) -> Floats:
    """Return the largest slow curves below (G, T) curves, as `pipeline.limit.lower_envelope`."""
    out = np.minimum.accumulate(curves - slope, axis=1) + 2 * slope
    back: Floats = np.minimum.accumulate(out[:, ::-1], axis=1)[:, ::-1] - slope
    return np.minimum(back, curves)
