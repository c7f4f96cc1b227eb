"""The ear: causal features of a sound that arrives in parts, and scores of its phones.

Frames are 10 ms apart; frame n has its middle at ``n FRAME_SECONDS + MIDDLE_SECONDS``. The features
are those of the acoustic model, but the mean of the cepstra follows a live voice: it begins at that
of ordinary recordings. Phones are those without a context.

Scores are natural logarithms of likelihoods; T frames, N phones.
"""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints, Singles
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.sound.listening.belief import PhoneLoop
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import FAINTEST_LOG, AcousticModel
from lipsync_lang.sound.speech.hearing.sphinx.features import (
    CEPSTRA,
    DELTA_FRAMES,
    EVEN_STEPS,
    FRAME_SECONDS,
    HISS_DEVIATION,
    HOP_SAMPLES,
    WINDOW_SAMPLES,
    CepstralFrames,
    derived,
)
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

STREAMS = 3
"""Number of streams of a model that is listened with."""

MEAN_PRIOR = np.array([52.0, 0.6, -2.0, 8.3, -3.7, -0.6, -3.3, -5.1, -0.7, -1.8, 3.4, -2.4, -0.8])
"""(13,) mean cepstra of ordinary recordings, from which that of a voice begins."""

PRIOR_FRAMES = 100.0
"""Frames of a voice that weigh as much as the prior."""

MEMORY_FRAMES = 800.0
"""Frames after which a frame counts 1 / e in the mean."""

HISS_SAMPLES = 1 << 16
"""Length of the added noise, which is repeated."""

CACHED_FRAMES = 16
"""Frames whose Gaussians are worked out at once, to stay in the processor's cache."""

MIDDLE_SECONDS = WINDOW_SAMPLES / SPEECH_RATE / 2
"""Middle of the first frame, in seconds."""

LOOK_AHEAD_SECONDS = DELTA_FRAMES * FRAME_SECONDS + MIDDLE_SECONDS
"""Sound after the middle of a frame that its features need, in seconds."""


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
        return (sums[count:] - sums[:-count]) / count


class VoiceGate:
    """The share of a sound that somebody speaks, by three measures of frames that arrive in parts.

    - Change: how fast the sound changes. Hiss, hum and held tones hardly change.
    - Tones: how well the fine spectrum agrees with that of 80 ms before. The pitch of a voice
      glides, so its harmonics agree little. The notes of an instrument stay where they are.
    - Contrast: how much likelier the best phone is than the mean of all. A vowel is like one phone,
      and noise is like many.

    A voice begins with change without tones. It lasts through a vowel that is held, which neither
    changes nor glides, while its contrast stays.
    """

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
    return ((values - low) / (high - low)).clip(0, 1)


def change_of(features: Floats) -> Floats:
    """Return how fast a sound changes in each frame of its features, (T, 3, 13): (T,)."""
    return np.abs(features[:, 1]).mean(axis=-1)


def contrast_of(scores: Singles, quiet: Bools) -> Floats:
    """Return how much likelier the best phone is than the mean: (T,).

    Parameters
    ----------
    scores : (T, N, S)
    quiet : (N,) phones that are never the best one
    """
    best = scores.max(axis=-1).astype(float)
    return best[:, ~quiet].max(axis=-1) - best.mean(axis=-1)


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
        return np.einsum("kb,kb->k", wide[TONE_FRAMES:], wide[:-TONE_FRAMES])


def _fine_shapes(frames: Floats) -> Floats:
    """Return log spectra of frames less their means over some bins, of length 1: (k, bins)."""
    spectra = np.fft.rfft(frames * np.hanning(TONE_SAMPLES))[:, TONE_BINS]
    logs = np.log(np.abs(spectra) + 1)
    half, bins = SMOOTH_BINS // 2, logs.shape[1]
    places = np.arange(-half - 1, bins + half).clip(0, bins - 1)
    sums = np.cumsum(logs[:, places], axis=1)
    fine = logs - (sums[:, SMOOTH_BINS:] - sums[:, :-SMOOTH_BINS]) / SMOOTH_BINS
    lengths = np.linalg.norm(fine, axis=1, keepdims=True)
    return fine / (lengths + 1e-9)


