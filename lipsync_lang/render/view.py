"""Layout of the plot of a line, computed before any drawing, and the sound panel of the plot.

Units: x is seconds; y is inches from the top of a strip, the scale of a printed page.

The sound panel has the waveform, a spectrogram, boundaries, and doubtful words. The spectrogram is
of the wide-band kind, which shows bursts and closures sharply: the boundary of a stop that an
aligner has found can be judged by eye.
"""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Floats
from lipsync_lang.performing.performer import PerformedLine
from lipsync_lang.pipeline.perform import Stage
from lipsync_lang.schedules.schedule import DOUBTFUL, Audio

if TYPE_CHECKING:
    from matplotlib.axes import Axes

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


class Spectrogram(NamedTuple):
    """Loudness over time and frequency."""

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
    low, high = axes.get_xlim()
    first, stop = (
        int(np.clip(round((at - found.start) / found.step), 0, found.image.shape[1]))
        for at in (low, high)
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
