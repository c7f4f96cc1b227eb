"""TextGrids: every text form, unusual files, and never a traceback."""

import struct
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.schedules import SILENCE, Schedule, read_schedule, read_timings
from lipsync_lang.schedules.readers.textgrid import read_textgrid
from lipsync_lang.schedules.timing_file import TimingFile

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
    return read_textgrid(TimingFile(PATH, text.encode(), **rest))


TIERS = [("words", WORDS), ("phones", PHONES)]


@pytest.mark.parametrize("form", [long_form, short_form])
@pytest.mark.parametrize("newline", ["\n", "\r\n", "\r"])
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be"])
def test_every_text_form_reads_alike(form, newline, encoding):
    text = form(TIERS).replace("\n", newline).replace("AY1", "ˈaɪ")
    schedule = read_textgrid(TimingFile(PATH, text.encode(encoding)))
    assert schedule.labels == (SILENCE, "HH", "ˈaɪ", SILENCE)
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.2, 0.45, 0.6])
    assert [(w.text, w.first, w.stop) for w in schedule.words] == [("hi", 1, 3)]


def test_old_short_files_and_files_without_a_last_newline_lose_nothing():
    text = (
        short_form(TIERS).replace("ooTextFile", "ooTextFile short").replace("Object class = ", "")
    )
    assert read(text.rstrip("\n")).labels == (SILENCE, "HH", "AY1", SILENCE)


def test_what_is_there_for_people_is_passed_over():
    text = (
        '! made by hand\nFile type="ooTextFile" Object class="TextGrid" from 0 to 0.5 seconds\n'
        'tiers? <exists> one tier: 1 "IntervalTier" "phones" from 0 to 0.5 (2 of them)\n 2\n'
        '1st: 0 to 0.2 = "a"! not "this"\n2nd: 0.2 0.5 "b""c\nd" ! 3 "intervals"'
    )
    with pytest.raises(ScheduleError, match=r"line.TextGrid:5: the text has an unpaired quote"):
        read(text)
    schedule = read(text.replace('"a"!', '"a" !'))
    assert schedule.labels == ("a", 'b"c\nd')
    assert schedule.lines == (5, 6)


def test_points_and_what_is_absent_are_passed_over():
    text = short_form(TIERS).replace(
        '"IntervalTier"', '"TextTier"\n"clicks"\n0\n0.6\n1\n0.3\n"click"\n"IntervalTier"', 1
    )
    text = text.replace("<exists>\n2", "<exists>\n3")
    assert read(text).labels == (SILENCE, "HH", "AY1", SILENCE)
    with pytest.raises(ScheduleError, match="has no phonemes"):
        read(short_form([]).replace("<exists>\n0", "<absent>"))


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
    message = "2 tiers look like phones: 'Ann - phones', 'Bob - phones'; choose one .`tier=\"Ann "
    "- p"
    with pytest.raises(ScheduleError, match=message):
        read(text)
    assert [w.text for w in read(text, tier="Ann").words] == ["hi"]
    assert [w.text for w in read(text, tier="Bob - phones").words] == ["ho"]
    with pytest.raises(ScheduleError, match="did you mean 'Bob - words'"):
        read(text, tier="Bob - word")


def test_a_speaker_who_says_nothing_is_no_choice():
    text = long_form([("Ann - phones", PHONES), ("Noise - phones", [("", 0, 0.6)])])
    assert len(read(text)) == len(PHONES)


def test_a_tier_is_any_that_is_named():
    text = long_form([("words", WORDS), ("sounds", PHONES), ("phones", [("x", 0, 0.6)])])
    assert read(text).labels == ("x",)
    assert read(text, tier="sounds").labels == (SILENCE, "HH", "AY1", SILENCE)
    assert [w.text for w in read(text, tier="sounds").words] == ["hi"]


def test_a_silent_tier_is_read_with_a_remark():
    schedule = read(long_form([("phones", [("", 0, 0.6)])]))
    assert schedule.labels == (SILENCE,)
    assert schedule.remarks == ("line.TextGrid: tier 'phones' has no labels",)


def test_a_rate_makes_seconds_of_other_units():
    rows = [(label, 1000 * start, 1000 * end) for label, start, end in PHONES]
    schedule = read(long_form([("phones", rows)], end=600), rate=1000)
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.2, 0.45, 0.6])


def test_every_label_has_its_line():
    assert read(long_form(TIERS)).lines == (34, 38, 42, 46)
    assert read(short_form(TIERS)).lines == (27, 30, 33, 36)


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


