"""Timings in tables."""

from pathlib import Path

import numpy as np
import pytest

from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.schedules import SILENCE
from lipsync_lang.schedules.timing_file import TimingFile
from lipsync_lang.schedules.timing_readers import find_reader

ROWS = [("HH", 0, 0.1), ("AY", 0.1, 0.3), ("M", 0.3, 0.4)]


def read(text, name="line.csv", **asked):
    """Read a text by its content and its name."""
    source = TimingFile(Path(name), text.encode(), **asked)
    return find_reader(source).read(source)


def refusal(text, name="line.csv", **asked):
    with pytest.raises(ScheduleError) as caught:
        read(text, name, **asked)
    return str(caught.value)


def rows(schedule):
    times = [round(float(time), 6) for time in schedule.times]
    return list(zip(schedule.labels, times, times[1:], strict=False))


def words(schedule):
    return [(word.text, word.first, word.stop) for word in schedule.words]


# Tables


@pytest.mark.parametrize("delimiter", ["\t", ",", ";", "|"])
@pytest.mark.parametrize(
    "head",
    [
        ("label", "start", "end"),
        ("Phoneme", "Begin", "Stop"),
        (" PHONE ", "xmin", "xmax"),
        None,
    ],
)
@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
def test_a_table_is_read_whatever_parts_its_cells(delimiter, head, newline):
    lines = ([head] if head else []) + [tuple(map(str, row)) for row in ROWS]
    text = newline.join(delimiter.join(line) for line in lines)
    schedule = read(text)
    assert rows(schedule) == ROWS
    assert schedule.lines == ((2, 3, 4) if head else (1, 2, 3))


@pytest.mark.parametrize(
    "text",
    [
        "start,end,label\n0,0.1,HH\n0.1,0.3,AY\n0.3,0.4,M\n",
        "start,label,duration\n0,HH,0.1\n0.1,AY,0.2\n0.3,M,0.1\n",
        "id,end,phone,label,start\n1,0.4,M,x,0.3\n2,0.1,HH,x,0\n3,.3,AY,x,1e-1\n",
        "0,0.1,HH\n0.1,0.3,AY\n0.3,0.4,M\n",
        "start;end;label\n0,0;0,1;HH\n0,1;0,3;AY\n\n;;\n0,3;0,4;M\n",
        '"label","start","end"\n"HH","0","0.1"\n"AY","0.1","0.3"\n"M","0.3","0.4"\n',
        "\ufefflabel,start,end\nHH,0,0.1\nAY,0.1,0.3\nM,0.3,0.4",
    ],
)
def test_columns_are_known_by_their_names_or_their_numbers(text):
    assert rows(read(text)) == ROWS


def test_gaps_and_blank_labels_are_silence():
    schedule = read("label,start,end\nHH,0.1,0.2\n,0.2,0.3\nAY,0.4,0.5\n")
    assert schedule.labels == (SILENCE, "HH", SILENCE, "AY")
    assert schedule.lines == (2, 2, 4, 4)


def test_words_are_rows_that_follow_each_other_with_the_same():
    schedule = read("word,phone,start,end\nhi,HH,0,.1\nhi,AY,.1,.3\n,sil,.3,.4\nI'm,AY,.4,.5\n")
    assert words(schedule) == [("hi", 0, 2), ("I'm", 3, 4)]


MFA = """Begin,End,Label,Type,Speaker
0.0,0.3,hi,words,Ann
0.0,0.2,oh,words,Bob
0.0,0.1,HH,phones,Ann
0.1,0.3,AY,phones,Ann
0.0,0.2,OW,phones,Bob
"""


def test_a_speaker_is_read_when_asked_for():
    assert words(read(MFA, tier="Ann")) == [("hi", 0, 2)]
    assert rows(read(MFA, tier="Bob - phones")) == [("OW", 0, 0.2)]
    told = refusal(MFA)
    assert told.startswith(
        "line.csv: 2 tiers look like phones: 'Ann - phones', 'Bob - phones'; choose"
    )
    assert told.endswith('(`tier="Ann - phones"`)')
    assert "no tier is named 'Anne'; known: Ann - phones, Ann - words" in refusal(MFA, tier="Anne")


