"""Clocks of captures: how well motion follows phonemes, and at which offset and speed.

The curves that a performer gives to the phonemes are compared with the recorded motion, at offsets
and speeds of the recorded clock. Timings of another line are told by chance: the same line with its
phonemes shuffled shows how alike motion and curves are without being of the same words.

Conventions: T frames at `CLOCK_FPS`, S signals; times are seconds. A likeness is a mean Pearson r
over the signals, weighted by how much the curves move each.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from random import Random
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lipsync_lang.pipeline.arrays import Floats, Ints

if TYPE_CHECKING:
    from lipsync_lang.capture.captured_line import CapturedLine
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.schedules.schedule import Schedule

CLOCK_FPS = 50.0
"""Frames per second of the comparison."""

EDGE_SECONDS = 0.15
"""Seconds before the first sound and after the last that are compared."""

FAR_SECONDS = 1.5
"""Largest offset that is tried."""

NEAR_SECONDS = 0.25
"""Largest offset that can be corrected."""

DRIFT_SECONDS = 0.4
"""Largest drift that is tried, from the middle of the speech to its ends."""

STEP_SECONDS = 0.04
"""Steps of the search for a drift."""

SHUFFLES = 10
"""Shuffled lines that show what chance gives."""

LEAST_SPREAD = 0.05
"""Standard deviation of likenesses by chance, at least."""

SPEEDS = (1 / 2, 24 / 30, 24 / 25, 25 / 24, 25 / 30, 30 / 25, 30 / 24, 48 / 60, 60 / 50, 2)
"""Speeds of a clock whose frame rate was taken for another."""

STILL = 1e-9
"""Standard deviation below which a signal does not move."""


class ClockReading(NamedTuple):
    """The clock of a capture, as the comparison shows it."""

    likeness: float
    """Likeness as the files lie, without any correction."""
    near: float
    """Best likeness at an offset of `NEAR_SECONDS` at most."""
    offset: float
    """Seconds by which the motion comes late there."""
    rival: float
    """Best likeness at another near offset."""
    far: float
    """Best likeness at a larger offset."""
    far_offset: float
    drifting: float
    """Best likeness at a drift."""
    drift: float
    """Seconds by which the clock loses over the speech there; below zero it gains."""
    chance: float
    """Mean likeness of shuffled lines, each at its best near offset."""
    spread: float
    """Standard deviation of those likenesses."""


@dataclass(frozen=True, eq=False)
class ComparedMotion:
    """The recorded motion of a line beside the curves of a performer."""

    times: Floats
    """(T,) frames of the speech."""
    shown: Floats
    """(T, S) the performer's signals."""
    line: "CapturedLine"

    def recorded(self, offset: float = 0.0, drift: float = 0.0, speed: float = 1.0) -> Floats:
        """Return the recorded values (T, S), read by a clock that is late, or drifts, or is fast.

        Parameters
        ----------
        drift : seconds that the clock loses from the first frame to the last
        speed : of the clock from its zero
        """
        middle = (self.times[0] + self.times[-1]) / 2
        length = max(self.times[-1] - self.times[0], 1e-9)
        seconds = (self.times + offset + (self.times - middle) / length * drift) * speed
        at = np.rint((seconds - self._start) * CLOCK_FPS).astype(np.intp)
        inside = (at >= 0) & (at < len(self._grid))
        out: Floats = self._grid[np.clip(at, 0, len(self._grid) - 1)]
        out[~inside] = np.nan
        return out

    @property
    def _start(self) -> float:
        return float(self.line.times[0])

    @cached_property
    def _grid(self) -> Floats:
        """The recorded values at the frames of the comparison."""
        return _sampled(self.line)

    def likeness(self, offset: float = 0.0, drift: float = 0.0, speed: float = 1.0) -> float:
        """Return how alike curves and motion are, from -1 to 1."""
        each, weights = self.correlations(offset, drift, speed)
        total = float(weights.sum())
        return float(each @ weights) / total if total > 0 else 0.0

    def correlations(
        self, offset: float = 0.0, drift: float = 0.0, speed: float = 1.0
    ) -> tuple[Floats, Floats]:
        """Return r of each signal, and its weight: (S,) each; 0 where either does not move."""
        x, y = self.recorded(offset, drift, speed), self.shown
        known = np.isfinite(x)
        counts = np.maximum(known.sum(axis=0), 1)
        x, y = np.where(known, x, 0.0), np.where(known, y, 0.0)
        x = np.where(known, x - x.sum(axis=0) / counts, 0.0)
        y = np.where(known, y - y.sum(axis=0) / counts, 0.0)
        across = np.sqrt((x * x).sum(axis=0)), np.sqrt((y * y).sum(axis=0))
        moving = (across[0] > STILL) & (across[1] > STILL)
        products = np.where(moving, across[0] * across[1], 1.0)
        each = np.where(moving, (x * y).sum(axis=0) / products, 0.0)
        return each, across[1] * (known.mean(axis=0) > 0.5)  # noqa: PLR2004 half of the speech


