"""Captured lines: recorded motion of a face with its phonemes, before a fit and after it.

A fit compares recorded values at the frames of a performance.

Conventions: T samples or frames, S signals, P poses; times are seconds on the schedule's clock.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np

from lipsync_lang import Motion, Performer, Schedule
from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.pipeline.perform import Performance
from lipsync_lang.pipeline.tables import Tables

GAP_SHARE = 1e-6
"""Minimum share of a lost value between two samples; a smaller one is rounding."""

MOST_FIT_FPS = 60.0
"""Frames per second of a fit of a few minutes; faster captures are resampled."""

LEAST_FIT_FPS = 30.0
"""Frames per second of a fit of many minutes."""

MOST_FRAMES = 24_000
"""Frames above which a fit lowers its rate."""

EDGE_SECONDS = 0.15
"""Seconds before the first sound and after the last sound that are compared and fitted."""

LONG_PAUSE_SECONDS = 0.5
"""Minimum length of a long pause, which is fitted only next to sounds."""

LEAST_FRAMES = 3
"""Minimum number of frames for r."""

STILL_SPREAD = 1e-9
"""Minimum standard deviation of a moving signal."""

FREE_SPREAD = 0.2
"""Standard deviation of signals without a scale after scaling, in weights of a pose."""


@dataclass(frozen=True, eq=False)
class CapturedLine:
    """Recorded motion of one spoken line, as signals that are sums of poses."""

    name: str
    """The file's name without its suffix, unique among the lines of a fit."""
    schedule: Schedule
    """The spoken phonemes with their times."""
    times: Floats
    """(T,) seconds, rising evenly."""
    signals: tuple[str, ...]
    """Names of the S recorded signals: poses, rig channels, or measures of the pose set."""
    values: Floats
    """(T, S) recorded values; NaN for a lost sensor."""
    gains: Floats
    """(S, P) gains; a signal is the sum of gains times weights of poses."""
    free: bool = False
    """True if the signals have an unknown scale and offset, as positions in millimetres have."""
    rigged: bool = False
    """True if the signals are channels of the character's rig, which also limits them."""
    speaker: str = ""
    """The speaker's name; empty if unknown."""
    remarks: tuple[str, ...] = ()
    """Doubtful points of the file, as sentences."""


def resampled(times: Floats, old: Floats, values: Floats) -> Floats:
    """Return signals at other times, (T, S); NaN within a gap.

    Beyond the ends, the first and the last known values are held. `times` are (T,) seconds of the
    result, and `old` (N,) rising seconds of the values, (N, S), which are NaN for a lost sensor.
    """
    out = np.full((len(times), values.shape[1]), np.nan)
    for number, signal in enumerate(values.T):
        known = np.isfinite(signal)
        if known.any():
            lost = np.interp(times, old, (~known).astype(float)) > GAP_SHARE
            filled = np.interp(times, old[known], signal[known])
            out[:, number] = np.where(lost, np.nan, filled)
    return out


@dataclass(frozen=True, eq=False)
class FitLine:
    """A captured line, prepared for performance and comparison."""

    captured: CapturedLine
    made: Performance
    """The performance before the fit."""
    wanted: Floats
    """(T, S) recorded values in units of the poses; NaN for lost values."""
    gains: Floats
    """(S, P)"""
    driven: Callable[[Floats, Motion, float], Floats] | None = None
    """Drives the rig whose channels the signals are; None for sums of poses."""
    columns: Ints | None = None
    """(S,) numbers of those channels."""

    def perform(self, tables: Tables, motion: Motion) -> Performance:
        """Return the performance of the line with other tables."""
        return self.made.with_tables(tables, motion)

    def signals(self, weights: Floats, motion: Motion) -> Floats:
        """Return the signals for (T, P) weights of poses: (T, S)."""
        if self.driven is None:
            return weights @ self.gains.T
        return self.driven(weights, motion, self.made.frames.fps)[:, self.columns]

    def errors(self, shown: Floats) -> Floats:
        """Return performed minus recorded signals: (T, S); 0 for lost values."""
        return np.nan_to_num(shown - self.wanted)

    @property
    def seen(self) -> Bools:
        """(T, S) True for recorded values."""
        return np.isfinite(self.wanted)


