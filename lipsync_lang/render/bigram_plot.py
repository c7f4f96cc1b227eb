"""Plot of bigrams as an animator sees them: every pose over normalised time (figure 3).

A panel per bigram. Dots and thin lines are the control polygons, thick lines the curves that move
the face. Units: x is normalised time, y is weight.
"""

from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from lipsync_lang.base.errors import OutputError
from lipsync_lang.pipeline.curve import bspline, polyline
from lipsync_lang.render.plot import INK, THIN, draw

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lipsync_lang.base.arrays import Floats
    from lipsync_lang.resolver.bigram_sources import ShownBigram

COLUMNS, MOST = 2, 12
"""Maximum numbers of panels per row and per picture."""

PANEL_INCHES = (5.4, 3.4)
"""Width and height of a panel with its title, axis and legend."""

TIMES: "Floats" = np.linspace(0, 1, 201)
"""Normalised times at which curves are drawn."""


def plot_bigrams(bigrams: "Sequence[ShownBigram]", stream: BinaryIO, format: str = "png") -> None:  # noqa: A002 as `plot`
    """Draw bigrams with their control points, in a format as of `plot`."""
    if len(bigrams) > MOST:
        raise OutputError(f"a picture has room for {MOST} bigrams, not {len(bigrams)}")
    draw(lambda: _page(bigrams), stream, format)


def _page(bigrams: "Sequence[ShownBigram]") -> "Figure":
    from matplotlib.figure import Figure

    columns = min(COLUMNS, len(bigrams))
    rows = -(-len(bigrams) // columns)
    width, height = PANEL_INCHES
    figure = Figure(figsize=(columns * width, rows * height), layout="constrained")
    for number, bigram in enumerate(bigrams, 1):
        _panel(figure.add_subplot(rows, columns, number, xlim=(0, 1), ylim=(-0.03, 1.05)), bigram)
    return figure


def _panel(axes: "Axes", bigram: "ShownBigram") -> None:
    word = f"  {bigram.origin.word}" if bigram.origin.word else ""
    axes.set_title(f"{bigram.origin.name}{word}", size=11, weight="bold", loc="left")
    axes.set_title(bigram.source, size=8, color=INK, loc="right")
    axes.axvline(bigram.boundary, color=INK, lw=0.8, ls=":", zorder=1)
    spans = (0.0, bigram.boundary, 1.0)
    for label, start, end in zip(bigram.origin.pair, spans[:-1], spans[1:], strict=True):
        axes.text((start + end) / 2, 0.95, label, size=10, ha="center", va="center", color=INK)
    for weight in (0, 1):
        axes.axhline(weight, **THIN)
    for number, (pose, points) in enumerate(bigram.curves.items()):
        colour = f"C{number % 10}"
        curve = (polyline if bigram.linear else bspline)(points[None], TIMES)[0].clip(0, 1)
        axes.plot(*points.T, color=colour, lw=0.8, ls="--", marker="o", ms=3, alpha=0.7)
        axes.plot(TIMES, curve, color=colour, lw=2, label=pose)
    if bigram.curves:
        axes.legend(loc="upper left", bbox_to_anchor=(1, 1), frameon=False)
    axes.set_xlabel("normalised time", size=8)
    axes.spines[["right", "top"]].set_visible(False)
