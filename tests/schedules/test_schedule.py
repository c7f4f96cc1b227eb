"""Schedules: refusals, words, and readers."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lipsync_lang as ll
from lipsync_lang.errors import ScheduleError
from lipsync_lang.schedules import SILENCE
from lipsync_lang.schedules.schedule import SNAP_SECONDS, words_from_spans
from lipsync_lang.schedules.timing_readers import TIMING_READERS

LABELS = ("HH", "AH0", "L", "OW1")
TIMES = (0, 0.1, 0.2, 0.3, 0.5)


def make(**rest):
    return ll.Schedule(LABELS, TIMES, **rest)


@st.composite
def intervals(draw):
    """Contiguous rows."""
    steps = draw(st.lists(st.floats(2e-3, 3), min_size=1, max_size=12))
    times = draw(st.floats(-5, 100)) + np.concatenate(([0], np.cumsum(steps)))
    labels = draw(st.lists(st.text(max_size=3), min_size=len(steps), max_size=len(steps)))
    return list(zip(labels, times[:-1].tolist(), times[1:].tolist(), strict=True))


# The form


def test_a_schedule_keeps_its_own_times_unchangeable():
    times = np.array(TIMES)
    schedule = ll.Schedule(LABELS, times)
    times[0] = -1
    assert schedule.start == 0
    with pytest.raises(ValueError, match="read-only"):
        schedule.times[0] = 1
    assert (schedule.end, len(schedule)) == (0.5, 4)


@pytest.mark.parametrize(
    ("labels", "times", "message"),
    [
        ((), (0,), "has no phonemes; give at least one"),
        (LABELS, (0, 1), "4 phonemes need 5 boundaries, got 2"),
        (LABELS, [TIMES], "4 phonemes need 5 boundaries, got 5"),
        (("A",), 1.0, "1 phonemes? needs? 2 boundaries, got 1"),
        (LABELS, (0, 0.1, float("nan"), 0.3, 0.5), "boundary 2 is nan; times must be finite"),
        (LABELS, (0, 0.1, 0.2, 0.3, float("inf")), "boundary 4 is inf; times must be finite"),
        (LABELS, (0, 0.1, 0.1, 0.3, 0.5), r"phoneme 1 \('AH0'\), 0.1 to 0.1 s, has no length; g"),
        (LABELS, (0, 0.2, 0.1, 0.3, 0.5), r"phoneme 1 \('AH0'\), 0.2 to 0.1 s, ends before"),
        (
            LABELS,
            (0, 100, 200, 300, 500),
            "sounds last 100 s each; write times in seconds, not in milliseconds",
        ),
        (LABELS, (0, 1, 2, 3, 90_000), "reaches 90000 s, more than a day; write times in seconds"),
        (LABELS, (-90_000, 1, 2, 3, 4), "reaches 90000 s, more than a day; write times in seconds"),
        (LABELS, ("a", "b", "c", "d", "e"), "boundaries must be numbers of seconds"),
        (LABELS, (0, None, {}, [], 1), "boundaries must be numbers of seconds"),
        (LABELS, (0, 1, 2, 3, 10**400), "boundaries must be numbers of seconds"),
        (("A", 5), (0, 1, 2), "phoneme 1: 5 is not a label; use text"),
        ((None,), (0, 1), "phoneme 0: None is not a label; use text"),
    ],
)
def test_what_cannot_be_performed_is_refused(labels, times, message):
    with pytest.raises(ScheduleError, match=f"^line: .*{message}"):
        ll.Schedule(labels, times, source="line")


def test_a_long_pause_is_no_mistake():
    for labels, times in (("A", SILENCE, "B"), (0, 0.1, 3600, 3600.1)), ((SILENCE,), (0, 3600)):
        assert ll.Schedule(labels, times).labels == labels


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ([ll.Word("hi", 0, 5)], "word 'hi' covers phonemes 0 to 4, but the schedule has 0 to 3"),
        ([ll.Word("hi", -1, 2)], "word 'hi' covers phonemes -1 to 1"),
        ([ll.Word("hi", 2, 2)], "word 'hi' covers"),
        ([ll.Word("a", 0, 2), ll.Word("b", 1, 3)], "words 'a' and 'b' share phoneme 1; .* order"),
        ([ll.Word("b", 2, 3), ll.Word("a", 0, 2)], "words 'b' and 'a' share phoneme 0"),
    ],
)
def test_words_that_do_not_fit_are_refused(words, message):
    with pytest.raises(ScheduleError, match=f"^line: {message}"):
        make(words=words, source="line")


def test_words_have_their_times():
    found = ll.Schedule(("_", "M", "AA"), [0, 0.1, 0.3, 0.7], words=(ll.Word("ma", 1, 3),))
    assert [(word.start, word.end) for word in found.words] == [(0.1, 0.7)]
    (later,) = replace(found, times=found.times + 1).words
    assert (later.start, later.end) == (1.1, 1.7)
    assert found.words == (ll.Word("ma", 1, 3),)


def test_words_are_found_by_phoneme():
    schedule = make(words=[ll.Word("hel", 0, 2), ll.Word("lo", 3, 4)])
    found = [schedule.word_at(index) for index in range(4)]
    assert [word and word.text for word in found] == ["hel", "hel", None, "lo"]


def test_moving_and_stretching_keep_everything_but_the_sound():
    audio = ll.Audio(np.zeros(100, np.int16), 100)
    assert audio.seconds == 1
    schedule = make(words=[ll.Word("hello", 0, 4)], language="x", audio=audio)
    moved, slow = schedule.moved(2), schedule.moved(1).stretched(3)
    np.testing.assert_allclose(moved.times, np.add(TIMES, 2))
    np.testing.assert_allclose(slow.times, 1 + np.multiply(TIMES, 3))
    for other in (moved, slow):
        assert (other.labels, other.words, other.language) == (LABELS, schedule.words, "x")
        assert other.audio is None


# Rows


@given(intervals())
def test_contiguous_rows_become_a_schedule(rows):
    schedule = ll.Schedule.from_intervals(rows)
    assert schedule.labels == tuple(label for label, _, _ in rows)
    assert schedule.times.tolist() == [rows[0][1], *(end for _, _, end in rows)]


@given(intervals(), st.data())
def test_rounding_between_rows_is_closed(rows, data):
    noise = st.floats(-0.9 * SNAP_SECONDS, 0.9 * SNAP_SECONDS)
    shaken = [(label, start + data.draw(noise), end) for label, start, end in rows]
    schedule = ll.Schedule.from_intervals(shaken)
    assert schedule.times.tolist() == [shaken[0][1], *(end for _, _, end in rows)]


@given(intervals(), st.floats(2 * SNAP_SECONDS, 1), st.booleans())
def test_gaps_and_overlaps_are_refused_with_the_row(rows, by, later):
    label, start, end = rows[-1]
    by = by if later else -by
    rows = [("x", start - 2, start), (label, start + by, max(end, start + by) + 1)]
    what = "a gap. Write silence there" if later else "they overlap. Move one of the two"
    with pytest.raises(ScheduleError, match=rf"phoneme 1 .* starts at .*: {what}"):
        ll.Schedule.from_intervals(rows)


def test_rows_may_hold_numpys_numbers_but_no_others():
    rows = [("a", np.float32(0), np.int64(1)), ("b", 1, np.float64(2))]
    assert ll.Schedule.from_intervals(rows).times.tolist() == [0, 1, 2]
    for odd in (True, np.True_, "1", None, 1j, np.complex64(1), np.array([1.0])):
        with pytest.raises(ScheduleError, match=r"phoneme 0 \('a'\): .* is not a time; times are"):
            ll.Schedule.from_intervals([("a", 0, odd)])


def test_words_take_the_phonemes_whose_middle_they_cover():
    schedule = make()
    spans = [("he", 0, 0.16), (" ", 0.16, 0.2), ("llo", 0.16, 0.5), ("!", 0.45, 0.5)]
    words = words_from_spans(schedule, spans)
    assert [(w.text, w.first, w.stop) for w in words] == [("he", 0, 2), ("llo", 2, 4)]


def test_words_that_overlap_share_no_phoneme():
    words = words_from_spans(make(), [("a", 0, 0.3), ("b", 0.1, 0.5), ("c", 0, 0.5)])
    assert [(w.text, w.first, w.stop) for w in words] == [("a", 0, 3), ("b", 3, 4)]


# Readers

assert TIMING_READERS, "a sweep over nothing passes"

ROWS = list(zip(LABELS, TIMES, TIMES[1:], strict=False))

WORDS_ONLY = {".words", ".wrd"}
"""Suffixes of files with times of words only."""

EXAMPLES = {
    "json": json.dumps(
        {
            "notation": "arpabet",
            "phonemes": [{"label": label, "start": at, "end": end} for label, at, end in ROWS],
            "words": [{"text": "hello", "start": 0, "end": 0.5}],
        }
    ),
    "audacity": "".join(f"{at:.6f}\t{end:.6f}\t{label}\n" for label, at, end in ROWS),
    "ctm": "".join(f"line 1 {at:.3f} {end - at:.3f} {label}\n" for label, at, end in ROWS),
    "mfa-json": json.dumps(
        {
            "start": 0,
            "end": 0.5,
            "tiers": {
                "words": {"type": "interval", "entries": [[0, 0.5, "hello"]]},
                "phones": {
                    "type": "interval",
                    "entries": [[start, end, label] for label, start, end in ROWS],
                },
            },
        }
    ),
    "table": "Begin,End,Label,Type,Speaker\n0,0.5,hello,words,Ann\n"
    + "".join(f"{start},{end},{label},phones,Ann\n" for label, start, end in ROWS),
    "textgrid": (
        'File type = "ooTextFile"\nObject class = "TextGrid"\n\n0\n0.5\n<exists>\n2\n'
        '"IntervalTier"\n"words"\n0\n0.5\n1\n0\n0.5\n"hello"\n'
        '"IntervalTier"\n"phones"\n0\n0.5\n4\n'
        + "".join(f'{start}\n{end}\n"{label}"\n' for label, start, end in ROWS)
    ),
    "htk": (
        "0 1000000 HH -58.1 hello\n1000000 2000000 AH0 -60.5\n"
        "2000000 3000000 L -49\n3000000 5000000 OW1 -1e2\n"
    ),
    "esps": (
        "separator ;\nnfields 1\n#\n    0.1000  121 HH\n    0.2000  121 AH0\n"
        "    0.3000  121 L ; long\n    0.5000  121 OW1\n"
    ),
    "timit": "0 1600 HH\n1600 3200 AH0\n3200 4800 L\n4800 8000 OW1\n",
    "partitur": (
        "LHD: Partitur 1.3\nREP: here\nSAM: 16000\nLBD:\nORT:\t0\thello\nMAU:\t0\t1599\t0\tHH\n"
        "MAU:\t1600\t1599\t0\tAH0\nMAU:\t3200\t1599\t0\tL\nMAU:\t4800\t3199\t0\tOW1\n"
    ),
    "gentle": json.dumps(
        {
            "transcript": "hello",
            "words": [
                {
                    "case": "success",
                    "word": "hello",
                    "start": 0,
                    "end": 0.5,
                    "phones": [
                        {"phone": f"{label}_{place}", "duration": end - at}
                        for (label, at, end), place in zip(ROWS, "BIIE", strict=True)
                    ],
                }
            ],
        }
    ),
    "rhubarb": "0.00\tA\n0.10\tC\n0.20\tH\n0.30\tF\n0.50\tX\n",
    "polly": (
        '{"time":0,"type":"word","start":0,"end":5,"value":"hello"}\n'
        '{"time":0,"type":"viseme","value":"k"}\n{"time":100,"type":"viseme","value":"E"}\n'
        '{"time":200,"type":"viseme","value":"t"}\n{"time":300,"type":"viseme","value":"o"}\n'
        '{"time":500,"type":"viseme","value":"sil"}\n'
    ),
    "azure": json.dumps(
        {
            "Metadata": [
                {
                    "Type": "WordBoundary",
                    "Data": {
                        "Offset": 0,
                        "Duration": 5_000_000,
                        "text": {"Text": "hello", "Length": 5, "BoundaryType": "Word"},
                    },
                },
                *(
                    {"Type": "Viseme", "Data": {"Offset": round(at * 1e7), "VisemeId": number}}
                    for number, at in ((12, 0), (4, 0.1), (14, 0.2), (8, 0.3))
                ),
                {"Type": "SessionEnd", "Data": {"Offset": 5_000_000}},
            ]
        }
    ),
    "sapi": "".join(
        f'{{"AudioPosition": "00:00:00.{at}000000", "Duration": "00:00:00.{long}000000",'
        f' "Viseme": {number}, "NextViseme": 0}}\n'
        for at, long, number in ((0, 1, 12), (1, 1, 4), (2, 1, 14), (3, 2, 8))
    ),
    "papagayo": (
        "lipsync version 1\nhello.wav\n10\n5\n1\n\tVoice 1\n\thello\n\t1\n\t\thello\n\t\t0\n\t\t4\n"
        "\t\t1\n\t\t\thello 0 4 4\n\t\t\t\t0 etc\n\t\t\t\t1 E\n\t\t\t\t2 L\n\t\t\t\t3 O\n"
    ),
    "bml": (
        '<?xml version="1.0" encoding="UTF-8"?>\n<bml>\n'
        '<speech><sync id="T0" time="0"/>hello<sync id="T1" time="0.5"/></speech>\n'
        '<lips viseme="H" articulation="1.0" start="0" ready="0" relax="0.1" end="0.1"/>\n'
        '<lips viseme="Ah" start="0.1" end="0.2"/>\n<lips viseme="L" start="0.2" end="0.3"/>\n'
        '<lips viseme="Ow" start="0.3" end="0.5"/>\n</bml>\n'
    ),
    "elan": (
        '<?xml version="1.0" encoding="UTF-8"?>\n'
        '<ANNOTATION_DOCUMENT AUTHOR="" DATE="2024-01-01T12:00:00+00:00" FORMAT="3.0">\n'
        '<HEADER MEDIA_FILE="" TIME_UNITS="milliseconds"/>\n<TIME_ORDER>\n'
        + "".join(
            f'<TIME_SLOT TIME_SLOT_ID="ts{n}" TIME_VALUE="{round(at * 1000)}"/>\n'
            for n, at in enumerate(TIMES)
        )
        + '</TIME_ORDER>\n<TIER LINGUISTIC_TYPE_REF="default-lt" TIER_ID="wd@Ann">\n<ANNOTATION>'
        '<ALIGNABLE_ANNOTATION ANNOTATION_ID="a1" TIME_SLOT_REF1="ts0" TIME_SLOT_REF2="ts4">'
        "<ANNOTATION_VALUE>hello</ANNOTATION_VALUE></ALIGNABLE_ANNOTATION></ANNOTATION>\n</TIER>\n"
        '<TIER LINGUISTIC_TYPE_REF="phones" PARENT_REF="wd@Ann" TIER_ID="ph@Ann">\n'
        + "".join(
            f'<ANNOTATION><ALIGNABLE_ANNOTATION ANNOTATION_ID="p{n}" TIME_SLOT_REF1="ts{n}" '
            f'TIME_SLOT_REF2="ts{n + 1}"><ANNOTATION_VALUE>{label}</ANNOTATION_VALUE>'
            "</ALIGNABLE_ANNOTATION></ANNOTATION>\n"
            for n, label in enumerate(LABELS)
        )
        + '</TIER>\n<LINGUISTIC_TYPE LINGUISTIC_TYPE_ID="default-lt" TIME_ALIGNABLE="true"/>\n'
        "</ANNOTATION_DOCUMENT>\n"
    ),
    "sppas": (
        '<?xml version="1.0" encoding="utf-8"?>\n'
        '<Document author="me" date="2024-01-01" format="1.4" name="AutomaticAlignment">\n'
        + "".join(
            f'<Tier id="{name}" tiername="{name}">\n'
            + "".join(
                f'<Annotation><Location><Interval><Begin midpoint="{at}" radius="0.005"/>'
                f'<End midpoint="{end}" radius="0.005"/></Interval></Location>'
                f'<Label><Tag type="str">{label}</Tag></Label></Annotation>\n'
                for label, at, end in rows
            )
            + "</Tier>\n"
            for name, rows in (("PhonAlign", ROWS), ("TokensAlign", [("hello", 0, 0.5)]))
        )
        + "</Document>\n"
    ),
    "emu": json.dumps(
        {
            "name": "line",
            "annotates": "line.wav",
            "sampleRate": 20000,
            "levels": [
                {
                    "name": "Word",
                    "type": "ITEM",
                    "items": [{"id": 1, "labels": [{"name": "Word", "value": "hello"}]}],
                },
                {
                    "name": "Phonetic",
                    "type": "SEGMENT",
                    "items": [
                        {
                            "id": number,
                            "sampleStart": round(at * 20000),
                            "sampleDur": round((end - at) * 20000) - 1,
                            "labels": [{"name": "Phonetic", "value": label}],
                        }
                        for number, (label, at, end) in enumerate(ROWS, 2)
                    ],
                },
            ],
            "links": [{"fromID": 1, "toID": number} for number in range(2, 6)],
        }
    ),
    "voicevox": json.dumps(
        {
            "accent_phrases": [
                {
                    "moras": [
                        {
                            "text": text,
                            "consonant": ROWS[at][0],
                            "consonant_length": ROWS[at][2] - ROWS[at][1],
                            "vowel": ROWS[at + 1][0],
                            "vowel_length": ROWS[at + 1][2] - ROWS[at + 1][1],
                            "pitch": 5.5,
                        }
                        for text, at in (("hel", 0), ("lo", 2))
                    ],
                    "accent": 1,
                    "pause_mora": None,
                    "is_interrogative": False,
                }
            ],
            "speedScale": 1.0,
            "prePhonemeLength": 0.0,
            "postPhonemeLength": 0.0,
            "outputSamplingRate": 24000,
            "kana": "",
        }
    ),
    "bournemouth": json.dumps(
        {
            "segments": [
                {
                    "start": 0.0,
                    "end": 0.6,
                    "text": "hello",
                    "phoneme_ts": [
                        {"ipa_label": label, "start_ms": at * 1000, "end_ms": end * 1000}
                        for label, at, end in ROWS
                    ],
                    "words_ts": [{"word": "hello", "start_ms": 0.0, "end_ms": 500.0}],
                }
            ]
        }
    ),
    "charsiu": json.dumps([[[at, end, label] for label, at, end in ROWS], [[0.0, 0.5, "hello"]]]),
    "moho": "MohoSwitch1\n1 etc\n4 E\n7 L\n10 O\n16 rest\n",
    "subtitles": "WEBVTT\n\n00:00.000 --> 00:00.500\n<v Ann>hello\n",
    "aeneas": json.dumps(
        {
            "fragments": [
                {
                    "begin": "0.000",
                    "children": [],
                    "end": "0.500",
                    "id": "f000001",
                    "language": "eng",
                    "lines": ["hello"],
                }
            ]
        }
    ),
    "elevenlabs": json.dumps(
        {
            "audio_base64": "",
            "alignment": {
                "characters": list("hello"),
                "character_start_times_seconds": [0.0, 0.1, 0.2, 0.25, 0.3],
                "character_end_times_seconds": [0.1, 0.2, 0.25, 0.3, 0.5],
            },
            "normalized_alignment": None,
        }
    ),
    "transcriber": (
        '<?xml version="1.0" encoding="ISO-8859-1"?>\n<!DOCTYPE Trans SYSTEM "trans-14.dtd">\n'
        '<Trans scribe="me" audio_filename="line" version="1" version_date="240101">\n<Speakers>\n'
        '<Speaker id="spk1" name="Ann" check="no" dialect="native" accent="" scope="local"/>\n'
        '</Speakers>\n<Episode>\n<Section type="report" startTime="0" endTime="0.5">\n'
        '<Turn speaker="spk1" startTime="0" endTime="0.5">\n<Sync time="0"/>\nhello\n'
        '<Event desc="b" type="noise" extent="instantaneous"/>\n</Turn>\n</Section>\n</Episode>\n'
        "</Trans>\n"
    ),
    "whisper": json.dumps(
        {
            "segments": [
                {
                    "start": 0.0,
                    "end": 0.5,
                    "text": " hello",
                    "words": [{"word": "hello", "start": 0.0, "end": 0.5, "score": 0.9}],
                }
            ],
            "language": "en",
        }
    ),
    "cartesia": json.dumps(
        {
            "type": "phoneme_timestamps",
            "phoneme_timestamps": {
                "phonemes": list(LABELS),
                "start": list(TIMES[:-1]),
                "end": list(TIMES[1:]),
            },
            "word_timestamps": {"words": ["hello"], "start": [0.0], "end": [0.5]},
        }
    ),
    "inworld": json.dumps(
        {
            "timestampInfo": {
                "wordAlignment": {
                    "words": ["hello", "."],
                    "wordStartTimeSeconds": [0.0, 0.5],
                    "wordEndTimeSeconds": [0.5, 0.5],
                    "phoneticDetails": [
                        {
                            "wordIndex": 0,
                            "phones": [
                                {
                                    "phoneSymbol": label,
                                    "startTimeSeconds": at,
                                    "durationSeconds": end - at,
                                    "visemeSymbol": "aei",
                                }
                                for label, at, end in ROWS
                            ],
                        }
                    ],
                }
            },
        }
    ),
    "mbrola": "; a line\nHH 100\nAH0 100 0 120 50 125\nL 100 (20,118)\nOW1 200.0\n",
    "azure-recognition": json.dumps(
        {
            "RecognitionStatus": "Success",
            "NBest": [
                {
                    "Confidence": 0.9,
                    "Words": [
                        {
                            "Word": "hello",
                            "Offset": 0,
                            "Duration": 5_000_000,
                            "Phonemes": [
                                {
                                    "Phoneme": label,
                                    "Offset": round(at * 1e7),
                                    "Duration": round((end - at) * 1e7),
                                }
                                for label, at, end in ROWS
                            ],
                        }
                    ],
                }
            ],
        }
    ),
}
"""The same line in every input format."""

ONLY_WORDS = {"aeneas", "elevenlabs", "subtitles", "transcriber", "whisper"}
"""Formats with times of words, but not of phonemes."""

SHAPES = {
    "rhubarb": ("A", "C", "H", "F"),
    "polly": ("k", "E", "t", "o"),
    "azure": ("12", "4", "14", "8"),
    "sapi": ("12", "4", "14", "8"),
    "papagayo": ("etc", "E", "L", "O"),
    "bml": ("H", "Ah", "L", "Ow"),
    "moho": ("etc", "E", "L", "O"),
}
"""The line's labels in formats of mouth shapes."""