def test_a_speaker_without_a_type_has_phones():
    text = "speaker,phone,start,end\nAnn,HH,0,0.1\nBob,OW,0,0.2\n"
    assert rows(read(text, tier="Bob")) == [("OW", 0, 0.2)]


def test_a_row_may_begin_with_its_tier():
    text = '"PhonAlign",0.0,0.1,"HH"\n"PhonAlign",0.1,0.3,"AY"\n"TokensAlign",0.0,0.3,"hi"\n'
    assert words(read(text)) == [("hi", 0, 2)]


@pytest.mark.parametrize(
    ("unit", "told"),
    [(1000, "milliseconds"), (100, "frames at 100 a second"), (30, "frames at 30 a second")],
)
def test_other_units_are_guessed_with_a_remark_or_named(unit, told):
    lines = [f"{label},{start * unit:g},{end * unit:g}" for label, start, end in ROWS]
    text = "\n".join(["label,start,end", *lines])
    guessed, named = read(text), read(text, rate=unit)
    assert (
        f"read as {told}; if they are not, state how many make a second (`rate={unit}`)"
        in (guessed.remarks[0])
    )
    np.testing.assert_allclose(guessed.times, [0, 0.1, 0.3, 0.4])
    np.testing.assert_allclose(named.times, [0, 0.1, 0.3, 0.4])
    assert named.remarks == ()


def test_seconds_are_taken_as_they_are():
    assert read("label,start,end\nAA,0,0.9\n").remarks == ()


def test_times_with_fractions_are_no_frames():
    held = read("AA1,0.4,4.9\n")
    assert held.times.tolist() == [0, 0.4, 4.9]
    assert held.remarks == ()
    fine = read("label,start,end\nHH,0.5,102.25\nAY,102.25,190\n")
    assert "read as milliseconds" in fine.remarks[0]
    assert fine.end == 0.19


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "label,start,end\nHH,0,0.2\nAY,0.1,0.3\n",
            ":3: 'AY', 0.1 to 0.3 s, starts before 'HH' end",
        ),
        ("label,start,end\nHH,0,0.2\nAY,0.2\n", ":3: has 2 cells, too few for the columns"),
        ("label,start,end\nHH,0,0.2\nAY,0.2,x\n", ":3: 'x' is not a time"),
        ("label,start,end\nHH,0,\n", ":2: '' is not a time"),
        ("label,start,end\nHH,0,nan\n", ":2: nan is not a time"),
        ("label,start,end\nHH,-0.1,0.1\n", ":2: 'HH', -0.1 to 0.1 s, starts below 0"),
        ("label,start,end\nHH,1,0.5\n", ":2: 'HH', 1 to 0.5 s, ends before it starts"),
        ("label,start,duration\nHH,1,-0.5\n", ":2: 'HH', 1 to 0.5 s, ends before it starts"),
        ("label,start,end\nHH,1,1\n", ":2: 'HH', 1 to 1 s, has no length"),
        (
            'label,start,end\nHH,0,1\n"AY,1,2\nB,2,3\n',
            ':3: unexpected end of data; check for a " that is open',
        ),
        ('label\tstart\tend\n"a"b\t0\t1\n', ":2: "),
        ("label,start,end\n", ": has no phonemes"),
        (f"label,start,end\nHH,0,1,{'x' * 200_000}\n", ":2: field larger than"),
    ],
)
def test_what_is_wrong_with_a_table_is_told_with_its_line(text, told):
    assert refusal(text).startswith(f"line.csv{told}")


@pytest.mark.parametrize(
    "text", ["a,b,c\n", "1,2,3\n", "HH,AY,M\n", "phone,start\nHH,0\n", "hello"]
)
def test_what_names_no_columns_is_told_how_to(text):
    assert refusal(text) == ("line.csv:1: the first row must name the columns: label,start,end")
