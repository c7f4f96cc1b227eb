"""What a sound is compared by: mel spectra, which frames of them are speech, and cepstra.

A recording and a voice differ in speaker, room and noise. The voice is made more alike before
they are compared: its bands take the level of the recording's, and its noise is added.

Frames are `HOP` seconds apart and centred on their time: frame k lies at ``k * HOP``.
"""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.errors import SpeechError

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Audio

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]

RATE = 16_000
HOP = 0.01
WINDOW = 0.025
BANDS, CEPSTRA = 40, 10
LOWEST, HIGHEST = 60.0, 7600.0
"""Hertz; the bands between are even in mel."""

RANGE = 35.0
"""Decibels below speech at which everything is silence."""

QUIET = 10
"""Per cent of the frames that are taken for what is heard while nobody speaks."""

SPOKEN = 0.25
"""Where speech begins between the quiet frames and the loud."""

LEAST = 2.0
"""Decibels between the two; below it there is no speech."""

_EMPHASIS = 0.97
_POINTS = 512
_BLOCK = 4096
_AROUND = 2
_TINY = 1e-10


class SpeechSpectrum(NamedTuple):
    """A recording, and what is speech in it."""

    power: Floats
    """(T, BANDS)"""
    noise: Floats
    """(BANDS,) power while nobody speaks."""
    floor: Floats
    """(BANDS,) power of silence: the noise, or `RANGE` below speech."""
    spoken: Bools
    """(T,)"""


def samples_of(audio: "Audio") -> Floats:
    """Return a sound at `RATE`, about zero, within 1 of it."""
    from lipsync_lang.speech.sound import resampled

    sound: Floats = resampled(audio, RATE).samples / 2.0**15
    sound -= sound.mean()
    return sound


def mel_power(samples: Floats, hop: float = HOP, tract: float = 1.0) -> Floats:
    """Return the power in bands: (T, BANDS).

    Parameters
    ----------
    samples : (n,) at `RATE`
    hop : seconds between frames
    tract : how much longer the bands take the speaker's vocal tract to be
    """
    width = int(WINDOW * RATE)
    sound = np.append(samples[:1], samples[1:] - _EMPHASIS * samples[:-1])
    sound = np.pad(sound, (width // 2, width))
    starts = (np.arange(int(len(samples) / RATE / hop) + 1) * hop * RATE).astype(np.intp)
    bank = _bank(tract)
    window, steps = np.hanning(width), np.arange(width)
    out = np.empty((len(starts), BANDS))
    for low in range(0, len(starts), _BLOCK):
        frames = sound[starts[low : low + _BLOCK, None] + steps] * window
        out[low : low + _BLOCK] = np.abs(np.fft.rfft(frames, _POINTS)) ** 2 @ bank
    return out


def _bank(tract: float) -> Floats:
    """Return the share of each band in each bin of the spectrum: (bins, BANDS)."""
    mels = np.linspace(_mel(LOWEST), _mel(HIGHEST), BANDS + 2)
    edges = 700 * (10 ** (mels / 2595) - 1) * tract
    bins = np.arange(_POINTS // 2 + 1)[:, None] * RATE / _POINTS
    low, middle, high = edges[:-2], edges[1:-1], edges[2:]
    rising, falling = (bins - low) / (middle - low), (high - bins) / (high - middle)
    return np.maximum(0, np.minimum(rising, falling))


def _mel(hertz: float) -> float:
    return float(2595 * np.log10(1 + hertz / 700))


def listen(samples: Floats) -> SpeechSpectrum:
    """Find the speech in a recording.

    Raises
    ------
    SpeechError
        There is none.
    """
    power = mel_power(samples)
    loudness = _smooth(power.sum(axis=1))
    noise = power[loudness <= np.percentile(loudness, QUIET)].mean(axis=0)
    loud = power[loudness >= np.percentile(loudness, 100 - QUIET)].mean(axis=0)
    floor = np.maximum(np.maximum(noise, loud * 10 ** (-RANGE / 10)), _TINY)
    above = _smooth(10 * np.log10((power + floor) / floor).mean(axis=1))
    quiet, top = np.percentile(above, QUIET), np.percentile(above, 100 - QUIET / 2)
    if top - quiet < LEAST:
        raise SpeechError(
            "the recording has no speech that stands out from what else is heard; "
            "give one that is louder, or with less noise"
        )
    return SpeechSpectrum(power, noise, floor, above > quiet + SPOKEN * (top - quiet))


def _smooth(values: Floats) -> Floats:
    """Return the mean over five frames."""
    return np.convolve(np.pad(values, 2, mode="edge"), np.full(5, 0.2), "valid")


def alike(heard: SpeechSpectrum, voice: Floats, sounding: Bools) -> tuple[Floats, Floats]:
    """Make a voice sound as if recorded with the recording, and return what compares the two.

    Parameters
    ----------
    voice : (M, BANDS) its power
    sounding : (M,) where it is not silent

    Returns
    -------
    (T, D) of the recording and (M, D) of the voice, each number about 1 apart between frames
    """
    level = np.maximum(heard.power[heard.spoken].mean(axis=0) - heard.noise, 0.1 * heard.floor)
    level = level / (voice[sounding].mean(axis=0) + _TINY)
    recorded = cepstra(np.log(heard.power + heard.floor))
    spoken = cepstra(np.log(voice * level + heard.noise + heard.floor))
    mean = recorded[heard.spoken].mean(axis=0)
    spread = recorded[heard.spoken].std(axis=0) + 1e-3
    return (recorded - mean) / spread, (spoken - mean) / spread


def cepstra(log_power: Floats) -> Floats:
    """Return cepstra and how they change: (T, 2 * CEPSTRA)."""
    orders, middles = np.arange(CEPSTRA), np.arange(BANDS) + 0.5
    out = log_power @ np.cos(np.pi * np.outer(middles, orders) / BANDS)
    around = np.pad(out, ((_AROUND, _AROUND), (0, 0)), mode="edge")
    steps = range(1, _AROUND + 1)
    ahead = [around[_AROUND + n : _AROUND + n + len(out)] for n in steps]
    behind = [around[_AROUND - n : _AROUND - n + len(out)] for n in steps]
    change = sum(n * (a - b) for n, a, b in zip(steps, ahead, behind, strict=True))
    return np.hstack([out, change])
