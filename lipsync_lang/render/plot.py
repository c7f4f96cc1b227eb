"""Plot of a line: the spoken text and the curve of each pose through the stages (figures 6 to 10).

The sound with its spectrogram, the words and the phonemes run along the time axis, above a row per
moving pose. A row shows the bigrams, the stitched curve and the final one. Shades mark the changes
of the stages in between: additions lie under the final curve, removals above it.

Units: x is seconds; y is inches from the top of a strip, the scale of a printed page.
"""

import warnings
from dataclasses import fields
from itertools import pairwise
from textwrap import shorten
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.extras import install_line
from lipsync_lang.performing.performer import PerformedLine
from lipsync_lang.pipeline.motion import PRESETS, Motion
from lipsync_lang.pipeline.perform import Stage
from lipsync_lang.render import view as layout
from lipsync_lang.render.fonts import quiet_fonts, with_fonts
from lipsync_lang.render.view import View
from lipsync_lang.schedules.schedule import Schedule

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


PLOT_FORMATS: dict[str, dict[str, Any] | None] = dict.fromkeys(("png", "svg", "pdf", "jpg", "webp"))
PLOT_FORMATS |= {"svg": {"Date": None}, "pdf": {"CreationDate": None}}
"""File formats, with the metadata that leaves out the date of each file."""

RC = {
    "font.size": 9,
    "text.parse_math": False,  # a word may hold a dollar sign
    "svg.fonttype": "none",
    "svg.hashsalt": "lipsync-lang",
    "pdf.fonttype": 42,
}
"""Differences from matplotlib's defaults; user settings are ignored for reproducible files."""

DPI = 100
TITLE_CHARS = 130  # maximum characters of a line in the title
THINNED = 4  # stride through the tabulated steps of a bigram, for small files

BIGRAMS = (("#d3e7f6", "#6ba6d3"), ("#f3e8c8", "#c2a54d"))
"""Fill and edge colours of alternate bigrams."""

STAGES = {
    "stitch": ("stitched", "#444444"),
    "overlay": ("own words", "#c9b458"),
    "dial": ("dialled", "#9c8fc9"),
    "smooth": ("smoothed", "#66c4ab"),
    "switch": ("one at a time", "#a9a38a"),
    "anticipate": ("anticipated", "#d8c15a"),
    "ease": ("eased", "#c3d7a4"),
    "bend": ("bent", "#3f7f6f"),
    "rest": ("brought to rest", "#b9b9b9"),
    "hold": ("contacts held", "#dca2c2"),
    "limit": ("speed limited", "#5fa4cf"),
    "constrain": ("constrained", "#e88f55"),
    "soften": ("softened", "#8fc9c9"),
}
"""Labels and colours of the stages (tints of Okabe and Ito's colour-blind safe palette)."""

FINAL, INK = "black", "#333333"
RULE, SILENT, OUTSIDE = "#c4c4c4", "#f5f5f5", "#e6e6e6"
STITCHED: dict[str, Any] = {"lw": 1.0, "ls": (0, (1, 1))}
THIN: dict[str, Any] = {"color": RULE, "lw": 0.6, "zorder": 0.5}
GATE: dict[str, Any] = {"facecolor": "none", "edgecolor": "#b8408a", "lw": 1.2, "zorder": 4.5}
"""Style of the box that shows the limits of a pose during a contact."""


def plot(animation: Animation, stream: BinaryIO, format: str = "png") -> None:  # noqa: A002
    """Draw an animation of a performer with its stages, in one of `PLOT_FORMATS`, in any case."""
    line = PerformedLine.of(animation)
    if line is None:
        what = "an animation without a performer has no stages; perform its schedule to draw it"
        raise OutputError(what)
    draw(lambda: _page(View(animation, line)), stream, format)


def draw(page: "Callable[[], Figure]", stream: BinaryIO, format: str) -> None:  # noqa: A002
    """Make a figure and write it, independent of the user's matplotlib settings."""
    name = format.lower()
    if name not in PLOT_FORMATS:
        what = f"no picture format '{format}'" if format else "the picture's name has no suffix"
        raise OutputError(f"{what}; known: {', '.join(PLOT_FORMATS)}")
    try:
        import matplotlib as mpl  # noqa: F401 loaded modules may hide that it is missing
        from matplotlib import style
    except ImportError:
        raise OutputError(f"a picture needs matplotlib: {install_line('plot')}") from None
    with warnings.catch_warnings(), style.context(RC, after_reset=True), quiet_fonts():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        warnings.filterwarnings("ignore", message="Matplotlib currently does not support")
        with_fonts(page).savefig(stream, format=name, dpi=DPI, metadata=PLOT_FORMATS[name])


