"""Names of aligners and recognisers, with and without a model."""

import numpy as np
import pytest

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules import Audio, Schedule
from lipsync_lang.schedules.schedule import Word
from lipsync_lang.sound.speech.hearing.align.aligners import ALIGNERS
from lipsync_lang.sound.speech.hearing.alignment import aligned, engine_and_model
from lipsync_lang.sound.speech.hearing.recognise.recognisers import RECOGNISERS
from lipsync_lang.sound.speech.hearing.recognition import recognised
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.manner import Hearing, Manner

SOUND = Audio(np.zeros(800, np.int16), 8000)


@pytest.mark.parametrize(
    ("named", "stated", "model", "found"),
    [
        (None, "warp", None, ("warp", None)),
        (None, None, None, (None, None)),
        (None, "lay", "en", ("lay", "en")),
        ("lay", "lay", "en", ("lay", "en")),
        ("warp", "lay", "en", ("warp", None)),
        ("lay:de", "lay", "en", ("lay", "de")),
        ("lay", "lay:de", "en", ("lay", "de")),
        ("lay:C:\\models\\de.zip", "warp", None, ("lay", "C:\\models\\de.zip")),
    ],
)
def test_the_model_is_that_of_the_engine(named, stated, model, found):
    assert engine_and_model(named, stated, model) == found


@pytest.mark.parametrize("named", ["lay:", ":de", "", " : "])
def test_half_a_name_is_told(named):
    with pytest.raises(SpeechError, match="write NAME, or NAME:MODEL"):
        engine_and_model(named, "warp")


class Noted:
    """An aligner and a recogniser that record their model."""

    def align(self, audio, text, speaker, model=None):
        """Align a text."""
        assert speaker.manner.language == "letters"
        times, words = np.array([0, audio.seconds]), (Word(text, 0, 1),)
        return Schedule((model or "none",), times, words, audio=audio)

    def recognise(self, audio, speaker, model=None):
        """Recognise a sound."""
        return self.align(audio, "", speaker, model)


def test_a_model_reaches_its_engine(monkeypatch):
    for known in (ALIGNERS.known, RECOGNISERS.known):
        monkeypatch.setitem(known, "noted", Noted())
    speaker = Speaker(Manner("letters", audio=Hearing(("noted:big",), "noted", "small")), {})
    assert aligned(speaker, SOUND, "a").labels == ("big",)
    assert aligned(speaker, SOUND, "a", aligner="noted:huge").labels == ("huge",)
    assert recognised(speaker, SOUND).labels == ("small",)
    assert recognised(speaker, SOUND, recogniser="noted:huge").labels == ("huge",)
    with pytest.raises(SpeechError, match="write NAME, or NAME:MODEL"):
        aligned(speaker, SOUND, "a", aligner="noted:")
