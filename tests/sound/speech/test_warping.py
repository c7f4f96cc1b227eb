"""Alignment by warping: the voice of any language, warped to a recording of the same text."""

from dataclasses import replace
from importlib.util import find_spec
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full
from voices import speak

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules import SILENCE, Audio, Schedule, Word
from lipsync_lang.schedules.schedule import DOUBTFUL
from lipsync_lang.sound.speech.hearing.align.aligners import ALIGNERS
from lipsync_lang.sound.speech.hearing.align.bending import SpokenVoice, _coarse, _edges
from lipsync_lang.sound.speech.hearing.align.spectrum import heard_in, mel_power, samples_of
from lipsync_lang.sound.speech.hearing.align.warping import MIN_PHONEME_SECONDS, _pauses, _spaced
from lipsync_lang.sound.speech.sound import SPEECH_RATE, read_audio
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.align import align as match

MISSING = [name for name in ("espeakng_loader", "dtaidistance") if find_spec(name) is None]
pytestmark = pytest.mark.skipif(bool(MISSING), reason=f"needs {' and '.join(MISSING)}")

WARP = ALIGNERS["warp"]
TEXT = "The juice of lemons makes fine punch, and the salt breeze came across from the sea."
SENTENCES = {
    "dfgspp_mo1_prosody_0020": "Sie arbeitet in einer Kneipe als Kellnerin.",
    "dfgspp_mo1_prosody_0024": "Morgen muss sie weder Klausur noch Examen schreiben.",
}


@pytest.fixture(scope="module")
def speakers():
    return {name: Speaker.of(name) for name in ("english", "german", "finnish")}


@pytest.fixture(scope="module")
def recording():
    """A recording by another, slower voice, with its true times."""
    # a voice without an echo, which would fill its closures
    return speak(TEXT, "en-us+m1", words_per_minute=130)


def errors(found, true, notation=None):
    """Return time differences between starts of sounds with the same sound before them."""
    names = [
        [(notation or {}).get(label, label) for label in one.labels if label != SILENCE]
        for one in (found, true)
    ]
    starts = [
        [t for label, t in zip(one.labels, one.times, strict=False) if label != SILENCE]
        for one in (found, true)
    ]
    at = match(names[1], names[0], {}, SILENCE)
    return np.array(
        [
            starts[0][n] - starts[1][at[n]]
            for n in range(1, len(at))
            if at[n - 1] >= 0 and at[n] == at[n - 1] + 1 and names[1][at[n]] == names[0][n]
        ]
    )


def gapped(schedule, at, seconds):
    """A recording with a pause of faint noise at a boundary."""
    sample = int(schedule.times[at] * schedule.audio.rate)
    hum = np.random.default_rng(1).integers(-3, 4, int(seconds * schedule.audio.rate))
    samples = schedule.audio.samples
    sound = np.concatenate([samples[:sample], hum.astype(np.int16), samples[sample:]])
    return Audio(sound, schedule.audio.rate)


@full
def test_another_voice_at_another_speed_is_found_to_a_frame(speakers, recording):
    found = WARP.align(recording.audio, TEXT, speakers["english"])
    wrong = np.abs(errors(found, recording))
    assert len(wrong) > 40
    assert np.median(wrong) < 0.01
    assert np.percentile(wrong, 90) < 0.03


def test_the_result_is_the_voices_phonemes_and_words_at_the_recordings_times(speakers, recording):
    found = WARP.align(recording.audio, TEXT, speakers["english"])
    said = speakers["english"].speak(TEXT)
    assert [x for x in found.labels if x != SILENCE] == [x for x in said.labels if x != SILENCE]
    assert [w.text for w in found.words] == [w.text for w in said.words]
    for mine, its in zip(found.words, said.words, strict=True):
        spoken = [x for x in found.labels[mine.first : mine.stop] if x != SILENCE]
        assert spoken == [x for x in said.labels[its.first : its.stop] if x != SILENCE]
    assert (found.notation, found.language) == (said.notation, "english")
    assert found.audio is recording.audio
    assert (found.start, found.end) == (0.0, recording.audio.seconds)
    assert np.diff(found.times).min() >= MIN_PHONEME_SECONDS - 1e-9
    assert not found.estimated


