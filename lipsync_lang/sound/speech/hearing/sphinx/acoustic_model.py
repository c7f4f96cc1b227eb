"""Acoustic models: the likelihood of each frame of a sound in each state of each phoneme.

A codebook has Gaussians, in one stream of features or several; each state has mixture weights for
its codebook. All states share one codebook (semi-continuous), the states of a phoneme do
(phonetically tied), or each state has its own (continuous). The states of a phoneme may depend on
its neighbours and its position in the word.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Any, NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints, Singles
from lipsync_lang.sound.speech.hearing.sphinx.features import EVEN_STEPS, FrontEnd


class WordPosition(IntEnum):
    """Position of a phoneme in its word."""

    INSIDE = 0
    BEGIN = 1
    END = 2
    ALONE = 3


STATES = 3
"""Number of states per phoneme, in sequence."""

MAX_KEPT_CELLS = 26_000_000
"""Most likelihoods of Gaussians that are kept for further states: 104 MB, a window's."""

MAX_BLOCK_CELLS = 200_000
"""Row block size of the matrix product."""

OUTSIDE = -1
"""Number in place of a phoneme or word, for none."""

VARIANCE_FLOOR = 1e-4
"""Variance floor."""

FAINTEST_LOG = -40.0
"""Log floor of a Gaussian relative to the nearest: negligible below, and slow to add."""

LOUD_PAUSE_LOG = -10.0
"""Most log likelihood of silence in a frame louder than the mean, relative to the best phoneme.

A steady sound, such as a held vowel, is like silence in all but its loudness.
"""


class Phone(NamedTuple):
    """A phoneme in context: its number and states."""

    number: int
    states: tuple[int, ...]


PhoneContext = tuple[int, int, int, WordPosition | None]
"""A phoneme, the ones before and after it, and its position; None outside words: no context."""


@dataclass(frozen=True, eq=False)
class AcousticModel:
    """Emission and transition parameters of every phoneme state.

    Parameters
    ----------
    names : phoneme names by number
    silence : the number of silence
    fillers : numbers of non-speech phonemes
    alone : context-independent phonemes by number
    keys : ascending, one for each phoneme in context (`context_key`)
    rows : state row of each key
    states : state numbers, (rows, `STATES`)
    stay : (phonemes, `STATES`) log probability of staying in a state for another frame
    gaussians : (books, S, 2 V + 1, Gaussians) factors of a frame's squares, of its values, and of
        1, for S streams of V values; their sum is the log likelihood of the frame
    weights : (S, Gaussians, states) mixture weights
    books : the codebook of each state
    front_end : extraction of features from samples at `SPEECH_RATE`: (T, S, V) or another shape
        with these values in this order; the first stream has the cepstra less their mean
    """

    names: tuple[str, ...]
    silence: int
    fillers: frozenset[int]
    alone: tuple[Phone, ...]
    keys: Ints
    rows: Ints
    states: Ints
    stay: Floats
    gaussians: Singles
    weights: Singles
    books: Ints
    front_end: FrontEnd

    def phones(self, contexts: Iterable[PhoneContext]) -> list[Phone]:
        """Return phonemes in context; each is the closest match in the model."""
        return [self._phone(*context) for context in contexts]

    def _phone(self, here: int, left: int, right: int, place: WordPosition | None) -> Phone:
        if place is None:
            return self.alone[here]
        # Models are trained on the contexts of their corpus alone. Silence is the neighbour in
        # most of them, so it comes before a phoneme without any context.
        for beside in ((left, right), (self.silence, right), (left, self.silence)):
            for where in dict.fromkeys((place, *WordPosition)):
                key = context_key(here, *beside, where)
                at = int(self.keys.searchsorted(key))
                if at < len(self.keys) and self.keys[at] == key:
                    return Phone(here, tuple(self.states[self.rows[at]].tolist()))
        return self.alone[here]


