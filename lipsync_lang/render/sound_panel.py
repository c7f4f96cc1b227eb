"""Sound panel of a plot: waveform, spectrogram, boundaries, and doubtful words.

The spectrogram is of the wide-band kind, which shows bursts and closures sharply: the boundary of a
stop that an aligner has found can be judged by eye.
"""

from typing import TYPE_CHECKING, Any, NamedTuple, Self

import numpy as np

from lipsync_lang.arrays import Floats
from lipsync_lang.render.view import SOUND, SPECTRUM

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from lipsync_lang.render.view import View
    from lipsync_lang.schedules.schedule import Audio

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
    def of(cls, audio: "Audio", begin: float, end: float, columns_per_second: float) -> Self:
        """Analyse a sound from `begin` to `end` seconds, or up to its end."""
        rate = audio.rate
        start, end = max(0.0, begin), min(end, audio.seconds)
        step = 1 / columns_per_second
        columns = max(0, int((end - start) / step))
        width = max(8, int(PANEL_WINDOW_SECONDS * rate))
        first = int(start * rate)
        part = audio.samples[max(0, first - width) : int(end * rate) + width] / 2.0**15
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
    loudest = max(
        1.0, *np.abs([audio.samples.min(initial=0), audio.samples.max(initial=0)], dtype=float)
    )
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
