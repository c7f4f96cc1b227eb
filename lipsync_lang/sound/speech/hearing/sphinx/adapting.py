"""Adaptation of an acoustic model to voices, from aligned recordings without labels.

The means of Gaussians move towards the frames that they explain, by shifts in their standard
deviations. The shift of all phonemes is the prior of the shift of one phoneme, and that is the
prior of the shift of one Gaussian (structural MAP, Shinoda and Lee 2001)::

    shift' = (tau shift + sum of g (x - m) / s) / (tau + sum of g)

with the posterior probability g of a Gaussian in the aligned state of frame x.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints, Singles
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import (
    FAINTEST_LOG,
    OUTSIDE,
    STATES,
    AcousticModel,
    Listening,
    PhoneContext,
    WordPosition,
)
from lipsync_lang.sound.speech.hearing.sphinx.forced import HeardPhoneme

MODEL_FRAMES = 20.0
"""Frames that weigh as much as the prior of a shift: tau."""

PLACES = {
    (True, True): WordPosition.INSIDE,
    (False, True): WordPosition.BEGIN,
    (True, False): WordPosition.END,
    (False, False): WordPosition.ALONE,
}
"""Positions of a phoneme, by whether the ones before and after it are in its word."""


class AlignedFrames(NamedTuple):
    """Frames of a recording with their states: (T, S, V) features and (T,) states."""

    features: Floats
    states: Ints


def aligned_frames(
    model: AcousticModel, features: Floats, heard: Sequence[HeardPhoneme]
) -> AlignedFrames:
    """Return the frames of phonemes and silence with their states, without other sound."""
    around = [model.silence if one.phone == OUTSIDE else one.phone for one in heard]
    around = [model.silence, *around, model.silence]
    words = [OUTSIDE, *(one.word for one in heard), OUTSIDE]
    contexts: list[PhoneContext] = []
    for n, one in enumerate(heard):
        inside = words[n] == one.word, words[n + 2] == one.word
        spoken = OUTSIDE not in (one.word, one.phone)
        place = PLACES[inside] if spoken else None
        contexts.append((around[n + 1], around[n], around[n + 2], place))
    states = np.full(len(features), OUTSIDE)
    for one, phone in zip(heard, model.phones(contexts), strict=True):
        if one.phone != OUTSIDE:
            span = slice(one.first, one.stop)
            scores = Listening(model, features[span]).scores([phone])[:, 0]
            states[span] = np.repeat(phone.states, _lengths(scores))
    kept = states != OUTSIDE
    shape = (len(features), len(model.weights), -1)
    return AlignedFrames(features.reshape(shape)[kept], states[kept])


def _lengths(scores: Singles) -> Ints:
    """Return how many frames each of the states has on the likeliest path through all."""
    count = len(scores)
    if count < STATES:
        return np.array([count, 0, 0])
    sums = np.vstack([np.zeros(STATES), np.cumsum(scores, axis=0, dtype=np.float64)])
    cuts = np.arange(1, count)
    early = sums[cuts, 0] - sums[cuts, 1]
    late = sums[cuts, 1] - sums[cuts, 2]
    best = np.maximum.accumulate(early)[:-1] + late[1:]
    second = int(best.argmax()) + 2
    first = int(early[: second - 1].argmax()) + 1
    return np.array([first, second - first, count - second])


@dataclass
class GaussianSums:
    """Sums over frames for each Gaussian."""

    model: AcousticModel
    counts: Floats = field(init=False)
    sums: Floats = field(init=False)

    def __post_init__(self) -> None:
        books, streams, size, gaussians = self.model.gaussians.shape
        self.counts = np.zeros((books, streams, gaussians))
        self.sums = np.zeros((books, streams, size // 2, gaussians))

    def add(self, line: AlignedFrames) -> float:
        """Add the frames of a line, and return their mean log likelihood."""
        total = 0.0
        model = self.model
        books = model.books[line.states]
        for book in np.unique(books).tolist():
            here = books == book
            states = line.states[here]
            for stream in range(len(model.weights)):
                frames = line.features[here, stream]
                posterior, likely = _posterior(model, book, stream, frames, states)
                total += float(likely.sum())
                self.counts[book, stream] += posterior.sum(axis=0)
                self.sums[book, stream] += frames.T @ posterior
        return total / max(len(line.states), 1)

    def adapted(self) -> AcousticModel:
        """Return the model with means moved towards the frames."""
        size, precision, means = self.sums.shape[2], *means_of(self.model)
        counts, scale = self.counts[:, :, None], np.sqrt(np.maximum(precision, 1e-30))
        away = (self.sums - counts * means) * scale
        shift = np.zeros(1)
        for below in ((0, 3), (3,), ()):  # all, the codebook of a phoneme, a Gaussian
            frames = MODEL_FRAMES + counts.sum(axis=below, keepdims=True)
            shift = (MODEL_FRAMES * shift + away.sum(axis=below, keepdims=True)) / frames
        moved = means + shift / scale
        gaussians = self.model.gaussians.copy()
        gaussians[:, :, size:-1] = precision * moved
        gaussians[:, :, -1] -= (precision * (moved**2 - means**2)).sum(axis=2) / 2
        return replace(self.model, gaussians=gaussians)


def means_of(model: AcousticModel) -> tuple[Floats, Floats]:
    """Return precisions and means of a model's Gaussians: (books, S, V, Gaussians) each."""
    size = model.gaussians.shape[2] // 2
    precision = -2 * model.gaussians[:, :, :size].astype(np.float64)
    return precision, model.gaussians[:, :, size:-1] / np.maximum(precision, 1e-30)


def _posterior(
    model: AcousticModel, book: int, stream: int, frames: Floats, states: Ints
) -> tuple[Floats, Floats]:
    """Return the posterior of each Gaussian, (T, Gaussians), and the log likelihoods, (T,)."""
    terms = np.hstack([frames * frames, frames, np.ones((len(frames), 1))])
    near = terms @ model.gaussians[book, stream].astype(np.float64)
    most = near.max(axis=1, keepdims=True)
    shares = np.exp(np.maximum(near - most, FAINTEST_LOG)) * model.weights[stream][:, states].T
    whole = shares.sum(axis=1, keepdims=True)
    return shares / whole, np.log(whole[:, 0]) + most[:, 0]
