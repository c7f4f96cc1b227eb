"""Plots of bigrams as an animator sees them: every pose over normalised time (figure 3).

A panel per bigram. Dots and thin lines are the control polygons, thick lines the curves that move
the face. Of the bigrams that a layer changes, a panel has each pose before and after.

Units: x is normalised time; y is weight, or of changes inches from the top of a panel, the scale of
a printed page.
"""

from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from lipsync_lang.base.errors import OutputError
from lipsync_lang.pipeline.curve import bspline, polyline
from lipsync_lang.render.plot import BIGRAMS, FINAL, INK, STAGES, THIN, VISIBLE_WEIGHT, WIDTH, draw
from lipsync_lang.resolver.bank_diff import TIMES, BigramChange, Diff

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lipsync_lang.base.arrays import Floats
    from lipsync_lang.resolver.bigram_sources import ShownBigram

BIGRAM_COLUMNS, MOST = 2, 12
"""Maximum numbers of panels per row of played bigrams, and per picture."""

PANEL_INCHES = (5.4, 3.4)
"""Width and height of a panel with its title, axis and legend."""

CURVE_TIMES: "Floats" = np.linspace(0, 1, 201)
"""Normalised times at which curves are drawn."""

DIFF_COLUMNS = 4
"""Panels per row of changed bigrams."""

HEAD, TITLE, AXIS, ROW, GAP, MARGIN = 0.85, 0.42, 0.45, 0.5, 0.14, 0.2
"""Inches: page head, panel title, panel axis, pose row, gap between panels, margin."""

LETTER_INCHES = 0.085
"""Approximate width in inches of one letter of a pose name."""

PALE, EDGE = BIGRAMS[0]
CHANGED = STAGES["constrain"][1]
BEFORE: dict[str, Any] = {"color": EDGE, "lw": 1.3, "zorder": 3}
AFTER: dict[str, Any] = {"color": FINAL, "lw": 1.7, "zorder": 4}

DiffPanel = tuple[BigramChange, list[int]]
"""A bigram with the poses that move before or after the change."""


def plot_bigrams(bigrams: "Sequence[ShownBigram]", stream: BinaryIO, format: str = "png") -> None:  # noqa: A002 as `plot`
    """Draw bigrams with their control points, in a format as of `plot`."""
    if len(bigrams) > MOST:
        raise OutputError(f"a picture has room for {MOST} bigrams, not {len(bigrams)}")
    draw(lambda: _bigram_page(bigrams), stream, format)


