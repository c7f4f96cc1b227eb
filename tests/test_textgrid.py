"""TextGrids: every text form, every odd kind, and never a traceback."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from lipsync_lang.errors import ScheduleError
from lipsync_lang.schedules import SILENCE, Schedule, read_schedule
from lipsync_lang.schedules.source import Source
from lipsync_lang.schedules.textgrid import read_textgrid, read_tier

PHONES = [("", 0, 0.1), ("HH", 0.1, 0.2), ("AY1", 0.2, 0.45), ("", 0.45, 0.6)]
WORDS = [("", 0, 0.1), ("hi", 0.1, 0.45), ("", 0.45, 0.6)]
PATH = Path("line.TextGrid")


def long_form(tiers, end=0.6, kind="IntervalTier"):
    lines = ['File type = "ooTextFile"', 'Object class = "TextGrid"', ""]
    lines += ["xmin = 0", f"xmax = {end}", "tiers? <exists>", f"size = {len(tiers)}", "item []:"]
    for number, (name, rows) in enumerate(tiers, 1):
        lines += [f"    item [{number}]:", f'        class = "{kind}"', f'        name = "{name}"']
        lines += ["        xmin = 0", f"        xmax = {end}"]
        lines += [f"        intervals: size = {len(rows)}"]
        for at, (label, start, stop) in enumerate(rows, 1):
            lines += [f"        intervals [{at}]:", f"            xmin = {start}"]
            lines += [f"            xmax = {stop}", f'            text = "{label}"']
    return "\n".join(lines) + "\n"


def short_form(tiers, end=0.6):
    lines = ['File type = "ooTextFile"', 'Object class = "TextGrid"', "", "0", str(end)]
    lines += ["<exists>", str(len(tiers))]
    for name, rows in tiers:
        lines += ['"IntervalTier"', f'"{name}"', "0", str(end), str(len(rows))]
        for label, start, stop in rows:
            lines += [str(start), str(stop), f'"{label}"']
    return "\n".join(lines) + "\n"


def read(text, **rest):
    return read_tier(PATH, text.encode(), **rest)


TIERS = [("words", WORDS), ("phones", PHONES)]


@pytest.mark.parametrize("form", [long_form, short_form])
@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_every_text_form_reads_alike(form, newline, encoding):
    text = form(TIERS).replace("\n", newline).replace("AY1", "ˈaɪ")
    schedule = read_textgrid(Source(PATH, text.encode(encoding)))
    assert schedule.labels == (SILENCE, "HH", "ˈaɪ", SILENCE)
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.2, 0.45, 0.6])
    assert [(w.text, w.first, w.stop) for w in schedule.words] == [("hi", 1, 3)]


def test_old_short_files_and_files_without_a_last_newline_lose_nothing():
    text = (
        short_form(TIERS).replace("ooTextFile", "ooTextFile short").replace("Object class = ", "")
    )
    assert read(text.rstrip("\n")).labels == (SILENCE, "HH", "AY1", SILENCE)


def test_textgrid_json_is_read():
    tier = {"type": "IntervalTier", "entries": [[0, 0.1, ""], [0.1, 0.3, "a"]]}
    text = json.dumps({"start": 0, "end": 0.3, "tiers": {"phones": tier}})
    assert read(text).labels == (SILENCE, "a")


@pytest.mark.parametrize(
    "name", ["phones", "Phone", "phonemes", "MAU", "PhonAlign", "segments", "Ann Lee - phones"]
)
def test_the_phone_tier_is_known_by_its_name(name):
    other = [("x", 0, 0.01), ("y", 0.01, 0.02), ("z", 0.02, 0.03), ("v", 0.03, 0.6)]
    assert len(read(long_form([("pitch", other), (name, PHONES)]))) == len(PHONES)


def test_the_phone_tier_is_known_by_its_looks():
    phones = [("h", 0, 0.1), ("ə", 0.1, 0.2), ("l", 0.2, 0.3), ("oʊ", 0.3, 0.6)]
    assert read(long_form([("words", [("hello", 0, 0.6)]), ("ann", phones)])).labels[0] == "h"


def test_a_speaker_keeps_to_his_own_words():
    text = long_form(
        [
            ("Ann - words", WORDS),
            ("Ann - phones", PHONES),
            ("Bob - words", [("ho", 0, 0.6)]),
            ("Bob - phones", [("HH", 0, 0.3), ("OW", 0.3, 0.6)]),
        ]
    )
    with pytest.raises(ScheduleError, match="2 tiers look like phones: 'Ann - phones', 'Bob"):
        read(text)
    assert [w.text for w in read(text, tier="Ann").words] == ["hi"]
    assert [w.text for w in read(text, tier="Bob - phones").words] == ["ho"]
    with pytest.raises(ScheduleError, match="did you mean 'Bob - words'"):
        read(text, tier="Bob - word")


def test_a_speaker_who_says_nothing_is_no_choice():
    text = long_form([("Ann - phones", PHONES), ("Noise - phones", [("", 0, 0.6)])])
    assert len(read(text)) == len(PHONES)


def test_time_zero_stays_that_of_the_sound_and_gaps_are_silence():
    schedule = read(long_form([("phones", [("a", 0.1, 0.2), ("b", 0.4, 0.5)])]))
    assert schedule.labels == (SILENCE, "a", SILENCE, "b")
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.2, 0.4, 0.5])


def test_rounding_between_neighbours_is_closed():
    rows = [("a", 0.0003, 0.2), ("b", 0.2004, 0.3), ("", 0.3, 0.3001), ("c", 0.2996, 0.6)]
    schedule = read(long_form([("phones", rows)]))
    assert schedule.labels == ("a", "b", "c")
    np.testing.assert_allclose(schedule.times, [0, 0.2, 0.3, 0.6])


def test_silences_side_by_side_become_one():
    rows = [("", 0.1, 0.2), ("a", 0.2, 0.3), ("", 0.4, 0.6)]
    assert read(long_form([("phones", rows)])).labels == (SILENCE, "a", SILENCE)


@pytest.mark.parametrize("form", [long_form, short_form])
def test_times_with_exponents_and_negative_zero_are_read(form):
    schedule = read(form([("phones", [("a", "-0", "5e-02"), ("b", "5.0E-2", "0.6")])]))
    np.testing.assert_allclose(schedule.times, [0, 0.05, 0.6])


@pytest.mark.parametrize("form", [long_form, short_form])
@pytest.mark.parametrize(
    ("tiers", "message"),
    [
        ([("phones", [("a", 0, 0.3), ("b", 0.2, 0.6)])], "phoneme 1 .* overlap"),
        ([("phones", [("a", 0, 0.3), ("b", 0.3, 0.3)])], "phoneme 1 .* has no length"),
        ([("phones", [("a", "-0.5", 0.3)])], "time below 0"),
        ([("phones", [("a", "zero", 0.3)])], "not a sound TextGrid|damaged"),
        ([("phones", [("a", 0, 4e6)])], "milliseconds"),
        ([("phones", [])], "no phonemes"),
        ([("phones", PHONES), ("phones", PHONES)], "2 tiers look like phones"),
        ([("words", WORDS)], "no tier looks like phones; there is 'words'"),
        ([], "no tier looks like phones; there is no interval tier|not a sound TextGrid"),
    ],
)
def test_what_cannot_be_performed_is_refused_with_the_files_name(form, tiers, message):
    with pytest.raises(ScheduleError, match=rf"^line\.TextGrid: .*({message})"):
        read(form(tiers))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "not a sound TextGrid"),
        (b"ooBinaryFile\x08TextGrid\x00\x01", "binary form"),
        (long_form([("phones", [("\xe9", 0, 0.6)])]).encode("latin-1"), "not UTF-8"),
        (b"hello", "not a sound TextGrid"),
        (b"[" * 100_000, "not a sound TextGrid"),
        (b'{"start": 0, "end": 1, "tiers": []}', "not a sound TextGrid"),
        (long_form(TIERS).encode("utf-16")[:-1], "not UTF-8 or UTF-16"),
    ],
)
def test_what_is_no_text_grid_is_refused(content, message):
    with pytest.raises(ScheduleError, match=message):
        read_textgrid(Source(PATH, content))


def test_a_file_with_fewer_intervals_than_it_says_is_refused():
    text = long_form(TIERS).replace("intervals: size = 4", "intervals: size = 5")
    with pytest.raises(ScheduleError, match="'phones' says it has 5 intervals, but 4"):
        read(text)


@pytest.mark.parametrize("form", [long_form, short_form])
def test_a_file_cut_off_anywhere_is_refused_or_loses_nothing(form):
    whole = form(TIERS)
    for length in range(len(whole)):
        try:
            schedule = read(whole[:length])
        except ScheduleError:
            continue
        assert schedule.labels == (SILENCE, "HH", "AY1", SILENCE)


@given(st.binary(max_size=200))
@example(b"\0")
@example(b"\xff\xfe")
def test_any_bytes_are_refused_in_words(content):
    with pytest.raises(ScheduleError):
        read_textgrid(Source(PATH, content))


@settings(suppress_health_check=[HealthCheck.too_slow])
@given(
    st.sampled_from([long_form(TIERS), short_form(TIERS)]),
    st.integers(0, 900),
    st.integers(0, 40),
    st.text(st.sampled_from(' "\n=[]-.019eE:a{}'), max_size=6),
)
def test_a_damaged_file_is_read_or_refused_in_words(text, at, length, instead):
    try:
        schedule = read(text[:at] + instead + text[at + length :])
    except ScheduleError as error:
        assert str(error).startswith("line.TextGrid: ")  # noqa: PT017 both ends are right
    else:
        assert isinstance(schedule, Schedule)
        assert schedule.start == 0


def test_a_file_is_known_by_its_suffix_in_any_case(tmp_path):
    path = tmp_path / "line.textgrid"
    path.write_text(long_form(TIERS), "utf-8")
    assert read_schedule(path, notation="arpabet").notation == "arpabet"


NO_CHOICE = ("no tier looks like phones", "tiers look like phones")


def test_files_by_many_tools_are_read_or_refused_in_words(data):
    found = sorted((data / "alignments").rglob("*.TextGrid"))
    assert found, "a sweep over nothing passes"
    read = 0
    for path in found:
        try:
            schedule = read_schedule(path)
        except ScheduleError as error:
            assert str(error).startswith(f"{path}: ")  # noqa: PT017 both ends are right
            assert any(w in str(error) for w in NO_CHOICE), path  # noqa: PT017 as above
        else:
            assert schedule.start == 0, path
            read += 1
    assert read >= len(found) / 2