@full
def test_a_recording_made_twice_is_aligned_alike(speakers, recording):
    one, two = (WARP.align(recording.audio, TEXT, speakers["english"]) for _ in range(2))
    assert np.array_equal(one.times, two.times)


@pytest.mark.parametrize("seconds", [0.4, 1.5])
def test_pauses_that_the_voice_lacks_become_silence_before_their_word(speakers, recording, seconds):
    word = next(w for w in recording.words if w.text == "makes")
    found = WARP.align(gapped(recording, word.first, seconds), TEXT, speakers["english"])
    at = next(w.first for w in found.words if w.text == "makes")
    start = recording.times[word.first]
    assert found.labels[at - 1] == SILENCE
    assert found.times[at - 1] == pytest.approx(start, abs=0.05)
    assert found.times[at] == pytest.approx(start + seconds, abs=0.05)


def test_a_long_pause_within_a_word_is_silence_there(speakers, recording):
    word = next(w for w in recording.words if w.text == "lemons")
    inside = word.first + 3
    found = WARP.align(gapped(recording, inside, 0.8), TEXT, speakers["english"])
    mine = next(w for w in found.words if w.text == "lemons")
    at = mine.first + found.labels[mine.first : mine.stop].index(SILENCE)
    start = recording.times[inside]
    assert found.times[at : at + 2] == pytest.approx([start, start + 0.8], abs=0.05)


def test_of_vocal_tracts_the_one_that_fits_is_taken(speakers, recording, monkeypatch):
    found = []
    for tracts in ((1.0,), (0.5, 1.0, 1.8)):
        monkeypatch.setattr("lipsync_lang.sound.speech.hearing.align.bending.TRACTS", tracts)
        found.append(WARP.align(recording.audio, TEXT, speakers["english"]))
    np.testing.assert_array_equal(found[0].times, found[1].times)


def test_silence_around_the_speech_is_silence(speakers, recording):
    quiet = np.random.default_rng(2).integers(-9, 10, SPEECH_RATE).astype(np.int16)
    samples = np.concatenate([quiet, recording.audio.samples, quiet])
    found = WARP.align(Audio(samples, recording.audio.rate), TEXT, speakers["english"])
    lead = SPEECH_RATE / recording.audio.rate
    first = next(n for n, x in enumerate(recording.labels) if x != SILENCE)
    assert found.labels[0] == found.labels[-1] == SILENCE
    assert found.times[1] == pytest.approx(lead + recording.times[first], abs=0.05)


