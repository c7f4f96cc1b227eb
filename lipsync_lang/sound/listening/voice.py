"""Voice or not: the share of a sound that somebody speaks, from three measures of each frame.

- Change: how fast the sound changes. Hiss, hum and held tones hardly change.
- Tones: how well the fine spectrum agrees with that of 80 ms before. The pitch of a voice glides,
  so its harmonics agree little. The notes of an instrument stay where they are.
- Contrast: how much likelier the best phone is than the mean of all. A vowel is like one phone, and
  noise is like many.

A voice begins with change without tones. It lasts through a vowel that is held, which neither
changes nor glides, while its contrast stays.
"""

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Singles
from lipsync_lang.sound.speech.hearing.sphinx.features import HOP_SAMPLES, WINDOW_SAMPLES
from lipsync_lang.sound.speech.sound import SPEECH_RATE

FAST_FRAMES, SLOW_FRAMES = 12, 40
"""Frames of a mean: for a voice that begins, and for one that lasts."""

FAST_EXCESS = 1.5
"""Change by which the fast mean must exceed the slow one's limits, as it varies more."""

STEADY_CHANGE, VOICED_CHANGE = 7.0, 8.0
"""Change up to which nobody speaks, and from which somebody surely does.

Speech has 12 in the middle and rarely less than 8, hiss and hum less than 6.5, drums about 7.
"""

GLIDING_TONES, STAYING_TONES = 0.2, 0.35
"""Agreement up to which a voice is possible, and from which tones are not those of a voice.

95 % of speech is below 0.2, and 95 % of music above 0.4.
"""

VAGUE_CONTRAST, CLEAR_CONTRAST = 5.5, 6.5
"""Contrast up to which a held sound is no vowel, and from which it is one."""

HELD_FRAMES_OF_VOWEL = 220
"""Frames for which a vowel may be held."""

TONE_SAMPLES = 1024
"""Window of the fine spectrum."""

TONE_FRAMES = 8
"""Frames between the two spectra, whose windows hardly overlap."""

TONE_BINS = slice(200 * TONE_SAMPLES // SPEECH_RATE, 4000 * TONE_SAMPLES // SPEECH_RATE)
"""Bins from 200 to 4000 Hz."""

SMOOTH_BINS = 9
"""Bins over which the spectrum is averaged, to leave its fine shape."""


class MovingMean:
    """Means of the last values, which arrive in parts.

    Parameters
    ----------
    frames : number of values in a mean
    first : all values before the first
    """

    def __init__(self, frames: int, first: float) -> None:
        self._kept = np.full(frames, first)

    def push(self, values: Floats) -> Floats:
        """Return the mean that ends with each value."""
        count = len(self._kept)
        wide = np.concatenate([self._kept, values])
        self._kept = wide[len(values) :]
        sums = np.cumsum(wide)
        means: Floats = (sums[count:] - sums[:-count]) / count
        return means


class VoiceGate:
    """The share of a sound that is a voice, for frames that arrive in parts."""

    def __init__(self) -> None:
        quiet = STEADY_CHANGE - FAST_EXCESS
        self._slow, self._fast = MovingMean(SLOW_FRAMES, quiet), MovingMean(FAST_FRAMES, quiet)
        self._tones = MovingMean(SLOW_FRAMES, 0.0)
        self._contrast = MovingMean(FAST_FRAMES, VAGUE_CONTRAST)
        self._recent = MovingMean(FAST_FRAMES, 0.0)
        self._share, self._left = 0.0, 0

    def push(self, change: Floats, tones: Floats, contrast: Floats) -> Floats:
        """Return the share of each frame, from 0 to 1: (k,), like each measure."""
        most = np.maximum(self._slow.push(change), self._fast.push(change) - FAST_EXCESS)
        sure = _ramp(most, STEADY_CHANGE, VOICED_CHANGE)
        sure *= 1 - _ramp(self._tones.push(tones), GLIDING_TONES, STAYING_TONES)
        vowel = _ramp(self._contrast.push(contrast), VAGUE_CONTRAST, CLEAR_CONTRAST)
        begun = self._recent.push(sure) >= 1 / 2
        share = np.empty(len(sure))
        for frame, least in enumerate(sure.tolist()):
            self._left = HELD_FRAMES_OF_VOWEL if begun[frame] else max(self._left - 1, 0)
            held = min(self._share, vowel[frame]) if self._left else 0.0
            share[frame] = self._share = max(least, held)
        return share


def _ramp(values: Floats, low: float, high: float) -> Floats:
    ramp: Floats = ((values - low) / (high - low)).clip(0, 1)
    return ramp


def change_of(features: Floats) -> Floats:
    """Return how fast a sound changes in each frame of its features, (T, 3, 13): (T,)."""
    change: Floats = np.abs(features[:, 1]).mean(axis=-1)
    return change


def contrast_of(scores: Singles, quiet: Bools) -> Floats:
    """Return how much likelier the best phone is than the mean: (T,).

    Parameters
    ----------
    scores : (T, N, S)
    quiet : (N,) phones that are never the best one
    """
    best = scores.max(axis=-1).astype(float)
    contrast: Floats = best[:, ~quiet].max(axis=-1) - best.mean(axis=-1)
    return contrast


class ToneTrack:
    """Agreement of the fine spectrum with that of `TONE_FRAMES` before, for sound in parts."""

    def __init__(self) -> None:
        self._sound = np.zeros(TONE_SAMPLES - WINDOW_SAMPLES)
        self._before = np.zeros((TONE_FRAMES, TONE_BINS.stop - TONE_BINS.start))

    def push(self, samples: Floats) -> Floats:
        """Return the agreement of the frames whose window ends with these samples: (k,)."""
        sound = np.concatenate([self._sound, samples])
        count = max((len(sound) - TONE_SAMPLES) // HOP_SAMPLES + 1, 0)
        self._sound = sound[count * HOP_SAMPLES :]
        if not count:
            return np.zeros(0)
        frames = np.lib.stride_tricks.sliding_window_view(sound, TONE_SAMPLES)[::HOP_SAMPLES]
        shapes = _fine_shapes(frames[:count])
        wide = np.concatenate([self._before, shapes])
        self._before = wide[-TONE_FRAMES:]
        agreement: Floats = np.einsum("kb,kb->k", wide[TONE_FRAMES:], wide[:-TONE_FRAMES])
        return agreement


def _fine_shapes(frames: Floats) -> Floats:
    """Return log spectra of frames less their means over some bins, of length 1: (k, bins)."""
    spectra = np.fft.rfft(frames * np.hanning(TONE_SAMPLES))[:, TONE_BINS]
    logs = np.log(np.abs(spectra) + 1)
    half, bins = SMOOTH_BINS // 2, logs.shape[1]
    places = np.arange(-half - 1, bins + half).clip(0, bins - 1)
    sums = np.cumsum(logs[:, places], axis=1)
    fine = logs - (sums[:, SMOOTH_BINS:] - sums[:, :-SMOOTH_BINS]) / SMOOTH_BINS
    lengths = np.linalg.norm(fine, axis=1, keepdims=True)
    shapes: Floats = fine / (lengths + 1e-9)
    return shapes
