"""Plot of one line on several faces, stacked on a common time axis in seconds."""

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.performer import performer_of
from lipsync_lang.render import plot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WIDTH, PER_SECOND, MOST = 4.0, 4.0, 15.0
"""Page width in inches: minimum, per second of the line, maximum."""

HEAD, ROW, GAP, FOOT = 0.75, 0.24, 0.3, 0.4
MARGIN, RIGHT = 0.2, 0.15

HUES = ("#4f8fbf", "#c2853f", "#5f9e77", "#b0629a", "#8a7fc0", "#9a8f4a")
"""Curve colours, one per face in turn."""


def plot_beside(animations: Sequence[Animation], stream: BinaryIO, format: str = "png") -> None:  # noqa: A002
    """Draw animations of one schedule, performed in this process, with a row per moving pose."""
    if not animations:
        raise LipsyncError("there is no animation to draw; give at least one")
    first = animations[0].schedule
    for own in (one.schedule for one in animations[1:]):
        if own.labels != first.labels or not np.array_equal(own.times, first.times):
            what = "the animations are of different lines"
            raise LipsyncError(f"{what}; give animations of the same schedule")
    plot.draw(lambda: _page(animations), stream, format)


def _page(animations: Sequence[Animation]) -> "Figure":
    from matplotlib.figure import Figure

    schedule = animations[0].schedule
    begin = min(float(one.times[0]) for one in animations)
    end = min(max(float(one.times[-1]) for one in animations), begin + plot.SHOWN)
    tops = [np.abs(one.weights).max(axis=0) for one in animations]
    rows: list[list[int]] = [np.flatnonzero(top > plot.VISIBLE_WEIGHT).tolist() for top in tops]
    heights = [max(1, len(row)) * ROW for row in rows]
    named = [one.poses[pose] for one, row in zip(animations, rows, strict=True) for pose in row]
    left = MARGIN + max((plot.text_width(name, 8) for name in named), default=0.0)
    width = left + RIGHT + float(np.clip((end - begin) * PER_SECOND, WIDTH, MOST))
    height = HEAD + sum(heights) + GAP * len(heights) + FOOT
    figure = Figure(figsize=(width, height))
    corner, title = (left / width, 1 - 0.1 / height), plot.title_of(schedule)
    figure.text(*corner, title, size=12, weight="bold", va="top")
    top = height - HEAD
    for number, (one, row, tall) in enumerate(zip(animations, rows, heights, strict=True)):
        top -= GAP
        place = (left / width, (top - tall) / height, 1 - (left + RIGHT) / width, tall / height)
        axes = figure.add_axes(place, xlim=(begin, end), ylim=(max(1, len(row)), 0))
        _face(axes, one, row, HUES[number % len(HUES)])
        axes.tick_params(axis="x", labelbottom=number == len(animations) - 1, length=0)
        top -= tall
    # The phonemes stand above the first face.
    for label, (start, stop) in zip(schedule.labels, pairwise(schedule.times), strict=True):
        if begin <= start < end:
            figure.axes[0].annotate(
                " ".join(label.split()), ((start + stop) / 2, 0), (0, 17),
                textcoords="offset points", ha="center", size=8, color=plot.INK,
            )  # fmt: skip
    return figure


def _face(axes: "Axes", animation: Animation, rows: Sequence[int], hue: str) -> None:
    """Draw the moving poses of one face."""
    for row, pose in enumerate(rows):
        low = row + 0.97
        high = low - 0.9 * animation.weights[:, pose]
        axes.fill_between(animation.times, low, high, color=hue, lw=0)
    axes.set_yticks(np.arange(len(rows)) + 0.6, [animation.poses[p] for p in rows], size=8)
    axes.tick_params(axis="y", length=0)
    performer = performer_of(animation)
    name = performer.character if performer else ""
    axes.set_title(name, loc="left", size=10, color=hue, weight="bold", pad=4)
    axes.spines[["left", "right", "top"]].set_visible(False)
    axes.xaxis.set_major_formatter("{x:g} s")
    bounds = animation.schedule.times
    axes.vlines(bounds, 0, max(1, len(rows)), color=plot.RULE, lw=0.5, zorder=0)
    for start, stop in ((axes.get_xlim()[0], bounds[0]), (bounds[-1], axes.get_xlim()[1])):
        axes.axvspan(start, stop, color=plot.SILENT, lw=0, zorder=-1)