def title_of(schedule: Schedule) -> str:
    """Return the spoken text, or the phonemes, in one line."""
    texts = [word.text for word in schedule.words] or schedule.labels
    return shorten(" ".join(texts), TITLE_CHARS, placeholder=" …")


def _page(view: View) -> "Figure":
    from matplotlib.figure import Figure

    animation, motion = view.animation, view.performance.motion
    parts = [view.performer.language, view.performer.character, f"{animation.fps:g} fps"]
    named = [name for name, preset in PRESETS.items() if preset == motion != Motion()]
    names = [field.name for field in fields(Motion)]
    changed = [name for name in names if getattr(motion, name) != getattr(Motion(), name)]
    settings = [f"{name} {getattr(motion, name)}" for name in changed]
    if settings:
        parts.append(f"motion: {', '.join(named or settings)}")
    if animation.schedule.estimated:
        parts.append("times are estimated")
    if view.end < animation.times[-1]:
        parts.append(f"the first {layout.SHOWN:g} s of {animation.times[-1] - view.begin:.1f} s")
    if view.resting:
        parts.append(f"at rest: {shorten(', '.join(view.resting), TITLE_CHARS, placeholder=' …')}")
    title, subtitle = title_of(animation.schedule), "   ·   ".join(parts)
    left = layout.LEFT / layout.WIDTH
    height = layout.HEAD + view.strips * (view.height + layout.AXIS) + layout.FOOT
    figure = Figure(figsize=(layout.WIDTH, height))
    figure.text(left, 1 - 0.12 / height, title, size=13, weight="bold", va="top")
    figure.text(left, 1 - 0.4 / height, subtitle, size=10, color=INK, va="top")
    _legend(figure, view, 1 - 0.64 / height)
    edges = np.linspace(view.begin, view.end, view.strips + 1).tolist()
    for number, limits in enumerate(pairwise(edges)):
        bottom = height - layout.HEAD - (number + 1) * view.height - number * layout.AXIS
        place = (view.left / layout.WIDTH, bottom / height)
        size = (1 - (view.left + layout.RIGHT) / layout.WIDTH, view.height / height)
        axes = figure.add_axes((*place, *size), xlim=limits, ylim=(view.height, 0))
        for draw in (
            _scales, _grounds, layout.draw_doubts, layout.draw_waveform, layout.draw_spectrogram,
            _labels, _bigrams, _curves,
        ):  # fmt: skip
            draw(axes, view)
    return figure


def _legend(figure: "Figure", view: View, top: float) -> None:
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    (first, ink), *rest = [_look(stage) for stage in view.stages]
    entries: dict[str, Any] = {
        "bigrams": tuple(Patch(facecolor=fill, edgecolor=edge) for fill, edge in BIGRAMS),
        first: Line2D([], [], color=ink, **STITCHED),
        **{name: Patch(facecolor=colour) for name, colour in rest},
        "final": Line2D([], [], color=FINAL, lw=2),
    }
    if view.gates:
        entries["bounds of a contact"] = Patch(**GATE)
    if view.spectrogram is not None:
        entries["boundaries"] = Line2D([], [], **layout.PHONEME_EDGES)
    if view.doubts:
        entries["word in doubt"] = Patch(**layout.IN_DOUBT)
    figure.legend(
        list(entries.values()), list(entries), ncols=len(entries), loc="upper left",
        bbox_to_anchor=(layout.LEFT / layout.WIDTH, top), frameon=False, borderpad=0,
        borderaxespad=0, fontsize=8.5, columnspacing=1.1, handlelength=1.6, handletextpad=0.5,
        handler_map={tuple: HandlerTuple(ndivide=None, pad=0)},
    )  # fmt: skip


def _look(stage: Stage) -> tuple[str, str]:
    return STAGES.get(stage.name, (stage.name, INK))


def _scales(axes: "Axes", view: View) -> None:
    """Label bands and poses at the left, draw lines at 0 and 1, and mark seconds below."""
    from matplotlib.ticker import AutoMinorLocator, FormatStrFormatter, MaxNLocator

    names = [(band.name, (band.top + band.bottom) / 2) for band in view.bands]
    names += [(view.animation.poses[p], view.y(row, 0.5)) for row, p in enumerate(view.moving)]
    ends = [(view.y(row, end), f"{end}") for row in range(len(view.moving)) for end in (0, 1)]
    if view.spectrogram is not None:
        names += [("sound", layout.SOUND / 2), ("spectrum", layout.SOUND + layout.SPECTRUM / 2)]
        highest = f"{view.spectrogram.highest / 1000:g}k"
        ends += [(layout.SOUND + layout.SPECTRUM, "0"), (layout.SOUND, highest)]
    axes.set_yticks([at for _, at in names], [name for name, _ in names], size=10)
    axes.tick_params(axis="y", length=0, pad=22)
    axes.set_yticks([at for at, _ in ends], [end for _, end in ends], minor=True, size=7)
    for row in range(len(view.moving)):
        axes.axhline(view.y(row, 0), **THIN | {"color": INK})
        axes.axhline(view.y(row, 1), **THIN)
    axes.xaxis.set_major_locator(MaxNLocator(14, steps=[1, 2, 5, 10]))
    axes.xaxis.set_minor_locator(AutoMinorLocator())
    axes.xaxis.set_major_formatter(FormatStrFormatter("%g s"))
    axes.spines[["left", "right", "top"]].set_visible(False)


