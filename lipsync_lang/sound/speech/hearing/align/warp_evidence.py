"""Confidence of a warp: evidence that a recording contains a text, and its calibration."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.sound.speech.hearing.align.bending import Fit, SpokenVoice
from lipsync_lang.sound.speech.hearing.sphinx.scheduling import logistic

LEAST_SECONDS = 0.02
"""Duration below which phonemes count as equally short."""

LEAST_UNEVEN = 0.05
"""Unevenness below which durations count as equal."""

MOST_BETTER = 0.15
"""Gain over the reversed voice above which more tells nothing: two synthetic voices are alike."""

LINE_WEIGHTS = (-1.7, 30.0, -1.8, -5.5)
"""Logistic weights of a line: constant, `better`, logarithm of `uneven`, `drift`."""

WORD_WEIGHTS = (0.4, 6.7, -3.3, 0.7)
"""Logistic weights of a word: constant, `better`, `uneven`, log odds of its line."""

PART_ODDS = 3.0
"""Log odds that a text loses where it was looked for in parts of the recording."""

TELLING_PHONEMES = 24
"""Phonemes of a text below which it loses more: a short one is like some part of any speech."""


class WarpEvidence(NamedTuple):
    """Agreement of a recording with a line or a word of the text."""

    better: float
    """Gain in distance over the time-reversed voice; 0 for unrelated speech, 1 for equal sounds."""
    uneven: float
    """Deviation of durations from the voice's, as a natural logarithm."""
    drift: float
    """Share of the path where one of the sounds runs ahead."""


def evidence(
    fit: Fit, lasts: Floats, voice: SpokenVoice
) -> tuple[WarpEvidence, list[WarpEvidence]]:
    """Return the evidence of a line and of each of its words.

    Parameters
    ----------
    lasts : (n,) durations of the phonemes found, in seconds
    """
    said = voice.ends - voice.starts
    ratios = np.log(np.maximum(lasts, LEAST_SECONDS) / np.maximum(said, LEAST_SECONDS))
    backwards = max(fit.backwards, 1e-6)
    line = WarpEvidence(1 - fit.cost / backwards, float(np.std(ratios)), fit.drift)
    usual = float(np.median(ratios))
    words = []
    for word in voice.words:
        own = slice(word.first, word.stop)
        cost = float(np.average(fit.costs[own], weights=lasts[own]))
        ratio = float(np.log(lasts[own].sum() / max(said[own].sum(), LEAST_SECONDS)))
        words.append(WarpEvidence(1 - cost / backwards, abs(ratio - usual), fit.drift))
    return line, words


def confidence_of(line: WarpEvidence) -> float:
    """Return the confidence from 0 to 1 that the recording contains the text."""
    uneven = float(np.log(max(line.uneven, LEAST_UNEVEN)))
    return logistic(_weighted(LINE_WEIGHTS, min(line.better, MOST_BETTER), uneven, line.drift))


def word_confidence_of(word: WarpEvidence, line: float) -> float:
    """Return the confidence from 0 to 1 that a word is spoken in a line of known confidence."""
    return logistic(_weighted(WORD_WEIGHTS, word.better, word.uneven, _odds(line)))


def in_part(confidence: float, phonemes: int) -> float:
    """Return a text's confidence in the best of several parts of the recording."""
    lost = PART_ODDS * max(1.0, TELLING_PHONEMES / phonemes)
    return logistic(_odds(confidence) - lost)


def _odds(confidence: float) -> float:
    return float(np.log((confidence + 1e-3) / (1 - confidence + 1e-3)))


def _weighted(weights: Sequence[float], *values: float) -> float:
    return weights[0] + float(np.dot(weights[1:], values))
