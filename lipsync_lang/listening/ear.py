"""The ear: causal scores of context-independent phones, from sound that arrives in parts.

Frames are 10 ms apart; frame n has its middle at ``n FRAME_SECONDS + MIDDLE_SECONDS``. The features
are those of the acoustic model, but the mean of the cepstra follows a live voice: it begins at that
of ordinary recordings.

Scores are natural logarithms of likelihoods; T frames, N phones.
"""

from functools import cache, cached_property
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.arrays import Floats, Singles
from lipsync_lang.speech.hearing.sphinx.acoustic_model import FAINTEST_LOG, STREAMS
from lipsync_lang.speech.hearing.sphinx.features import (
    CEPSTRA,
    DELTA_FRAMES,
    FRAME_SECONDS,
    WINDOW_SAMPLES,
    CepstralFrames,
    derived,
)
from lipsync_lang.speech.hearing.sphinx.scheduling import HISS_DEVIATION
from lipsync_lang.speech.sound import SPEECH_RATE

if TYPE_CHECKING:
    from lipsync_lang.speech.hearing.sphinx.acoustic_model import AcousticModel

MEAN_PRIOR = np.array([52.0, 0.6, -2.0, 8.3, -3.7, -0.6, -3.3, -5.1, -0.7, -1.8, 3.4, -2.4, -0.8])
"""(13,) mean cepstra of ordinary recordings, from which that of a voice begins."""

PRIOR_FRAMES = 100.0
"""Frames of a voice that weigh as much as the prior."""

MEMORY_FRAMES = 800.0
"""Frames after which a frame counts 1 / e in the mean."""

HISS_SAMPLES = 1 << 16
"""Length of the added noise, which is repeated."""

MIDDLE_SECONDS = WINDOW_SAMPLES / SPEECH_RATE / 2
"""Middle of the first frame, in seconds."""

LOOK_AHEAD_SECONDS = DELTA_FRAMES * FRAME_SECONDS + MIDDLE_SECONDS
"""Sound after the middle of a frame that its features need, in seconds."""


class PhoneScores:
    """Scores of all phones of an acoustic model, each without its neighbours."""

    def __init__(self, model: "AcousticModel") -> None:
        self.model = model
        books = [phone.book for phone in model.alone]
        states = np.array([phone.states for phone in model.alone])
        gaussians = model.gaussians[books]
        self._mixtures = gaussians.shape[-1]
        # one product for all phones: (streams, 27, phones x Gaussians)
        self._factors = [
            np.ascontiguousarray(gaussians[:, stream].transpose(1, 0, 2).reshape(27, -1))
            for stream in range(STREAMS)
        ]
        self._weights = [
            np.ascontiguousarray(model.weights[stream][:, states].transpose(1, 0, 2))
            for stream in range(STREAMS)
        ]

    def of(self, features: Floats) -> Singles:
        """Return the log likelihood of each frame, (T, 3, 13), in each state: (T, N, 3)."""
        count, phones = len(features), len(self.model.names)
        found = np.zeros((phones, count, 3), np.float32)
        for stream in range(STREAMS):
            here = features[:, stream]
            terms = np.hstack([here * here, here, np.ones((count, 1))]).astype(np.float32)
            near = (terms @ self._factors[stream]).reshape(count, phones, self._mixtures)
            most = near.max(axis=-1, keepdims=True)
            near -= most
            np.maximum(near, FAINTEST_LOG, out=near)
            shares = np.exp(near, out=near).swapaxes(0, 1)
            found += np.log(shares @ self._weights[stream]) + most.swapaxes(0, 1)
        return found.swapaxes(0, 1)


@cache
def phone_scores(model: "AcousticModel") -> PhoneScores:
    """Return the scores of a model's phones, which all listeners share."""
    return PhoneScores(model)


class Ear:
    """Scores of phones for a sound that arrives in parts, at `SPEECH_RATE`."""

    def __init__(self, scores: PhoneScores) -> None:
        self.scores = scores
        self._frames = CepstralFrames()
        self._heard = 0
        self._wide = np.zeros((0, CEPSTRA))
        self._sum, self._count = MEAN_PRIOR * PRIOR_FRAMES, PRIOR_FRAMES

    def hear(self, samples: Floats) -> Singles:
        """Return the scores of the frames whose features are complete now: (k, N, 3)."""
        return self._scored(self._frames.push(self._hissed(samples)))

    def finish(self) -> Singles:
        """Return the scores of the last frames."""
        rest = self._scored(self._frames.last(np.zeros(0)))
        if not len(self._wide):
            return rest
        last = self._derived(np.repeat(self._wide[-1:], DELTA_FRAMES, axis=0))
        return np.concatenate([rest, last])

    def _hissed(self, samples: Floats) -> Floats:
        at = (self._heard + np.arange(len(samples))) % HISS_SAMPLES
        self._heard += len(samples)
        noised: Floats = samples + self._hiss[at]
        return noised

    @cached_property
    def _hiss(self) -> Floats:
        return np.random.default_rng(0).normal(0.0, HISS_DEVIATION, HISS_SAMPLES)

    def _scored(self, cepstra: Floats) -> Singles:
        if not len(cepstra):
            return np.zeros((0, len(self.scores.model.names), 3), np.float32)
        keep = 1 - 1 / MEMORY_FRAMES
        less = np.empty_like(cepstra)
        for number, here in enumerate(cepstra):
            self._sum, self._count = self._sum * keep + here, self._count * keep + 1
            less[number] = here - self._sum / self._count
        if not len(self._wide):
            less = np.concatenate([np.repeat(less[:1], DELTA_FRAMES, axis=0), less])
        return self._derived(less)

    def _derived(self, more: Floats) -> Singles:
        wide = np.concatenate([self._wide, more])
        self._wide = wide[-2 * DELTA_FRAMES :]
        if len(wide) <= 2 * DELTA_FRAMES:
            self._wide = wide
            return np.zeros((0, len(self.scores.model.names), 3), np.float32)
        return self.scores.of(derived(wide))
