"""Recognition: what is said in a recording that nobody wrote down."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import costly, full, swept

import lipsync_lang as ll
from lipsync_lang.schedules import SILENCE
from lipsync_lang.speech.hearing import recognised
from lipsync_lang.speech.recognise.pocketsphinx_recogniser import LONGEST, SHORTEST, parts
from lipsync_lang.speech.speaking import Speaker
from lipsync_lang.speech.sphinx.features import RATE, STEP

pytest.importorskip("pocketsphinx")
pytest.importorskip("soundfile")


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
    assert heard.confidence > 0.8


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
    module = "lipsync_lang.speech.recognise.pocketsphinx_recogniser"
    monkeypatch.setattr(f"{module}.SHORTEST", 2 * RATE)
    monkeypatch.setattr(f"{module}.LONGEST", 4 * RATE)
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
    found = recognised(english, ll.Audio(np.zeros(count, np.int16), RATE))
    assert found.labels == (SILENCE,)
    assert found.words == ()
    assert found.confidence == 0
    assert "no words were heard" in found.remarks[0]


@full
def test_sounds_without_words_are_heard_as_phonemes(heard, english, monkeypatch):
    monkeypatch.setattr(
        "lipsync_lang.speech.recognise.pocketsphinx_recogniser._words", lambda *_: []
    )
    found = recognised(english, heard.audio)
    assert found.words == ()
    sounds = [label for label in found.labels if label != SILENCE]
    assert len(sounds) > 15
    assert all(english.notations["arpabet"].find(label) for label in sounds)
    assert found.confidence == 0


def test_a_language_without_a_recogniser_says_what_can_be_done():
    with pytest.raises(ll.SpeechError, match=r"finnish has no recogniser: give the text"):
        ll.recognise(ll.Audio(np.zeros(RATE, np.int16), RATE), "finnish")


def test_a_recogniser_that_is_not_there_is_told(english):
    with pytest.raises(ll.SpeechError, match="no recogniser 'pocketsphinks'; did you mean"):
        recognised(english, ll.Audio(np.zeros(RATE, np.int16), RATE), recogniser="pocketsphinks")


@costly()
@given(st.integers(1, 3 * LONGEST), st.integers(0, 1000))
def test_parts_cover_the_sound_without_gaps(count, seed):
    sound = np.random.default_rng(seed).normal(size=count)
    found = list(parts(sound))
    assert found[0][0] == 0
    assert found[-1][1] == count
    for (_, stop), (start, _) in pairwise(found):
        assert stop == start
        assert start % STEP == 0
    assert all(SHORTEST <= b - a <= LONGEST for a, b in found[:-1])


def test_parts_are_cut_where_it_is_quietest():
    sound = np.ones(2 * LONGEST)
    sound[15 * RATE : 16 * RATE] = 0
    (_, stop), *_ = parts(sound)
    assert 15 * RATE <= stop <= 16 * RATE


def test_the_command_line_recognises(data, cli, tmp_path):
    sound = data / "alignments" / "english_hts" / "arctic_a0009.wav"
    out = tmp_path / "line.csv"
    ended = cli("run", "--audio", sound, "-l", "english", "-c", "facefx", "-o", out)
    assert ended.code == 0
    assert "heard: he turned sharply" in ended.err
    assert out.exists()