@dataclass(frozen=True, eq=False)
class Listening:
    """Log likelihoods of a sound under a model.

    Parameters
    ----------
    model : acoustic model
    features : (T, S, V) of the sound, by the model's front end
    """

    model: AcousticModel
    features: Floats
    _near: dict[tuple[int, int], tuple[Singles, Floats]] = field(
        init=False, repr=False, default_factory=dict
    )

    def scores(self, phones: Sequence[Phone]) -> Singles:
        """Return the log likelihood of each frame in each state of the given phonemes.

        Parameters
        ----------
        phones : P phonemes

        Returns
        -------
        (T, P, `STATES`) natural logarithms
        """
        states = np.array([phone.states for phone in phones])
        wanted, back = np.unique(states, return_inverse=True)
        books = self.model.books[wanted]
        found = np.empty((len(self.features), len(wanted)), np.float32)
        for book in np.unique(books).tolist():
            own = np.flatnonzero(books == book)
            heard = np.zeros((len(self.features), len(own)))
            for stream, weights in enumerate(self.model.weights):
                # log sum exp, with the nearest Gaussian taken out so that no exponent underflows
                shares, most = self._shares(book, stream)
                heard += np.log(_product(shares, weights[:, wanted[own]])) + most
            found[:, own] = np.rint(heard * EVEN_STEPS) / EVEN_STEPS
        return found[:, back.reshape(states.shape)]

    def _shares(self, book: int, stream: int) -> tuple[Singles, Floats]:
        """Return Gaussian likelihoods relative to the nearest, and the log likelihood of that."""
        key = (book, stream)
        if key in self._near:
            return self._near[key]
        gaussians = self.model.gaussians[key]
        here = self.features.reshape(len(self.features), len(self.model.weights), -1)[:, stream]
        here = np.rint(here * EVEN_STEPS) / EVEN_STEPS
        terms = np.hstack([here * here, here, np.ones((len(here), 1))])
        near = _product(terms, gaussians)
        most = near.max(axis=1, keepdims=True)
        near -= most
        np.maximum(near, FAINTEST_LOG, out=near)
        found = np.exp(near, out=near).astype(np.float32), most
        if (len(self._near) + 1) * near.size <= MAX_KEPT_CELLS:
            self._near[key] = found
        return found


class FrameBests(NamedTuple):
    """Log likelihoods per frame of the likeliest context-independent phoneme, (T,) each."""

    speech: Singles
    quiet: Singles
    """Silence and noises instead of phonemes of speech."""
    pause: Singles
    """The most that silence may have between words."""

    @classmethod
    def of(cls, sound: Listening, alone: Singles) -> "FrameBests":
        """Return those of a sound, by the scores of all such phonemes."""
        best, model = alone.max(axis=2), sound.model
        quiet = np.array([phone.number in model.fillers for phone in model.alone])
        speech = best[:, ~quiet].max(axis=1)
        # the first cepstrum is the loudness, less its mean
        loud = sound.features.reshape(len(speech), -1)[:, 0] > 0
        pause = np.where(loud, speech + np.float32(LOUD_PAUSE_LOG), np.float32(np.inf))
        return cls(speech, best[:, quiet].max(axis=1), pause)


def _product(many: Floats | Singles, few: Singles) -> Floats:
    """Multiply a long matrix by a small one in float64, in blocks of rows.

    A single product would start threads whose synchronisation costs more than the work.
    """
    # BLAS multiplies a stack of small matrices in this thread; only the rest is left over.
    rows = max(MAX_BLOCK_CELLS // few.size, 1)
    whole = len(many) // rows * rows
    many, few64 = np.asarray(many, np.float64), few.astype(np.float64)
    found = np.empty((len(many), few.shape[1]))
    pieces = many[:whole].reshape(-1, rows, many.shape[1])
    np.matmul(pieces, few64, out=found[:whole].reshape(-1, rows, few.shape[1]))
    np.matmul(many[whole:], few64, out=found[whole:])
    return found


def context_key(here: Any, left: Any, right: Any, place: Any) -> Any:
    """Return the integer key of a phoneme in context; vectorised."""
    return ((here * 256 + left) * 256 + right) * 256 + place


def gaussian_factors(means: Floats, variances: Floats) -> Singles:
    """Return diagonal Gaussians as `AcousticModel.gaussians` has them, from (..., Gaussians, V)."""
    precision = 1 / np.maximum(variances, VARIANCE_FLOOR)
    # log N(x) = sum(log(p / 2 pi) - p (x - m)^2) / 2, with p for 1 / variance, as factors of x^2, x
    # and 1, so that one matrix product has all frames
    constant = (np.log(precision / (2 * np.pi)) - precision * means**2).sum(axis=-1) / 2
    factors = [-precision / 2, precision * means, constant[..., None]]
    return np.concatenate(factors, axis=-1).swapaxes(-1, -2).astype(np.float32)
