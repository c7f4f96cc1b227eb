"""Acoustic features for alignment by warping: mel spectra, speech detection and cepstra.

Recording and synthetic voice differ in speaker, room and noise. Before comparison, the band
levels of the voice are matched to the recording, and the recording's noise is added to it.

Frames are `HOP` seconds apart and centred on their time: frame k is at ``k * HOP``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from lipsync_lang.errors import SpeechError

if TYPE_CHECKING:
    from lipsync_lang.schedules.schedule import Audio

Floats = npt.NDArray[np.float64]
Sound = npt.NDArray[np.float32]
Ints = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]

RATE = 16_000
HOP = 0.01
WINDOW = 0.025
BANDS, CEPSTRA = 40, 10
LOWEST, HIGHEST = 60.0, 7600.0
"""Band limits in hertz; bands are evenly spaced in mel."""

RANGE = 35.0
"""Silence floor in decibels below speech level."""

QUIET = 10
"""Percentile of frame power taken as background noise."""

SPOKEN = 0.25
"""Speech threshold as a fraction of the range from noise level to speech level."""

LEAST = 2.0
"""Minimum decibels from noise level to speech level; a smaller range means no speech."""

PAUSE = 0.2
"""Minimum pause in seconds; a shorter silence counts as a closure."""

ISLAND = 0.06
"""Minimum sound between two pauses in seconds; a shorter sound counts as a click."""

_EMPHASIS = 0.97
_POINTS = 512
_BLOCK = 4096
_AROUND = 2
_TINY = 1e-10


@dataclass(frozen=True)
class SpeechSpectrum:
    """Mel spectrum of a recording with its speech detection."""

    power: Floats
    """Mel power, (T, BANDS)."""
    noise: Floats
    """(BANDS,) noise power."""
    floor: Floats
    """(BANDS,) silence power: the noise, or `RANGE` below speech."""
    spoken: Bools
    """Speech mask, (T,)."""

    @cached_property
    def features(self) -> tuple[Floats, Floats, Floats]:
        """Features (T, D), their mean in speech (D,), and their deviation in speech (D,)."""
        features = cepstra(np.log(self.power + self.floor))
        said = features[self.spoken]
        return features, said.mean(axis=0), said.std(axis=0) + 1e-3


def samples_of(audio: "Audio") -> Sound:
    """Convert a sound to `RATE`, zero mean and amplitudes within 1."""
    from lipsync_lang.speech.sound import resampled

    sound = resampled(audio, RATE).samples.astype(np.float32)
    sound -= sound.mean(dtype=np.float64)
    sound /= 2.0**15
    return sound


def mel_power(
    samples: Sound | Floats, hop: float = HOP, tracts: Sequence[float] = (1.0,)
) -> Floats:
    """Return the power in mel bands for each tract: (len(tracts), T, BANDS).

    Parameters
    ----------
    samples : (n,) at `RATE`
    hop : seconds between frames
    tracts : vocal tract lengths relative to the nominal one
    """
    width = int(WINDOW * RATE)
    sound = np.pad(samples, (width // 2 + 1, width))
    starts = (np.arange(int(len(samples) / RATE / hop) + 1) * hop * RATE).astype(np.intp)
    banks = [_bank(tract) for tract in tracts]
    window, steps = np.hanning(width), np.arange(width + 1)
    out = np.empty((len(tracts), len(starts), BANDS))
    for low in range(0, len(starts), _BLOCK):
        frames = sound[starts[low : low + _BLOCK, None] + steps].astype(np.float64)
        frames = (frames[:, 1:] - _EMPHASIS * frames[:, :-1]) * window
        power = np.abs(np.fft.rfft(frames, _POINTS)) ** 2
        for number, bank in enumerate(banks):
            out[number, low : low + _BLOCK] = power @ bank
    return out


@lru_cache(maxsize=8)
def _bank(tract: float) -> Floats:
    """Return triangular filter weights of the bands: (bins, BANDS)."""
    mels = np.linspace(_mel(LOWEST), _mel(HIGHEST), BANDS + 2)
    edges = 700 * (10 ** (mels / 2595) - 1) * tract
    bins = np.arange(_POINTS // 2 + 1)[:, None] * RATE / _POINTS
    low, middle, high = edges[:-2], edges[1:-1], edges[2:]
    rising, falling = (bins - low) / (middle - low), (high - bins) / (high - middle)
    return np.maximum(0, np.minimum(rising, falling))


def _mel(hertz: float) -> float:
    return float(2595 * np.log10(1 + hertz / 700))


def listen(samples: Floats) -> SpeechSpectrum:
    """Detect the speech in a recording.

    Raises
    ------
    SpeechError
        The recording has no speech.
    """
    (power,) = mel_power(samples)
    return heard_in(power)


def heard_in(power: Floats) -> SpeechSpectrum:
    """Detect the speech in a stretch of a recording by its levels alone; `power` is (T, BANDS).

    Raises
    ------
    SpeechError
        The stretch has no speech.
    """
    loudness = _smooth(power.sum(axis=1))
    noise = power[loudness <= np.percentile(loudness, QUIET)].mean(axis=0)
    loud = power[loudness >= np.percentile(loudness, 100 - QUIET)].mean(axis=0)
    floor = np.maximum(np.maximum(noise, loud * 10 ** (-RANGE / 10)), _TINY)
    above = _smooth(10 * np.log10((power + floor) / floor).mean(axis=1))
    quiet, top = np.percentile(above, QUIET), np.percentile(above, 100 - QUIET / 2)
    if top - quiet < LEAST:
        raise SpeechError(
            "the speech cannot be told apart from the other sounds; "
            "use a louder recording, or one with less noise"
        )
    return SpeechSpectrum(power, noise, floor, above > quiet + SPOKEN * (top - quiet))


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
    level = np.maximum(heard.power[heard.spoken].mean(axis=0) - heard.noise, 0.1 * heard.floor)
    level = level / (voice[sounding].mean(axis=0) + _TINY)
    recorded, mean, spread = heard.features
    spoken = cepstra(np.log(voice * level + heard.noise + heard.floor))
    return (recorded - mean) / spread, (spoken - mean) / spread


def cepstra(log_power: Floats) -> Floats:
    """Return cepstra and their time derivatives: (T, 2 * CEPSTRA)."""
    orders, middles = np.arange(CEPSTRA), np.arange(BANDS) + 0.5
    out = log_power @ np.cos(np.pi * np.outer(middles, orders) / BANDS)
    around = np.pad(out, ((_AROUND, _AROUND), (0, 0)), mode="edge")
    steps = range(1, _AROUND + 1)
    ahead = [around[_AROUND + n : _AROUND + n + len(out)] for n in steps]
    behind = [around[_AROUND - n : _AROUND - n + len(out)] for n in steps]
    change = sum(n * (a - b) for n, a, b in zip(steps, ahead, behind, strict=True))
    return np.hstack([out, change])


def speech_frames(spoken: Bools) -> Ints:
    """Return indices of the frames to compare: speech and short silences, without clicks."""
    kept = [run for run in runs(np.flatnonzero(spoken)) if len(run) * HOP >= ISLAND]
    return np.concatenate(kept) if kept else np.flatnonzero(spoken)


def runs(frames: Ints) -> list[Ints]:
    """Split frames into runs at pauses, with shorter silences filled."""
    cuts = np.flatnonzero(np.diff(frames) * HOP >= PAUSE) + 1
    return [np.arange(run[0], run[-1] + 1) for run in np.split(frames, cuts)]


def pooled(frames: Floats, step: int) -> Floats:
    """Return the mean of each group of `step` frames."""
    starts = np.arange(0, len(frames), step)
    counts = np.diff([*starts, len(frames)])
    return np.add.reduceat(frames, starts) / counts[:, None]
