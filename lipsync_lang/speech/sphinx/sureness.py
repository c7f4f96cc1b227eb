"""Confidence of an alignment by an acoustic model: of the line, and of each word.

Both are logistic functions of what the search found, fitted to right and wrong texts (decision
0026).
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.speech.sphinx.acoustic_model import OUTSIDE
from lipsync_lang.speech.sphinx.forced import HeardPhoneme


class LineWeights(NamedTuple):
    """Weights of the evidence in the logit of a line's confidence."""

    fit: float
    covered: float
    base: float


class WordWeights(NamedTuple):
    """Weights of the evidence in the logit of a word's confidence."""

    fit: float
    hurried: float
    base: float


LINE = LineWeights(1.75, 14.2, -5.5)
WORD = WordWeights(0.45, -1.4, 3.0)

SPEECH = -3.0
"""Fit of silence and noises below which a sound is speech; that of speech is -5 to -10, and
-3 to -7 with noise 10 dB below it."""

DIN = 3.0
"""Weight of the excess over that in the logit of a line's confidence."""

HURRIED = 3
"""Frames; a phoneme of no more has the minimum duration of the model."""


def line_confidence(heard: Sequence[HeardPhoneme]) -> float:
    """Return the probability that the words are those that the sound has, in [0, 1].

    The evidence: the mean fit of their phonemes, their share of all speech, and the fit of silence
    and noises to them, which is high where nobody speaks.
    """
    said = [one for one in heard if _of_word(one)]
    if not said:
        return 0.0
    spoken = sum(map(_frames, said))
    other = sum(_frames(one) for one in heard if one.phone == OUTSIDE and one.noise < SPEECH)
    fit = float(np.mean([one.fit for one in said]))
    noise = sum(one.noise * _frames(one) for one in said) / spoken
    din = DIN * max(0.0, noise - SPEECH)
    return _logistic(LINE.fit * fit + LINE.covered * spoken / (spoken + other) + LINE.base - din)


def word_confidence(phonemes: Sequence[HeardPhoneme]) -> float:
    """Return the probability that a word is said where it was found, in [0, 1].

    The evidence: the mean fit of its phonemes, and the share of them that have no time.
    """
    fit = float(np.mean([one.fit for one in phonemes]))
    hurried = float(np.mean([_frames(one) <= HURRIED for one in phonemes]))
    return _logistic(WORD.fit * fit + WORD.hurried * hurried + WORD.base)


def _of_word(one: HeardPhoneme) -> bool:
    return OUTSIDE not in (one.word, one.phone)


def _frames(one: HeardPhoneme) -> int:
    return one.stop - one.first


def _logistic(logit: float) -> float:
    return float(1 / (1 + np.exp(-np.clip(logit, -50, 50))))
