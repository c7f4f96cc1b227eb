"""Many recordings at once: the same results as one by one, even if some fail."""

import threading
from dataclasses import replace

import numpy as np
import pytest
from lanes import full

import lipsync_lang as ll
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules import Audio, Schedule
from lipsync_lang.sound.speech.hearing.align.aligners import ALIGNERS
from lipsync_lang.sound.speech.hearing.align.pocketsphinx_aligner import PocketsphinxAligner
from lipsync_lang.sound.speech.hearing.align.warping import Warp
from lipsync_lang.sound.speech.hearing.alignment import align_many, aligned
from lipsync_lang.sound.speech.hearing.recognise.recognisers import RECOGNISERS
from lipsync_lang.sound.speech.hearing.recognition import recognise_many, recognised
from lipsync_lang.sound.speech.hearing.sphinx import decoders
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.manner import Hearing, Manner

MANNER = Manner("letters", audio=Hearing(("ruler",), "ruler"))
SOUND = Audio(np.zeros(800, np.int16), 8000)


class Ruler:
    """An aligner and a recogniser that divide the sound evenly, and fail at `!`."""

    def align(self, audio, text, speaker, model=None):
        """Align a text."""
        assert model is None
        if "!" in text or not text:
            raise SpeechError(f"'{text}' does not fit")
        times = np.linspace(0, audio.seconds, len(text) + 1)
        return Schedule(tuple(text), times, language=speaker.manner.language, audio=audio)

    def recognise(self, audio, speaker, model=None):
        """Recognise a sound."""
        return self.align(audio, "a", speaker, model)


class BatchRuler(Ruler):
    """A ruler that takes two texts at once."""

    def align_many(self, recordings, speaker, model=None):
        """Align pairs of texts."""
        source = iter(recordings)
        for first in source:
            for sound, text in [first, *(one for one in [next(source, None)] if one)]:
                try:
                    yield self.align(sound(), text, speaker, model)
                except SpeechError as error:
                    yield error


@pytest.fixture(params=[Ruler, BatchRuler])
def speaker(request, monkeypatch):
    """A speaker of a language with a ruler as its aligner."""
    monkeypatch.setitem(ALIGNERS.known, "ruler", request.param())
    monkeypatch.setitem(RECOGNISERS.known, "ruler", request.param())
    monkeypatch.setattr(Speaker, "of", lambda *_: made)
    made = Speaker(MANNER, {})
    return made


def plain(result):
    """Return the values of a result for comparisons."""
    if isinstance(result, SpeechError):
        return str(result)
    return repr(replace(result, audio=None)), result.times.tobytes(), result.words


def one_by_one(speaker, pairs, **how):
    """Align each pair by itself."""
    for audio, text in pairs:
        try:
            yield aligned(speaker, audio, text, **how)
        except SpeechError as error:
            yield error


def test_many_are_what_each_is_by_itself(speaker, tmp_path):
    pairs = [(SOUND, "ab"), (SOUND, "no!"), (tmp_path / "none.wav", "ab"), (SOUND, "*a* b")]
    found = [plain(one) for one in align_many(speaker, pairs)]
    assert found == [plain(one) for one in one_by_one(speaker, pairs)]
    assert [isinstance(one, str) for one in found] == [False, True, True, False]
    assert "none.wav" in found[2]


def test_recordings_are_read_when_their_turn_comes(speaker, tmp_path, monkeypatch):
    taken, reading = [], []
    monkeypatch.setattr(
        "lipsync_lang.sound.speech.hearing.alignment.sound_of",
        lambda audio: reading.append(audio) or SOUND,
    )
    files = (taken.append(n) or (tmp_path / f"{n}.wav", "a") for n in range(100))
    found = align_many(speaker, files)
    assert next(found).labels == ("a",)
    assert len(taken) <= 2
    assert len(reading) == 1
    assert sum(1 for _ in found) == 99


def test_several_recordings_give_an_iterator(speaker):
    several = ll.align([SOUND, SOUND, SOUND], ["a", "a!", "b"], "letters")
    assert next(several).labels == ("a",)
    with pytest.raises(SpeechError, match="does not fit"):
        next(several)
    assert next(several).labels == ("b",)
    assert isinstance(ll.align(SOUND, "a", "letters"), Schedule)
    assert [one.labels for one in ll.recognise(iter([SOUND, SOUND]), "letters")] == [("a",)] * 2
    assert isinstance(ll.recognise(SOUND, "letters"), Schedule)
    assert speaker.manner is MANNER


@pytest.mark.parametrize(
    ("audio", "text", "message"),
    [
        ([SOUND], ["a", "b"], "more texts than recordings"),
        ([SOUND, SOUND], ["a"], "more recordings than texts"),
        ([SOUND, SOUND], "ab", "is a list of recordings"),
        (SOUND, ["a"], "one recording"),
    ],
)
@pytest.mark.usefixtures("speaker")
def test_each_recording_has_a_text(audio, text, message):
    with pytest.raises(SpeechError, match=message):
        list(ll.align(audio, text, "letters"))


def test_what_fails_for_all_is_the_error_of_each(speaker):
    for found in (
        align_many(speaker, [(SOUND, "a")] * 2, aligner="rulr"),
        recognise_many(speaker, [SOUND] * 2, recogniser="rulr"),
        Warp().align_many([(lambda: SOUND, "a")] * 2, speaker, "en-us"),
        PocketsphinxAligner().align_many([(lambda: SOUND, "a")] * 2, speaker, None),
    ):
        assert [type(one) for one in found] == [SpeechError] * 2


# Engines

TEXTS = ["Please buy five maps.", "", "Never say so of the old one, in 1999!", "Nobody knows it."]


@pytest.fixture(scope="module")
def recordings():
    """Recordings with their texts; the second text is empty, and one belongs to another."""
    pytest.importorskip("espeakng_loader")
    pytest.importorskip("soundfile")
    spoken = [one.audio for one in Speaker.of("english").speak_many(TEXTS[::2])]
    return [(spoken[0], TEXTS[0]), (spoken[1], TEXTS[1]), (spoken[1], TEXTS[2]),
            (spoken[1].__class__(spoken[1].samples[:500], spoken[1].rate), TEXTS[3]),
            (spoken[1], TEXTS[0])]  # fmt: skip


@full
@pytest.mark.parametrize("name", ["warp", "pocketsphinx"])
def test_aligners_find_the_same_in_many(recordings, name):
    pytest.importorskip("dtaidistance" if name == "warp" else name)
    speaker = Speaker.of("english")
    together = [plain(one) for one in align_many(speaker, recordings, aligner=name)]
    assert together == [plain(one) for one in one_by_one(speaker, recordings, aligner=name)]
    assert [isinstance(one, str) for one in together][:4] == [False, True, False, True]


@full
def test_a_decoder_is_loaded_once_in_a_thread_and_hears_the_same(recordings, monkeypatch):
    pytest.importorskip("pocketsphinx")
    speaker = Speaker.of("english")
    sounds = [recordings[0][0], recordings[2][0], recordings[0][0]]
    by = {"recogniser": "pocketsphinx"}
    alone = []
    for sound in sounds:
        monkeypatch.setattr(decoders, "threads", threading.local())
        alone.append(plain(recognised(speaker, sound, **by)))
    together = [plain(one) for one in recognise_many(speaker, sounds, **by)]
    assert together == alone
    assert len(decoders.threads.loaded) == 1
