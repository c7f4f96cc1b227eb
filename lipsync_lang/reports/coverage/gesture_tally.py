"""Counts of gestures in a script, at the times of its lines, or at estimated ones."""

from collections import Counter
from typing import Self

from lipsync_lang.performing.gesturing import GestureScales, gesture_curves, scales_of
from lipsync_lang.performing.performer import Performer
from lipsync_lang.reports.coverage.report import GestureNeed
from lipsync_lang.schedules.schedule import Schedule

COUNTED_FPS = 30.0
"""Frames per second at which gestures are laid; a line has the same gestures at any rate."""


class GestureTally:
    """Gestures of the lines of a character, by their facts."""

    def __init__(self, performer: Performer, scales: list[float]) -> None:
        self._performer, self._scales = performer, scales
        self.seconds = 0.0
        """Length of the lines, with the movements before and after them."""
        self._counts: Counter[tuple[int, str]] = Counter()

    @classmethod
    def of(cls, performer: Performer, asked: GestureScales | None) -> Self | None:
        """Return a tally of the gestures asked for; None if the pose set has none of them."""
        scales = scales_of(performer.compiled, asked)
        return None if scales is None else cls(performer, scales)

    def add(self, schedule: Schedule) -> None:
        """Count the gestures of a line."""
        times = self._performer.performance(schedule, COUNTED_FPS).frames.times()
        _, laid = gesture_curves(self._performer, schedule, times, COUNTED_FPS, self._scales, {})
        self._counts.update((one.gesture.number, one.gesture.trigger) for one in laid)
        # With lead-in and tail, in which gestures of silence come too.
        self.seconds += float(times[-1] - times[0])

    def needs(self) -> tuple[GestureNeed, ...]:
        """Return the gestures that occur, in the order of the pose set."""
        found = []
        for number, shape in enumerate(self._performer.gesture_set.shapes):
            by = {
                trigger or "by itself": count
                for (own, trigger), count in self._counts.most_common()
                if own == number
            }
            count = sum(by.values())
            if count:
                rate = round(60 * count / self.seconds, 1)
                found.append(GestureNeed(gesture=shape.name, count=count, a_minute=rate, facts=by))
        return tuple(found)