def _grounds(axes: "Axes", view: View) -> None:
    """Shade silence and the time outside the schedule, and draw the phoneme boundaries."""
    schedule, track = view.animation.schedule, view.performance.track
    silent = np.flatnonzero(track.ids == view.performance.tables.silence)
    spans = [(track.bounds[i], track.bounds[i + 1], SILENT) for i in silent]
    spans += [(view.begin, schedule.start, OUTSIDE), (schedule.end, view.end, OUTSIDE)]
    for start, end, colour in spans:
        if start < end:
            axes.axvspan(start, end, color=colour, lw=0, zorder=0)
    axes.vlines(track.bounds, view.bands[-1].bottom, view.height, **THIN)


def _labels(axes: "Axes", view: View) -> None:
    """Draw each label at the middle of its span, in its strip."""
    low, high = axes.get_xlim()
    for band in view.bands:
        axes.axhline(band.bottom, **THIN)
        axes.vlines(np.unique(band.spans), band.top, band.bottom, **THIN)
        middles = band.spans.mean(axis=1).tolist()
        for text, middle, lane in zip(band.texts, middles, band.lanes, strict=True):
            if low <= middle < high:
                at = band.top + (lane + 0.575) * layout.LANE
                axes.text(middle, at, text, size=band.size, ha="center", va="center")


def _bigrams(axes: "Axes", view: View) -> None:
    """Draw each bigram's own curve over its span, in alternate colours."""
    from matplotlib.collections import LineCollection, PolyCollection

    low, high = axes.get_xlim()
    lines: list[list[Floats]] = [[] for _ in BIGRAMS]
    for i in range(len(view.performance.track.rows)):
        times, curves = view.performance.bigram(i, THINNED)
        if times[0] < high and times[-1] > low:
            for row, pose in enumerate(view.moving):
                curve = curves[:, pose]
                if curve.max() > layout.VISIBLE_WEIGHT:
                    line = np.column_stack([times, view.y(row, curve)])
                    feet = [(at, view.y(row, 0)) for at in (times[0], times[-1])]
                    lines[i % len(BIGRAMS)].append(np.vstack([feet[:1], line, feet[1:]]))
    for shapes, (fill, edge) in zip(lines, BIGRAMS, strict=True):
        axes.add_collection(PolyCollection(shapes, facecolor=fill, lw=0, alpha=0.7, zorder=2))
        axes.add_collection(LineCollection(shapes, color=edge, lw=0.7, zorder=2.5))


def _curves(axes: "Axes", view: View) -> None:
    """Shade what each stage changes; draw contacts, the stitched curve and the final one."""
    stitched = _near(axes, view.times)
    shown = view.times[stitched]
    for before, after in pairwise(view.stages):
        colour = _look(after)[1]
        for row, pose in enumerate(view.moving):
            old, new = before.curves[pose, stitched], after.curves[pose, stitched]
            changed = np.abs(new - old) > layout.VISIBLE_WEIGHT
            if changed.any():
                changed = np.convolve(changed, np.ones(3))[1:-1] > 0  # to where the curves meet
                lines = (shown, view.y(row, old), view.y(row, new))
                axes.fill_between(*lines, where=changed, color=colour, lw=0, zorder=3)
    low, high = axes.get_xlim()
    for row, start, end, least, greatest in view.gates:
        if start < high and end > low:
            axes.fill_between((start, end), view.y(row, least), view.y(row, greatest), **GATE)
    first, times = view.stages[0], view.animation.times
    final = _near(axes, times)
    for row, pose in enumerate(view.moving):
        curve = view.y(row, first.curves[pose, stitched])
        axes.plot(shown, curve, color=_look(first)[1], zorder=4, **STITCHED)
        curve = view.y(row, view.animation.weights[final, pose])
        axes.plot(times[final], curve, color=FINAL, lw=1.9, zorder=5)


def _near(axes: "Axes", times: Floats) -> Bools:
    """Select the frames of a strip and their direct neighbours."""
    low, high = axes.get_xlim()
    step = times[1] - times[0] if len(times) > 1 else 0.0
    return (times >= low - step) & (times <= high + step)
