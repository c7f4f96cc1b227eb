"""Plot of a line: the spoken text and the curve of each pose through the stages (figures 6 to 10).

The sound with its spectrogram, the words and the phonemes run along the time axis, above a row per
moving pose. A row shows the bigrams, the stitched curve and the final one. Shades mark the changes
of the stages in between: additions lie under the final curve, removals above it.

Units: x is seconds; y is inches from the top of a strip, the scale of a printed page.
"""

import math
import warnings
from collections.abc import Iterator
from itertools import pairwise
from textwrap import shorten
from typing import TYPE_CHECKING, Any, BinaryIO, NamedTuple, Self

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.extras import needing
from lipsync_lang.performing.performer import PerformedLine
from lipsync_lang.performing.trace import STAGE_WORDS
from lipsync_lang.pipeline.motion import PRESETS, Motion
from lipsync_lang.pipeline.perform import Stage
from lipsync_lang.render.fonts import quiet_fonts, with_fonts
from lipsync_lang.schedules.schedule import DOUBTFUL, Audio, Schedule

if TYPE_CHECKING:
    from collections.abc import Callable

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HIGHEST_HERTZ = 5_500.0
"""Highest frequency of the picture; lips and tongue show below it."""

PANEL_WINDOW_SECONDS = 0.008
RANGE_DECIBELS = 55.0
"""Range from black to white."""

POINTS = 512
PIXELS_PER_INCH = 100
PRE_EMPHASIS = 0.97

SOUND_INK = "#777777"
PHONEME_EDGES: dict[str, Any] = {"color": "#0072b2", "lw": 0.7, "zorder": 2}
WORD_EDGES: dict[str, Any] = PHONEME_EDGES | {"lw": 1.6}
"""Phoneme and word boundaries."""

IN_DOUBT: dict[str, Any] = {
    "facecolor": "#fbe0d0", "edgecolor": "#e9a583", "hatch": "////", "lw": 0, "zorder": 0.4,
}  # fmt: skip
"""Background of a doubtful word; the hatch shows it without colour, too."""

DOUBT_INK = "#d55e00"

STRIP, SHOWN = 6.5, 60.0
"""Seconds: length of a strip, after which a line wraps, and maximum length of the plot."""

WIDTH, HEAD, AXIS, FOOT, LEFT, RIGHT = 15.0, 0.9, 0.5, 0.1, 0.15, 0.25
SOUND, SPECTRUM, LANE, GAP, APART = 0.45, 1.1, 0.18, 0.15, 0.04
ROW, LOW_ROW, ALL_ROWS = 0.8, 0.3, 80.0
"""Inches: page and margins; bands; a row, and its minimum height on a full page."""

COLUMNS_PER_INCH = 100.0
"""Columns of the spectrogram."""

LANES = 3
"""Number of text lanes for the crowded labels of a band."""

VISIBLE_WEIGHT = 5e-3
"""Weight threshold for resting poses and for invisible changes of a stage."""

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

STAGES = {name: (one["label"], one["colour"]) for name, one in STAGE_WORDS.items()}
"""Labels and colours of the stages (tints of Okabe and Ito's colour-blind safe palette)."""

FINAL, INK = "black", "#333333"
RULE, SILENT, OUTSIDE = "#c4c4c4", "#f5f5f5", "#e6e6e6"
STITCHED: dict[str, Any] = {"lw": 1.0, "ls": (0, (1, 1))}
THIN: dict[str, Any] = {"color": RULE, "lw": 0.6, "zorder": 0.5}
GATE: dict[str, Any] = {"facecolor": "none", "edgecolor": "#b8408a", "lw": 1.2, "zorder": 4.5}
"""Style of the box that shows the limits of a pose during a contact."""


