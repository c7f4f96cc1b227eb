"""Timings in label tracks, CTM and JSON of tiers."""

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_tables_of_timings import ROWS, read, refusal, rows, words
from test_timed_words import spans

from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.schedules import SILENCE, Schedule, read_schedule
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import find_reader, timings_of

# Label tracks

TRACK = "0.000000\t0.100000\tHH\n\\\t100.000000\t4000.000000\n0.100000\t0.300000\tAY\n"


def test_a_label_track_is_read_without_its_frequencies():
    schedule = read(TRACK, "labels.txt")
    assert rows(schedule) == ROWS[:2]
    assert schedule.lines == (1, 3)


def test_decimals_of_a_label_may_have_a_comma():
    assert rows(read(TRACK.replace(".", ","), "labels.txt")) == ROWS[:2]


def test_a_label_without_text_is_silence():
    assert read("0.0\t0.1\n0.1\t0.2\t\n0.2\t0.3\tAY", "labels.txt").labels == (SILENCE, "AY")


@given(
    st.lists(st.sampled_from(["M", "AA", "", "a, b", "\u2028", "s\tp"]), min_size=1), st.booleans()
)
def test_a_track_of_labels_alone_reads_as_one_with_frequencies(labels, comma):
    lines = [f"{at / 10}\t{(at + 1) / 10}\t{label}\n" for at, label in enumerate(labels)]
    text = "".join(lines).replace(".", "," if comma else ".")
    at_once = read(text, "labels.txt")
    line_by_line = read(f"{text}\\\t100.0\t4000.0\n", "labels.txt")
    assert (at_once.labels, at_once.lines) == (line_by_line.labels, line_by_line.lines)
    assert at_once.times.tolist() == line_by_line.times.tolist()


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("0.200000\t0.400000\tB", ":4: 'B', 0.2 to 0.4 s, starts before 'AY' ends"),
        ("0.3 0.4 B", ":4: '0.3 0.4 B' is not a label; write START, END and TEXT"),
    ],
)
def test_what_is_wrong_with_a_label_is_told_with_its_line(line, told):
    assert refusal(TRACK + line, "labels.txt").startswith(f"labels.txt{told}")


# CTM


def test_a_ctm_is_read_without_what_is_added_to_its_labels():
    text = (
        ";; phones\nline 1 0.00 0.10 HH_B 0.98\nline 1 0.10 0.20 AY_E\n\nline 1 0.30 0.10 M_S 1 x\n"
    )
    schedule = read(text, "line.ctm")
    assert rows(schedule) == ROWS
    assert schedule.lines == (2, 3, 5)


@pytest.mark.parametrize(
    ("others", "names"),
    [
        ("b 1 0 0.2 OW\n", ["a", "b"]),
        ("a 2 0 0.2 OW\n", ["1", "2"]),
        ("a 2 0 0.2 OW\nb 1 0 0.1 M\n", ["a 1", "a 2", "b 1"]),
    ],
)
def test_files_and_channels_of_a_ctm_are_read_when_asked_for(others, names):
    text = f"a 1 0 0.1 HH\n{others}"
    shown = ", ".join(f"'{name}'" for name in names)
    told = f'{len(names)} files or channels: {shown}; choose one (`tier="{names[0]}"`)'
    assert refusal(text, "line.ctm") == f"line.ctm: {told}"
    assert [read(text, "line.ctm", tier=name).labels[0] for name in names[:2]] == ["HH", "OW"]


def test_what_is_wrong_with_a_ctm_is_told_with_its_line():
    text = "a 1 0 0.1 HH\n"
    assert refusal(text + "a 1 0.1", "line.ctm") == (
        "line.ctm:2: 'a 1 0.1' is not a sound; write FILE CHANNEL START DURATION LABEL"
    )
    assert refusal(text + "a 1 0.1 1.2.3 M", "line.ctm").startswith(
        "line.ctm:2: '1.2.3' is not a t"
    )
    assert refusal(text + "a 1 0.02 0.1 M", "line.ctm").startswith("line.ctm:2: 'M', 0.02 to 0.12")


# JSON of tiers


def tiers(**named):
    return {"start": 0, "end": 1, "tiers": named}


def tier(*entries, kind="interval"):
    return {"type": kind, "entries": entries}


