import itertools
import subprocess
import sys
import unicodedata
from importlib import import_module

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full, needs_espeak
from places import ROOT
from voices import speak

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules import SILENCE, Schedule
from lipsync_lang.sound.speech import ENGINES
from lipsync_lang.sound.speech.speaking.espeak import (
    MAX_ESPEAK_CHARS,
    Espeak,
    SpokenSound,
    closed,
    intervals,
    read_events,
)
from lipsync_lang.sound.speech.speaking.speech_engines import MAX_WORDS_PER_MINUTE as FASTEST
from lipsync_lang.sound.speech.speaking.speech_engines import MIN_WORDS_PER_MINUTE as SLOWEST
from lipsync_lang.sound.speech.speaking.word_spans import find_words
from lipsync_lang.text.phonology.espeak.process import WORKER


def same(left, right):
    return (
        left.labels == right.labels
        and left.words == right.words
        and np.array_equal(left.times, right.times)
        and np.array_equal(left.audio.samples, right.audio.samples)
    )


def spoken(schedule, word):
    return list(schedule.labels[word.first : word.stop])


def texts(schedule):
    return [word.text for word in schedule.words]


# What is said


@needs_espeak
def test_words_phonemes_and_pauses_of_a_short_line():
    schedule = speak("Hello, world", "en-us")
    assert [label for label in schedule.labels if label != SILENCE] == [
        "h",
        "ə",
        "l",
        "oʊ",
        "w",
        "ɜː",
        "l",
        "d",
    ]
    assert [(w.text, spoken(schedule, w)) for w in schedule.words] == [
        ("Hello", ["h", "ə", "l", "oʊ"]),
        ("world", ["w", "ɜː", "l", "d"]),
    ]
    between = schedule.labels[schedule.words[0].stop : schedule.words[1].first]
    assert between == (SILENCE,)
    assert schedule.notation == "ipa"
    assert not schedule.estimated


@needs_espeak
@pytest.mark.parametrize("voice", ["en-us", "en-gb", "de", "fr-fr", "cmn", "ru", "vi", "ca"])
def test_phonemes_fill_the_sound_from_its_start_to_its_end(voice):
    schedule = speak("One, two. 3 Ärzte, naïve; đi được! 你好", voice)
    assert schedule.start == 0
    assert schedule.end == schedule.audio.seconds
    assert (np.diff(schedule.times) > 0).all()
    assert schedule.labels[-1] == SILENCE
    assert schedule.audio.rate == 22050
    assert schedule.audio.samples.any()


@needs_espeak
def test_labels_carry_no_stress_tones_flags_or_silence_of_other_names():
    for voice, text in [
        ("en-us", "Extraordinary!"),
        ("cmn", "你好 OK 世界"),
        ("ru", "привет, день"),
    ]:
        labels = set(speak(text, voice).labels) - {SILENCE}
        assert not {c for label in labels for c in label} & set("ˈˌ0123456789()_| "), voice
        assert not [x for x in labels if not x[0].isalpha() or unicodedata.category(x[0]) == "Lm"]


@needs_espeak
def test_a_name_that_the_library_cuts_is_whole():
    schedule = speak("não, são mãos", "pt")
    assert "ɐ̃ʊ̃" in schedule.labels
    assert "ɐ̃ʊ" not in schedule.labels


@needs_espeak
def test_sound_is_loud_in_words_and_quiet_in_pauses():
    schedule = speak("Mama. Mama.", "en-us")
    samples = schedule.audio.samples.astype(float) / 32768

    def loudness(first, stop):
        start, end = (int(schedule.times[n] * schedule.audio.rate) for n in (first, stop))
        return np.sqrt(np.mean(samples[start:end] ** 2))

    one, two = schedule.words
    assert loudness(one.stop, two.first) < 0.02 * loudness(one.first, one.stop)
    assert loudness(two.first, two.stop) > 0.01


