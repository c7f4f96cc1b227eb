"""Timings written, and read back."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import needs_plug_ins

from lipsync_lang.base.errors import OutputError
from lipsync_lang.schedules.schedule import Audio, Schedule, Word
from lipsync_lang.schedules.timing_readers import read_schedule
from lipsync_lang.schedules.writers import TIMING_WRITERS
from lipsync_lang.schedules.writers.textgrid import textgrid_text

LINE = Schedule(
    ("m", "ɑː", "_", 'n"', "iː"), np.array([0, 0.1, 0.3, 0.45, 0.5, 0.7]),
    words=(Word('ma "x"', 0, 2, 1.5), Word("née", 3, 5)), notation="ipa", stress=(0, 1, None, 0, 2),
)  # fmt: skip


def again(suffix, schedule, folder):
    path = folder / f"line.{suffix}"
    path.write_text(TIMING_WRITERS[suffix](schedule), "utf-8")
    return read_schedule(path)


@needs_plug_ins
@pytest.mark.parametrize("suffix", sorted(TIMING_WRITERS.keys() - {"txt"}))
def test_what_is_written_is_read_back(suffix, tmp_path):
    found = again(suffix, LINE, tmp_path)
    assert found.labels == LINE.labels
    assert found.times == pytest.approx(LINE.times)
    told = [(word.text, word.first, word.stop) for word in found.words]
    assert told == [(word.text, word.first, word.stop) for word in LINE.words]


SOUNDS = ("m", "ɑː", 'n"', "tʃ", "<p", "a&b", "iː,")


@st.composite
def schedules(draw):
    """Draw schedules with words, some silence and some confidences."""
    labels, words, sure = [], [], st.none() | st.integers(0, 100).map(lambda n: n / 100)
    for text in draw(st.lists(st.text("aä'\"&<,;é中", min_size=1), min_size=1, max_size=5)):
        if draw(st.booleans()) and labels[-1:] != ["_"]:
            labels.append("_")
        first = len(labels)
        labels += draw(st.lists(st.sampled_from(SOUNDS), min_size=1, max_size=4))
        words.append(Word(text, first, len(labels), confidence=draw(sure)))
    labels += ["_"] * draw(st.integers(0, 1))
    steps = draw(st.lists(st.integers(12, 400), min_size=len(labels), max_size=len(labels)))
    return Schedule(tuple(labels), np.cumsum([0, *steps]) / 1000, tuple(words))


@needs_plug_ins
@given(schedules())
def test_reading_back_gives_the_same_schedule(tmp_path_factory, schedule):
    folder = tmp_path_factory.mktemp("timings")
    for suffix in TIMING_WRITERS:
        found = again(suffix, schedule, folder)
        assert found.labels == schedule.labels, suffix
        assert found.times == pytest.approx(schedule.times, abs=1e-6), suffix
        assert found.words == (() if suffix == "txt" else schedule.words), suffix


@needs_plug_ins
def test_what_is_before_zero_is_left_out_but_in_json(tmp_path):
    early = replace(LINE, times=LINE.times - 0.2)
    for suffix in ("TextGrid", "eaf", "csv", "txt"):
        found = again(suffix, early, tmp_path)
        assert found.labels == LINE.labels[1:], suffix
        assert found.times == pytest.approx([0, 0.1, 0.25, 0.3, 0.5]), suffix
    assert again("json", early, tmp_path).start == pytest.approx(-0.2)


@needs_plug_ins
def test_boundaries_within_a_millisecond_stay_apart_in_elan(tmp_path):
    close = replace(LINE, times=np.array([0, 0.1, 0.1002, 0.3, 0.3003, 0.7]))
    found = again("eaf", close, tmp_path)
    assert found.times == pytest.approx([0, 0.1, 0.101, 0.3, 0.301, 0.7])


def test_json_keeps_stress_notation_and_the_fields_of_words(tmp_path):
    first, *others = LINE.words
    line = replace(LINE, words=(replace(first, relabelled=True), *others))
    found = again("json", line, tmp_path)
    assert (found.notation, found.stress, found.words) == (line.notation, line.stress, line.words)


def test_a_textgrid_is_as_long_as_its_sound(tmp_path):
    sounding = replace(LINE, audio=Audio(np.zeros(20_000, np.int16), 20_000))
    assert "\nxmax = 1.0\n" in textgrid_text(sounding)
    found = again("TextGrid", sounding, tmp_path)
    assert (found.labels[-1], found.end) == ("_", 1.0)


def test_a_line_that_starts_late_starts_in_silence(tmp_path):
    found = again("TextGrid", replace(LINE, times=LINE.times + 1), tmp_path)
    assert found.times[:3] == pytest.approx([0, 1, 1.1])
    assert found.labels[:2] == ("_", "m")


def test_a_schedule_is_saved_by_its_suffix(tmp_path):
    for suffix in TIMING_WRITERS:
        path = tmp_path / f"line.{suffix.upper()}"
        LINE.save(path)
        assert path.read_text("utf-8") == TIMING_WRITERS[suffix](LINE)
    with pytest.raises(OutputError, match=r"line\.mp3: timings cannot be written as '\.mp3'"):
        LINE.save(tmp_path / "line.mp3")


@pytest.mark.parametrize("suffix", sorted(TIMING_WRITERS.keys() - {"json"}))
def test_timings_that_end_at_once_are_refused(suffix):
    schedule = replace(LINE, times=LINE.times * 1e-9)
    with pytest.raises(OutputError, match=r"ends at 7e-10 s; check its units per second"):
        TIMING_WRITERS[suffix](schedule)


def test_labels_that_begin_like_formulas_are_text_for_spreadsheets_and_read_back(tmp_path):
    labels = ("@", "'@", "m", "''-x", "'m")
    words = (Word("-58.1", 0, 2), Word("=1+1", 2, 4), Word("'ma", 4, 5))
    schedule = Schedule(labels, np.arange(6) / 10, words)
    cells = [row.split(",")[2] for row in TIMING_WRITERS["csv"](schedule).splitlines()[1:]]
    assert cells == ["'-58.1", "'=1+1", "'ma", "'@", "''@", "m", "'''-x", "'m"]
    found = again("csv", schedule, tmp_path)
    assert found.labels == labels
    assert [word.text for word in found.words] == ["-58.1", "=1+1", "'ma"]