def test_a_click_is_no_speech(speakers, recording):
    quiet = np.random.default_rng(2).integers(-9, 10, SPEECH_RATE).astype(np.int16)
    quiet[SPEECH_RATE // 4 : SPEECH_RATE // 4 + SPEECH_RATE // 50] += 6000
    samples = np.concatenate([quiet, recording.audio.samples])
    found = WARP.align(Audio(samples, recording.audio.rate), TEXT, speakers["english"])
    first = next(n for n, x in enumerate(recording.labels) if x != SILENCE)
    start = SPEECH_RATE / recording.audio.rate + recording.times[first]
    assert found.times[1] == pytest.approx(start, abs=0.05)


@pytest.mark.parametrize("decibels", [20, 10])
def test_noise_does_no_great_harm(speakers, recording, decibels):
    sound = recording.audio.samples.astype(float)
    hiss = np.random.default_rng(3).standard_normal(len(sound))
    noisy = sound + hiss * np.sqrt((sound**2).mean()) * 10 ** (-decibels / 20)
    audio = Audio(np.clip(noisy, -32768, 32767).astype(np.int16), recording.audio.rate)
    found = WARP.align(audio, TEXT, speakers["english"])
    assert np.median(np.abs(errors(found, recording))) < 0.015
    assert found.confidence > 0.6


def test_the_level_of_a_recording_does_not_count(speakers, recording):
    soft = Audio((recording.audio.samples // 16).astype(np.int16), recording.audio.rate)
    found = WARP.align(soft, TEXT, speakers["english"])
    assert np.median(np.abs(errors(found, recording))) < 0.01


@full
def test_a_text_that_is_not_said_is_doubted(speakers, recording):
    right = WARP.align(recording.audio, TEXT, speakers["english"])
    wrong = WARP.align(
        recording.audio,
        "Four hours of steady work faced us while a large size in stockings is hard to sell.",
        speakers["english"],
    )
    assert right.confidence > 0.9
    assert right.remarks == ()
    assert wrong.confidence < DOUBTFUL


def test_any_language_with_a_voice_is_aligned(speakers):
    text = "Hyvää huomenta, mitä kuuluu tänään?"
    recording = speak(text, "fi+f2", words_per_minute=140)
    found = WARP.align(recording.audio, text, speakers["finnish"])
    assert np.median(np.abs(errors(found, recording))) < 0.015


@full
@pytest.mark.parametrize("other", ["noise", "another line"])
def test_other_sound_around_a_line_does_not_move_it(speakers, recording, other):
    rate = recording.audio.rate
    if other == "noise":
        sound = np.random.default_rng(4).normal(0, 3000, 5 * rate).astype(np.int16)
    else:
        line = "Four hours of steady work faced us, and the box was thrown beside the truck."
        sound = speak(line, "en-us+m3").audio.samples
    clean = WARP.align(recording.audio, TEXT, speakers["english"])
    joined = Audio(np.concatenate([sound, recording.audio.samples, sound]), rate)
    found = WARP.align(joined, TEXT, speakers["english"])
    starts = [np.array([w.times[one.first] for one in w.words]) for w in (clean, found)]
    assert np.median(np.abs(starts[1] - len(sound) / rate - starts[0])) < 0.02
    told = [remark for remark in found.remarks if "sound without text" in remark]
    assert told[0].count(" to ") == 2


@full
def test_a_long_recording_is_aligned_in_parts_as_well_as_a_short_one(speakers):
    text = " ".join([TEXT, "Four hours of steady work faced us. The box was thrown."] * 6)
    recording = speak(text, "en-us+f3", words_per_minute=140)
    assert recording.audio.seconds > 45
    found = WARP.align(recording.audio, text, speakers["english"])
    assert np.median(np.abs(errors(found, recording))) < 0.01
    assert np.percentile(np.abs(errors(found, recording)), 99) < 0.2


@pytest.mark.parametrize("name", SENTENCES)
def test_real_speech_is_found_within_25_milliseconds(data, speakers, name):
    folder = data / "articulography"
    rows = [row.split() for row in (folder / f"{name}.phones.tsv").read_text("utf-8").splitlines()]
    true = Schedule.from_intervals(
        [(SILENCE if label == "&p:" else label, float(s), float(e)) for s, e, label in rows]
    )
    found = WARP.align(read_audio(folder / f"{name}.wav"), SENTENCES[name], speakers["german"])
    notations = speakers["german"].notations
    shared = {
        label: " ".join(name for name, _ in notations[notation].find(label) or ())
        for notation, one in (("sampa", true), ("ipa", found))
        for label in one.labels
        if label != SILENCE
    }
    wrong = np.abs(errors(found, true, shared))
    assert len(wrong) > 20
    assert np.median(wrong) < 0.025
    assert found.confidence > 0.6


def test_silence_has_no_speech_to_align(speakers):
    for samples in (np.zeros(SPEECH_RATE, np.int16), np.full(SPEECH_RATE, 500, np.int16)):
        with pytest.raises(SpeechError, match="speech cannot be told apart"):
            WARP.align(Audio(samples, SPEECH_RATE), TEXT, speakers["english"])


def test_a_recording_too_short_for_the_text_is_told(speakers, recording):
    short = Audio(recording.audio.samples[: recording.audio.rate // 2], recording.audio.rate)
    with pytest.raises(SpeechError, match=r"0\.\d+ s of speech.*\d+ phonemes"):
        WARP.align(short, TEXT, speakers["english"])


def test_a_language_without_a_voice_is_told(speakers, recording):
    mute = Speaker(replace(speakers["english"].manner, voice=None), speakers["english"].notations)
    with pytest.raises(SpeechError, match="english has no voice"):
        WARP.align(recording.audio, TEXT, mute)


def test_a_model_is_none_of_its_business(speakers, recording):
    with pytest.raises(SpeechError, match=r"no model.*'en'"):
        WARP.align(recording.audio, TEXT, speakers["english"], "en")


def pausing_voice(rest):
    """Four words of two sounds; the voice pauses before the third."""
    labels = tuple("ababab" if rest is None else "abab_ab") + tuple("ab")
    steps = [0.1 if label != SILENCE else rest for label in labels]
    words = [
        Word(f"w{n}", at, at + 2)
        for n, at in enumerate(i for i, x in enumerate(labels) if x == "a")
    ]
    audio = Audio(np.zeros(SPEECH_RATE, np.int16), SPEECH_RATE)
    return SpokenVoice.of(Schedule(labels, np.cumsum([0.0, *steps]), tuple(words), audio=audio))


@pytest.mark.parametrize(("rest", "word"), [(0.3, 4), (0.11, 2), (None, 2)])
def test_a_pause_belongs_to_the_word_before_which_the_voice_pauses(rest, word):
    kept = np.array([*range(30), *range(80, 130)])
    edges = np.array([0.0, 10.0, 28.0, 34.0, 44.0, 50.0, 60.0, 70.0])
    assert list(_pauses(edges, kept, pausing_voice(rest))) == [word]


def test_a_long_sound_is_refined_in_steps(monkeypatch):
    monkeypatch.setattr("lipsync_lang.sound.speech.hearing.align.bending.MAX_DIRECT_FRAMES", 60)
    monkeypatch.setattr("lipsync_lang.sound.speech.hearing.align.bending.PART_FRAMES", 40)
    monkeypatch.setattr("lipsync_lang.sound.speech.hearing.align.bending.CONTEXT_FRAMES", 10)
    said = np.cumsum(np.random.default_rng(1).normal(size=(900, 6)), axis=0)
    heard = np.repeat(said, [1, 1, 2] * 300, axis=0)
    path, _ = _coarse(heard, said)
    starts = np.flatnonzero(np.diff(np.repeat(np.arange(900), [1, 1, 2] * 300), prepend=-1))
    assert np.abs(_edges(heard, said, path) - starts).max() <= 3


@given(st.lists(st.floats(-1, 5), min_size=1, max_size=60).map(sorted), st.floats(0.05, 6))
def test_boundaries_are_kept_apart_and_inside_wherever_they_are_wanted(starts, end):
    times = _spaced(np.array(starts), end)
    assert (times[0], times[-1]) == (0.0, pytest.approx(end))
    least = min(MIN_PHONEME_SECONDS, end / (2 * len(starts)))
    assert all(b - a >= least - 1e-9 for a, b in pairwise(times))


def test_bands_are_empty_where_a_tone_is_not():
    tone = np.sin(2 * np.pi * 1000 * np.arange(SPEECH_RATE) / SPEECH_RATE)
    power = mel_power(tone)[0, 50]
    assert power.argmax() == pytest.approx(13, abs=2)
    assert power[30:].max() < power.max() * 1e-4


def test_speech_is_told_from_what_is_around_it(recording):
    quiet = np.zeros(SPEECH_RATE // 2)
    samples = np.concatenate([quiet, samples_of(recording.audio), quiet])
    spoken = heard_in(mel_power(samples)[0]).spoken
    assert not spoken[:45].any()
    assert not spoken[-45:].any()
    assert spoken[60:-60].mean() > 0.7