@needs_espeak
def test_speaking_again_gives_the_same_bytes():
    line = "The birch canoe slid on the smooth planks, 10 times."
    first = speak(line, "en-us")
    assert all(same(first, speak(line, "en-us")) for _ in range(4))


@full
@needs_espeak
def test_a_long_text_is_spoken_whole_and_the_same_each_time():
    sentence = "Rice is often served in round bowls, and 12 cats look on. "
    text = (sentence * 200)[:10_000]
    schedule = speak(text, "en-us")
    assert schedule.end > 300
    assert texts(schedule)[:12] == [x.strip(",.") for x in sentence.split()]
    assert texts(schedule)[-1] in text.split()[-1]
    assert len(schedule.words) == len(text.split())
    assert same(schedule, speak(text, "en-us"))


@needs_espeak
def test_speed_is_settable_within_what_the_library_times_well():
    slow, normal, fast = (
        speak("The smooth planks.", "en-us", words_per_minute=n).end
        for n in (SLOWEST, None, FASTEST)
    )
    assert slow > normal > fast
    for rate in (0, SLOWEST - 1, FASTEST + 1):
        with pytest.raises(SpeechError, match=f"{SLOWEST} to {FASTEST}"):
            speak("The planks.", "en-us", words_per_minute=rate)


# Words


SPELLINGS = {
    "10 cats": ["10", "cats"],
    "I have $5.50 & 50% off": ["I", "have", "$5.50", "&", "50%", "off"],
    "It's 1,234.5 e.g. at 12:45pm": ["It's", "1,234.5", "e.g", "at", "12:45pm"],
    "well-known rock'n'roll": ["well-known", "rock'n'roll"],
    "Mr. and Mrs. Smith's 2nd car": ["Mr", "and", "Mrs", "Smith's", "2nd", "car"],
    "most of the the news": ["most of", "the", "the", "news"],
    'Wait -- what?! (no) "quoted" — \'tis': ["Wait", "what", "no", "quoted", "tis"],
    "etc. and so on": ["etc", "and", "so", "on"],
    "- what": ["what"],
    "word—another mind...thoughts": ["word", "another", "mind", "thoughts"],
    "naïve café 😀 fool 🦀 crab": ["naïve", "café", "😀", "fool", "🦀", "crab"],
    "🥰 a b": ["🥰", "a", "b"],
    "𝐇ello ﬁne x": ["𝐇ello", "ﬁne", "x"],
    "cafe\u0301 x": ["cafe\u0301", "x"],
    "a\tb\nc\n\nd": ["a", "b", "c", "d"],
    "don’t ‘quoted’": ["don’t", "quoted"],
    "Привет мир": ["Привет", "мир"],
    "3rd of 1000000 a": ["3rd", "of", "1000000", "a"],
    "www.x.com a_b": ["www.x.com", "a_b"],
}


@needs_espeak
@pytest.mark.parametrize(("text", "expected"), SPELLINGS.items(), ids=ascii)
def test_words_keep_the_users_spelling(text, expected):
    assert texts(speak(text, "en-us")) == expected


@needs_espeak
def test_words_of_scripts_without_spaces_are_those_that_the_voice_marks():
    assert "".join(texts(speak("你好，世界。", "cmn"))) == "你好世界"
    assert texts(speak("ሰላም፡ልዑል ሆይ", "am")) == ["ሰላም", "ልዑል", "ሆይ"]


WORDS = [
    "cat",
    "naïve",
    "Straße",
    "мир",
    "𝐇i",
    "🦀",
    "10",
    "2,000",
    "o'clock",
    "well-known",
    "ʻokina",
]
GLUE = [" ", ", ", ". ", "! ", " — ", "\n", "…", ' "', "  (", ") "]