def _bigram_page(bigrams: "Sequence[ShownBigram]") -> "Figure":
    from matplotlib.figure import Figure

    columns = min(BIGRAM_COLUMNS, len(bigrams))
    rows = -(-len(bigrams) // columns)
    width, height = PANEL_INCHES
    figure = Figure(figsize=(columns * width, rows * height), layout="constrained")
    for number, bigram in enumerate(bigrams, 1):
        axes = figure.add_subplot(rows, columns, number, xlim=(0, 1), ylim=(-0.03, 1.05))
        _bigram_panel(axes, bigram)
    return figure


def _bigram_panel(axes: "Axes", bigram: "ShownBigram") -> None:
    word = f"  {bigram.origin.word}" if bigram.origin.word else ""
    axes.set_title(f"{bigram.origin.name}{word}", size=11, weight="bold", loc="left")
    axes.set_title(bigram.origin.source, size=8, color=INK, loc="right")
    axes.axvline(bigram.boundary, color=INK, lw=0.8, ls=":", zorder=1)
    spans = (0.0, bigram.boundary, 1.0)
    for label, start, end in zip(bigram.origin.pair, spans[:-1], spans[1:], strict=True):
        axes.text((start + end) / 2, 0.95, label, size=10, ha="center", va="center", color=INK)
    for weight in (0, 1):
        axes.axhline(weight, **THIN)
    for number, (pose, points) in enumerate(bigram.curves.items()):
        colour = f"C{number % 10}"
        curve = (polyline if bigram.linear else bspline)(points[None], CURVE_TIMES)[0].clip(0, 1)
        axes.plot(*points.T, color=colour, lw=0.8, ls="--", marker="o", ms=3, alpha=0.7)
        axes.plot(CURVE_TIMES, curve, color=colour, lw=2, label=pose)
    if bigram.curves:
        axes.legend(loc="upper left", bbox_to_anchor=(1, 1), frameon=False)
    axes.set_xlabel("normalised time", size=8)
    axes.spines[["right", "top"]].set_visible(False)


def plot_diff(diff: Diff, stream: BinaryIO, format: str = "png") -> None:  # noqa: A002 as `plot`
    """Draw the requested bigrams, by default the most different ones, in a format of `plot`."""
    if not diff.named:
        raise OutputError(f"nothing to draw: no bigram differs from those of {diff.against}")
    draw(lambda: _diff_page(diff), stream, format)


def _diff_page(diff: Diff) -> "Figure":
    from matplotlib.figure import Figure

    panels: list[DiffPanel] = []
    for change in diff.named[:MOST]:
        tops = np.maximum(change.before.curves, change.after.curves).max(axis=0)
        panels.append((change, np.flatnonzero(tops > VISIBLE_WEIGHT).tolist()))
    columns = min(DIFF_COLUMNS, len(panels))
    bands = [panels[n : n + columns] for n in range(0, len(panels), columns)]
    tall = [TITLE + max(len(poses) * (ROW + GAP) for _, poses in band) + AXIS for band in bands]
    height = HEAD + sum(tall)
    figure = Figure(figsize=(WIDTH, height))
    _head(figure, diff, len(panels), height)
    names = [diff.poses[pose] for _, poses in panels for pose in poses]
    left = 0.35 + LETTER_INCHES * max(map(len, names), default=0)
    cell = (WIDTH - MARGIN) / DIFF_COLUMNS
    for number, band in enumerate(bands):
        top = height - HEAD - sum(tall[:number]) - TITLE
        for column, panel in enumerate(band):
            size = max(len(panel[1]) * (ROW + GAP), GAP)
            corner = ((column * cell + left) / WIDTH, (top - size) / height)
            place = (*corner, (cell - left - MARGIN) / WIDTH, size / height)
            _diff_panel(figure.add_axes(place, xlim=(0, 1), ylim=(size, 0)), panel, diff.poses)
    return figure


def _head(figure: "Figure", diff: Diff, shown: int, height: float) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    left = MARGIN / WIDTH
    title = f"{diff.character} against {diff.against}"
    figure.text(left, 1 - 0.12 / height, title, size=13, weight="bold", va="top")
    parts = [diff.language, f"{len(diff.changes)} of {diff.total} bigrams differ"]
    if shown < len(diff.named):
        parts.append(f"showing the {shown} with the largest differences")
    line = "   ·   ".join(parts)
    figure.text(left, 1 - 0.4 / height, line, size=10, color=INK, va="top")
    entries = {
        "before": Line2D([], [], **BEFORE),
        "after": Line2D([], [], **AFTER),
        "difference": Patch(facecolor=CHANGED, alpha=0.6),
        "end of the first phoneme": Line2D([], [], color=INK, lw=0.8, ls=":"),
    }
    figure.legend(
        list(entries.values()), list(entries), ncols=len(entries), loc="upper right",
        bbox_to_anchor=(1 - left, 1 - 0.36 / height), frameon=False, borderpad=0, borderaxespad=0,
    )  # fmt: skip


def _diff_panel(axes: "Axes", panel: DiffPanel, names: tuple[str, ...]) -> None:
    """Draw one bigram: a row per pose, with rules at weights 0 and 1 as in the plot of a line."""
    change, poses = panel
    word = f"  {change.word}" if change.word else ""
    axes.set_title(f"{change.bigram}{word}", size=11, weight="bold", loc="left", pad=16)
    axes.annotate(
        f"{change.before} → {change.after}" if change.changed else "unchanged",
        (0, 1), (0, 5), xycoords="axes fraction", textcoords="offset points", size=8, color=INK,
    )  # fmt: skip
    tops = np.arange(len(poses)) * (ROW + GAP) + GAP
    axes.set_yticks(tops + ROW / 2, [names[pose] for pose in poses], size=9)
    axes.tick_params(axis="y", length=0)
    axes.set_xticks([0, 0.25, 0.5, 0.75, 1], ["0", "", "0.5", "", "1"], size=8)
    axes.spines[["left", "right", "top"]].set_visible(False)
    for side, look in ((change.before, BEFORE), (change.after, AFTER)):
        for boundary in side.boundaries:
            axes.axvline(boundary, color=look["color"], lw=0.8, ls=":", zorder=1)
    for top, pose in zip(tops, poses, strict=True):
        axes.axhline(top + ROW, **THIN | {"color": INK})
        axes.axhline(top, **THIN)
        sides = (change.before, change.after)
        old, new = (top + ROW * (1 - side.curves[:, pose]) for side in sides)
        axes.fill_between(TIMES, top + ROW, old, color=PALE, lw=0, alpha=0.7, zorder=2)
        axes.fill_between(TIMES, old, new, color=CHANGED, lw=0, alpha=0.6, zorder=2.5)
        axes.plot(TIMES, old, **BEFORE)
        axes.plot(TIMES, new, **AFTER)
