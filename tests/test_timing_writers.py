"""Timings written, and read back."""

from dataclasses import replace

import numpy as np
import pytest

from lipsync_lang.schedules.schedule import Audio, Schedule, Word
from lipsync_lang.schedules.timing_readers import read_schedule
from lipsync_lang.schedules.timing_writers import TIMING_WRITERS, textgrid_text

LINE = Schedule(
    ("m", "ɑː", "_", 'n"', "iː"), np.array([0, 0.1, 0.3, 0.45, 0.5, 0.7]),
    words=(Word('ma "x"', 0, 2, 1.5), Word("née", 3, 5)), notation="ipa", stress=(0, 1, None, 0, 2),
)  # fmt: skip


def again(suffix, schedule, folder):
    path = folder / f"line.{suffix}"
    path.write_text(TIMING_WRITERS[suffix](schedule), "utf-8")
    return read_schedule(path)


@pytest.mark.parametrize("suffix", TIMING_WRITERS)
def test_what_is_written_is_read_back(suffix, tmp_path):
    found = again(suffix, LINE, tmp_path)
    assert found.labels == LINE.labels
    assert found.times == pytest.approx(LINE.times)
    told = [(word.text, word.first, word.stop) for word in found.words]
    assert told == [(word.text, word.first, word.stop) for word in LINE.words]


def test_json_keeps_stress_emphasis_and_notation(tmp_path):
    found = again("json", LINE, tmp_path)
    assert (found.notation, found.stress, found.words) == (LINE.notation, LINE.stress, LINE.words)


def test_a_textgrid_is_as_long_as_its_sound(tmp_path):
    sounding = replace(LINE, audio=Audio(np.zeros(20_000, np.int16), 20_000))
    assert "\nxmax = 1.0\n" in textgrid_text(sounding)
    found = again("TextGrid", sounding, tmp_path)
    assert (found.labels[-1], found.end) == ("_", 1.0)


def test_a_line_that_starts_late_starts_in_silence(tmp_path):
    found = again("TextGrid", replace(LINE, times=LINE.times + 1), tmp_path)
    assert found.times[:3] == pytest.approx([0, 1, 1.1])
    assert found.labels[:2] == ("_", "m")