WORDLESS = {
    "audacity": "a label track holds one kind of label",
    "ctm": "a line is a phone or a word, and does not say which",
    "esps": "words are in another file",
    "timit": "words are in another file",
    "rhubarb": "the program hears words, but does not write them",
    "sapi": "words are other events",
    "mbrola": "phonemes are all that there is",
    "moho": "drawings are all that there is",
}
"""Formats whose example file has no words."""

UNITS = {
    "azure": 1e7,
    "azure-recognition": 1e7,
    "bournemouth": 1e3,
    "elan": 1e3,
    "emu": 20e3,
    "htk": 1e7,
    "mbrola": 1e3,
    "moho": 30,
    "papagayo": 10,
    "partitur": 16e3,
    "polly": 1e3,
    "timit": 16e3,
}
"""Units per second of examples with other units than seconds."""

ROUNDED_SECONDS = {"voicevox": 0.0125}
"""Formats whose times are rounded to frames of an engine, with the error of the example."""


def test_every_reader_has_an_example():
    assert set(EXAMPLES) == set(TIMING_READERS)


@pytest.mark.parametrize(
    ("name", "suffix"),
    [(r.name, end) for r in TIMING_READERS.values() for end in r.suffixes if end not in WORDS_ONLY],
)
def test_every_reader_reads_its_example(name, suffix, tmp_path):
    for path in (tmp_path / f"line{suffix}", tmp_path / f"loud{suffix.upper()}"):
        path.write_text(EXAMPLES[name], "utf-8")
        if name in ONLY_WORDS:
            timed = ll.read_timings(path)
            assert [(w.text, w.start, w.end) for w in timed.words] == [("hello", 0, 0.5)]
            assert timed.source == str(path)
            continue
        schedule = ll.read_schedule(path, rate=30 if name == "moho" else None)
        assert schedule.labels == SHAPES.get(name, LABELS)
        np.testing.assert_allclose(schedule.times, TIMES, atol=ROUNDED_SECONDS.get(name, 1e-9))
        assert schedule.words == (() if name in WORDLESS else (ll.Word("hello", 0, 4),))
        assert any("mouth shapes" in told for told in schedule.remarks) == (name in SHAPES)
        assert schedule.source == str(path)
        assert ll.read_schedule(str(path), notation="ipa").notation == "ipa"


