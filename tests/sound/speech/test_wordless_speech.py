"""Speech between recognised words: the mouth follows the sound there."""

from types import SimpleNamespace

import numpy as np
import pytest
from lanes import full

import lipsync_lang as ll
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules import SILENCE
from lipsync_lang.schedules.schedule import Word
from lipsync_lang.sound.speech.hearing import recognition
from lipsync_lang.sound.speech.hearing.recognition import with_wordless_speech
from lipsync_lang.sound.speech.speaking.speaker import Speaker

RATE = 16_000


@pytest.fixture(scope="module")
def english():
    return Speaker.of("english")


def recording(loudness):
    """Return a second of words, a second of some loudness, and a second of words."""
    noise = np.random.default_rng(0).standard_normal(3 * RATE)
    noise[RATE : 2 * RATE] *= loudness
    return ll.Audio((3000 * noise).astype(np.int16), RATE)


def recognised(audio, **more):
    """Return two words with silence between them."""
    labels, times = ("M", "AA", SILENCE, "P", "AA"), [0, 0.5, 1, 2, 2.5, 3]
    words = (Word("ma", 0, 2, confidence=0.9), Word("pa", 3, 5, confidence=0.8))
    facts = {"notation": "arpabet", "confidence": 0.8, "recognised": True, **more}
    return ll.Schedule(labels, times, words=words, audio=audio, **facts)


@pytest.fixture
def hears(monkeypatch):
    """Return a function that states what `sound` hears: labels and their starts."""

    def put(*sounds):
        def recognise(audio, _):
            if not sounds:
                raise SpeechError("not installed")
            labels, starts = zip(*sounds, strict=True)
            return ll.Schedule(labels, [*starts, audio.seconds], notation="ipa")

        engine = SimpleNamespace(recognise=recognise)
        monkeypatch.setattr(recognition, "RECOGNISERS", SimpleNamespace(find=lambda *_: engine))

    return put


SPEECH = (("m", 0.0), (SILENCE, 1.05), ("n", 1.2), ("oʊ", 1.3), (SILENCE, 1.6), ("p", 2.0))


def test_the_mouth_moves_where_a_word_was_missed(english, hears):
    hears(*SPEECH)
    found = with_wordless_speech(english, recognised(recording(1.0), stress=(None, 1, None, 0, 1)))
    assert found.labels == ("M", "AA", SILENCE, "N", "OW", SILENCE, "P", "AA")
    assert found.times == pytest.approx([0, 0.5, 1, 1.2, 1.3, 1.6, 2, 2.5, 3])
    assert [(one.text, one.start, one.end) for one in found.words] == [("ma", 0, 1), ("pa", 2, 3)]
    assert found.stress == (None, 1, None, None, None, None, 0, 1)
    assert found.remarks == ("speech without words, whose mouth follows the sound: 1.2 to 1.6 s",)
    assert found.confidence == pytest.approx(0.8 * 2 / 2.4)
    assert found.recognised


def test_sounds_may_last_from_word_to_word(english, hears):
    hears(("n", 0.9), ("oʊ", 1.2), ("n", 1.5), ("oʊ", 1.7), ("p", 2.1))
    found = with_wordless_speech(english, recognised(recording(1.0)))
    assert found.labels[2:7] == ("N", "OW", "N", "OW", "P")
    assert found.times[2:6] == pytest.approx([1, 1.2, 1.5, 1.7])


@pytest.mark.parametrize(
    ("loudness", "heard"),
    [
        (0.1, SPEECH),  # breath
        (1.0, (("m", 0.0), (SILENCE, 1.1), ("p", 2.0))),  # noise, and the end of a word
        (1.0, ((SILENCE, 0.0), ("ɜ", 1.1), ("n", 1.5), (SILENCE, 1.9))),  # tones of music
        (1.0, ()),
    ],
)
def test_nothing_moves_it_without_speech(english, hears, loudness, heard):
    hears(*heard)
    given = recognised(recording(loudness))
    assert with_wordless_speech(english, given) is given


def test_schedules_without_words_or_sound_stay(english, hears):
    hears(*SPEECH)
    for one in (recognised(None), recognised(recording(1.0), notation=None)):
        assert with_wordless_speech(english, one) is one
    alone = ll.Schedule(("m", SILENCE), [0, 1, 3], notation="ipa", audio=recording(1.0))
    assert with_wordless_speech(english, alone) is alone


@full
def test_words_that_a_recogniser_missed_are_heard(english):
    pytest.importorskip("pocketsphinx")
    spoken = ll.speak("Look out behind you. No, no, no! Get away from the door.", "english")
    missed = [number for number, word in enumerate(spoken.words) if word.text.casefold() == "no"]
    first, stop = spoken.words[missed[0]].first, spoken.words[missed[-1]].stop
    labels = (*spoken.labels[:first], SILENCE, *spoken.labels[stop:])
    times = np.delete(spoken.times, range(first + 1, stop))
    given = ll.Schedule(
        labels,
        times,
        words=(Word("Look out behind you", 0, first - 1),),
        notation=spoken.notation,
        audio=spoken.audio,
        confidence=1.0,
    )
    found = with_wordless_speech(english, given)
    start, end = spoken.times[first], spoken.times[stop]
    spans = zip(found.labels, found.times, found.times[1:], strict=False)
    heard = sum(z - a for label, a, z in spans if label != SILENCE and start <= a and z <= end)
    assert heard > 0.5 * (end - start)
    assert "speech without words" in found.remarks[-1]