def fit_rate(lines: Iterable[CapturedLine]) -> float:
    """Return the frames per second of a fit."""
    lines = tuple(lines)
    seconds = sum(float(line.times[-1] - line.times[0]) for line in lines)
    own = max(1 / float(np.median(np.diff(line.times))) for line in lines)
    enough = max(LEAST_FIT_FPS, MOST_FRAMES / max(seconds, 1e-9))
    return float(min(MOST_FIT_FPS, own, enough))


def lay_lines(
    performer: Performer, captured: Sequence[CapturedLine], fps: float
) -> tuple[FitLine, ...]:
    """Prepare captured lines for a fit; scale signals without a scale like the performer's curves.

    A free signal is shifted and scaled, line by line, so that its mean and its standard deviation
    are those of the curves before the fit. All free signals have equal influence.
    """
    tables, motion = performer.compiled.tables, performer.motion
    # The paper's thresholds are tables of their own, which performers choose as well.
    tables = tables.papers if motion.thresholds == "paper" else tables
    laid = []
    for line in captured:
        # Loudness would open the mouth, and the fit would take it for a target.
        made = performer.performance(replace(line.schedule, audio=None), fps)
        times = made.frames.times()
        wanted = resampled(times, line.times, line.values)
        # `resampled` holds the ends, which nobody recorded.
        wanted[(times < line.times[0]) | (times > line.times[-1])] = np.nan
        # Sounds and short pauses count whole, and long pauses next to sounds.
        sounding = made.track.ids != tables.silence
        starts, ends = made.track.bounds[:-1], made.track.bounds[1:]
        counts = sounding | ((ends - starts) < LONG_PAUSE_SECONDS)
        counts[[0, -1]] &= sounding[[0, -1]]
        spoken = np.zeros(len(times), bool)
        for start, end in zip(starts[counts], ends[counts], strict=True):
            spoken |= (times >= start - EDGE_SECONDS) & (times <= end + EDGE_SECONDS)
        wanted[~spoken] = np.nan
        driven, at = None, None
        if line.rigged and (driver := performer.driver) is not None:
            order = [channel.name for channel in driver.channels]
            driven, at = driver.driven, np.array([order.index(name) for name in line.signals])
        laid.append(FitLine(line, made, wanted, line.gains, driven, at))
    return _scaled(tuple(laid), tables, motion)


def _scaled(lines: tuple[FitLine, ...], tables: Tables, motion: Motion) -> tuple[FitLine, ...]:
    """Return the lines with their free signals in units of the poses."""
    free = [line for line in lines if line.captured.free]
    shown = {id(line): line.perform(tables, motion).weights() @ line.gains.T for line in free}
    curves_of: dict[str, list[Floats]] = {}
    for line in free:
        for signal, seen, curve in zip(
            line.captured.signals, line.seen.T, shown[id(line)].T, strict=True
        ):
            curves_of.setdefault(signal, []).append(curve[seen])
    deviations = {
        name: float(values.std()) if (values := np.concatenate(curves)).size else 0.0
        for name, curves in curves_of.items()
    }
    even = {name: FREE_SPREAD / one if one > 0 else 0.0 for name, one in deviations.items()}
    out = []
    for line in lines:
        if not line.captured.free:
            out.append(line)
            continue
        factors = np.array([even[signal] for signal in line.captured.signals])
        wanted = line.wanted.copy()
        for number, seen in enumerate(line.seen.T):
            curve, recorded = shown[id(line)][seen, number], wanted[seen, number]
            spread = float(recorded.std()) if recorded.size else 0.0
            factor = float(curve.std()) / spread if spread > 0 else 0.0
            offset = float(curve.mean()) if curve.size else 0.0
            offset -= factor * float(recorded.mean()) if spread > 0 else 0.0
            wanted[:, number] = (wanted[:, number] * factor + offset) * factors[number]
        out.append(replace(line, wanted=wanted, gains=line.gains * factors[:, None]))
    return tuple(out)


