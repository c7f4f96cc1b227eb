"""Confidence of a warp: evidence for and against it."""

import numpy as np
import pytest

from lipsync_lang.schedules import Audio, Schedule, Word
from lipsync_lang.sound.speech.hearing.align.bending import Fit, SpokenVoice
from lipsync_lang.sound.speech.hearing.align.warping import (
    WarpEvidence,
    confidence_of,
    evidence,
    in_part,
    word_confidence_of,
)
from lipsync_lang.sound.speech.sound import SPEECH_RATE

RIGHT = WarpEvidence(better=0.13, uneven=0.28, drift=0.18)
WRONG = WarpEvidence(better=0.01, uneven=0.52, drift=0.29)


def voice():
    words = tuple(Word(name, at, at + 4) for name, at in (("one", 0), ("two", 4), ("six", 8)))
    times = 0.1 * np.arange(13)
    audio = Audio(np.zeros(2 * SPEECH_RATE, np.int16), SPEECH_RATE)
    return SpokenVoice.of(Schedule(tuple("a" * 12), times, words, audio=audio))


def fit(costs):
    return Fit(np.arange(12.0), float(np.mean(costs)), np.array(costs), 0.2, 6.0)


def test_typical_right_and_wrong_texts_are_told_apart():
    assert confidence_of(RIGHT) > 0.9
    assert confidence_of(WRONG) < 0.2


@pytest.mark.parametrize("change", [{"better": 0.05}, {"uneven": 0.6}, {"drift": 0.5}])
def test_each_piece_of_evidence_counts(change):
    assert confidence_of(RIGHT._replace(**change)) < confidence_of(RIGHT)


def test_a_word_that_is_not_said_is_doubted_in_a_line_that_is():
    costs, lasts = [4.5] * 4 + [7.0] * 4 + [4.5] * 4, [0.1] * 4 + [0.4] * 4 + [0.1] * 4
    _, words = evidence(fit(costs), np.array(lasts), voice())
    one, two, six = (word_confidence_of(word, 0.9) for word in words)
    assert two < 0.5 < min(one, six)


def test_a_slower_speaker_is_no_evidence_against_a_text():
    line, words = evidence(fit([5.0] * 12), np.full(12, 0.17), voice())
    assert line.uneven == pytest.approx(0)
    assert [word.uneven for word in words] == pytest.approx([0, 0, 0])


def test_a_short_text_is_found_in_any_speech_and_so_in_doubt():
    assert in_part(0.99, 60) > 0.7
    assert in_part(0.99, 4) < 0.01
    assert in_part(0.7, 60) < 0.5
