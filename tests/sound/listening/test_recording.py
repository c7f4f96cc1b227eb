"""Recordings without a text, in any language: the recogniser `sound`."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from lanes import costly, full, swept
from shipped import LIBRARY

import lipsync_lang as ll
from lipsync_lang.resolver.nearest_phonemes import model_phones
from lipsync_lang.schedules import SILENCE
from lipsync_lang.sound.listening import recording
from lipsync_lang.sound.listening.mouth import heard_labels
from lipsync_lang.sound.listening.recording import (
    NOTHING_REMARK,
    SOUND_REMARK,
    likeliest_path,
    risks,
)
from lipsync_lang.sound.speech.hearing import progress
from lipsync_lang.sound.speech.hearing.recognition import recognised
from lipsync_lang.sound.speech.hearing.sphinx.decoders import MAX_PART_SAMPLES
from lipsync_lang.sound.speech.hearing.sphinx.folder import find_models
from lipsync_lang.sound.speech.sound import SPEECH_RATE
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.labels import Notation
from lipsync_lang.text.phonology.manner import Manner

pytest.importorskip("pocketsphinx")
SECOND = ll.Audio(np.zeros(SPEECH_RATE, np.int16), SPEECH_RATE)


@pytest.fixture(scope="module")
def finnish():
    return Speaker.of("finnish")


@pytest.fixture(scope="module")
def names():
    return find_models("en-us").model.names


def believed(names, *spans):
    """Return a belief of spans: their frames, and the probability of phones."""
    belief = np.zeros((sum(frames for frames, _ in spans), len(names)))
    at = 0
    for frames, chances in spans:
        for name, chance in chances.items():
            belief[at : at + frames, names.index(name)] = chance
        at += frames
    return belief


@pytest.fixture
def hear(finnish, names, monkeypatch):
    """Return a function that hears a belief in Finnish."""

    def hear(*spans):
        monkeypatch.setattr(recording, "recorded_belief", lambda *_: believed(names, *spans))
        return recognised(finnish, SECOND, recogniser="sound")

    return hear


@pytest.mark.parametrize("name", swept([one.name for one in LIBRARY.names("language")], quick=6))
def test_every_language_spells_the_phones_of_the_model(name):
    notation = Speaker.of(name).notations["ipa"]
    spelled = heard_labels(model_phones(), notation)
    assert len(spelled) == len(find_models("en-us").numbers)
    assert all(notation.find(label) is not None for label in spelled.values())


def test_a_language_without_a_letter_takes_the_nearest():
    few = Notation({"m": (("bmp", 1.0),), "f": (("f", 1.0),), "s": (("s", 1.0),)})
    spelled = heard_labels(model_phones(), few)
    assert (spelled["M"], spelled["F"], spelled["V"], spelled["Z"]) == ("m", "f", "f", "s")
    with pytest.raises(ll.SpeechError, match="toy has no notation 'ipa'"):
        recognised(Speaker(Manner("toy"), {}), SECOND, recogniser="sound")


@costly()
@given(st.integers(1, 3000), st.sampled_from([8000, 16000, 22050, 44100, 48000]))
@example(18757, 16000)
def test_no_phoneme_begins_behind_the_end_of_the_sound(names, samples, rate):
    audio = ll.Audio(np.zeros(samples, np.int16), rate)
    turns = np.array([names.index("M"), names.index("AA")])
    with pytest.MonkeyPatch.context() as patch:
        # another phone in each frame, the last one included
        patch.setattr(recording, "likeliest_path", lambda risk: np.resize(turns, len(risk)))
        found = recognised(Speaker.of("finnish"), audio, recogniser="sound")
    assert (np.diff(found.times) > 0).all()
    assert found.times[-1] == audio.seconds


def test_sounds_are_heard_in_the_letters_of_the_language(hear):
    found = hear((20, {"SIL": 1}), (10, {"M": 0.8, "B": 0.2}), (70, {"AA": 1}))
    assert (found.labels, found.notation) == ((SILENCE, "m", "ɑ"), "ipa")
    assert found.times[1:3] == pytest.approx([0.2, 0.3], abs=0.02)
    assert (found.recognised, found.confidence, found.words) == (True, None, ())
    assert found.remarks == (SOUND_REMARK,)
    assert found.likely[1][:2] == (("m", 0.8), ("b", 0.2))


def test_nothing_heard_is_told(hear):
    quiet = hear((100, {"SIL": 1}))
    assert (quiet.labels, quiet.remarks) == ((SILENCE,), (NOTHING_REMARK,))


def test_of_doubtful_sounds_that_which_looks_like_most_is_shown(hear):
    """An s is likeliest, but lips that close are likelier still."""
    doubt = {"S": 0.4, "P": 0.32, "B": 0.28}
    found = hear((20, {"SIL": 1}), (20, {"AA": 1}), (20, doubt), (40, {"AA": 1}))
    assert found.labels == (SILENCE, "ɑ", "p", "ɑ")
    assert found.likely[2][0] == ("s", 0.4)


def test_an_unsure_sound_is_shown_between_the_likely_ones(hear):
    """The mouth of a vowel that may be another one is the mean of both, by their probability."""
    performer = ll.resolve("finnish", "facefx")
    opened = []
    for sure in (1, 0.75, 0.25, 0):
        vowel = {"AA": sure, "IY": 1 - sure}
        found = hear((30, {"SIL": 1}), (40, vowel), (30, {"SIL": 1}))
        opened.append(performer.perform(found).weights[:, performer.poses.index("open")].max())
    assert sorted(opened, reverse=True) == opened
    assert opened[1] == pytest.approx(0.75 * opened[0] + 0.25 * opened[3], abs=0.02)


def test_six_likely_sounds_share_the_mouth(hear):
    """A vowel is heard among five others, and each moves the mouth in its share."""
    performer, chances = ll.resolve("finnish", "facefx"), np.array([4, 3, 3, 2, 2, 2]) / 16
    vowels = "AA", "IY", "UW", "AE", "OW", "EH"

    def shown(vowel):
        found = hear((30, {"SIL": 1}), (40, vowel), (30, {"SIL": 1}))
        assert sum(chance > 0 for _, chance in found.likely[1]) == len(vowel)
        return performer.perform(found, 100).weights[45:55].mean(axis=0)

    mean = np.average([shown({one: 1}) for one in vowels], axis=0, weights=chances)
    together = shown(dict(zip(vowels, chances, strict=True)))
    np.testing.assert_allclose(together, mean, atol=0.03)


def test_a_sound_that_a_user_corrects_is_shown_alone(hear):
    found = hear((30, {"SIL": 1}), (40, {"AA": 0.6, "IY": 0.4}), (30, {"SIL": 1}))
    known = replace(found, labels=(SILENCE, "m", SILENCE))
    performer = ll.resolve("finnish", "facefx")
    corrected, alone = (performer.perform(one) for one in (known, replace(known, likely=())))
    np.testing.assert_allclose(corrected.weights, alone.weights, atol=1e-6)


def test_an_explanation_says_that_likely_sounds_are_mixed(hear):
    found = hear((30, {"SIL": 1}), (40, {"AA": 0.6, "IY": 0.4}), (30, {"SIL": 1}))
    told = ll.resolve("finnish", "facefx").perform(found).explain(0.5)
    assert "the mean of the likely sounds" in str(told)


def test_a_change_must_be_worth_its_price(names):
    away = believed(names, (20, {"AA": 1}), (1, {"AA": 0.45, "EH": 0.55}), (20, {"AA": 1}))
    path = likeliest_path(away @ risks(model_phones(), names))
    assert {*path} == {names.index("AA")}
    assert risks(model_phones(), names)[names.index("P"), names.index("P")] == 0


@pytest.mark.parametrize("kind", ["silence", "hiss", "hum"])
def test_the_mouth_rests_where_nobody_speaks(finnish, kind):
    at = np.arange(6 * SPEECH_RATE) / SPEECH_RATE
    sound = {
        "silence": 0 * at,
        "hiss": np.random.default_rng(5).normal(size=len(at)) * 2000,
        "hum": 3000 * sum(np.sin(2 * np.pi * 50 * n * at) / n for n in (1, 2, 3, 5)),
    }[kind]
    found = recognised(finnish, ll.Audio(sound.astype(np.int16), SPEECH_RATE), recogniser="sound")
    assert (found.labels, found.remarks) == ((SILENCE,), (NOTHING_REMARK,))


@pytest.mark.parametrize("count", [1, 100, 1000])
def test_short_recordings_are_heard(finnish, count):
    found = recognised(
        finnish, ll.Audio(np.full(count, 9, np.int16), SPEECH_RATE), recogniser="sound"
    )
    assert (found.start, found.end) == (0, count / SPEECH_RATE)


@full
def test_long_recordings_are_heard_in_parts_with_their_progress(finnish):
    sound = np.random.default_rng(0).normal(size=3 * MAX_PART_SAMPLES) * 100
    told = []
    with progress.followed(told.append):
        recognised(finnish, ll.Audio(sound.astype(np.int16), SPEECH_RATE), recogniser="sound")
    assert len(told) >= 3
    assert told == sorted(told)


@full
def test_a_mouth_moves_in_a_language_without_a_recogniser(data):
    found = ll.recognise(data / "articulography/dfg91_s1em_0666.wav", "german", recogniser="sound")
    assert len(found) > 15
    assert len(found.likely) == len(found)
    animation = ll.resolve("german", "facefx").perform(found)
    assert animation.weights.max() > 0.3
    assert "likeliest by sound: " in str(animation.explain(found.end / 2))
    assert "cannot judge contacts" in ll.check(animation).remarks[-1]
    again = ll.recognise(found.audio, "german", recogniser="sound")
    assert (again.labels, again.likely) == (found.labels, found.likely)
