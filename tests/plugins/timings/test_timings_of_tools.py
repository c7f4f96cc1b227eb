"""Timings as tools write them: sounds without length, lists of phrases, milliseconds, marks."""

import json

import pytest
from numpy.testing import assert_allclose
from shipped import LANGUAGES, LIBRARY

from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.schedules import read_timings
from lipsync_lang.schedules.rows import is_pause

KALDI = """\
u 1 0.00 0.00 38
u 1 0.00 0.10 4_B
u 1 0.10 0.10 5_I
u 1 0.20 0.00 6_I
u 1 0.20 0.20 7_E
u 1 0.40 0.00 8_S
"""
PHRASES = [
    {"moras": [{"text": "マ", "consonant": "m", "consonant_length": 0.08, "vowel": "a",
                "vowel_length": 0.12, "pitch": 5.0}], "accent": 1, "pause_mora": None}
]  # fmt: skip


def read(folder, name, text):
    (folder / name).write_text(text, "utf-8")
    return read_timings(folder / name)


def test_sounds_without_length_share_the_time_of_a_neighbour(tmp_path):
    found = read(tmp_path, "kaldi.ctm", KALDI)
    assert found.labels == ("38", "4", "5", "6", "7", "8")
    assert_allclose(found.times, [0, 0.05, 0.1, 0.2, 0.2667, 0.3333, 0.4], atol=1e-3)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.csv", "label,start,end\nm,0,0.2\na,0.2,0.2\n_,0.2,0.2\np,0.2,0.4\na,0.4,0.4\n"),
        ("a.txt", "0.0\t0.2\tm\n0.2\t0.2\ta\n0.2\t0.4\tp\n0.4\t0.4\ta\n"),
        ("a.lab", "0 2000000 m\n2000000 2000000 a\n2000000 4000000 p\n4000000 4000000 a\n"),
    ],
)
def test_sounds_without_length_share_it_in_every_format(tmp_path, name, text):
    found = read(tmp_path, name, text)
    assert found.labels == ("m", "a", "p", "a")
    assert_allclose(found.times, [0, 0.2, 0.2667, 0.3333, 0.4], atol=1e-3)


PAUSES = ["sp", "sil", "SIL", "pau", "<eps>", "h#", "spn", "<p:>", "#", "_"]


def test_the_last_sounds_share_the_time_of_one_whose_end_is_rounded(tmp_path):
    # .11 + .1 is not .21
    rows = "u 1 0 0.11 m\nu 1 0.11 0.10 a\nu 1 0.21 0 p\nu 1 0.21 0 a\n"
    found = read(tmp_path, "a.ctm", rows)
    assert found.labels == ("m", "a", "p", "a")
    assert_allclose(found.times, [0, 0.11, 0.1433, 0.1767, 0.21], atol=1e-3)


AROUND_A_PAUSE = {
    "a.lab": "0 5000000 AA1\n5000000 5000000 {}\n5000000 10000000 AA1\n",
    "a.mlf": '#!MLF!#\n"a.lab"\n0 5000000 AA1\n5000000 5000000 {}\n5000000 10000000 AA1\n.\n',
    "a.csv": "label,start,end\nAA1,0,0.5\n{},0.5,0.5\nAA1,0.5,1\n",
    "a.ctm": "u 1 0 0.5 AA1\nu 1 0.5 0 {}\nu 1 0.5 0.5 AA1\n",
    "a.txt": "0.0\t0.5\tAA1\n0.5\t0.5\t{}\n0.5\t1.0\tAA1\n",
    "a.json": '[{{"label": "AA1", "start": 0, "end": 0.5}},'
    ' {{"label": "{}", "start": 0.5, "end": 0.5}},'
    ' {{"label": "AA1", "start": 0.5, "end": 1, "stress": 1}}]',
}


@pytest.mark.parametrize("name", AROUND_A_PAUSE)
@pytest.mark.parametrize("pause", PAUSES)
def test_a_pause_without_length_takes_no_time(tmp_path, name, pause):
    found = read(tmp_path, name, AROUND_A_PAUSE[name].format(pause))
    assert found.labels == ("AA1", "AA1")
    assert found.times.tolist() == [0, 0.5, 1]
    assert found.stress == ((None, 1) if name == "a.json" else ())


def test_a_sound_without_length_is_no_pause(tmp_path):
    assert read(tmp_path, "a.lab", AROUND_A_PAUSE["a.lab"].format("s")).labels == (
        "AA1",
        "s",
        "AA1",
    )
    with pytest.raises(ScheduleError, match=r"phoneme 1 \('s'\), 0.5 to 0.5 s, has no length"):
        read(tmp_path, "a.json", AROUND_A_PAUSE["a.json"].format("s"))


def test_every_label_of_silence_is_a_pause_and_no_sound_is():
    labels = [one for one in LIBRARY.common().model.silence_labels if one]
    assert labels
    assert [one for one in labels if not is_pause(one)] == []
    for name in LANGUAGES:
        for table in LIBRARY.language(name).model.notations.values():
            assert [label for label in table if is_pause(label)] == []


def test_the_phrases_of_voicevox_are_read_without_their_query(tmp_path):
    found = read(tmp_path, "phrases.json", json.dumps(PHRASES))
    assert found.labels == ("m", "a")
    assert [word.text for word in found.words] == ["マ"]


def test_whispers_table_is_in_milliseconds(tmp_path):
    text = "start\tend\ttext\n0\t1200\tHello there.\n1500\t2600\tHow are you?\n"
    found = read(tmp_path, "whisper.tsv", text)
    assert [(word.text, word.start, word.end) for word in found.words] == [
        ("Hello there.", 0.0, 1.2),
        ("How are you?", 1.5, 2.6),
    ]


WORDS_BY_FORMAT = {
    "words.ctm": ("u 1 0 0.3 Hello\nu 1 0.3 0.3 {}\nu 1 0.6 0.3 friends\n"),
    "words.srt": (
        "1\n00:00:00,000 --> 00:00:00,300\nHello\n\n2\n00:00:00,300 --> 00:00:00,600\n{}\n\n"
        "3\n00:00:00,600 --> 00:00:00,900\nfriends\n"
    ),
    "words.json": (
        '{"words": [{"word": "Hello", "start": 0, "end": 0.3},'
        ' {"word": "{}", "start": 0.3, "end": 0.6}, {"word": "friends", "start": 0.6, "end": 0.9}]}'
    ),
}


@pytest.mark.parametrize("name", WORDS_BY_FORMAT)
@pytest.mark.parametrize("mark", ["...", "…", "ipu_1", "—", "SIL", "silB", "[noise]"])
def test_a_mark_among_words_is_no_word(tmp_path, name, mark):
    found = read(tmp_path, name, WORDS_BY_FORMAT[name].replace("{}", mark))
    assert [word.text for word in found.words] == ["Hello", "friends"]


@pytest.mark.parametrize("word", ["silver", "silence", "[sobs] no [sobs]", "&", "ipu"])
def test_a_word_like_a_mark_is_a_word(tmp_path, word):
    found = read(tmp_path, "words.srt", WORDS_BY_FORMAT["words.srt"].replace("{}", word))
    assert [word.text for word in found.words] == ["Hello", word, "friends"]


def test_the_name_of_a_unit_is_not_read_before_its_text(tmp_path):
    found = read(tmp_path, "units.csv", "start,end,word\n0,1,#\n1,2,ipu_1 hello there\n")
    assert [word.text for word in found.words] == ["hello there"]