@pytest.mark.parametrize("name", TIMING_READERS)
def test_every_reader_counts_in_the_units_that_are_asked_for(name, tmp_path):
    path = tmp_path / f"line{TIMING_READERS[name].suffixes[0]}"
    path.write_text(EXAMPLES[name], "utf-8")
    schedule = ll.read_timings(path, rate=2 * UNITS.get(name, 1))
    if name in ONLY_WORDS:
        assert [(w.text, w.start, w.end) for w in schedule.words] == [("hello", 0, 0.25)]
        return
    off = ROUNDED_SECONDS.get(name, 1e-9)
    np.testing.assert_allclose(schedule.times, np.array(TIMES) / 2, atol=off)
    assert schedule.words == ll.read_schedule(path).words


@pytest.mark.parametrize("reader", TIMING_READERS.values(), ids=TIMING_READERS)
def test_a_tier_is_asked_for_where_there_may_be_several(reader, tmp_path):
    path = tmp_path / f"line{reader.suffixes[0]}"
    path.write_text(EXAMPLES[reader.name], "utf-8")
    if reader.name == "htk":  # only a master file has several
        assert ll.read_schedule(path, tier="x").labels == LABELS
        return
    told = "'x'" if reader.tiers else f"{reader.name} files have no tiers; leave out `tier='x'`"
    with pytest.raises(ScheduleError, match=told):
        ll.read_schedule(path, tier="x")


def test_our_json_says_its_notation(tmp_path):
    path = tmp_path / "line.json"
    path.write_text(EXAMPLES["json"], "utf-8")
    assert ll.read_schedule(path).notation == "arpabet"


@pytest.mark.parametrize("reader", TIMING_READERS.values(), ids=TIMING_READERS)
def test_every_reader_says_what_it_reads(reader):
    assert reader.title.endswith(".")
    assert all(suffix == suffix.lower() and suffix[0] == "." for suffix in reader.suffixes)


@pytest.mark.parametrize("reader", TIMING_READERS.values(), ids=TIMING_READERS)
@pytest.mark.parametrize("content", [b"", b"\0" * 99, b"\xff" * 9, b"hello", b"[" * 10_000])
def test_every_reader_refuses_in_words(reader, content, tmp_path):
    path = tmp_path / f"line{reader.suffixes[0]}"
    path.write_bytes(content)
    with pytest.raises(ScheduleError, match=r"line\.") as caught:
        ll.read_schedule(path)
    assert str(caught.value).startswith(str(path))
