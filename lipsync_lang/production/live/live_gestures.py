"""Live gestures: a face blinks, looks about and breathes as time goes on, and moves beside speech.

Gestures that come by themselves are drawn at each frame, without any delay. Gestures on facts come
with a spoken text, whose facts are known when it begins; a voice has none of them.
"""

from collections.abc import Sequence
from random import Random
from typing import NamedTuple

import numpy as np

from lipsync_lang.pipeline.gestures.laying import GestureSet
from lipsync_lang.pipeline.gestures.placing import DRAWING_SECONDS, LineFacts, place
from lipsync_lang.production.live.live_frame import LiveFrame


class BegunGesture(NamedTuple):
    """A gesture that moves its poses."""

    number: int
    begin: float
    height: float


class LiveGestures:
    """Gestures beside the frames of a session, in the order of their times.

    Parameters
    ----------
    scales : factor of each gesture of the set; 0 leaves it out
    seed : of the gestures that come by themselves
    """

    def __init__(self, own: GestureSet, scales: Sequence[float], fps: float, seed: int = 0) -> None:
        self.own, self.scales, self.fps = own, scales, fps
        self.amounts = np.zeros(len(own.poses))
        self._random = Random(seed)  # noqa: S311 blinks are no secret
        self._left = [self._random.random() * self._gap(n) for n in range(len(own.shapes))]
        """Mean gaps until the next one of each gesture that comes by itself."""
        self._free = [0.0] * len(own.shapes)
        self._coming: list[BegunGesture] = []
        self._facts: list[tuple[float, str]] = []
        self._seconds = 0.0
        self._longest = max((shape.seconds for shape in own.shapes), default=0.0)

    def expect(self, line: LineFacts, moved: float) -> None:
        """Place the gestures of a spoken line, whose times are `moved` later in the session."""
        on = [by * bool(one.on) for by, one in zip(self.scales, self.own.shapes, strict=True)]
        for one in place(self.own.shapes, on, line):
            self._coming.append(BegunGesture(one.number, one.begin + moved, one.height))
        for name, facts in line.facts.items():
            self._facts += [(fact.seconds + moved, name) for fact in facts]

    def beside(self, frame: LiveFrame) -> LiveFrame:
        """Return a frame of lips with the amounts of gestures after its weights."""
        # A machine that slept wakes with one late frame: not with all blinks of the night at once.
        elapsed = min(max(frame.seconds - self._seconds, 0.0), 1.0)
        self._seconds = frame.seconds
        self._draw(frame.seconds, elapsed, speaking=bool(frame.weights.any()))
        amounts = np.zeros(len(self.own.poses))
        for one in self._coming:
            _, _, block = self.own.laid(one.number, self.fps)
            row = round((frame.seconds - one.begin) * self.fps)
            if 0 <= row < len(block):
                amounts += one.height * block[row]
        ended = frame.seconds - self._longest
        self._coming = [one for one in self._coming if one.begin >= ended]
        step = self.own.speed * max(elapsed, 1 / self.fps)
        bound = amounts.clip(self.own.low, self.own.high)
        # Gestures that meet by chance add up, so the sum is kept within the speed of a face.
        self.amounts = bound.clip(self.amounts - step, self.amounts + step)
        return frame._replace(weights=np.concatenate((frame.weights, self.amounts)))

    def _draw(self, seconds: float, elapsed: float, *, speaking: bool) -> None:
        """Begin the gestures that come by themselves now."""
        self._facts = [fact for fact in self._facts if fact[0] >= seconds]
        for number, shape in enumerate(self.own.shapes):
            if shape.rates is None or not self.scales[number]:
                continue
            self._left[number] -= elapsed * shape.rates[not speaking] / 60
            if self._left[number] > 0 or seconds < self._free[number]:
                continue
            near = (at for at, name in self._facts if name in shape.at)
            begin = min(near, default=seconds)
            begin = begin if begin <= seconds + DRAWING_SECONDS else seconds
            self._coming.append(BegunGesture(number, begin, self.scales[number]))
            self._free[number] = begin + shape.room
            # Added, not set: what the gap before went beyond zero counts, so the rate stays true.
            self._left[number] += self._gap(number)

    def _gap(self, number: int) -> float:
        """Draw a log-normal gap with the mean 1."""
        spread = self.own.shapes[number].spread
        return self._random.lognormvariate(-spread * spread / 2, spread)


def beside(gestures: LiveGestures | None, frames: Sequence[LiveFrame]) -> list[LiveFrame]:
    """Return frames with gestures, if there are any."""
    return [*frames] if gestures is None else [gestures.beside(frame) for frame in frames]