FAULTS = [
    ([("a", 0, 0.3), ("b", 0.2, 0.6)], "'b', 0.2 to 0.6 s, starts before 'a' ends .* overlap", 1),
    ([("b", 0.3, 0.3)], "'b', 0.3 to 0.3 s, has no length; give it some time", 0),
    ([("a", 0, 0.3), ("b", 0.5, 0.4)], "'b', 0.5 to 0.4 s, ends before it starts; swap", 1),
    ([("a", "-0.5", 0.3)], "'a', -0.5 to 0.3 s, starts below 0; shift all times", 0),
    ([("a", 0, "1e999")], "inf is not a time", 0),
    ([("a", 0, "1.2.3")], "'1.2.3' is not a time", 0),
]


@pytest.mark.parametrize(("rows", "message", "at"), FAULTS)
def test_what_cannot_be_performed_is_refused_with_its_line(rows, message, at):
    for form, first, step in ((long_form, 16, 4), (short_form, 13, 3)):
        line = first + at * step
        with pytest.raises(ScheduleError, match=rf"^line\.TextGrid:{line}: .*({message})"):
            read(form([("phones", rows)]))


def test_words_that_run_backwards_are_refused_with_their_line():
    words = [("hi", 0.3, 0.1)]
    with pytest.raises(ScheduleError, match=r"^line\.TextGrid:16: 'hi', 0.3 to 0.1 s, ends before"):
        read(long_form([("words", words), ("phones", PHONES)]))


@pytest.mark.parametrize("form", [long_form, short_form])
@pytest.mark.parametrize(
    ("tiers", "message"),
    [
        ([("phones", [("a", 0, 4e6)])], "milliseconds"),
        ([("phones", [])], "no phonemes"),
        (
            [("notes", WORDS)],
            "no tier looks like phones; there is 'notes'. Name the tier .`tier=.NAME.`",
        ),
        ([("words", [("", 0, 0.6), ("<sil>", 0.6, 0.7)])], "no word"),
        ([], "has no phonemes; check that the file is complete"),
    ],
)
def test_what_holds_no_phones_is_refused(form, tiers, message):
    with pytest.raises(ScheduleError, match=rf"^line\.TextGrid: .*({message})"):
        read(form(tiers))


def test_tiers_of_one_name_are_told_with_both_lines():
    text = long_form([("phones", PHONES), ("phones", PHONES)])
    message = (
        r"line.TextGrid:33: 2 tiers look like phones, two of them 'phones' \(one in line 11\); r"
    )
    for tier in (None, "phones"):
        with pytest.raises(ScheduleError, match=message):
            read(text, tier=tier)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is not a text TextGrid; in Praat, use 'Save as text"),
        (
            b"ooBinaryFile\x08TextGrid\x00\x01",
            "at byte 21, the file is incomplete; save it again in Praat",
        ),
        (
            b"ooBinaryFile\x07Formant",
            "the file has no TextGrid; in Praat, select a TextGrid and save it",
        ),
        (b'"Praat chronological TextGrid text file"\n0 1', "is not a text TextGrid"),
        (b'File type = "ooTextFile"\nObject class = "PitchTier"\n', ":2: the file has no TextGrid"),
        (b"hello", "is not a text TextGrid"),
        (b"[" * 100_000, "is not a text TextGrid"),
        (long_form([("phones", [("\xe9", 0, 0.6)])]).encode("latin-1"), "18: is not UTF-8.*`enc"),
        (long_form(TIERS).encode("utf-16")[:-1], "not UTF-8 or UTF-16"),
    ],
)
def test_what_is_no_text_grid_is_refused(content, message):
    with pytest.raises(ScheduleError, match=rf"^line\.TextGrid.*{message}"):
        read_textgrid(TimingFile(PATH, content))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "intervals: size = 4",
            "intervals: size = 5",
            "48: interval 5 of 5 of",
        ),
        ("intervals: size = 4", "intervals: size = 3", "46: there is more text than the file st"),
        (
            "intervals: size = 3",
            "intervals: size = 4",
            "28: expected interval 4 of 4 of tier",
        ),
        ("intervals: size = 4", "intervals: size = 4.5", "32: expected the number of intervals"),
        (
            "size = 2",
            "size = 3",
            "48: the class of tier 3 is missing at the end; check that",
        ),
        ("size = 2", "size = 1", "28: there is more text than the file"),
        ('"IntervalTier"', '"Interval"', "10: a tier is one of IntervalTier and TextTier"),
        (
            "xmin = 0.1\n",
            "xmin = zero\n",
            "expected interval 2 of 3 of tier 'words' here, not 'hi'",
        ),
        ('text = "hi"', 'text = "say "hi" now"', ":22: the text has an unpaired quote"),
    ],
)
def test_a_damaged_file_is_told_with_the_line(old, new, message):
    text = long_form(TIERS)
    assert old in text
    with pytest.raises(ScheduleError, match=rf"^line\.TextGrid.*{message}"):
        read(text.replace(old, new, 1))