class Spectrogram(NamedTuple):
    """Loudness over time and frequency, in the wide-band kind.

    That shows bursts and closures sharply: the boundary of a stop that an aligner has found can be
    judged by eye.
    """

    image: Floats
    """(rows, columns) from 0 to 1; the lowest frequency is first."""
    start: float
    """Seconds at the left edge."""
    step: float
    """Duration of a column in seconds."""
    highest: float
    """Hertz at the upper edge."""

    @classmethod
    def of(cls, audio: Audio, begin: float, end: float, columns_per_second: float) -> Self:
        """Analyse a sound from `begin` to `end` seconds, or up to its end."""
        rate = audio.rate
        start, end = max(0.0, begin), min(end, audio.seconds)
        step = 1 / columns_per_second
        columns = max(0, int((end - start) / step))
        width = max(8, int(PANEL_WINDOW_SECONDS * rate))
        first = int(start * rate)
        part = audio.samples[max(0, first - width) : int(end * rate) + width] / 2.0**15
        # Voices lose some 6 dB per octave; without this, fricatives would not show.
        sound = np.append(part[:1], part[1:] - PRE_EMPHASIS * part[:-1])
        sound = np.pad(sound, (max(0, width - first), 2 * width))
        middles = ((np.arange(columns) + 0.5) * step * rate).astype(np.intp) + width
        frames = sound[middles[:, None] - width // 2 + np.arange(width)] * np.hanning(width)
        size = max(POINTS, 1 << (width - 1).bit_length())
        power = np.abs(np.fft.rfft(frames, size)) ** 2
        highest = min(HIGHEST_HERTZ, rate / 2)
        rows = int(highest / rate * size) + 1
        loud = 10 * np.log10(power[:, :rows].T + 1e-12)
        top = float(loud.max(initial=-120.0 + RANGE_DECIBELS))
        image = np.clip((loud - top) / RANGE_DECIBELS + 1, 0, 1)
        return cls(image, start, step, highest)


def draw_waveform(axes: "Axes", view: "View") -> None:
    """Draw the minimum and maximum of the sound per column of pixels."""
    audio = view.animation.schedule.audio
    if audio is None:
        return
    start, stop = (int(t * audio.rate) for t in np.clip(axes.get_xlim(), 0, audio.seconds))
    step = max(1, round(audio.rate / (view.scale * PIXELS_PER_INCH)))
    count = (stop - start) // step
    extremes = [audio.samples.min(initial=0), audio.samples.max(initial=0)]
    loudest = max(1.0, *np.abs(extremes, dtype=float))
    columns = audio.samples[start : start + count * step].reshape(count, step) / loudest
    if count:
        times = (start + np.arange(count) * step) / audio.rate
        low, high = (SOUND * (0.5 - 0.45 * take(columns, axis=1)) for take in (np.min, np.max))
        axes.fill_between(times, low, high, color=SOUND_INK, lw=0.4)


def draw_spectrogram(axes: "Axes", view: "View") -> None:
    """Draw the strip's part of the spectrogram, and the boundaries on it."""
    found, schedule = view.spectrogram, view.animation.schedule
    if found is None:
        return
    first, stop = (
        int(np.clip(round((at - found.start) / found.step), 0, found.image.shape[1]))
        for at in axes.get_xlim()
    )
    bottom = SOUND + SPECTRUM
    if stop > first:
        left, right = (found.start + n * found.step for n in (first, stop))
        axes.imshow(
            found.image[:, first:stop], extent=(left, right, bottom, SOUND), origin="lower",
            aspect="auto", cmap="Greys", vmin=0, vmax=1, interpolation="bilinear", zorder=1,
        )  # fmt: skip
    edges = [schedule.times[n] for word in schedule.words for n in (word.first, word.stop)]
    axes.vlines(schedule.times, SOUND, bottom, **PHONEME_EDGES)
    axes.vlines(np.unique(edges), 0, bottom, **WORD_EDGES)


def draw_doubts(axes: "Axes", view: "View") -> None:
    """Hatch the doubtful words, from the waveform down to their text."""
    band = view.bands[0]
    for start, end in view.doubts:
        axes.fill_between((start, end), band.top, band.bottom, **IN_DOUBT)
        axes.hlines(band.bottom - 0.02, start, end, color=DOUBT_INK, lw=3, zorder=2)


class Band(NamedTuple):
    """Labels along the time axis, in several lanes if crowded."""

    name: str
    texts: list[str]
    spans: Floats
    """(n, 2) seconds."""
    lanes: list[int]
    size: float
    top: float
    bottom: float


class View:
    """Contents and layout of a plot, before any drawing."""

    def __init__(self, animation: Animation, line: PerformedLine) -> None:
        """Run the stages on the visible part of the line."""
        self.animation = animation
        self.performer = line.performer
        self.performance = line.performance(animation)
        self.begin = float(animation.times[0])
        self.end = min(float(animation.times[-1]), self.begin + SHOWN)
        self.end = max(self.end, self.begin + 1 / animation.fps)
        self.strips = math.ceil((self.end - self.begin) / STRIP)
        self.left = 0.5 + max(text_width(name, 10) for name in (*animation.poses, "phonemes"))
        self.scale = (WIDTH - self.left - RIGHT) * self.strips / (self.end - self.begin)
        """Inches per second."""
        frames = self.performance.frames
        times = frames.times()
        self.times = times[times < self.end + 1 / frames.fps]
        # Stages look ahead, so frames beyond the picture change its last ones.
        stop = min(frames.count, len(self.times) + self.performance.halo())
        stages = self.performance.stages(0, frames.count if self.performance.far else stop)
        self.stages = [Stage(name, curves[:, : len(self.times)]) for name, curves in stages]
        tops = np.max([stage.curves.max(axis=1) for stage in self.stages], axis=0)
        self.moving = np.flatnonzero(tops > VISIBLE_WEIGHT)
        self.resting = [animation.poses[i] for i in np.flatnonzero(tops <= VISIBLE_WEIGHT)]
        self.gates = list(_gates(self))
        self.bands = _bands(self)
        audio, columns = animation.schedule.audio, self.scale * COLUMNS_PER_INCH
        self.spectrogram = (
            None if audio is None else Spectrogram.of(audio, self.begin, self.end, columns)
        )
        bounds = animation.schedule.times
        self.doubts = [
            (float(bounds[word.first]), float(bounds[word.stop]))
            for word in animation.schedule.words
            if word.confidence is not None and word.confidence < DOUBTFUL
        ]
        """Start and end of each word with low confidence."""
        self.row = float(np.clip(ALL_ROWS / self.strips / max(1, len(self.moving)), LOW_ROW, ROW))
        first = self.bands[-1].bottom + GAP
        self.tops = first + np.arange(len(self.moving)) * (self.row + GAP)
        self.height = first + len(self.moving) * (self.row + GAP)

    def y(self, row: int, weights: Floats | float) -> Any:
        """Map weights to heights in a pose's row."""
        return self.tops[row] + self.row * (1 - weights)


def _gates(view: View) -> Iterator[tuple[int, float, float, float, float]]:
    """Yield the contact limits of poses: row, start and end (s), minimum and maximum weight."""
    performance = view.performance
    if performance.motion.contacts != "hold":
        return
    half = 0.5 / performance.frames.fps
    for contact, (_, frames) in zip(performance.tables.contacts, performance.held, strict=True):
        change = np.flatnonzero(np.diff(frames[: len(view.times)], prepend=False, append=False))
        for first, stop in change.reshape(-1, 2).tolist():
            for row, pose in enumerate(view.moving):
                least, greatest = float(contact.floor[pose]), float(contact.ceiling[pose])
                if (least, greatest) != (0, 1):
                    start, end = view.times[first] - half, view.times[stop - 1] + half
                    yield row, start, end, least, greatest


def _bands(view: View) -> list[Band]:
    """Lay out the words, the spoken phonemes and the common phonemes."""
    schedule, track = view.animation.schedule, view.performance.track
    names = view.performer.compiled.phonemes
    spoken, common = (np.column_stack([b[:-1], b[1:]]) for b in (schedule.times, track.bounds))
    words = [(spoken[word.first, 0], spoken[word.stop - 1, 1]) for word in schedule.words]
    rows = [
        ("words", [word.text for word in schedule.words], np.array(words).reshape(-1, 2), 10.0),
        ("phonemes", schedule.labels, spoken, 9.0),
        ("common", [names[number] for number in track.ids], common, 8.0),
    ]
    bands: list[Band] = []
    top = SOUND + SPECTRUM if schedule.audio else 0.0
    for name, texts, times, size in rows[0 if words else 1 :]:
        spans = times.clip(view.begin, view.end)
        shown = np.flatnonzero(spans[:, 0] < spans[:, 1])
        labels, spans = [" ".join(texts[i].split()) for i in shown.tolist()], spans[shown]
        # Each label has the first lane with room for it.
        ends = [-math.inf] * LANES
        lanes: list[int] = []
        for label, middle in zip(labels, spans.mean(axis=1).tolist(), strict=True):
            half = (text_width(label, size) + APART) / view.scale / 2
            room = (lane for lane in range(LANES) if ends[lane] <= middle - half)
            lanes.append(next(room, ends.index(min(ends))))
            ends[lanes[-1]] = middle + half
        bottom = top + LANE * (max(lanes, default=0) + 1.15)
        bands.append(Band(name, labels, spans, lanes, size, top, bottom))
        top = bottom
    return bands


def text_width(text: str, size: float) -> float:
    """Measure the width of a text in inches, for a font size in points."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    font = FontProperties(size=size)
    return float(text_to_path.get_text_width_height_descent(text, font, ismath=False)[0]) / 72


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
    with needing(OutputError, "a picture needs matplotlib:", "plot"):
        import matplotlib as mpl  # noqa: F401 loaded modules may hide that it is missing
        from matplotlib import style
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
    usual = vars(Motion())
    settings = [f"{name} {one}" for name, one in vars(motion).items() if one != usual[name]]
    if settings:
        parts.append(f"motion: {', '.join(named or settings)}")
    if animation.schedule.estimated:
        parts.append("times are estimated")
    if view.end < animation.times[-1]:
        parts.append(f"the first {SHOWN:g} s of {animation.times[-1] - view.begin:.1f} s")
    if view.resting:
        parts.append(f"at rest: {shorten(', '.join(view.resting), TITLE_CHARS, placeholder=' …')}")
    title, subtitle = title_of(animation.schedule), "   ·   ".join(parts)
    left = LEFT / WIDTH
    height = HEAD + view.strips * (view.height + AXIS) + FOOT
    figure = Figure(figsize=(WIDTH, height))
    figure.text(left, 1 - 0.12 / height, title, size=13, weight="bold", va="top")
    figure.text(left, 1 - 0.4 / height, subtitle, size=10, color=INK, va="top")
    _legend(figure, view, 1 - 0.64 / height)
    edges = np.linspace(view.begin, view.end, view.strips + 1).tolist()
    for number, limits in enumerate(pairwise(edges)):
        bottom = height - HEAD - (number + 1) * view.height - number * AXIS
        place = (view.left / WIDTH, bottom / height)
        size = (1 - (view.left + RIGHT) / WIDTH, view.height / height)
        axes = figure.add_axes((*place, *size), xlim=limits, ylim=(view.height, 0))
        for draw in (
            _scales, _grounds, draw_doubts, draw_waveform, draw_spectrogram,
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
        entries["boundaries"] = Line2D([], [], **PHONEME_EDGES)
    if view.doubts:
        entries["word in doubt"] = Patch(**IN_DOUBT)
    figure.legend(
        list(entries.values()), list(entries), ncols=len(entries), loc="upper left",
        bbox_to_anchor=(LEFT / WIDTH, top), frameon=False, borderpad=0,
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
        names += [("sound", SOUND / 2), ("spectrum", SOUND + SPECTRUM / 2)]
        highest = f"{view.spectrogram.highest / 1000:g}k"
        ends += [(SOUND + SPECTRUM, "0"), (SOUND, highest)]
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
                at = band.top + (lane + 0.575) * LANE
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
                if curve.max() > VISIBLE_WEIGHT:
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
            changed = np.abs(new - old) > VISIBLE_WEIGHT
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
