"""Timings of speech services and recognisers, in the forms of their documents and programs."""

import json

import numpy as np
import pytest

import lipsync_lang as ll
from lipsync_lang.base.errors import ScheduleError


@pytest.fixture
def read(tmp_path):
    """Write a document, or a text, and read its timings."""

    def run(document, suffix=".json", **options):
        path = tmp_path / f"line{suffix}"
        text = document if isinstance(document, str) else json.dumps(document)
        path.write_text(text, "utf-8")
        return ll.read_timings(path, **options)

    return run


def words_of(timed):
    return [(word.text, word.start, word.end) for word in timed.words]


def test_words_that_google_repeats_with_their_speakers_are_read_once(read):
    words = [
        {"startTime": "0.100s", "endTime": "0.300s", "word": "old"},
        {"startTime": "0.300s", "endTime": "0.700s", "word": "maps"},
    ]
    spoken = [{**one, "speakerTag": 1} for one in words]
    results = [{"alternatives": [{"words": one}]} for one in (words, spoken)]
    expected = [("old", 0.1, 0.3), ("maps", 0.3, 0.7)]
    assert words_of(read({"results": results})) == expected
    assert words_of(read({"response": {"results": results}})) == expected


@pytest.mark.parametrize("names", [("start_time", "end_time"), ("start_offset", "end_offset")])
def test_names_and_durations_of_googles_libraries(read, names):
    times = [({"seconds": 0, "nanos": 100_000_000}, "0.300s"), ("0.300s", {"seconds": "1"})]
    words = [{"word": "ma", **dict(zip(names, one, strict=True))} for one in times]
    del words[0][names[0]]
    timed = read({"results": [{"alternatives": [{"words": words}]}]})
    assert words_of(timed) == [("ma", 0, 0.3), ("ma", 0.3, 1)]
    words[1][names[1]] = {"minutes": 1}
    with pytest.raises(ScheduleError, match="dict is not a time"):
        read({"results": [{"alternatives": [{"words": words}]}]})


def spoken_by(**fields):
    return {"text": "ma", "word": "ma", "content": "ma", "value": "ma", **fields}


SPEAKERS = {
    "deepgram": lambda one, two: {
        "results": {"channels": [{"alternatives": [{"words": [
            spoken_by(start=0.1, end=0.2, speaker=one), spoken_by(start=0.3, end=0.4, speaker=two),
        ]}]}]}
    },
    "rev": lambda one, two: {
        "monologues": [
            {"speaker": who, "elements": [spoken_by(ts=at, end_ts=at + 0.1)]}
            for who, at in ((one, 0.1), (two, 0.3))
        ]
    },
    "speechmatics": lambda one, two: {
        "results": [
            {"start_time": at, "end_time": at + 0.1, "alternatives": [spoken_by(speaker=who)]}
            for who, at in ((one, 0.1), (two, 0.3))
        ]
    },
}  # fmt: skip


@pytest.mark.parametrize("service", SPEAKERS)
def test_a_file_with_several_speakers_needs_one_named(read, service):
    one, two = ("S1", "S2") if service == "speechmatics" else (0, 1)
    with pytest.raises(ScheduleError, match=rf"2 tiers hold words: '{one} - words', '{two} - "):
        read(SPEAKERS[service](one, two))
    assert words_of(read(SPEAKERS[service](one, two), tier=str(two)))[0][1] == 0.3
    assert len(words_of(read(SPEAKERS[service](one, one)))) == 2
    with pytest.raises(ScheduleError, match="no tier is named"):
        read(SPEAKERS[service](one, two), tier="Bo")


def test_boundaries_of_edge_tts_stand_on_a_line_each(read):
    rows = [
        {"type": "WordBoundary", "offset": 1_000_000.0, "duration": 3_750_000.0, "text": "Old"},
        {"type": "WordBoundary", "offset": 5_000_000.0, "duration": 3_750_000.0, "text": "maps"},
    ]
    timed = read("\n".join(map(json.dumps, rows)), ".jsonl")
    assert words_of(timed) == [("Old", 0.1, 0.475), ("maps", 0.5, 0.875)]
    rows[1].pop("duration")
    with pytest.raises(ScheduleError, match=r"line\.jsonl:2: record 2 has no 'duration'"):
        read("\n".join(map(json.dumps, rows)), ".jsonl")


CHARACTERS = "^hə, wˈɜːld$"


