"""Files with times of words only: subtitles, Whisper's variants, ElevenLabs, aeneas and others."""

import json

import pytest

import lipsync_lang as ll
from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.schedules.timing_readers import TIMING_READERS
from lipsync_lang.text.lines.line_readers import read_lines
from lipsync_lang.text.lines.plain import TIMING_SUFFIXES


@pytest.fixture
def read(tmp_path):
    """Write a file, and read its words with their times."""

    def run(name, text, **options):
        path = tmp_path / name
        data = text if isinstance(text, (str, bytes)) else json.dumps(text)
        path.write_bytes(data if isinstance(data, bytes) else data.encode())
        timed = ll.read_timings(path, **options)
        assert isinstance(timed, ll.TimedWords)
        return timed

    return run


def told(timed):
    """The words with their times."""
    return [(word.text, round(word.start, 3), round(word.end, 3)) for word in timed.words]


# Subtitles

SRT = """1
00:00:01,000 --> 00:00:02,500
- <i>Tom</i> &amp; {\\an8}Ann

2
00:01:03,250 --> 00:01:04,000
are here.

Now.
"""

ROLLING = """WEBVTT
Kind: captions

NOTE 00:00.000 --> is no cue

00:00:00.080 --> 00:00:02.310 align:start position:0%

Are<00:00:00.400><c> you</c><00:00:00.800><c> ready?</c>

00:00:02.310 --> 00:00:02.320 align:start position:0%
Are you ready?

00:00:02.320 --> 00:00:04.000 align:start position:0%
Are you ready?
Yes.<00:00:03.040><c> Yes.</c>
"""


def test_subrip_is_timed_by_cues(read, tmp_path):
    timed = read("line.srt", SRT)
    assert told(timed) == [("Tom & Ann", 1.0, 2.5), ("are here. Now.", 63.25, 64.0)]
    assert [line.text for line in read_lines(tmp_path / "line.srt")] == [
        "Tom & Ann",
        "are here.",
        "Now.",
    ]


def test_webvtt_is_timed_by_words_and_what_rolls_is_said_once(read):
    timed = read("line.vtt", ROLLING)
    assert any("repeat the previous cue are left out: 2" in one for one in timed.remarks)
    assert told(timed) == [
        ("Are", 0.08, 0.4),
        ("you", 0.4, 0.8),
        ("ready?", 0.8, 2.31),
        ("Yes.", 2.32, 3.04),
        ("Yes.", 3.04, 4.0),
    ]


def test_webvtt_of_two_speakers_asks_for_one(read):
    text = "WEBVTT\n\n" + "".join(
        f"00:0{n}.000 --> 00:0{n}.500\n<v {who}>{said}</v>\n\n"
        for n, (who, said) in enumerate((("Ann", "Hi."), ("Bob", "Ho."), ("Ann", "Ha.")))
    )
    with pytest.raises(ScheduleError, match="'Ann - words', 'Bob - words'; choose one"):
        read("line.vtt", text)
    assert told(read("line.vtt", text, tier="Ann")) == [("Hi.", 0, 0.5), ("Ha.", 2, 2.5)]


def test_a_cue_whose_times_run_backwards_is_located(read):
    with pytest.raises(ScheduleError, match=r"line.srt:3: 'no', 2 to 1 s, ends before it starts"):
        read("line.srt", "1\n00:00:02,000 --> 00:00:01,000\nno\n")


SDH = """1
00:00:01,000 --> 00:00:02,000
BOB: Hello.
- ANN LEE: Oh, hi.

2
00:00:03,000 --> 00:00:04,000
<i>BOB:</i> It is 10:30, Ann: go.

3
00:00:05,000 --> 00:00:06,000
WARNING: LEAVE NOW

4
00:00:07,000 --> 00:00:08,000
So Bob: why?
"""


def test_names_before_subtitles_are_speakers_and_are_not_said(read, tmp_path):
    timed = read("line.srt", SDH)
    texts = ["Hello. Oh, hi.", "It is 10:30, Ann: go.", "WARNING: LEAVE NOW", "So Bob: why?"]
    assert [word.text for word in timed.words] == texts
    assert timed.remarks[0].endswith("names before rows are not said: BOB, ANN LEE")
    lines = list(read_lines(tmp_path / "line.srt"))
    assert [line.text for line in lines] == texts
    assert [line.speaker for line in lines] == ["BOB", "BOB", "", ""]


# Recognisers


def test_whisperx_words_without_times_fill_the_gap_between_their_neighbours(read):
    words = [
        {"word": "in"},
        {"word": "May", "start": 0.1, "end": 0.3, "score": 0.9},
        {"word": "1999,"},
        {"word": "§"},
        {"word": "Yes", "start": 0.8, "end": 0.9, "score": 1.5},
        {"word": "100"},
    ]
    timed = read("line.json", {"segments": [{"start": 0, "end": 2, "text": "", "words": words}]})
    assert told(timed) == [
        ("in", 0, 0.1), ("May", 0.1, 0.3), ("1999, §", 0.3, 0.8), ("Yes", 0.8, 0.9),
        ("100", 0.9, 2),
    ]  # fmt: skip
    assert [word.confidence for word in timed.words] == [None, 0.9, None, None, None]


def test_whisperx_words_without_times_or_gap_share_those_of_a_neighbour(read):
    words = [
        {"word": "in"},
        {"word": "May", "start": 0.1, "end": 0.3, "score": 0.9},
        {"word": "1999."},
        {"word": "Yes", "start": 0.32, "end": 0.9},
    ]
    timed = read("line.json", {"segments": [{"start": 0.1, "end": 1, "text": "", "words": words}]})
    assert told(timed) == [("in May 1999.", 0.1, 0.3), ("Yes", 0.32, 0.9)]


