"""Recognition of speech in recordings without a text."""

from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import costly, full, swept

import lipsync_lang as ll
from lipsync_lang.schedules import SILENCE
from lipsync_lang.sound.speech.hearing.recognise.pocketsphinx_recogniser import _remarks, chance
from lipsync_lang.sound.speech.hearing.recognition import recognised as recognised_by
from lipsync_lang.sound.speech.hearing.sphinx.decoders import (
    MAX_PART_SAMPLES,
    MIN_PART_SAMPLES,
    parts,
)
from lipsync_lang.sound.speech.hearing.sphinx.features import HOP_SAMPLES
from lipsync_lang.sound.speech.hearing.sphinx.forced import HeardPhoneme
from lipsync_lang.sound.speech.hearing.sphinx.scheduling import Saying
from lipsync_lang.sound.speech.sound import SPEECH_RATE
from lipsync_lang.sound.speech.speaking.speaker import Speaker

pytest.importorskip("pocketsphinx")
pytest.importorskip("soundfile")

recognised = partial(recognised_by, recogniser="pocketsphinx")


@pytest.fixture(scope="module")
def english():
    return Speaker.of("english")


@pytest.fixture(scope="module")
def heard(data, english):
    return recognised(english, data / "alignments" / "english_hts" / "arctic_a0009.wav")


@full
def test_words_that_are_said_are_heard(heard):
    said = ["he", "turned", "sharply", "and", "faced", "gregson", "across", "the", "table"]
    assert [word.text for word in heard.words] == said
    assert heard.confidence > 0.6
    sure = [word.confidence for word in heard.words]
    assert heard.confidence == pytest.approx(np.mean(sure))
    assert min(sure) < max(sure)


@full
def test_what_was_recognised_says_so_and_repeats_it(heard):
    assert heard.recognised
    assert "heard: he turned sharply" in heard.remarks[0]
    assert (heard.notation, heard.language) == ("arpabet", "english")


@full
def test_what_was_recognised_is_aligned(heard):
    text = " ".join(word.text for word in heard.words)
    known = ll.align(heard.audio, text, "english")
    assert heard.labels[1:5] == known.labels[1:5]
    assert np.abs(heard.times[1:10] - known.times[1:10]).max() < 0.02
    assert (heard.start, heard.end) == (0.0, heard.audio.seconds)


@full
def test_what_was_recognised_can_be_performed(heard):
    animation = ll.resolve("english", "facefx").perform(heard)
    assert animation.weights.max() > 0.3


