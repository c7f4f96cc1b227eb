"""Captured lines with the curves before and after a fit, and figures of their agreement.

Conventions: T frames, S signals; times are seconds.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lipsync_lang.arrays import Floats
from lipsync_lang.capture.fit_lines import FitLine

LEAST_FRAMES = 3
"""Minimum number of frames for r."""

STILL_SPREAD = 1e-9
"""Minimum standard deviation of a moving signal."""


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


def shown_lines(
    lines: Sequence[FitLine], before: Sequence[Floats], after: Sequence[Floats]
) -> tuple[ShownLine, ...]:
    """Return lines of a fit for its page, with the curves before and after it, (T, S) each."""
    out = []
    for line, old, new in zip(lines, before, after, strict=True):
        captured, schedule = line.captured, line.captured.schedule
        figures = signal_figures(captured.signals, line.wanted, old, new)
        out.append(
            ShownLine(
                captured.name, line.frames.times(), captured.signals, line.wanted, old, new,
                schedule.labels, schedule.times, figures, captured.speaker,
            )
        )  # fmt: skip
    return tuple(out)
