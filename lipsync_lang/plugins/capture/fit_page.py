"""The page of a fit: captures, curves and fitted values as one self-contained HTML file.

The page has the style of the coverage page, and no script. Curves are SVG that stretches to the
available width, with the phonemes as text above them.
"""

import json
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from lipsync_lang.base.presentation.pages import PageEnvironment
from lipsync_lang.plugins.capture.fit_file import FitProposal
from lipsync_lang.plugins.capture.fit_lines import ShownLine, SignalFigures

MAX_DRAWN_LINES = 200
"""Maximum number of lines with a drawing; the table lists all lines."""

MAX_DRAWN_SIGNALS = 12
"""Maximum number of signals in a drawing, largest movement first."""

MAX_POINTS = 1_500
"""Maximum number of points of a drawn curve."""

MAX_TABLE_ROWS = 1_000
"""Maximum number of rows of the table of lines, and of the table of values."""

MAX_VALUE_CHARS = 120
"""Maximum length of a value in a row, in characters."""

MAX_DRAWN_LABELS = 400

LABEL_REM = 1.3
"""Width of a phoneme above a drawing, in rem, on a narrow screen."""

DRAWN_MARGIN_SECONDS = 0.1
"""Seconds in a drawing before and after the captured part."""

WIDTH, HEIGHT = 1_000, 100
"""Width and height of a drawing in its own units; it stretches."""


def fit_page(lines: Sequence[ShownLine], proposal: FitProposal) -> str:
    """Return a fit as one self-contained HTML page."""
    environment = PageEnvironment(__package__, "page_templates")
    environment.filters["number"] = lambda value: "–" if value is None else f"{value:.3f}"
    environment.filters["value"] = _value
    environment.globals |= {
        "WIDTH": WIDTH,
        "HEIGHT": HEIGHT,
        "MAX_ROWS": MAX_TABLE_ROWS,
        "MAX_DRAWN_SIGNALS": MAX_DRAWN_SIGNALS,
    }
    worst = sorted(lines, key=lambda line: (-line.rms_after, line.name))
    items = sorted(proposal.items, key=lambda one: (-one.confidence * one.occurrences, one.item))
    values = {
        "lines": worst,
        "proposal": proposal,
        "items": items,
        "drawings": [_drawing(line) for line in worst[:MAX_DRAWN_LINES]],
        "r": [_mean(line.r_before for line in lines), _mean(line.r_after for line in lines)],
        "rms": [_mean(line.rms_before for line in lines), _mean(line.rms_after for line in lines)],
    }
    return environment.page("fit.html", values, "fit.css")


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return sum(known) / len(known) if known else None


def _value(value: object) -> str:
    """Format a value of an item briefly."""
    text = "–" if value is None else json.dumps(value, ensure_ascii=False, default=str)
    return text if len(text) <= MAX_VALUE_CHARS else f"{text[: MAX_VALUE_CHARS - 1]}…"


def _drawing(line: ShownLine) -> dict[str, Any]:
    """Return the drawing of a line for the template."""
    start, end = float(line.times[0]), float(line.times[-1])
    known = line.times[np.isfinite(line.captured).any(axis=1)]
    if len(known):
        start = float(known[0]) - DRAWN_MARGIN_SECONDS
        end = float(known[-1]) + DRAWN_MARGIN_SECONDS
    length = max(end - start, 1e-9)
    at = [(float(bound) - start) / length for bound in line.bounds]
    inside = [share for share in at if 0 <= share <= 1]
    middles = [(one + other) / 2 for one, other in pairwise(at)]
    labels = [(t, m) for t, m in zip(line.labels, middles, strict=False) if 0 <= m <= 1]
    moving = sorted(line.figures, key=lambda one: -one.spread)[:MAX_DRAWN_SIGNALS]
    bounds = (f"M{share * WIDTH:.1f} 0V{HEIGHT}" for share in inside[:MAX_DRAWN_LABELS])
    return {
        "line": line,
        "signals": [_signal(line, figures, start, end) for figures in moving],
        "bounds": "".join(bounds),
        "labels": labels[:MAX_DRAWN_LABELS],  # each with its position as a share of the width
        "width": max(20.0, LABEL_REM * len(labels[:MAX_DRAWN_LABELS])),  # rem, to be readable
    }


def _signal(line: ShownLine, figures: SignalFigures, start: float, end: float) -> dict[str, Any]:
    number = line.signals.index(figures.signal)
    at = np.flatnonzero((line.times >= start) & (line.times <= end))
    at = at[:: max(1, -(-len(at) // MAX_POINTS))]
    x = (line.times[at] - start) / max(end - start, 1e-9) * WIDTH
    curves = [one[at, number] for one in (line.captured, line.before, line.after)]
    known = np.concatenate([one[np.isfinite(one)] for one in curves])
    low, high = float(known.min()), float(known.max())
    span = high - low or 1.0  # a signal at rest lies at the foot
    drawn: dict[str, Any] = {"figures": figures, "low": low, "high": high}
    for name, curve in zip(("captured", "before", "after"), curves, strict=True):
        parts, pen = [], "M"
        y = (low + span - curve) / span * HEIGHT
        for here, there in zip(x.tolist(), y.tolist(), strict=True):
            known_here = np.isfinite(there)
            if known_here:
                parts.append(f"{pen}{here:.1f} {there:.1f}")
            pen = "L" if known_here else "M"  # a gap at a missing value
        drawn[name] = "".join(parts)
    return drawn
