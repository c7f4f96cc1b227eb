"""Festival as a speech engine: phonemes, times, and no execution of texts."""

import shutil
import wave
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import costly, full

import lipsync_lang as ll
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.commands import doctor_checks
from lipsync_lang.packs.library import Library
from lipsync_lang.plugins.festival.festival_engine import MAX_FESTIVAL_CHARS, NOTATIONS, Festival
from lipsync_lang.schedules import SILENCE
from lipsync_lang.sound.speech import ENGINES

VOICE = "kal_diphone"
VOICES = Path("/usr/share/festival/voices/english") / VOICE

needs_festival = pytest.mark.skipif(
    shutil.which("festival") is None or not VOICES.is_dir(),
    reason="needs festival and festvox-kallpc16k",
)


def speak(text, **how):
    return Festival().speak(text, VOICE, **how)


def said(schedule):
    return [(w.text, " ".join(schedule.labels[w.first : w.stop])) for w in schedule.words]


@needs_festival
def test_a_line_is_phones_words_and_sound():
    schedule = speak("Hello, world")
    assert said(schedule) == [("Hello", "HH AX L OW"), ("world", "W ER L D")]
    assert schedule.labels[0] == schedule.labels[-1] == SILENCE
    assert schedule.notation == "arpabet"
    assert (schedule.start, schedule.end) == (0.0, schedule.audio.seconds)
    assert schedule.audio.rate == 16000
    assert [stress for stress in schedule.stress if stress is not None] == [0, 1, 1]


@needs_festival
def test_the_times_are_those_of_the_sound():
    """The sound of an s is noise, and a pause is silent."""
    schedule = speak("so, so")
    for label, start, end in zip(schedule.labels, schedule.times, schedule.times[1:], strict=False):
        low, high = (int(t * schedule.audio.rate) for t in (start, end))
        loud = np.abs(schedule.audio.samples[low:high].astype(float)).mean()
        assert (loud < 30) == (label == SILENCE), (label, start, loud)


@full
@needs_festival
def test_words_keep_the_spelling_of_the_text():
    schedule = speak("“Café”: naïve — 10,000 U.S. men’s")
    assert [word for word, _ in said(schedule)][:3] == ["Café", "naïve", "10,000"]
    assert schedule.unread == ()
    assert speak("hello 日本").unread == ("日", "本")


@full
@needs_festival
def test_faster_speech_is_shorter():
    slow, fast = (speak("the birch canoe", words_per_minute=n) for n in (100, 300))
    assert slow.labels == fast.labels
    assert slow.end > 2 * fast.end


@full
@needs_festival
@pytest.mark.parametrize(
    "text",
    [
        'a") (system "touch {mark}") (print "b',
        '(system "touch {mark}")',
        'a\\") (system \\"touch {mark}\\")',
        '\'(system "touch {mark}") #.(system "touch {mark}") `touch {mark}` $(touch {mark})',
        'a" nil)) (fopen "{mark}" "w") ;',
    ],
)
def test_nothing_of_a_text_is_executed(text, tmp_path):
    mark = tmp_path / "mark"
    schedule = speak(text.format(mark=mark))
    assert len(schedule.words) > 1
    assert not mark.exists()


@needs_festival
def test_nothing_of_a_voice_is_executed(tmp_path):
    mark = tmp_path / "mark"
    with pytest.raises(SpeechError, match="Festival has no voice"):
        Festival().speak("hi", f'{VOICE}) (system "touch {mark}")')
    assert not mark.exists()


@full
@needs_festival
@costly()
@given(st.text(st.characters(codec="ascii"), min_size=1, max_size=40))
def test_any_text_is_spoken_or_refused_with_a_reason(text):
    try:
        schedule = speak("ok " + text)
    except SpeechError as error:
        assert "Festival" in str(error)  # noqa: PT017 either is right
    else:
        assert schedule.words[0].text.startswith("ok")
        assert schedule.end == schedule.audio.seconds


@needs_festival
def test_all_its_phones_are_known_to_the_language():
    """Every phone of the phone sets in Festival's files."""
    radio = (
        "aa ae ah ao aw ax axr ay b ch d dh dx eh el em en er ey f g hh hv ih iy jh k l m n nx ng "
        "ow oy p r s sh t th uh uw v w y z zh"
    )
    notation = ll.resolve("english", "facefx").speaker.notations["arpabet"]
    assert [phone for phone in radio.split() if notation.find(phone.upper()) is None] == []