def test_tiers_of_json_are_chosen_like_those_of_a_textgrid():
    both = {
        "Ann - words": tier([0, 0.3, "hi"]),
        "Ann - phones": tier([0, 0.1, "HH"], [0.1, 0.3, "AY"]),
        "Bob - phones": tier([0, 0.2, "OW"]),
        "clicks": tier([0.1, "click"], kind="PointTier"),
    }
    text = json.dumps(tiers(**both))
    assert words(read(text, "line.json", tier="Ann")) == [("hi", 0, 2)]
    assert 'choose one (`tier="Ann - phones"`)' in refusal(text, "line.json")


@pytest.mark.parametrize("form", ["json", "textgrid_json"])
def test_what_praatio_saves_as_json_is_read(form, tmp_path):
    textgrid = pytest.importorskip("praatio.textgrid", reason="needs praatio, which writes them")
    grid = textgrid.Textgrid()
    rows_ = [(start, end, label) for label, start, end in ROWS]
    grid.addTier(textgrid.IntervalTier("phones", rows_, 0, 0.4))
    grid.addTier(textgrid.IntervalTier("words", [(0, 0.4, "hime")], 0, 0.4))
    grid.addTier(textgrid.PointTier("clicks", [(0.2, "click")], 0, 0.4))
    for name in ("line.json", "line.TextGrid"):
        grid.save(tmp_path / name, form, includeBlankSpaces=True)
        schedule = read_schedule(tmp_path / name)
        assert rows(schedule) == ROWS
        assert words(schedule) == [("hime", 0, 3)]


@pytest.mark.parametrize(
    ("document", "told"),
    [
        ({"tiers": 5}, "has no tiers; the form is "),
        ({"tiers": [5]}, "has no tiers; the form is "),
        ({"tiers": {"phones": 5}}, "tier 'phones' has no entries; the form is "),
        ({"tiers": {"phones": {}}}, "tier 'phones' has no entries; the form is "),
        ({"tiers": []}, "has no phonemes; check that the file is complete"),
        (tiers(phones=tier()), "has no phonemes"),
        (tiers(phones=tier([0, 1])), "tier 'phones': an entry is [start, end, label], not [0, 1]"),
        (tiers(phones=tier([0, 1, 2])), "tier 'phones': an entry is [start, end, label], not [0"),
        (tiers(phones=tier([0, "1s", "a"])), "'1s' is not a time"),
        (tiers(phones=tier([0, float("nan"), "a"])), "nan is not a time"),
        (tiers(phones=tier([0, 1, "a"], [0.5, 1, "b"])), "'b', 0.5 to 1 s, starts before 'a' ends"),
    ],
)
def test_what_is_wrong_with_json_of_tiers_is_told(document, told):
    assert refusal(json.dumps(document), "line.json").startswith(f"line.json: {told}")


# All of them


@given(st.sampled_from(["table", "audacity", "ctm", "mfa-json"]), st.text(max_size=200))
def test_any_text_is_read_or_refused_in_words(name, text):
    source = TimingFile(Path("line.x"), text.encode("utf-8", "replace"))
    try:
        assert isinstance(find_reader(source, name).read(source), Schedule)
    except ScheduleError as error:
        assert str(error).startswith("line.x:")  # noqa: PT017 both ends are right


def test_labels_too_long_for_phones_are_timed_words():
    track = "0.1\t0.3\tmy\n0.3\t0.8\tmaps\n0.8\t0.9\t[noise]\n0.9\t1.2\tare here\n"
    found = timings_of(TimingFile(Path("labels.txt"), track.encode()))
    assert [word.text for word in found.words] == ["my", "maps", "are here"]
    ctm = "line 1 0.10 0.20 hello 0.98\nline 1 0.29 0.31 there\nline 1 0.7 0.1 <eps> 1.0\n"
    found = timings_of(TimingFile(Path("line.ctm"), ctm.encode()))
    assert spans(found) == [("hello", 0.1, 0.295), ("there", 0.295, 0.6)]
    assert [word.confidence for word in found.words] == [0.98, None]
    words = timings_of(TimingFile(Path("line.WRD"), b"1600 4800 hi\n4800 8000 you\n"))
    assert spans(words) == [("hi", 0.1, 0.3), ("you", 0.3, 0.5)]