def test_an_encoding_can_be_named():
    content = long_form([("phones", [("\xe9", 0, 0.6)])]).encode("latin-1")
    assert read_textgrid(TimingFile(PATH, content, encoding="latin-1")).labels == ("\xe9",)
    for none in ("klingon", "base64", "undefined", "latin\0", ""):
        with pytest.raises(ScheduleError, match=r"^line\.TextGrid:.*(no encod|is not|no TextGrid)"):
            read_textgrid(TimingFile(PATH, content, encoding=none))


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
        read_textgrid(TimingFile(PATH, content))


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
        assert str(error).startswith("line.TextGrid:")  # noqa: PT017 both ends are right
    else:
        assert isinstance(schedule, Schedule)
        assert schedule.start == 0


@pytest.mark.parametrize(
    ("labels", "said", "told"),
    [
        (("maps\nNNS", "fall\nVBP"), ["maps", "fall"], "such as NNS, are not spoken"),
        (("STOP\nNOW", "GO\nAWAY"), ["STOP NOW", "GO AWAY"], ""),
        (("maps\nof it", "fall\nVBP"), ["maps of it", "fall VBP"], ""),
    ],
)
def test_a_second_line_of_a_label_may_be_a_part_of_speech(tmp_path, labels, said, told):
    rows = "".join(f'{at / 2} {(at + 1) / 2} "{label}" ' for at, label in enumerate(labels))
    head = 'File type = "ooTextFile"\nObject class = "TextGrid"\n0 1 <exists> 1\n'
    path = tmp_path / "line.TextGrid"
    path.write_text(f'{head}"IntervalTier" "words" 0 1 {len(labels)} {rows}')
    timed = read_timings(path)
    assert [word.text for word in timed.words] == said
    assert any("parts of speech" in one for one in timed.remarks) == bool(told)
    assert told in "".join(timed.remarks)


def test_a_file_is_known_by_its_suffix_in_any_case(tmp_path):
    path = tmp_path / "line.textgrid"
    path.write_text(long_form(TIERS), "utf-8")
    assert read_schedule(path, notation="arpabet").notation == "arpabet"


OTHER = "no tier looks like phones; there is "
TWO = "2 tiers look like phones: "
WORDS_ALONE = {
    "mfa_tests/61-70968-0000",
    "mfa_tests/short_segments",
    "mfa_tests/vietnamese",
    *(f"mfa_tests/multilingual_ipa{one}" for one in ("", "_2", "_3", "_4", "_5")),
    *(f"mfa_tests/multilingual_ipa_us{one}" for one in ("", "_2", "_3", "_4", "_5")),
    "mfa_tests/words_tier_only",
    "polyglotdb/textgrids/pronunc_variants_corpus",
    "polyglotdb/textgrids/tobi",
    "praatio/bobby_words",
}
"""Files with a tier of words or utterances, and no phones."""

REFUSED = {
    "mfa_tests/michaelandsickmichael": OTHER,
    "mfa_tests/michaelandsickmichael_short_tg": OTHER,
    "polyglotdb/textgrids/2speakers": TWO,
    "polyglotdb/textgrids/fave/fave_stereo": TWO,
    "polyglotdb/textgrids/fave/fave_test": TWO,
    "polyglotdb/textgrids/fave/fave_test2": TWO,
    "polyglotdb/textgrids/mfa/invalid/mfa_test_phones_speaker1_speaker2_no": TWO,
    "polyglotdb/textgrids/mfa/valid/mfa_test_phones_speaker1_speaker2_yes": TWO,
    "polyglotdb/textgrids/overlapped_speech/overlapped": TWO,
    "praatio/all_tiers_have_the_same_name": OTHER,
    "praatio/bobby_words_with_newlines": OTHER,
    "praatio/bobby_words_with_newlines_longfile": OTHER,
    "praatio/bobby_words_with_newlines_longfile_elan": OTHER,
    "praatio/damon_set_test_output": OTHER,
    "praatio/empty_textgrid": OTHER,
    "praatio/textgrid_to_merge": OTHER,
    "praatio/textgrid_to_merge_longfile": OTHER,
}
"""Files of many tools without phones, or with several speakers; all others are read."""