@full
@needs_festival
def test_a_language_speaks_with_it_and_what_is_heard_is_what_is_said(cli, tmp_path):
    files = [tmp_path / "line.wav", tmp_path / "line.csv"]
    outputs = [part for file in files for part in ("-o", file)]
    command = ["run", "Hello, world", "-l", "english", "-c", "facefx", "--tts", "festival"]
    assert cli(*command, *outputs).code == 0
    assert all(file.stat().st_size > 1000 for file in files)
    schedule = ll.speak("Hello, world", "english", engine="festival")
    assert schedule.language == "english"
    assert said(schedule) == said(speak("Hello, world"))


@needs_festival
def test_its_voices_are_listed(cli):
    ended = cli("voices", "festival")
    assert ended.code == 0
    assert VOICE in ended.out


def test_a_language_without_a_voice_of_it_says_so():
    told = (
        r"german has no voice of festival; add to its pack `tts: \{others: \{festival: VOICE\}\}`"
    )
    with pytest.raises(SpeechError, match=told):
        ll.speak("Hallo", "german", engine="festival")


def test_an_engine_that_is_none_is_told():
    with pytest.raises(
        SpeechError, match="unknown speech engine 'festivel'; did you mean 'festival'"
    ):
        ll.speak("Hello", "english", engine="festivel")


@full
def test_packs_name_voices_of_engines_that_there_are():
    library = Library(project=None)
    stated = {
        engine
        for found in library.names("language")
        if (tts := library.language(found.name).model.tts) is not None
        for engine in (tts.engine, *tts.others)
    }
    assert "festival" in stated
    assert stated <= set(ENGINES)


def test_without_the_program_it_is_said_how_to_get_it():
    with pytest.raises(SpeechError, match="apt-get install festival"):
        Festival(program="no-such-program").speak("hello", VOICE)


def test_a_program_that_does_not_end_is_given_up(tmp_path):
    program = tmp_path / "slow"
    program.write_text("#!/bin/sh\nexec sleep 60\n", "ascii")
    program.chmod(0o755)
    with pytest.raises(SpeechError, match=r"did not finish within .* s with 'hello'"):
        Festival(program=str(program), patience=0.1).speak("hello", VOICE)


def test_a_program_that_fails_is_quoted(tmp_path):
    program = tmp_path / "broken"
    program.write_text("#!/bin/sh\necho 'SIOD ERROR: no luck' >&2\nexit 3\n", "ascii")
    program.chmod(0o755)
    with pytest.raises(SpeechError, match=r"Festival failed .*\(SIOD ERROR: no luck\)"):
        Festival(program=str(program)).speak("hello", VOICE)


def test_a_voice_in_an_unknown_phone_set_is_refused(tmp_path):
    sound = tmp_path / "silence.wav"
    with wave.open(str(sound), "wb") as stream:
        stream.setparams((1, 2, 8000, 0, "NONE", ""))
        stream.writeframes(bytes(3200))
    answer = "phones mrpa\ntoken a\nsound a 0.2 1 0"
    program = tmp_path / "other"
    program.write_text(f"#!/bin/sh\ncp '{sound}' sound.wav\necho '{answer}'\n", "utf-8")
    program.chmod(0o755)
    with pytest.raises(SpeechError, match=f"phone set 'mrpa'.*{next(iter(NOTATIONS))}"):
        Festival(program=str(program)).speak("a", VOICE)


@pytest.mark.parametrize(
    ("text", "how", "told"),
    [
        ("", {}, "no letter or digit"),
        ("... !", {}, "no letter or digit"),
        ("日本", {}, "no letter or digit that Festival can read"),
        ("a" * (MAX_FESTIVAL_CHARS + 1), {}, "speak it line by line"),
        ("hi", {"words_per_minute": 1000}, "Festival speaks 80 to 350"),
    ],
)
def test_what_cannot_be_said_is_refused(text, how, told):
    with pytest.raises(SpeechError, match=told):
        speak(text, **how)


def test_a_program_that_leaves_no_sound_is_refused(tmp_path):
    program = tmp_path / "mute"
    program.write_text("#!/bin/sh\nprintf 'phones radio\\ntoken a\\nsound a 0.2 1 0\\n'\n", "utf-8")
    program.chmod(0o755)
    with pytest.raises(SpeechError, match="Festival wrote no readable sound"):
        Festival(program=str(program)).speak("a", VOICE)


def test_the_doctor_says_how_to_get_the_program(monkeypatch):
    monkeypatch.setattr(doctor_checks.shutil, "which", lambda _: None)
    (found,) = doctor_checks.engines()
    assert (found.part, found.state) == ("voices of festival", "missing")
    assert "festival" in found.told