def _sampled(line: "CapturedLine") -> Floats:
    """Return the values of a line at an even rate from its first time on; NaN where lost."""
    times = np.arange(line.times[0], line.times[-1] + 0.5 / CLOCK_FPS, 1 / CLOCK_FPS)
    out = np.full((len(times), len(line.signals)), np.nan)
    for number, values in enumerate(line.values.T):
        known = np.isfinite(values)
        if known.any():
            made = np.interp(times, line.times[known], values[known])
            lost = np.interp(times, line.times, (~known).astype(float)) > STILL
            out[:, number] = np.where(lost, np.nan, made)
    return out


def compared(
    performer: "Performer", line: "CapturedLine", schedules: "list[Schedule]"
) -> list[ComparedMotion]:
    """Lay the curves of schedules beside the motion of a line."""
    performed = performer.perform_many(schedules, fps=CLOCK_FPS, intensity=None)
    out = []
    for schedule, animation in zip(schedules, performed, strict=True):
        start, end = spoken_span(performer, schedule)
        times = np.arange(start - EDGE_SECONDS, end + EDGE_SECONDS, 1 / CLOCK_FPS)
        weights = [np.interp(times, animation.times, one, 0, 0) for one in animation.weights.T]
        out.append(ComparedMotion(times, np.column_stack(weights) @ line.gains.T, line))
    return out


def spoken_span(performer: "Performer", schedule: "Schedule") -> tuple[float, float]:
    """Return the start of the first sound and the end of the last."""
    ids, bounds, _ = performer.common_phonemes(schedule)
    sounds = np.flatnonzero(ids != performer.compiled.tables.silence)
    return float(bounds[sounds[0]]), float(bounds[sounds[-1] + 1])


def sounds_of(performer: "Performer", schedule: "Schedule") -> Ints:
    """Return the numbers of the labels that are sounds."""
    ids, _, source = performer.common_phonemes(schedule)
    found: Ints = np.unique(source[(ids != performer.compiled.tables.silence) & (source >= 0)])
    return found


def read_clock(performer: "Performer", line: "CapturedLine") -> tuple[ClockReading, ComparedMotion]:
    """Compare the motion of a line with its phonemes."""
    motion, *shuffled = compared(performer, line, [line.schedule, *_shuffles(performer, line)])
    offsets = np.arange(-FAR_SECONDS, FAR_SECONDS + 1e-9, 1 / CLOCK_FPS)
    alike = np.array([motion.likeness(offset) for offset in offsets])
    near = np.abs(offsets) <= NEAR_SECONDS + 1e-9
    best = int(np.where(near, alike, -2).argmax())
    far = int(np.where(near, -2, alike).argmax())
    apart = near & (np.abs(offsets - offsets[best]) > 0.12)  # noqa: PLR2004 another sound's time
    drifting, drift = _drift(motion, float(offsets[best]))
    few = np.arange(-NEAR_SECONDS, NEAR_SECONDS + 1e-9, STEP_SECONDS)
    chance = np.array([max(one.likeness(offset) for offset in few) for one in shuffled])
    reading = ClockReading(
        float(alike[len(offsets) // 2]),
        float(alike[best]),
        float(offsets[best]),
        float(alike[apart].max()),
        float(alike[far]),
        float(offsets[far]),
        drifting,
        drift,
        float(chance.mean()),
        max(float(chance.std()), LEAST_SPREAD),
    )
    return reading, motion


def _shuffles(performer: "Performer", line: "CapturedLine") -> "list[Schedule]":
    """Return the schedule with its sounds in other orders, at the same times."""
    places = sounds_of(performer, line.schedule).tolist()
    out = []
    for seed in range(SHUFFLES):
        labels = list(line.schedule.labels)
        other = Random(seed).sample(places, len(places))  # noqa: S311 no secret
        for place, source in zip(places, other, strict=True):
            labels[place] = line.schedule.labels[source]
        out.append(replace(line.schedule, labels=tuple(labels), words=(), stress=()))
    return out


def _drift(motion: ComparedMotion, offset: float) -> tuple[float, float]:
    """Return the best likeness at a drift, and that drift over the speech."""
    drifts = np.arange(-2 * DRIFT_SECONDS, 2 * DRIFT_SECONDS + 1e-9, 2 * STEP_SECONDS)
    around = offset + np.arange(-3, 4) * STEP_SECONDS
    best = max(
        (max(motion.likeness(late, drift) for late in around), -abs(drift), drift)
        for drift in drifts.tolist()
    )
    return best[0], best[2]


def best_speed(motion: ComparedMotion) -> tuple[float, float]:
    """Return the best likeness at a speed of the clock, and that speed."""
    around = np.arange(-3, 4) * STEP_SECONDS
    return max(
        (max(motion.likeness(late, speed=speed) for late in around), speed) for speed in SPEEDS
    )