WORDS = [{"word": " hello", "start": 0.1, "end": 0.5, "probability": 0.9}]
EVENTS = [
    {"text": "hello", "start": 0.1, "end": 0.5, "type": "word"},
    {"text": " ", "start": 0.5, "end": 0.6, "type": "spacing"},
    {"text": "(laughs)", "start": 0.6, "end": 0.9, "type": "audio_event"},
]
CPP = [
    {"text": "[_BEG_]", "offsets": {"from": 0, "to": 0}},
    {"text": " hel", "offsets": {"from": 100, "to": 300}},
    {"text": "lo", "offsets": {"from": 300, "to": 500}},
]


@pytest.mark.parametrize(
    "document",
    [
        {"text": "hello", "segments": [{"start": 0.1, "end": 0.5, "text": " hello", "words": []}]},
        {"text": "hello", "words": WORDS, "segments": [{"start": 0, "end": 3, "text": "hello"}]},
        {"text": "hello", "segments": [{"start": 0, "end": 3, "text": "hello", "words": WORDS}]},
        WORDS,
        {"result": [{"conf": 0.9, "word": "hello", "start": 0.1, "end": 0.5}], "text": "hello"},
        {"text": "hello", "words": EVENTS},
        {"text": " hello", "chunks": [{"timestamp": [0.1, 0.5], "text": " hello"}]},
        {"transcription": [{"offsets": {"from": 100, "to": 500}, "text": " hello"}]},
        {"transcription": [{"offsets": {"from": 0, "to": 3000}, "text": " hello", "tokens": CPP}]},
    ],
)
def test_every_relative_of_whisper_says_the_same(read, document):
    assert told(read("line.json", document)) == [("hello", 0.1, 0.5)]


def test_whisper_asks_for_one_of_its_speakers(read):
    document = {
        "segments": [
            {"start": n, "end": n + 0.5, "text": text, "speaker": who}
            for n, (who, text) in enumerate((("S0", "Hi."), ("S1", "Ho.")))
        ]
    }
    with pytest.raises(ScheduleError, match="2 speakers: 'S0', 'S1'; choose one"):
        read("line.json", document)
    assert told(read("line.json", document, tier="S1")) == [("Ho.", 1, 1.5)]


# Voices


def test_elevenlabs_characters_between_spaces_are_words(read):
    starts = [100 * n for n in range(8)]
    streamed = [
        {
            "audio": "",
            "alignment": {
                "chars": list(text),
                "charStartTimesMs": starts[first : first + len(text)],
                "charDurationsMs": [100] * len(text),
            },
        }
        for text, first in (("Hi t", 0), ("here", 4))
    ]
    whole = "\n".join(json.dumps(one) for one in [*streamed, {"isFinal": True}])
    assert told(read("line.jsonl", whole)) == [("Hi", 0, 0.2), ("there", 0.3, 0.8)]
    streamed[1]["alignment"]["charStartTimesMs"] = starts[:4]
    with pytest.raises(ScheduleError, match="'h' starts before the character before it"):
        read("line.json", streamed)
    streamed[1]["alignment"]["charStartTimesMs"] = starts[:3]
    with pytest.raises(ScheduleError, match="needs three lists of one length; the form is"):
        read("line.json", streamed[1:])


def test_aeneas_reads_the_smallest_fragments(read):
    children = [
        {"begin": "0.1", "end": "0.3", "lines": ["Hi"], "children": []},
        {"begin": "0.3", "end": "0.5", "lines": ["there"], "children": []},
    ]
    whole = {"begin": "0.1", "end": "0.5", "lines": ["Hi there"], "children": children}
    timed = read("line.json", {"fragments": [whole]})
    assert told(timed) == [("Hi", 0.1, 0.3), ("there", 0.3, 0.5)]
    with pytest.raises(ScheduleError, match="a fragment has no lines; the form is"):
        read("line.json", {"fragments": [{"begin": "0"}]})


# Transcriber

TRS = """<?xml version="1.0" encoding="ISO-8859-1"?>
<!DOCTYPE Trans SYSTEM "trans-14.dtd">
<Trans><Speakers><Speaker id="spk1" name="Zo\xeb"/><Speaker id="spk2" name="Bob"/></Speakers>
<Episode><Section><Turn startTime="0" endTime="1"><Sync time="0"/></Turn>
<Turn speaker="spk1" startTime="1" endTime="4"><Sync time="1"/>
alors <Event desc="rire" type="noise"/> oui
<Sync time="2.5"/>
bien
</Turn>
<Turn speaker="spk1 spk2" startTime="4" endTime="6"><Sync time="4"/>
<Who nb="1"/>
ouais
<Who nb="2"/>
d'accord
</Turn></Section></Episode></Trans>"""


def test_transcriber_parts_turns_and_those_who_talk_at_once(read):
    data = TRS.encode("latin-1")
    with pytest.raises(ScheduleError, match="'Zoë - words', 'Bob - words'; choose one"):
        read("line.trs", data)
    timed = read("line.trs", data, tier="Zoë")
    assert any("events are left out: rire" in one for one in timed.remarks)
    assert told(timed) == [
        ("alors oui", 1, 2.5),
        ("bien", 2.5, 4),
        ("ouais", 4, 6),
    ]
    assert told(read("line.trs", data, tier="Bob")) == [("d'accord", 4, 6)]


def test_a_script_of_subtitles_is_not_taken_for_the_timings_of_a_recording():
    scripts = {suffix for one in TIMING_READERS.values() if one.script for suffix in one.suffixes}
    assert scripts == {".srt", ".vtt"}
    assert {".eaf", ".trs", ".json"} <= {*TIMING_SUFFIXES}
    assert scripts.isdisjoint(TIMING_SUFFIXES)