class PhoneScores:
    """Scores of the phones of an acoustic model, by the groups of their neighbours.

    Parameters
    ----------
    neighbours : groups of phones; all others are one more
    """

    def __init__(self, model: AcousticModel, neighbours: Sequence[Sequence[str]]) -> None:
        self.model = model
        number = {name: group for group, names in enumerate(neighbours) for name in names}
        groups = np.array([number.get(name, len(neighbours)) for name in model.names])
        self.loop = PhoneLoop(groups, np.isin(np.arange(len(groups)), sorted(model.fillers)))
        states = np.array([phone.states for phone in model.alone])
        books = model.books[states]
        if model.weights.shape[0] != STREAMS or (books != books[:, :1]).any():
            raise SpeechError(
                "listening without a text needs an acoustic model of three streams whose phones "
                "each have one codebook; other models align texts"
            )
        gaussians = model.gaussians[books[:, 0]].astype(np.float64)
        # (streams, N, 27, Gaussians), so that each product is too small for threads, which cost
        # more than it does
        self._factors = np.ascontiguousarray(gaussians.swapaxes(0, 1))
        self._weights = _group_weights(model, groups)

    def of(self, features: Floats) -> Singles:
        """Return the log likelihood of each frame, (T, 3, 13), in each state: (T, N, S)."""
        features = np.rint(features * EVEN_STEPS) / EVEN_STEPS
        terms = np.concatenate([features**2, features, np.ones_like(features[..., :1])], axis=-1)
        rows = terms.swapaxes(0, 1)[:, None]
        found = np.empty((len(features), *self._weights.shape[1::2]), np.float32)
        for start in range(0, len(features), CACHED_FRAMES):
            block = slice(start, start + CACHED_FRAMES)
            near = rows[:, :, block] @ self._factors
            most = near.max(axis=-1, keepdims=True)
            near -= most
            np.maximum(near, FAINTEST_LOG, out=near)
            shares = np.exp(near, out=near) @ self._weights
            exact = (np.log(shares, out=shares) + most).sum(axis=0).swapaxes(0, 1)
            found[block] = np.rint(exact * EVEN_STEPS) / EVEN_STEPS
        return found


def _group_weights(model: AcousticModel, groups: Ints) -> Floats:
    """Return the mixture weights of each state: (streams, N, Gaussians, S).

    They are the means over all contexts whose neighbour is of the group, of the phone without a
    context if the model has none.
    """
    count = int(groups.max()) + 1
    # as `context_key` has them
    here, left, right = (model.keys >> shift & 255 for shift in (24, 16, 8))
    states = model.states[model.rows]
    found = np.empty((STREAMS, len(groups), model.weights.shape[1], 2 * count + 1))
    for phone, alone in enumerate(model.alone):
        own = here == phone
        columns = [(own & (groups[left] == group), 0) for group in range(count)]
        columns += [(own, 1)]
        columns += [(own & (groups[right] == group), 2) for group in range(count)]
        for column, (chosen, state) in enumerate(columns):
            used = states[chosen, state] if chosen.any() else [alone.states[state]]
            found[:, phone, :, column] = model.weights[:, :, used].mean(axis=-1)
    return found


@cache
def phone_scores(model: AcousticModel, neighbours: tuple[tuple[str, ...], ...] = ()) -> PhoneScores:
    """Return the scores of a model's phones, which all listeners share."""
    return PhoneScores(model, neighbours)


class Heard(NamedTuple):
    """Some frames of a sound."""

    features: Floats
    """(k, 3, 13)"""
    tones: Floats
    """(k,) as `ToneTrack` measures them."""


class Ear:
    """Features of a sound that arrives in parts, at `SPEECH_RATE`."""

    def __init__(self) -> None:
        self._frames, self._tones = CepstralFrames(), ToneTrack()
        self._heard = 0
        self._wide = np.zeros((0, CEPSTRA))
        self._last_tone = np.zeros(1)
        self._sum, self._count = MEAN_PRIOR * PRIOR_FRAMES, PRIOR_FRAMES

    def hear(self, samples: Floats) -> Heard:
        """Return the frames that are complete now."""
        at = (self._heard + np.arange(len(samples))) % HISS_SAMPLES
        self._heard += len(samples)
        sound = samples + _hiss()[at]
        tones = self._tones.push(sound)
        self._last_tone = tones[-1:] if len(tones) else self._last_tone
        found = self._derived(self._less_mean(self._frames.push(sound)))
        # tones need no later frames, so the first of them come before the first features
        return Heard(found, tones[len(tones) - len(found) :])

    def finish(self) -> Heard:
        """Return the last frames."""
        last = self._less_mean(self._frames.cepstra(self._frames.last([])))
        end = last if len(last) else self._wide
        found = self._derived(np.concatenate([last, np.repeat(end[-1:], DELTA_FRAMES, axis=0)]))
        return Heard(found, np.repeat(self._last_tone, len(found)))

    def _less_mean(self, cepstra: Floats) -> Floats:
        """Take the mean of the voice so far from cepstra."""
        less = np.empty_like(cepstra)
        keep = 1 - 1 / MEMORY_FRAMES
        for number, here in enumerate(cepstra):
            self._sum, self._count = self._sum * keep + here, self._count * keep + 1
            less[number] = here - self._sum / self._count
        return less

    def _derived(self, less: Floats) -> Floats:
        if not len(self._wide):  # the first frame stands in for those before it
            less = np.concatenate([np.repeat(less[:1], DELTA_FRAMES, axis=0), less])
        wide = np.concatenate([self._wide, less])
        self._wide = wide[-2 * DELTA_FRAMES :]
        if len(wide) <= 2 * DELTA_FRAMES:
            wide = np.zeros((2 * DELTA_FRAMES, CEPSTRA))
        return derived(wide)


@cache
def _hiss() -> Floats:
    return np.random.default_rng(0).normal(0.0, HISS_DEVIATION, HISS_SAMPLES)