def test_files_by_many_tools_are_read_or_refused_with_the_reason(data):
    folder = data / "alignments"
    found = {
        path.relative_to(folder).with_suffix("").as_posix(): path
        for path in folder.rglob("*.TextGrid")
    }
    assert found.keys() > REFUSED.keys() | WORDS_ALONE
    for name, path in found.items():
        if name in REFUSED:
            with pytest.raises(ScheduleError) as caught:
                read_schedule(path)
            assert str(caught.value).startswith(f"{path}: {REFUSED[name]}"), name
        elif name in WORDS_ALONE:
            assert read_timings(path).words, name
        else:
            schedule = read_schedule(path)
            assert schedule.start == 0, name
            assert len(schedule.lines) == len(schedule), name


def test_each_of_several_speakers_is_read_when_asked_for(data):
    folder = data / "alignments"
    for name, reason in REFUSED.items():
        path = folder / f"{name}.TextGrid"
        if reason == TWO:
            with pytest.raises(ScheduleError) as caught:
                read_schedule(path)
            names = str(caught.value).partition(TWO)[2].partition("; choose one")[0]
            for tier in names.removeprefix("'").removesuffix("'").split("', '"):
                assert read_schedule(path, tier=tier).start == 0, (name, tier)


def test_praatio_finds_the_same_in_files_by_many_tools(data):
    textgrid = pytest.importorskip("praatio.textgrid", reason="needs praatio, a second reader")
    compared = 0
    for path in (data / "alignments").rglob("*.TextGrid"):
        name = path.relative_to(data / "alignments").with_suffix("").as_posix()
        if name in {*REFUSED, *WORDS_ALONE}:
            continue
        other = textgrid.openTextgrid(path, includeEmptyIntervals=True, duplicateNamesMode="rename")
        theirs = [list(other.getTier(one).entries) for one in other.tierNames]
        heard = [row for row in _rows(read_schedule(path)) if row[2] != SILENCE]
        assert heard in [_heard(rows) for rows in theirs], name
        compared += 1
    assert compared > len(REFUSED)


def _rows(schedule):
    times = [round(float(t), 3) for t in schedule.times]
    return list(zip(times, times[1:], schedule.labels, strict=False))


def _heard(rows):
    return [(round(r[0], 3), round(r[1], 3), r[2]) for r in rows if len(r) == 3 and r[2].strip()]


# Binary files


def packed(text):
    """Return a text in Praat's binary form."""
    if text.isascii():
        return struct.pack(">h", len(text)) + text.encode()
    wide = text.encode("utf-16-be")
    return struct.pack(">hH", -1, len(wide) // 2) + wide


def binary(tiers, end=0.6):
    out = b"ooBinaryFile\x08TextGrid" + struct.pack(">ddBi", 0, end, 1, len(tiers) + 1)
    out += b"\x08TextTier" + packed("points") + struct.pack(">ddi", 0, end, 1)
    out += struct.pack(">d", 0.1) + packed("H*")
    for name, rows in tiers.items():
        out += b"\x0cIntervalTier" + packed(name) + struct.pack(">ddi", 0, end, len(rows))
        for start, stop, label in rows:
            out += struct.pack(">dd", start, stop) + packed(label)
    return out


def test_binary_files_read_like_text():
    tiers = {"phones": [(0, 0.2, "ʃ"), (0.2, 0.6, "iː")], "words": [(0, 0.6, "she")]}
    schedule = read_textgrid(TimingFile(PATH, binary(tiers)))
    assert schedule.labels == ("ʃ", "iː")
    np.testing.assert_allclose(schedule.times, (0, 0.2, 0.6))
    assert [word.text for word in schedule.words] == ["she"]


def test_binary_files_that_are_cut_off_or_damaged_are_refused():
    whole = binary({"phones": [(0, 0.2, "ʃ"), (0.2, 0.6, "i")]})
    for length in range(12, len(whole)):
        with pytest.raises(ScheduleError, match=r"line.TextGrid: at byte \d+, (the file|a t)"):
            read_textgrid(TimingFile(PATH, whole[:length]))
    for at in range(12, len(whole)):
        damaged = whole[:at] + b"\xff" + whole[at + 1 :]
        try:
            read_textgrid(TimingFile(PATH, damaged))
        except ScheduleError as error:
            assert str(error).startswith("line.TextGrid:")  # noqa: PT017 both ends are right