@full
@needs_espeak
def test_words_stand_in_the_text_in_order_whatever_the_punctuation():
    for shift, (voice, size) in enumerate(itertools.product(["en-us", "de", "ru"], [3, 7, 11])):
        picks = [WORDS[(shift + 3 * n) % len(WORDS)] for n in range(size)]
        text = "".join(w + GLUE[(shift + 7 * n) % len(GLUE)] for n, w in enumerate(picks))
        schedule = speak(text, voice)
        at = 0
        for part in " ".join(texts(schedule)).split():
            at = text.index(part, at) + len(part)
        assert len(schedule.words) > size / 2, text


@given(
    text=st.text(alphabet="ab 1.,-—…'😀好ก \n(", max_size=30),
    marks=st.lists(st.tuples(st.integers(-2, 40), st.integers(0, 8)), max_size=10),
    labels=st.lists(st.sampled_from(["a", "b", SILENCE]), min_size=8, max_size=8),
)
def test_words_of_any_marks_are_in_order_and_never_overlap(text, marks, labels):
    marks = list(zip((m[0] for m in marks), sorted(m[1] for m in marks), strict=True))
    words = find_words(text, marks, labels)
    Schedule(tuple(labels), np.arange(9.0), words=words)
    for word in words:
        assert SILENCE not in (labels[word.first], labels[word.stop - 1])


# From events to intervals


@given(
    st.lists(st.tuples(st.sampled_from(["a", "b", "ʲ", SILENCE]), st.integers(0, 30)), max_size=20),
    st.integers(0, 20),
)
def test_intervals_are_contiguous_and_each_has_some_length(rows, pause):
    ends = list(itertools.accumulate(length for _, length in rows))
    sounds = [
        SpokenSound(label, end - length, end)
        for (label, length), end in zip(rows, ends, strict=True)
    ]
    labels, bounds, index, stress = intervals(sounds, pause)
    assert len(stress) == len(labels)
    assert len(bounds) == len(labels) + 1
    assert (np.diff(bounds) > 0).all()
    assert all(0 <= n <= len(labels) for n in index)
    assert sorted(index) == index
    if labels:
        assert (bounds[0], bounds[-1]) == (0, ends[-1])
    for n, label in enumerate(labels[1:-1], 1):
        assert label != SILENCE or bounds[n + 1] - bounds[n] >= pause


def of(*rows):
    ends = list(itertools.accumulate(length for _, length in rows))
    sounds = [
        SpokenSound(label, end - length, end)
        for (label, length), end in zip(rows, ends, strict=True)
    ]
    labels, bounds, *_ = intervals(sounds, 50)
    return list(zip(labels, np.diff(bounds).tolist(), strict=True))


def test_a_short_silence_belongs_to_the_sound_before_and_a_long_one_is_a_pause():
    assert of(("a", 100), ("_", 40), ("b", 100), ("_", 60), ("a", 9)) == [
        ("a", 140),
        ("b", 100),
        ("_", 60),
        ("a", 9),
    ]
    assert of(("_", 10), ("a", 100), ("_", 10)) == [("_", 10), ("a", 100), ("_", 10)]


def test_a_sound_without_length_gets_its_closure_or_a_part_of_its_neighbour():
    assert of(("a", 90), ("_", 40), ("d", 0), ("e", 70)) == [("a", 90), ("d", 40), ("e", 70)]
    assert of(("a", 100), ("l", 0), ("z", 50)) == [("a", 70), ("l", 30), ("z", 50)]
    assert of(("_", 90), ("l", 0), ("a", 100)) == [("_", 90), ("l", 30), ("a", 70)]
    assert of(("l", 90), ("l", 0), ("a", 100)) == [("l", 90), ("a", 100)]


@given(
    st.lists(st.tuples(st.sampled_from([SILENCE, "a", "p"]), st.integers(1, 9)), min_size=1),
    st.data(),
)
def test_only_a_silence_of_all_samples_moves_to_the_sound_behind_it(rows, data):
    labels, lengths = zip(*rows, strict=True)
    bounds = [0, *itertools.accumulate(lengths)]
    loud = data.draw(st.lists(st.sampled_from([0, -1, 9, -(2**15)]), min_size=bounds[-1]))
    samples = np.array(loud, np.int16)
    moved = closed(labels, bounds, samples, 3)
    assert (moved[0], moved[-1]) == (bounds[0], bounds[-1])
    assert all(a < z for a, z in itertools.pairwise(moved))
    for start, known in zip(moved, bounds, strict=True):
        assert (np.abs(samples[start:known].astype(int)) <= 1).all()