@pytest.mark.parametrize("field", ["seconds", "num_samples"])
def test_marks_of_phonetic_characters_belong_to_their_sounds(read, field):
    length = 0.1 if field == "seconds" else 1600
    rows = [{"phoneme": one, field: length} for one in CHARACTERS]
    schedule = read(rows, rate=16000 if field == "num_samples" else None)
    assert schedule.labels == ("_", "h", "ə", "_", "w", "ˈɜː", "l", "d", "_")
    np.testing.assert_allclose(schedule.times, np.array([0, 1, 2, 3, 5, 6, 9, 10, 11, 12]) / 10)


def test_the_characters_of_kokoro_are_timed_alike(read):
    rows = [
        {"phoneme": one, "start": at / 10, "end": (at + 1) / 10} for at, one in enumerate("mˈæ ps")
    ]
    schedule = read(rows)
    assert schedule.labels == ("m", "ˈæ", "p", "s")
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.4, 0.5, 0.6])


def test_a_mark_of_google_lasts_until_the_next(read):
    marks = [{"markName": "old", "timeSeconds": 0.24}, {"markName": "maps", "timeSeconds": 0.5}]
    timed = read({"audioContent": "", "timepoints": marks})
    assert words_of(timed) == [("old", 0.24, 0.5), ("maps", 0.5, 0.58)]
    assert "does not state when its last label, 'maps', ends" in timed.remarks[0]


def test_columns_of_unequal_length_are_refused(read):
    lists = {"visemes": ["PP", "aa"], "vtimes": [100], "vdurations": [100, 150]}
    with pytest.raises(ScheduleError, match=r"line\.json: needs three lists of one length"):
        read(lists)


def test_punctuation_alone_is_no_word(read):
    with pytest.raises(ScheduleError, match="has no words"):
        read({"words": [{"word": ".", "start_time": 0.1, "end_time": 0.2}]})


JULIUS = """STAT: jconf successfully finalized
{words}=== begin forced alignment ===
-- phoneme alignment --
 id: from  to    n_score    unit
 ----------------------------------------
[   0   28]  -23.198976  silB
[  29   40]  -23.000000  m-a+Q[a]
[  41   60]  -22.100000  silE
re-computed AM score: -1213.5
=== end forced alignment ===
"""
WORDS = """=== begin forced alignment ===
-- word alignment --
[   0   28]  -23.198976  <s>\t[silB]
[  29   40]  -23.000000  w_1\t[あ]
[  41   60]  -22.100000  </s>\t[silE]
=== end forced alignment ===
"""


def test_frames_of_julius_are_half_a_window_late(read):
    schedule = read(JULIUS.format(words=""), ".log")
    assert schedule.labels == ("silB", "a", "silE")
    np.testing.assert_allclose(schedule.times, (0, 0.3025, 0.4225, 0.6225))
    spoken = read(JULIUS.format(words=WORDS), ".txt").words
    assert [(word.text, word.first, word.stop) for word in spoken] == [("あ", 1, 2)]


def test_a_log_of_several_recordings_needs_a_tier(read):
    log = JULIUS.format(words="") + JULIUS.format(words="").replace("m-a+Q[a]", "o")
    with pytest.raises(ScheduleError, match="recordings"):
        read(log, ".log")
    assert read(log, ".log", tier="2").labels[1] == "o"


@pytest.mark.parametrize(
    ("log", "message"),
    [
        ("STAT: nothing\n", "has no alignment of phonemes; run julius with -palign"),
        (JULIUS.format(words="").replace("[  29   40]", "[  29 ]"), ":7: '\\[  29 \\]"),
        (JULIUS.format(words="").split("re-computed")[0], ":2: ends before 'end forced"),
    ],
)
def test_a_log_that_cannot_be_read_is_located(read, log, message):
    with pytest.raises(ScheduleError, match=message):
        read(log, ".log")


def test_phones_of_allosaurus_last_until_the_next(read):
    rows = "0.210 0.045 æ\n0.390 0.045 l (0.9) ɹ (0.1)\n0.450 0.045 u\n1.450 0.045 s\n"
    schedule = read(rows, ".txt")
    assert schedule.labels == ("_", "æ", "l", "u", "_", "s")
    np.testing.assert_allclose(schedule.times, (0, 0.21, 0.39, 0.45, 0.495, 1.45, 1.495))
    swapped = read("".join(reversed(rows.splitlines(keepends=True))), ".txt")
    assert (swapped.labels, swapped.times.tolist()) == (schedule.labels, schedule.times.tolist())
