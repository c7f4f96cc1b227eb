"""Schedules: refusals, words, and readers."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from places import TESTS

import lipsync_lang as ll
from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.schedules import SILENCE
from lipsync_lang.schedules.rows import LabelRow, schedule_of
from lipsync_lang.schedules.schedule import SNAP_SECONDS, words_from_spans
from lipsync_lang.schedules.timing_file import TimingFile
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

WORDS_ONLY = {".words", ".wrd"}
"""Suffixes of files with times of words only."""

EXAMPLES = {path.stem: path.read_bytes().decode() for path in sorted(TESTS.glob("**/examples/*.*"))}
"""The same line in every input format."""

ONLY_WORDS = {
    "aeneas",
    "aws-transcribe",
    "deepgram",
    "edge-tts",
    "elevenlabs",
    "gladia",
    "google",
    "google-timepoints",
    "google-v2",
    "kokoro-tokens",
    "rev",
    "speechmatics",
    "subtitles",
    "transcriber",
    "whisper",
    "word-times",
}
"""Formats with times of words, but not of phonemes."""

SHAPES = {
    "rhubarb": ("A", "C", "H", "F"),
    "polly": ("k", "E", "t", "o"),
    "azure": ("12", "4", "14", "8"),
    "sapi": ("12", "4", "14", "8"),
    "papagayo": ("etc", "E", "L", "O"),
    "bml": ("H", "Ah", "L", "Ow"),
    "moho": ("etc", "E", "L", "O"),
    "talking-head": ("DD", "E", "DD", "O"),
}
"""The line's labels in formats of mouth shapes."""

IN_IPA = {"allosaurus": ("h", "a", "l", "o")}
"""The line's labels in formats that hold IPA alone."""

WORDLESS = {
    "audacity": "a label track holds one kind of label",
    "ctm": "a line is a phone or a word, and does not say which",
    "esps": "words are in another file",
    "timit": "words are in another file",
    "cslu": "words are in another file",
    "rhubarb": "the program hears words, but does not write them",
    "sapi": "words are other events",
    "mbrola": "phonemes are all that there is",
    "moho": "drawings are all that there is",
    "allosaurus": "phones are all that there is",
    "kokoro": "phonemes are all that there is",
    "piper": "the text is not timed",
    "piper-samples": "the text is not timed",
}
"""Formats whose example file has no words."""

UNITS = {
    "cslu": 1e3,
    "azure": 1e7,
    "azure-recognition": 1e7,
    "bournemouth": 1e3,
    "edge-tts": 1e7,
    "elan": 1e3,
    "emu": 20e3,
    "htk": 1e7,
    "mbrola": 1e3,
    "moho": 30,
    "papagayo": 10,
    "partitur": 16e3,
    "piper-samples": 22050,
    "polly": 1e3,
    "talking-head": 1e3,
    "timit": 16e3,
}
"""Units per second of examples with other units than seconds."""

ROUNDED_SECONDS = {"voicevox": 0.0125, "julius": 0.01251}
"""Formats whose times are those of an engine's frames, with the error of the example."""


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
        assert schedule.labels == (SHAPES | IN_IPA).get(name, LABELS)
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


@given(
    st.lists(st.tuples(st.integers(0, 30), st.sampled_from([0, 0, 3, 5])), min_size=2, max_size=8)
)
def test_sounds_without_length_have_a_gap_or_the_time_of_a_neighbour(steps):
    rows, at = [], 0.0
    for gap, length in steps:
        rows.append(LabelRow("a", at + gap / 100, at + (gap + length) / 100))
        at = rows[-1].end
    source = TimingFile(Path("a.ctm"), b"")
    if not any(length for _, length in steps):
        with pytest.raises(ScheduleError, match="has no length"):
            schedule_of(source, rows)
        return
    found = schedule_of(source, rows)
    assert found.labels.count("a") == len(rows)
    assert np.diff(found.times).min() > 0
    assert found.times[-1] == pytest.approx(at)


def test_sounds_without_length_between_gaps_have_the_usual_length():
    rows = [("a", 0, 0.1), ("u", 0.3, 0.3), ("b", 0.3, 0.3), ("i", 0.5, 0.7), ("m", 0.8, 0.8)]
    found = schedule_of(TimingFile(Path("a.ctm"), b""), [LabelRow(*row) for row in rows])
    assert found.labels == ("a", "_", "u", "b", "_", "i", "_", "m")
    assert found.times == pytest.approx([0, 0.1, 0.3, 0.38, 0.46, 0.5, 0.7, 0.72, 0.8])


@given(st.lists(st.integers(1, 9), min_size=1, max_size=3), st.integers(1, 40))
def test_likely_labels_have_their_shares_of_the_copies(weights, count):
    chances = np.array(weights) / sum(weights)
    likely = tuple(zip("AEO", chances.tolist(), strict=False))
    line = ll.Schedule(("A", "M"), [0, 1, 2], likely=(likely, ()))
    copies = line.weighed(count)
    assert {one.labels[1] for one in copies} == {"M"}
    for label, chance in likely:
        assert abs(sum(one.labels[0] == label for one in copies) / count - chance) <= 1 / count
    assert replace(line, likely=()).weighed(count) == []
