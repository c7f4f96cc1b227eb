"""Clocks of captures: likeness of motion and phonemes, with the best offset and speed.

The curves that a performer gives to the phonemes are compared with the recorded motion, at offsets
and speeds of the recorded clock. A comparison with chance
exposes the timings of another line: the same line with shuffled phonemes shows the likeness of
motion and curves that belong to different words.

Conventions: T frames at `CLOCK_FPS`, S signals; times are seconds. A likeness is a mean Pearson r
over the measures of the mouth and their speeds, weighted by how much the curves move each. Over 2 s
of a measure alone, a few slow turns agree by chance, and its speed tells other words apart.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from random import Random
from typing import NamedTuple

import numpy as np

from lipsync_lang import Performer, Schedule
from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.plugins.capture.fit_lines import EDGE_SECONDS, CapturedLine, resampled

CLOCK_FPS = 50.0
"""Frames per second of the comparison."""

PAUSE_EDGE_SECONDS = 0.5
"""Seconds at each end of a pause in the comparison."""

FAR_SECONDS = 1.5
"""Largest offset in the search."""

NEAR_SECONDS = 0.25
"""Largest offset that can be corrected."""

DRIFT_SECONDS = 0.4
"""Largest drift in the search, from the middle of the speech to its ends."""

DRIFT_STEP_SECONDS = 0.04
"""Steps of the search for a drift."""

SEARCHED_OFFSETS_SECONDS: Floats = np.arange(-3.0, 4.0) * DRIFT_STEP_SECONDS
"""Number of offsets in the search with every drift and speed."""

SHUFFLES = 20
"""Number of shuffled lines for the estimate of chance."""

LEAST_SPREAD = 0.05
"""Minimum standard deviation of likenesses by chance, on the scale of `_stretched`."""

MOST_LIKENESS = 0.999
"""Largest likeness on that scale, where 1 is infinite."""

SPEEDS = (1 / 2, 24 / 30, 24 / 25, 25 / 24, 25 / 30, 30 / 25, 30 / 24, 48 / 60, 60 / 50, 2)
"""Speeds of a clock with a mistaken frame rate."""

APART_SECONDS = 0.12
"""Minimum distance in seconds of separate peaks: the time of a sound and a half."""

LEAST_KNOWN = 0.5
"""Minimum share of the speech in which a signal is recorded."""

MAX_COMPARED_VALUES = 2_000_000
"""Maximum number of values in one comparison."""

SPEED_FRAMES = 6
"""Frames over which a speed is taken: less than a sound, and more than a tremble of tracking."""

STILL_SIZE = 1e-6
"""Minimum size of a signal's motion; smaller signals count as still."""


class ClockReading(NamedTuple):
    """The clock of a capture according to the comparison."""

    likeness: float
    """Likeness without any correction."""
    near: float
    """Best likeness at an offset of `NEAR_SECONDS` at most."""
    offset: float
    """Delay of the motion at that offset, in seconds."""
    rival: float
    """Best likeness at another near offset."""
    far: float
    """Best likeness at a larger offset."""
    far_offset: float
    drifting: float
    """Best likeness with a drift."""
    drift: float
    """Seconds that the clock loses over the speech at that drift; negative if it gains."""
    chance: float
    """Usual likeness of shuffled lines, each at its best near offset."""
    spread: float
    """Standard deviation of those likenesses, on the scale of `_stretched`."""

    def beyond_chance(self, deviations: float) -> float:
        """Return the likeness that lies a number of standard deviations beyond chance."""
        return float(np.tanh(_stretched(self.chance) + deviations * self.spread))

    @property
    def drift_gain(self) -> float:
        """Gain of likeness by the drift, in standard deviations of chance."""
        return float(_stretched(self.drifting) - _stretched(self.near)) / self.spread