@needs_espeak
@pytest.mark.parametrize(("text", "label"), [("a topper", "p"), ("the cocoa", "k")])
def test_a_stop_begins_with_its_closure(text, label):
    schedule = speak(text, "en-us")
    number = len(schedule) - 1 - schedule.labels[::-1].index(label)
    first = round(schedule.times[number] * schedule.audio.rate)
    closure = schedule.audio.samples[first : first + round(0.03 * schedule.audio.rate)]
    assert np.abs(closure.astype(int)).max() <= 1
    assert schedule.labels[number - 1] != SILENCE


def test_modifiers_join_the_sound_before():
    assert of(("k", 20), ("ʲ", 30), ("o", 50)) == [("kʲ", 50), ("o", 50)]


def test_event_names_are_cleaned_and_completed():
    def label(name, spelled=()):
        cut = name.encode()[:8].decode("latin-1")
        return read_events([["phoneme", 0, cut]], spelled, 9)[0][1].label

    assert label("ˈoʊ") == "oʊ"
    assert label("i2") == "i"
    assert label("(en)") == label("") == label("1") == SILENCE
    assert label("ˈɐ̃ʊ̃", ["ˈɐ̃ʊ̃"]) == "ɐ̃ʊ̃"
    assert label("ˈaːɪɚ") == "aːɪ"  # cut inside a character, and nothing to complete it from


# What cannot be said


@pytest.mark.parametrize("text", ["", " ", "\n\t ", "\0", "\ud800", "\ue000\u200b\ufeff"])
def test_no_text_says_so(text):
    with pytest.raises(SpeechError, match="no text to speak"):
        speak(text, "en-us")


@pytest.mark.parametrize("text", ["...", "!!!", "?", "😀", "— * —", "…"])
def test_text_without_a_letter_or_digit_says_so(text):
    with pytest.raises(SpeechError, match="no letter or digit"):
        speak(text, "en-us")


def test_a_text_of_a_book_is_to_be_spoken_line_by_line():
    with pytest.raises(SpeechError, match="line by line"):
        speak("a" * (MAX_ESPEAK_CHARS + 1), "en-us")


@full
@needs_espeak
def test_a_script_that_the_voice_does_not_know_says_so_or_is_spelled_out():
    assert texts(speak("你好 world", "en-us")) == ["你好", "world"]
    for text in ("Привет", "สวัสดี", "नमस्ते", "שלום", "ᏣᎳᎩ", "𐍈𐌰", "ꠅꠝ"):
        try:
            assert len(speak(text, "en-us")) > 1
        except SpeechError as error:
            assert "says nothing" in str(error)  # noqa: PT017 both ends are right


@needs_espeak
@pytest.mark.parametrize(
    ("text", "plain"),
    [
        ("a\x01b\x7f c\0d", "a b  c d"),
        ("one\ud83d two", "one  two"),
        ("\ufeffone\u200b two", " one  two"),
        ("one\r\ntwo", "one \ntwo"),
    ],
)
def test_characters_that_steer_the_library_are_spaces(text, plain):
    assert same(speak(text, "en-us"), speak(plain, "en-us"))


@needs_espeak
def test_markup_is_text():
    assert len(speak("<b>bold</b>", "en-us").words) == 3
    assert "h ə l oʊ" not in " ".join(speak("[[h@l'oU]]", "en-us").labels)
    slow = speak('<prosody rate="x-slow">hello</prosody>', "en-us")
    hello = next(word for word in slow.words if word.text == "hello")
    assert slow.times[hello.stop] - slow.times[hello.first] < 0.7


