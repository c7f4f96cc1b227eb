"""Timings as real tools write them: rounded, in quotes, with noise and notes between the labels."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.performing.label_reader import label_remarks
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.schedules import SILENCE, Schedule
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import find_reader
from lipsync_lang.text.phonology.labels import Notation


def read(text, name, **asked):
    source = TimingFile(Path(name), text.encode(), **asked)
    return find_reader(source).read(source)


def ctm(*rows, name="u"):
    return "".join(f"{name} 1 {start} {length} {label}\n" for start, length, label in rows)


def test_neighbours_that_overlap_or_part_by_10_ms_meet_in_the_middle():
    rounded = ctm(("0.00", "0.10", "SIL"), ("0.09", "0.11", "HH_B"), ("0.21", "0.10", "AY_E"))
    schedule = read(rounded, "a.ctm")
    assert schedule.labels == ("SIL", "HH", "AY")
    np.testing.assert_allclose(schedule.times, [0, 0.095, 0.205, 0.31])
    gap = read(ctm(("0.10", "0.10", "HH"), ("0.22", "0.10", "AY")), "a.ctm")
    assert gap.labels == (SILENCE, "HH", SILENCE, "AY")
    with pytest.raises(ScheduleError, match=r"a\.ctm:2: 'AY', 0.14 to 0.24 s, starts before 'HH'"):
        read(ctm(("0.10", "0.10", "HH"), ("0.14", "0.10", "AY")), "a.ctm")
    short = ctm(("0.10", "0.01", "HH"), ("0.10", "0.01", "AY"))
    np.testing.assert_allclose(read(short, "a.ctm").times, [0, 0.1, 0.105, 0.11])


def test_neighbours_that_overlap_by_more_meet_there_with_a_remark():
    schedule = read(
        ctm(("0.10", "0.10", "HH"), ("0.18", "0.10", "AY"), ("0.27", "0.1", "M")), "a.ctm"
    )
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.19, 0.275, 0.37])
    assert schedule.remarks[0].startswith(
        "a.ctm: neighbours overlap by up to 0.020 s (1 time, such as 'AY', 0.18 to 0.28 s); their"
    )
    timed = read("word,start,end\nmy,0.1,0.30\nmaps,0.28,0.7\n", "a.csv")
    assert timed.words[0].end == timed.words[1].start == pytest.approx(0.29)
    assert "overlap by up to 0.020 s (1 time, such as 'maps', 0.28 to 0.7 s)" in timed.remarks[0]
    with pytest.raises(ScheduleError, match="they overlap"):  # more than one of them lasts
        read(ctm(("0.10", "0.03", "HH"), ("0.10", "0.20", "AY")), "a.ctm")


def test_times_in_quotes_are_times():
    cues = '{"mouthCues": [{"start": "0.00", "end": "0.10", "value": "A"}]}'
    assert read(cues, "a.json").end == 0.1
    with pytest.raises(ScheduleError, match="'1e9' is not a time"):
        read(cues.replace("0.10", "1e9"), "a.json")


def test_of_many_utterances_few_are_named():
    many = "".join(ctm(("0.0", "0.1", "HH"), name=f"speaker-{n:05}") for n in range(2000))
    with pytest.raises(ScheduleError, match="2000 files or channels: 'speaker-00000'") as caught:
        read(many, "a.ctm")
    assert len(str(caught.value)) < 200
    with pytest.raises(ScheduleError, match="no tier is named 'xyz'; there is") as caught:
        read(many, "a.ctm", tier="xyz")
    assert len(str(caught.value)) < 200
    assert len(read(many, "a.ctm", tier="speaker-00003")) == 1


def test_aligned_tiers_come_before_those_of_the_text():
    grid = 'File type = "ooTextFile"\nObject class = "TextGrid"\n0 1 <exists> 4\n'
    for name, label in (
        ("Tokens", "we go"), ("Phones", "w-i g-@U"), ("PhonAlign", "w"), ("TokensAlign", "we"),
    ):  # fmt: skip
        grid += f'"IntervalTier" "{name}" 0 1 1 0 1 "{label}"\n'
    schedule = read(grid, "a.TextGrid")
    assert schedule.labels == ("w",)
    assert [word.text for word in schedule.words] == ["we"]


def test_a_run_of_digits_is_no_tone():
    known = Notation({"f": (("f", 1.0),), "a": (("aa", 1.0),)})
    assert known.find("f000001") is None
    assert known.find("a214") == known.find("a˨ˀ˥"[:1]) == (("aa", 1.0),)


@pytest.fixture(scope="module")
def performer():
    return resolve("english-uk", "facefx")


def test_labels_of_more_tools_are_known(performer):
    def common(*labels, notation=None):
        schedule = Schedule(labels, np.arange(len(labels) + 1) / 10, notation=notation)
        return [[name for name, _ in value] for value in performer.labels.values(schedule)]

    noise = ("br", "NS", "{LG}", "dummy", "@@", "+", "!SIL", "AP", "B_TRANS")
    assert common("m", *noise, "m") == [["bmp"], *[["_"]] * len(noise), ["bmp"]]
    praat = (r"\sh", r"\ae", r"\ng", r"\o/", r"t\sh", r"\as\:f", r"\vt")
    ipa = ("ʃ", "æ", "ŋ", "ø", "tʃ", "ɑː", "ʌ")
    assert common(*praat[:3], *praat[4:]) == common(*ipa[:3], *ipa[4:], notation="ipa")
    assert performer.labels.notations["praat"].text(praat[3]) == ipa[3]
    assert common("@:", "i@", "H", "A", "@u", "db", notation="macquarie") == [
        ["ah"], ["ih", "ax"], ["h"], ["ae"], ["ow"], ["d", "bmp"],
    ]  # fmt: skip
    assert common("@:", "I@", "{I", notation="sampa") == [["ah"], ["ih", "ax"], ["ey"]]


@pytest.fixture(scope="module")
def american():
    return resolve("english", "facefx").labels


@pytest.mark.parametrize(
    ("labels", "told"),
    [
        (("M", "AE1", "P", "S"), None),
        (("m", "æ", "p", "s"), None),
        (("M", "spn", "AE1", "BR", "P"), r"mouth rests for 0\.2 s: 'spn' \(1\), 'BR' \(1\)"),
        (("m", "æ̃ʰ", "p", "s"), r"labels are read as ipa, a notation with 75% of them"),
        (("p", "3:", "s"), None),
        (("M", "AH0", "M"), None),
        (
            ("T", "N"),
            r"read as arpabet, .* 100% .*; they can also be sampa.* \(`notation='sampa'`\)",
        ),
    ],
)
def test_doubts_about_labels_are_told(american, labels, told):
    schedule = Schedule(labels, np.arange(len(labels) + 1) / 10, source="a.csv")
    remarks = "\n".join(label_remarks(american, schedule))
    assert re.search(f"^a\\.csv: .*{told}$", remarks) if told else not remarks
    assert not label_remarks(american, replace(schedule, notation="ipa")) or "spn" in labels


def test_tiers_that_are_passed_over_are_named():
    grid = 'File type = "ooTextFile"\nObject class = "TextGrid"\n0 1 <exists> 3\n'
    for name, label in (("phones", "m"), ("words", "m"), ("pitch", "180")):
        grid += f'"IntervalTier" "{name}" 0 1 1 0 1 "{label}"\n'
    assert read(grid, "a.TextGrid").remarks == ("a.TextGrid: skipped tiers: 'pitch'",)
    assert not read(grid, "a.TextGrid", tier="phones").remarks