@dataclass(frozen=True, eq=False)
class ComparedMotion:
    """The recorded motion of a line, with curves for its times: its own, then shuffled ones.

    Conventions: K curves, L clocks.
    """

    times: Floats
    """(T,) frames of the speech."""
    shown: Floats
    """(K, T, 2 S) signals of the curves, then their speeds."""
    line: CapturedLine

    def likenesses(
        self, offsets: Sequence[float], drifts: Sequence[float] = (), speeds: Sequence[float] = ()
    ) -> Floats:
        """Return the likeness of curves and motion with each clock, from -1 to 1: (L, K).

        `offsets` are delays of the motion in seconds, `drifts` the seconds that the clock loses
        from the first frame to the last (empty for none), and `speeds` those of the clock from its
        zero (empty for 1): (L,) each.
        """
        clocks = np.zeros((len(offsets), 3))
        clocks[:, 0] = offsets
        clocks[:, 1] = drifts or 0.0
        clocks[:, 2] = speeds or 1.0
        size = len(self.times) * self.shown.shape[2] * len(clocks)
        parts = np.array_split(clocks, max(1, size // MAX_COMPARED_VALUES))
        out = []
        for part in parts:
            each, weights = self._correlations(part)
            total = weights.sum(axis=2)
            out.append((each * weights).sum(axis=2) / np.where(total > 0, total, 1.0))
        return np.concatenate(out)

    def signals(self) -> Floats:
        """Return r of each signal with its own curve, without correction: (S,)."""
        each = self._correlations(np.array([[0.0, 0.0, 1.0]]))[0][0, 0]
        return each[: len(self.line.signals)]

    def _correlations(self, clocks: Floats) -> tuple[Floats, Floats]:
        """Return r and weight of each column, (L, K, 2 S) each; 0 if signal or curve is still."""
        middle = (self.times[0] + self.times[-1]) / 2
        # The clock turns around the middle of the speech, so that a drift needs no offset to fit.
        along = (self.times - middle) / max(self.times[-1] - self.times[0], 1e-9)
        offset, drift, speed = clocks.T[..., None]
        seconds = (self.times + offset + along * drift) * speed
        at = np.rint((seconds - self.line.times[0]) * CLOCK_FPS).astype(np.intp)
        inside = (at >= 0) & (at < len(self._grid))
        # The nearest sample of an even grid: interpolation would take most of the search.
        recorded = self._grid[np.clip(at, 0, len(self._grid) - 1)]  # (L, T, S)
        recorded[~inside] = np.nan
        known = np.isfinite(recorded)
        counts = np.maximum(known.sum(axis=1), 1)
        x = np.where(known, recorded, 0.0)
        x -= np.where(known, (x.sum(axis=1) / counts)[:, None], 0.0)
        seen = known.astype(float)
        # Sums over the known samples alone, as products of masks, for all clocks and curves at
        # once.
        sums, squares = (np.einsum("lts,kts->lks", seen, y) for y in (self.shown, self.shown**2))
        recorded_size = np.sqrt((x * x).sum(axis=1))[:, None]
        shown_size = np.sqrt(np.maximum(squares - sums**2 / counts[:, None], 0.0))
        moving = (recorded_size > STILL_SIZE) & (shown_size > STILL_SIZE)
        products = np.where(moving, recorded_size * shown_size, 1.0)
        each = np.where(moving, np.einsum("lts,kts->lks", x, self.shown) / products, 0.0)
        enough = known.mean(axis=1)[:, None] > LEAST_KNOWN
        return each, np.where(enough & (shown_size > STILL_SIZE), shown_size, 0.0)

    @cached_property
    def _grid(self) -> Floats:
        """The recorded values and speeds at an even rate from the line's first time on."""
        line = self.line
        times = np.arange(line.times[0], line.times[-1] + 0.5 / CLOCK_FPS, 1 / CLOCK_FPS)
        return _with_speeds(resampled(times, line.times, line.values))


def _with_speeds(signals: Floats) -> Floats:
    """Return signals, (..., T, S), with their speeds: (..., T, 2 S)."""
    edges = [(0, 0)] * (signals.ndim - 2) + [(SPEED_FRAMES // 2,) * 2, (0, 0)]
    wide = np.pad(signals, edges, "edge")
    speeds = wide[..., SPEED_FRAMES:, :] - wide[..., :-SPEED_FRAMES, :]
    return np.concatenate((signals, speeds), axis=-1)


def _as_measures(performer: Performer, line: CapturedLine) -> CapturedLine:
    """Return weights of poses or channels as measures; other signals as they are.

    Tracking shares a movement out among channels otherwise than targets do.
    """
    rig = performer.compiled.rig if line.rigged else None
    known = rig["measures"] if rig else performer.compiled.measures
    sums = np.array([[gains.get(one, 0.0) for one in line.signals] for gains in known.values()])
    if line.free or not sums.any():
        return line
    names = tuple(name for name, gains in zip(known, sums, strict=True) if gains.any())
    sums = sums[sums.any(axis=1)]
    values, gains = line.values @ sums.T, sums @ line.gains
    return replace(line, signals=names, values=values, gains=gains, free=True)


def compared(
    performer: Performer, line: CapturedLine, schedules: Sequence[Schedule]
) -> ComparedMotion:
    """Combine the motion of a line with the curves of schedules with the same times."""
    line = _as_measures(performer, line)
    start, end = spoken_span(performer, schedules[0])
    times = np.arange(start - EDGE_SECONDS, end + EDGE_SECONDS, 1 / CLOCK_FPS)
    sounds = sounds_of(performer, schedules[0])
    starts, ends = schedules[0].times[sounds], schedules[0].times[sounds + 1]
    before = np.searchsorted(starts, times, side="right") - 1
    since = times - ends[np.maximum(before, 0)]
    until = starts[np.minimum(before + 1, len(starts) - 1)] - times
    # Long pauses are left out, except next to sounds.
    times = times[(before < 0) | (since <= PAUSE_EDGE_SECONDS) | (until <= PAUSE_EDGE_SECONDS)]
    shown = []
    for animation in performer.perform_many(schedules, fps=CLOCK_FPS, intensity=None):
        weights = [np.interp(times, animation.times, one, 0, 0) for one in animation.weights.T]
        shown.append(np.column_stack(weights) @ line.gains.T)
    curves = _with_speeds(np.array(shown))
    if line.free:  # its measures count alike
        curves /= np.maximum(curves.std(axis=(0, 1)), STILL_SIZE)
    return ComparedMotion(times, curves, line)


def spoken_span(performer: Performer, schedule: Schedule) -> tuple[float, float]:
    """Return the start of the first sound and the end of the last."""
    ids, bounds, _ = performer.common_phonemes(schedule)
    sounds = np.flatnonzero(ids != performer.compiled.tables.silence)
    return float(bounds[sounds[0]]), float(bounds[sounds[-1] + 1])


def sounds_of(performer: Performer, schedule: Schedule) -> Ints:
    """Return the indices of the labels other than silence."""
    ids, _, source = performer.common_phonemes(schedule)
    return np.unique(source[(ids != performer.compiled.tables.silence) & (source >= 0)])


def read_clock(performer: Performer, line: CapturedLine) -> tuple[ClockReading, ComparedMotion]:
    """Compare the motion of a line with its phonemes."""
    motion = compared(performer, line, [line.schedule, *_shuffles(performer, line)])
    own = replace(motion, shown=motion.shown[:1])
    offsets = np.arange(-FAR_SECONDS, FAR_SECONDS + 1e-9, 1 / CLOCK_FPS)
    alike = own.likenesses(offsets.tolist())[:, 0]
    near = np.abs(offsets) <= NEAR_SECONDS + 1e-9
    best = int(np.where(near, alike, -2).argmax())
    far = int(np.where(near, -2, alike).argmax())
    apart = near & (np.abs(offsets - offsets[best]) > APART_SECONDS)
    drifts = np.arange(-2 * DRIFT_SECONDS, 2 * DRIFT_SECONDS + 1e-9, 2 * DRIFT_STEP_SECONDS)
    searched = np.meshgrid(float(offsets[best]) + SEARCHED_OFFSETS_SECONDS, drifts)
    late, lost = (one.ravel().tolist() for one in searched)
    drifted = own.likenesses(late, lost)[:, 0].tolist()
    # Of equal likenesses, the smallest drift.
    drifting, _, drift = max(zip(drifted, (-abs(one) for one in lost), lost, strict=True))
    few = np.arange(-NEAR_SECONDS, NEAR_SECONDS + 1e-9, DRIFT_STEP_SECONDS)
    # Each shuffled line may choose its best offset too, or chance would look too poor.
    chance = _stretched(motion.likenesses(few.tolist())[:, 1:].max(axis=0))
    found = (
        *(alike[len(offsets) // 2], alike[best], offsets[best], alike[apart].max()),
        *(alike[far], offsets[far], drifting, drift),
        *(np.tanh(chance.mean()), max(chance.std(), LEAST_SPREAD)),
    )
    return ClockReading(*map(float, found)), own


def _stretched(likeness: Floats | float) -> Floats:
    """Return Fisher's z of likenesses, whose spread by chance is even: near 1, r hardly spreads."""
    return np.arctanh(np.clip(likeness, -MOST_LIKENESS, MOST_LIKENESS))


def _shuffles(performer: Performer, line: CapturedLine) -> list[Schedule]:
    """Return copies of the schedule with its sounds shuffled, at the same times."""
    places = sounds_of(performer, line.schedule).tolist()
    out = []
    for seed in range(SHUFFLES):
        labels = list(line.schedule.labels)
        other = Random(seed).sample(places, len(places))  # noqa: S311 no secret
        for place, source in zip(places, other, strict=True):
            labels[place] = line.schedule.labels[source]
        out.append(replace(line.schedule, labels=tuple(labels), words=(), stress=()))
    return out