class SignalFigures(NamedTuple):
    """Agreement of curves with a captured signal, before and after a fit."""

    signal: str
    r_before: float | None
    """Pearson r; None if either does not move."""
    r_after: float | None
    rms_before: float
    """Root of the mean squared difference."""
    rms_after: float
    spread: float
    """Standard deviation of the captured signal."""


@dataclass(frozen=True, eq=False)
class ShownLine:
    """A captured line with the curves before and after a fit."""

    name: str
    times: Floats
    """(T,) seconds."""
    signals: tuple[str, ...]
    captured: Floats
    """(T, S) captured values; NaN for lost values."""
    before: Floats
    """(T, S) signals of the curves before the fit."""
    after: Floats
    """(T, S) signals of the curves after it."""
    labels: tuple[str, ...]
    """Phonemes."""
    bounds: Floats
    """Boundaries of the phonemes: one more than labels."""
    figures: tuple[SignalFigures, ...]
    """Figures of each captured signal, worst first."""
    speaker: str = ""

    @classmethod
    def of(cls, line: FitLine, before: Floats, after: Floats) -> Self:
        """Return a line of a fit with the curves before and after it, (T, S) each."""
        captured, schedule = line.captured, line.captured.schedule
        return cls(
            captured.name, line.made.frames.times(), captured.signals, line.wanted, before, after,
            schedule.labels, schedule.times,
            signal_figures(captured.signals, line.wanted, before, after), captured.speaker,
        )  # fmt: skip

    @property
    def r_before(self) -> float | None:
        """Mean r before the fit, weighted by the movement of the signals."""
        return _mean(self.figures, [one.r_before for one in self.figures])

    @property
    def r_after(self) -> float | None:
        """Mean r after the fit, weighted by the movement of the signals."""
        return _mean(self.figures, [one.r_after for one in self.figures])

    @property
    def rms_before(self) -> float:
        """RMS difference over all signals before."""
        return _root([one.rms_before for one in self.figures])

    @property
    def rms_after(self) -> float:
        """RMS difference over all signals after."""
        return _root([one.rms_after for one in self.figures])


def _mean(figures: Sequence[SignalFigures], values: Sequence[float | None]) -> float | None:
    pairs = [(v, f.spread) for v, f in zip(values, figures, strict=True) if v is not None]
    total = sum(weight for _, weight in pairs)
    return sum(value * weight for value, weight in pairs) / total if total > 0 else None


def _root(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values)))) if values else 0.0


def signal_figures(
    signals: Sequence[str], captured: Floats, before: Floats, after: Floats
) -> tuple[SignalFigures, ...]:
    """Measure the agreement of curves with the known values of captured signals, worst first."""
    found = []
    for number, signal in enumerate(signals):
        known = np.isfinite(captured[:, number])
        if known.any():
            wanted, old, new = (one[known, number] for one in (captured, before, after))
            r = _r(wanted, old), _r(wanted, new)
            rms = [float(np.sqrt(np.mean((wanted - one) ** 2))) for one in (old, new)]
            found.append(SignalFigures(signal, *r, rms[0], rms[1], float(wanted.std())))
    return tuple(sorted(found, key=lambda one: -one.rms_after))


def _r(wanted: Floats, shown: Floats) -> float | None:
    if len(wanted) < LEAST_FRAMES or wanted.std() <= STILL_SPREAD or shown.std() <= STILL_SPREAD:
        return None
    return float(np.corrcoef(wanted, shown)[0, 1])