@full
def test_long_recordings_are_heard_in_parts(heard, english, monkeypatch):
    short = partial(parts, shortest=2 * SPEECH_RATE, longest=4 * SPEECH_RATE)
    monkeypatch.setattr(
        "lipsync_lang.sound.speech.hearing.recognise.pocketsphinx_recogniser.parts", short
    )
    pause = np.zeros(heard.audio.rate // 2, np.int16)
    whole = np.concatenate([*[heard.audio.samples, pause] * 2])
    found = recognised(english, ll.Audio(whole, heard.audio.rate))
    words = [word.text for word in found.words]
    assert words.count("table") == words.count("gregson") == 2
    tables = [found.times[word.first] for word in found.words if word.text == "table"]
    assert tables[1] - tables[0] == pytest.approx(found.end / 2, abs=0.05)


@full
@pytest.mark.parametrize("count", swept([16_000, 100, 1]))
def test_silence_is_a_pause(english, count):
    found = recognised(english, ll.Audio(np.zeros(count, np.int16), SPEECH_RATE))
    assert found.labels == (SILENCE,)
    assert found.words == ()
    assert found.confidence == 0
    assert "no words were heard" in found.remarks[0]


@pytest.mark.parametrize("heard_by", [ll.recognise, lambda sound, of: ll.align(sound, "maps", of)])
def test_a_recording_without_samples_has_no_sound(heard_by):
    with pytest.raises(ll.SpeechError, match="has no sound; record it again"):
        heard_by(ll.Audio(np.zeros(0, np.int16), 16000), "english")


@full
def test_sounds_without_words_are_heard_as_phonemes(heard, english, monkeypatch):
    monkeypatch.setattr(
        "lipsync_lang.sound.speech.hearing.recognise.pocketsphinx_recogniser.decoded_words",
        lambda *_: [],
    )
    found = recognised(english, heard.audio)
    assert found.words == ()
    sounds = [label for label in found.labels if label != SILENCE]
    assert len(sounds) > 15
    assert all(english.notations[found.notation].find(label) for label in sounds)
    assert found.remarks[0] == "no words were heard"
    assert found.confidence == 0


def fitting(fit, frames=10):
    return HeardPhoneme(0, 1, 0, frames, fit)


def test_a_word_is_as_sure_as_its_posterior_and_its_fit():
    assert chance(1.0, [fitting(1.0)]) > 0.7
    assert chance(0.01, [fitting(1.0)]) < 0.3
    assert chance(1.0, [fitting(-4.0)]) < 0.15, "a posterior of 1 does not make a word right"
    assert chance(1.0, [fitting(1.0, 90), fitting(-4.0)]) > chance(1.0, [fitting(-4.0)])
    assert chance(0.0, [fitting(0.0)]) < 0.01
    assert chance(1.0, []) == 0


def test_words_in_doubt_are_named_with_their_time():
    sayings = [Saying("good", ()), Saying("morning", ())]
    heard = [fitting(0.0, 30), HeardPhoneme(1, 2, 30, 60, 0.0)]
    assert _remarks(heard, sayings, [0.9, 0.1]) == (
        "heard: good morning", "words in doubt: 'morning' at 0.3 s",
    )  # fmt: skip
    assert _remarks(heard, sayings, [0.9, 0.8]) == ("heard: good morning",)


@full
def test_words_of_music_are_not_sure(english):
    at = np.arange(5 * SPEECH_RATE) / SPEECH_RATE
    tones = sum(np.sin(2 * np.pi * f * at) * np.exp(-3 * ((2 * at) % 1)) for f in (220, 277, 440))
    found = recognised(english, ll.Audio((3000 * tones).astype(np.int16), SPEECH_RATE))
    assert found.confidence < 0.4


def test_a_model_of_another_language_recognises_no_words():
    sound = ll.Audio(np.zeros(SPEECH_RATE, np.int16), SPEECH_RATE)
    with pytest.raises(ll.SpeechError, match=r"finnish.*'en-us'"):
        ll.recognise(sound, "finnish", recogniser="pocketsphinx:en-us")


def test_a_recogniser_that_is_not_there_is_told(english):
    with pytest.raises(ll.SpeechError, match="'pocketsphinks'; did you mean"):
        recognised_by(
            english,
            ll.Audio(np.zeros(SPEECH_RATE, np.int16), SPEECH_RATE),
            recogniser="pocketsphinks",
        )


@costly()
@given(st.integers(1, 3 * MAX_PART_SAMPLES), st.integers(0, 1000))
def test_parts_cover_the_sound_without_gaps(count, seed):
    sound = np.random.default_rng(seed).normal(size=count)
    found = list(parts(sound))
    assert found[0][0] == 0
    assert found[-1][1] == count
    for (_, stop), (start, _) in pairwise(found):
        assert stop == start
        assert start % HOP_SAMPLES == 0
    assert all(MIN_PART_SAMPLES <= b - a <= MAX_PART_SAMPLES for a, b in found[:-1])


def test_parts_are_cut_where_it_is_quietest():
    sound = np.ones(2 * MAX_PART_SAMPLES)
    sound[15 * SPEECH_RATE : 16 * SPEECH_RATE] = 0
    (_, stop), *_ = parts(sound)
    assert 15 * SPEECH_RATE <= stop <= 16 * SPEECH_RATE


def test_the_command_line_recognises(data, cli, tmp_path):
    sound = data / "alignments" / "english_hts" / "arctic_a0009.wav"
    out = tmp_path / "line.csv"
    to = ("-l", "english", "-c", "facefx", "--recogniser", "pocketsphinx", "-o", out)
    ended = cli("run", "--audio", sound, *to)
    assert ended.code == 0
    assert "heard: he turned sharply" in ended.err
    assert out.exists()