@full
@needs_espeak
def test_an_unknown_voice_names_a_near_one():
    with pytest.raises(SpeechError, match="no voice 'en-uss'; did you mean 'en-us'"):
        speak("Hello", "en-uss")
    with pytest.raises(SpeechError, match=r"no voice 'f3'"):
        speak("Hello", "f3")
    with pytest.raises(SpeechError, match=r"'f33'; did you mean 'f3'"):
        speak("Hello", "en-us+f33")
    for voice in ("", "../../en_dict", "\0", "en-us\0", "+f3", "x" * 10_000):
        with pytest.raises(SpeechError, match="no voice"):
            speak("Hello", voice)


@needs_espeak
def test_a_voice_goes_by_code_title_identifier_and_variant():
    plain = speak("Hello", "en-us")
    for name in ("EN-US", "English (America)", "gmw/en-US"):
        assert same(plain, speak("Hello", name))
    assert not same(plain, speak("Hello", "en-us+f3"))
    assert same(speak("Bonjour", "fr"), speak("Bonjour", "fr-fr"))
    voices = ENGINES["espeak"].voices()
    assert voices["en-us"] == "English (America)"
    assert len(voices) > 100


@full
@needs_espeak
def test_every_voice_speaks_its_own_code_or_says_why_not():
    for voice in list(ENGINES["espeak"].voices())[::12]:
        try:
            assert speak("a 5", voice).end > 0
        except SpeechError as error:
            assert "eSpeak NG" in str(error)  # noqa: PT017 both ends are right


# The process apart


def test_an_unknown_engine_names_a_near_one():
    with pytest.raises(SpeechError, match="'espaek'; did you mean 'espeak'"):
        speak("Hello", "en-us", engine="espaek")


def test_a_studios_own_engine_is_one_small_class(monkeypatch):
    class Beeps:
        def speak(self, text, voice, *, words_per_minute=None):
            assert words_per_minute is None
            return Schedule((voice,) * len(text), np.arange(len(text) + 1.0))

        def voices(self):
            return {"beep": "Beeps"}

    monkeypatch.setitem(ENGINES.known, "beeps", Beeps())
    assert speak("abc", "beep", engine="beeps").labels == ("beep",) * 3


def test_a_missing_library_names_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "espeakng_loader", None)
    with pytest.raises(SpeechError, match=r'pip install "lipsync-lang\[speech\]"'):
        speak("Hello", "en-us")


@needs_espeak
def test_half_an_installation_says_what_is_missing(monkeypatch, tmp_path):
    monkeypatch.setattr("espeakng_loader.get_library_path", lambda: str(tmp_path / "no.so"))
    with pytest.raises(SpeechError, match="not installed whole"):
        speak("Hello", "en-us")


@needs_espeak
def test_a_library_that_cannot_be_loaded_is_no_crash_of_ours(monkeypatch, tmp_path):
    fake = tmp_path / "lib.so"
    fake.write_text("not a library")
    monkeypatch.setattr("espeakng_loader.get_library_path", lambda: str(fake))
    with pytest.raises(SpeechError, match="ended with code 1"):
        speak("Hello", "en-us")


@needs_espeak
def test_data_without_a_voice_in_it_says_so(monkeypatch, tmp_path):
    (tmp_path / "espeak-ng-data").mkdir()
    monkeypatch.setattr("espeakng_loader.get_data_path", lambda: str(tmp_path / "espeak-ng-data"))
    with pytest.raises(SpeechError, match="cannot read its data"):
        speak("Hello", "en-us")


