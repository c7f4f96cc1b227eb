"""Acoustic features for alignment by warping: mel spectra, speech detection and cepstra.

Recording and synthetic voice differ in speaker, room and noise. Before comparison, the band
levels of the voice are matched to the recording, and the recording's noise is added to it.

Frames are `HOP` seconds apart and centred on their time: frame k is at ``k * HOP``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints, Singles
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules.schedule import Audio
from lipsync_lang.sound.speech.hearing.sphinx.features import (
    FFT_POINTS,
    PRE_EMPHASIS,
    mel_edges,
    triangles,
)
from lipsync_lang.sound.speech.sound import SPEECH_RATE, resampled

HOP = 0.01
WINDOW_SECONDS = 0.025
BANDS, CEPSTRA = 40, 10
LOWEST, HIGHEST = 60.0, 7600.0
"""Band limits in hertz; bands are evenly spaced in mel."""

SPEECH_RANGE_DB = 35.0
"""Silence floor in decibels below speech level."""

NOISE_PERCENTILE = 10
"""Percentile of frame power taken as background noise."""

SPEECH_THRESHOLD = 0.25
"""Speech threshold as a fraction of the range from noise level to speech level."""

MIN_RANGE_DB = 2.0
"""Minimum decibels from noise level to speech level; a smaller range means no speech."""

MIN_PAUSE_SECONDS = 0.2
"""Minimum pause in seconds; a shorter silence counts as a closure."""

MIN_ISLAND_SECONDS = 0.06
"""Minimum sound between two pauses in seconds; a shorter sound counts as a click."""

_BLOCK_FRAMES = 4096
_DERIVATIVE_FRAMES = 2
_TINY_POWER = 1e-10


@dataclass(frozen=True)
class SpeechSpectrum:
    """Mel spectrum of a recording with its speech detection."""

    power: Floats
    """Mel power, (T, BANDS)."""
    noise: Floats
    """(BANDS,) noise power."""
    floor: Floats
    """(BANDS,) silence power: the noise, or `SPEECH_RANGE_DB` below speech."""
    spoken: Bools
    """Speech mask, (T,)."""

    @cached_property
    def features(self) -> tuple[Floats, Floats, Floats]:
        """Features (T, D), their mean in speech (D,), and their deviation in speech (D,)."""
        features = cepstra(np.log(self.power + self.floor))
        said = features[self.spoken]
        return features, said.mean(axis=0), said.std(axis=0) + 1e-3


def samples_of(audio: Audio) -> Singles:
    """Convert a sound to `SPEECH_RATE`, zero mean and amplitudes within 1."""
    sound = resampled(audio, SPEECH_RATE).samples.astype(np.float32)
    sound -= sound.mean(dtype=np.float64)
    sound /= 2.0**15
    return sound


def mel_power(
    samples: Singles | Floats, hop: float = HOP, tracts: Sequence[float] = (1.0,)
) -> Floats:
    """Return the power in mel bands for each tract: (len(tracts), T, BANDS).

    Parameters
    ----------
    samples : (n,) at `SPEECH_RATE`
    hop : seconds between frames
    tracts : vocal tract lengths relative to the nominal one
    """
    width = int(WINDOW_SECONDS * SPEECH_RATE)
    # One sample more in front than half a window: pre-emphasis takes the one before each.
    sound = np.pad(samples, (width // 2 + 1, width))
    count = int(len(samples) / SPEECH_RATE / hop) + 1
    starts = (np.arange(count) * hop * SPEECH_RATE).astype(np.intp)
    # A longer vocal tract moves all formants by one factor, so the bands move with it.
    edges = mel_edges(LOWEST, HIGHEST, BANDS)
    banks = [triangles(edges * tract) for tract in tracts]
    window, steps = np.hanning(width), np.arange(width + 1)
    out = np.empty((len(tracts), len(starts), BANDS))
    # In blocks: an hour of frames at once would take gigabytes.
    for low in range(0, len(starts), _BLOCK_FRAMES):
        frames = sound[starts[low : low + _BLOCK_FRAMES, None] + steps].astype(np.float64)
        frames = (frames[:, 1:] - PRE_EMPHASIS * frames[:, :-1]) * window
        power = np.abs(np.fft.rfft(frames, FFT_POINTS)) ** 2
        for number, bank in enumerate(banks):
            out[number, low : low + _BLOCK_FRAMES] = power @ bank
    return out


def heard_in(power: Floats) -> SpeechSpectrum:
    """Detect the speech in a stretch of a recording by its levels alone; `power` is (T, BANDS).

    A stretch without speech is a `SpeechError`.
    """
    loudness = _smooth(power.sum(axis=1))
    noise = power[loudness <= np.percentile(loudness, NOISE_PERCENTILE)].mean(axis=0)
    loud = power[loudness >= np.percentile(loudness, 100 - NOISE_PERCENTILE)].mean(axis=0)
    # Digital silence has no noise at all; without this floor, its logarithm would outweigh speech.
    floor = np.maximum(np.maximum(noise, loud * 10 ** (-SPEECH_RANGE_DB / 10)), _TINY_POWER)
    above = _smooth(10 * np.log10((power + floor) / floor).mean(axis=1))
    quiet, top = np.percentile(above, (NOISE_PERCENTILE, 100 - NOISE_PERCENTILE / 2))
    if top - quiet < MIN_RANGE_DB:
        raise SpeechError(
            "the speech cannot be told apart from the other sounds; "
            "use a louder recording, or one with less noise"
        )
    return SpeechSpectrum(power, noise, floor, above > quiet + SPEECH_THRESHOLD * (top - quiet))


def _smooth(values: Floats) -> Floats:
    """Return the moving mean over five frames."""
    return np.convolve(np.pad(values, 2, mode="edge"), np.full(5, 0.2), "valid")


def alike(heard: SpeechSpectrum, voice: Floats, sounding: Bools) -> tuple[Floats, Floats]:
    """Match a voice to the recording's noise and band levels; return features of both.

    Parameters
    ----------
    voice : (M, BANDS) power
    sounding : (M,) mask of frames with sound

    Returns
    -------
    (T, D) of the recording and (M, D) of the voice, scaled to differences near 1 between frames
    """
    # The level of speech alone: power adds up, so noise is taken off before the voice is matched.
    level = np.maximum(heard.power[heard.spoken].mean(axis=0) - heard.noise, 0.1 * heard.floor)
    level = level / (voice[sounding].mean(axis=0) + _TINY_POWER)
    recorded, mean, spread = heard.features
    spoken = cepstra(np.log(voice * level + heard.noise + heard.floor))
    return (recorded - mean) / spread, (spoken - mean) / spread


def cepstra(log_power: Floats) -> Floats:
    """Return cepstra and their time derivatives: (T, 2 * CEPSTRA)."""
    orders, middles = np.arange(CEPSTRA), np.arange(BANDS) + 0.5
    # A cosine transform of the bands; the first coefficients have the shape of the mouth, and the
    # later ones the pitch.
    out = log_power @ np.cos(np.pi * np.outer(middles, orders) / BANDS)
    around = np.pad(out, ((_DERIVATIVE_FRAMES, _DERIVATIVE_FRAMES), (0, 0)), mode="edge")
    steps = range(1, _DERIVATIVE_FRAMES + 1)
    ahead = [around[_DERIVATIVE_FRAMES + n : _DERIVATIVE_FRAMES + n + len(out)] for n in steps]
    behind = [around[_DERIVATIVE_FRAMES - n : _DERIVATIVE_FRAMES - n + len(out)] for n in steps]
    # The slope of a line fitted to five frames, up to a factor, which scaling takes out later.
    change = sum(n * (a - b) for n, a, b in zip(steps, ahead, behind, strict=True))
    return np.hstack([out, change])


def speech_frames(spoken: Bools) -> Ints:
    """Return indices of the frames to compare: speech and short silences, without clicks."""
    kept = [run for run in runs(np.flatnonzero(spoken)) if len(run) * HOP >= MIN_ISLAND_SECONDS]
    return np.concatenate(kept) if kept else np.flatnonzero(spoken)


def runs(frames: Ints) -> list[Ints]:
    """Split frames into runs at pauses, with shorter silences filled."""
    cuts = np.flatnonzero(np.diff(frames) * HOP >= MIN_PAUSE_SECONDS) + 1
    return [np.arange(run[0], run[-1] + 1) for run in np.split(frames, cuts)]


def pooled(frames: Floats, step: int) -> Floats:
    """Return the mean of each group of `step` frames."""
    starts = np.arange(0, len(frames), step)
    counts = np.diff([*starts, len(frames)])
    return np.add.reduceat(frames, starts) / counts[:, None]
