"""Recordings in any form: the same boundaries, and a remark if the text does not fit.

All of it is aligned by each aligner that needs nothing but this program.
"""

from itertools import pairwise

import numpy as np
import pytest
from lanes import full

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules import Audio
from lipsync_lang.schedules.schedule import DOUBTFUL, SILENCE
from lipsync_lang.sound.speech.hearing.alignment import align_many, aligned
from lipsync_lang.sound.speech.sound import read_audio, resampled
from lipsync_lang.sound.speech.speaking.speaker import Speaker

pytest.importorskip("pocketsphinx")
soundfile = pytest.importorskip("soundfile")
pytestmark = full

RATE = 16_000
TEXT = "Glue the sheet to the dark blue background."
ALIGNERS = ["pocketsphinx", "warp"]


@pytest.fixture(scope="module")
def english():
    return Speaker.of("english")


@pytest.fixture(scope="module")
def voice(english):
    """Sound of the language's voice, at the rate of the models."""
    return resampled(english.speak(TEXT).audio, RATE).samples


# What fits nothing


def noise(seconds):
    return np.random.default_rng(3).normal(0, 2000, seconds * RATE).astype(np.int16)


def tone(seconds):
    return np.rint(3000 * np.sin(np.arange(seconds * RATE) / 5)).astype(np.int16)


def music(seconds):
    times = np.arange(seconds * RATE) / RATE
    chord = sum(np.sin(2 * np.pi * hertz * times) for hertz in (220, 277, 330))
    return (1300 * chord * (1 + np.sin(4 * np.pi * times))).astype(np.int16)


@pytest.mark.parametrize("aligner", ALIGNERS)
@pytest.mark.parametrize(
    ("made", "text"),
    [
        (lambda _: np.zeros(5 * RATE, np.int16), TEXT),
        (lambda _: noise(5), TEXT),
        (lambda _: music(5), TEXT),
        (lambda voice: voice, "Four hours of steady work faced us."),
        (lambda _: tone(1), "Four hours of steady work faced us all"),
        (lambda voice: np.tile(voice, 15)[: 30 * RATE], "map"),
        (lambda voice: voice[:RATE], "please buy five maps " * 250),
        (lambda voice: voice[: RATE // 50], "hello"),
        (lambda voice: voice[:1], "hello"),
    ],
    ids=[
        "silence", "noise", "music", "another text", "a tone", "a word for half a minute",
        "a thousand words for a second", "a fiftieth of a second", "a sample",
    ],
)  # fmt: skip
def test_what_does_not_fit_is_told_and_nothing_is_pretended(english, voice, aligner, made, text):
    (found,) = align_many(english, [(Audio(made(voice), RATE), text)], aligner=aligner)
    if isinstance(found, SpeechError):
        assert len(str(found)) < 300
        return
    assert found.confidence < DOUBTFUL
    assert "hardly fits the recording" in found.remarks[0]


# Every file that people have

FORMS = {
    "8 kHz": ("a.wav", {"rate": 8000}),
    "44.1 kHz, 24 bits": ("a.wav", {"rate": 44_100, "subtype": "PCM_24"}),
    "96 kHz, floats": ("a.wav", {"rate": 96_000, "subtype": "FLOAT"}),
    "mp3": ("a.mp3", {}),
    "ogg": ("a.ogg", {}),
    "opus": ("a.opus", {"format": "OGG", "subtype": "OPUS"}),
    "left alone": ("a.wav", {"channels": (1, 0)}),
    "right alone": ("a.wav", {"channels": (0, 1)}),
    "one reversed": ("a.wav", {"channels": (1, -1)}),
    "quiet": ("a.wav", {"gain": 0.01}),
    "clipped": ("a.wav", {"gain": 8.0}),
    "beside a constant": ("a.wav", {"constant": 0.3}),
}


def as_file(path, sound, **how):
    """Write a sound in a file format."""
    usual = {"rate": RATE, "channels": (1,), "gain": 1.0, "constant": 0.0}
    rate, channels, gain, constant = (how.pop(name, value) for name, value in usual.items())
    samples = resampled(sound, rate).samples / 2**15
    samples = np.clip(samples * gain + constant, -1, 1 - 2**-15)
    soundfile.write(path, samples[:, None] * np.array(channels), rate, **how)
    return path


@pytest.mark.parametrize("aligner", ALIGNERS)
@pytest.mark.parametrize("form", FORMS)
def test_the_form_of_a_file_moves_next_to_nothing(english, voice, tmp_path, aligner, form):
    sound = Audio(voice, RATE)
    plain = aligned(english, sound, TEXT, aligner=aligner)
    name, how = FORMS[form]
    heard = aligned(english, as_file(tmp_path / name, sound, **how), TEXT, aligner=aligner)
    assert [word.text for word in heard.words] == [word.text for word in plain.words]
    away = np.abs(starts(heard) - starts(plain))
    assert np.median(away) <= 0.01
    assert away.max() <= 0.06
    assert heard.end == pytest.approx(heard.audio.seconds)


def starts(schedule):
    """Return the start of each word."""
    return np.array([schedule.times[word.first] for word in schedule.words])


@pytest.mark.parametrize(
    ("language", "word"), [("english", "map"), ("english", "pumpkin"), ("hindi", "नमस्ते")]
)
def test_a_word_between_long_pauses_stays_in_its_place(language, word):
    speaker = Speaker.of(language)
    said = resampled(speaker.speak(word).audio, RATE)
    pause = np.zeros(2 * RATE, np.int16)
    long = Audio(np.concatenate([pause, said.samples, pause]), RATE)
    alone, padded = (aligned(speaker, one, word, aligner="pocketsphinx") for one in (said, long))
    assert padded.confidence >= DOUBTFUL
    places, later = (
        [start for label, start in zip(one.labels, one.times, strict=False) if label != SILENCE]
        for one in (alone, padded)
    )
    assert np.subtract(later, 2) == pytest.approx(places, abs=0.05)


@pytest.mark.parametrize("aligner", ALIGNERS)
def test_each_channel_may_have_its_own_speaker(english, voice, tmp_path, aligner):
    other = resampled(english.speak("The hogs were fed chopped corn and garbage.").audio, RATE)
    length = min(len(voice), len(other.samples))
    path = tmp_path / "two.wav"
    soundfile.write(path, np.stack([voice[:length], other.samples[:length]], axis=1), RATE)
    texts = (TEXT, "The hogs were fed chopped corn and garbage.")
    sure = [
        [
            aligned(english, read_audio(path, channel), text, aligner=aligner).confidence
            for channel in (1, 2)
        ]
        for text in texts
    ]
    assert sure[0][0] > 0.5 > sure[0][1]
    assert sure[1][1] > 0.5 > sure[1][0]


def test_a_natural_recording_is_aligned_alike_in_every_form(english, data, tmp_path):
    folder = data / "recordings" / "mfa_tests"
    text = (folder / "61-70968-0000.lab").read_text("utf-8").strip()
    sound = read_audio(folder / "61-70968-0000.flac")
    plain = starts(aligned(english, sound, text))
    assert all(later > earlier for earlier, later in pairwise(plain))
    for form in ("8 kHz", "mp3", "opus", "left alone", "quiet"):
        name, how = FORMS[form]
        heard = aligned(english, as_file(tmp_path / name, sound, **how), text)
        away = np.abs(starts(heard) - plain)
        assert np.median(away) <= 0.01
        assert np.quantile(away, 0.9) <= 0.05