FRAME = """
import sys
def frame(raw, sound=b""):
    sys.stdout.buffer.write(b"lipsync1" + len(raw).to_bytes(4, "little") + raw + sound)
"""
ENDINGS = {
    "abort": ("import os; os.abort()", "crashed|ended with code"),
    "fault": ("import ctypes; ctypes.string_at(0)", "crashed|ended with code"),
    "exit": ("import sys; sys.exit('out of order')", r"ended with code 1 .*\(out of order\)"),
    "nothing": ("pass", "an unreadable answer"),
    "noise": ("print('hello')", "an unreadable answer"),
    "short": (FRAME + "frame(b'')", "an unreadable answer"),
    "list": (FRAME + "frame(b'[]')", "an unreadable answer"),
    "empty": (FRAME + "frame(b'{}')", "an unreadable answer"),
    "cut": (FRAME + """frame(b'{"bytes": 8}', b'1234')""", "an unreadable answer"),
    "odd": (FRAME + """frame(b'{"bytes": 3}', b'123')""", "an unreadable answer"),
    "events": (
        FRAME + """frame(b'{"rate": 9, "spelled": [], "events": [["phoneme", 1, 2]]}')""",
        "an unreadable answer",
    ),
    "silent": (FRAME + """frame(b'{"rate": 9, "spelled": [], "events": []}')""", "says nothing"),
}


@needs_espeak
@pytest.mark.parametrize("ending", ENDINGS)
def test_however_the_engine_ends_the_error_is_plain(ending, tmp_path):
    script, message = ENDINGS[ending]
    worker = tmp_path / "worker.py"
    worker.write_text(script)
    with pytest.raises(SpeechError, match=message):
        Espeak(worker=worker).speak("Hello", "en-us")


@needs_espeak
def test_an_engine_that_hangs_is_ended(tmp_path):
    worker = tmp_path / "worker.py"
    worker.write_text("import time; time.sleep(600)")
    with pytest.raises(SpeechError, match="did not finish within"):
        Espeak(worker=worker, patience=0.2).speak("Hello", "en-us")


@needs_espeak
def test_an_interpreter_that_is_not_there_says_so():
    with pytest.raises(SpeechError, match="cannot be started with 'nothing/python'"):
        Espeak(python="nothing/python").speak("Hello", "en-us")


@needs_espeak
@pytest.mark.skipif(sys.platform == "win32", reason="links need rights there")
def test_paths_may_be_long_and_have_spaces_and_accents(monkeypatch, tmp_path):
    plain = speak("Hello", "en-us")
    folder = tmp_path / "mit Leerzeichen und ünïcödé 音声" / ("long" * 50)
    folder.mkdir(parents=True)
    for name, get in [("data", "get_data_path"), ("lib.so", "get_library_path")]:
        (folder / name).symlink_to(getattr(import_module("espeakng_loader"), get)())
        monkeypatch.setattr(f"espeakng_loader.{get}", lambda name=name: str(folder / name))
    monkeypatch.chdir(folder)
    assert same(plain, speak("Hello", "en-us"))


@needs_espeak
def test_the_environment_changes_nothing(monkeypatch, tmp_path):
    plain = speak("Hello, wörld", "en-us")
    for name in ("LC_ALL", "LANG"):
        monkeypatch.setenv(name, "C")
    for name in ("ESPEAK_DATA_PATH", "PYTHONPATH", "PYTHONHOME", "HOME"):
        monkeypatch.setenv(name, str(tmp_path))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "json.py").write_text("raise SystemExit(9)")
    assert same(plain, speak("Hello, wörld", "en-us"))


@needs_espeak
def test_the_library_is_never_loaded_into_our_process():
    script = (
        "import sys; import lipsync_lang.sound.speech as s;"
        "assert 'espeakng_loader' not in sys.modules;"
        "next(s.speak_many(['Hello'], 'en-us')); maps = open('/proc/self/maps').read()"
        " if sys.platform == 'linux' else ''; sys.exit('espeak-ng.so' in maps)"
    )
    root = ROOT
    assert subprocess.run([sys.executable, "-c", script], cwd=root, check=False).returncode == 0


def test_the_worker_needs_the_standard_library_alone():
    script = f"import runpy; runpy.run_path({str(WORKER)!r}, run_name='worker')"
    assert subprocess.run([sys.executable, "-I", "-S", "-c", script], check=False).returncode == 0
