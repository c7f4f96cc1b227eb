"""Schedulers of phonemes that need their own reading: CSLU, FaceFX, CereProc and SAPI."""

import json

import pytest
from numpy.testing import assert_allclose

import lipsync_lang as ll
from lipsync_lang.base.errors import ScheduleError

CSLU = """\
MillisecondsPerFrame: 1.000000
END OF HEADER
2 113 .pau
113 191 w
191 267 ^
267 395 n
"""
"""The example of the formats of the Portland Cellular Corpus: "one"."""

DIMEX = """\
MillisecondsPerFrame: 1.0
END OF HEADER
0.000000 56.149734 .sil
56.149734 117.647057 k
117.647057 180.5 r(
"""
"""The form of DIMEx100, a corpus of Mexican Spanish."""

FACEFX = """\
%phonlist -clear
%phonlist -append -phoneme "H" -startTime 0 -endTime .5
%phonlist -append -phoneme "A" -startTime .5 -endTime 2
%phonlist -group -startIndex 0 -endIndex 1 -wordText "Ha";
"""
"""The example of FaceFX's page of the command."""

CEREPROC = """\
INFO: wav_mk 0, wav_done 11025
INFO: phoneme: 0.000 0.050 sil
INFO: word: 0.050 0.250 a
INFO: phoneme: 0.050 0.250 @
INFO: marker: 0.250 0.250 cptk_0_0_1_1
INFO: word: 0.000 0.300 map
INFO: phoneme: 0.000 0.100 m
INFO: phoneme: 0.100 0.200 ae
INFO: phoneme: 0.200 0.300 p
INFO: marker: 0.300 0.300 cprc_final
"""
"""Two parts of a speech, as the example `basictts` prints their events."""

HELLO = ((26, 80), (21, 80), (1, 0), (31, 80), (35, 180), (8, 0))
""""hello" in the numbers of SAPI's table, `h eh - l ow 1`, with durations in milliseconds."""


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "facefx")


def heard(performer, line):
    numbers, _, _ = performer.common_phonemes(line)
    return [performer.compiled.phonemes[n] for n in numbers]


def numbered(pairs, **more):
    fields = ("StreamNumber", "StreamPosition", "NextPhoneId", "Feature")
    return [
        {**dict.fromkeys(fields, 0), "CurrentPhoneId": number, "Duration": length, **more}
        for number, length in pairs
    ]


def test_frames_of_cslu_last_as_its_header_says(read, performer):
    found = read("one.phn", CSLU)
    assert_allclose(found.times[-4:], [0.113, 0.191, 0.267, 0.395])
    assert [one for one in heard(performer, found) if one != "_"] == ["w", "ah", "n"]
    assert read("one.phn", CSLU.replace("1.000000", "10")).end == 3.95
    assert read("one.phn", CSLU, rate=100).end == 3.95


def test_frames_of_cslu_may_have_fractions(read):
    found = read("s00101.phn", DIMEX)
    assert found.labels == (".sil", "k", "r(")
    assert_allclose(found.times, [0, 0.056149734, 0.117647057, 0.1805])


def test_a_stop_of_worldbet_is_its_closure_and_its_breath(read, performer):
    text = CSLU + "395 420 tc\n420 450 th\n450 600 9r\n600 700 &r\n"
    assert heard(performer, read("a.phn", text))[-4:] == ["d", "d", "r", "axr"]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("END OF HEADER\n", "", r"one.phn: has no line 'END OF HEADER'"),
        ("1.000000", "0", r"one.phn:1: a frame lasts 0 ms; give a number above 0"),
        ("1.000000", "x", r"one.phn:1: 'x' is not a time"),
        ("113 191 w", "113 w", r"one.phn:4: '113 w' is not two frames and a label"),
    ],
)
def test_a_mistake_of_cslu_has_its_line(read, old, new, said):
    with pytest.raises(ScheduleError, match=said):
        read("one.phn", CSLU.replace(old, new))


def test_facefx_lists_phonemes_by_its_command(read):
    found = read("ha.fxl", FACEFX)
    assert found.labels == ("H", "A")
    assert found.times.tolist() == [0, 0.5, 2]
    assert [(word.text, word.first, word.stop) for word in found.words] == [("Ha", 0, 2)]
    short = FACEFX.replace("-append -phoneme", "-a -ph").replace("-startTime", "-ST")
    assert read("ha.txt", short).labels == found.labels


def test_facefx_begins_anew_where_it_clears(read):
    found = read("ha.fxl", FACEFX + FACEFX.replace('"A"', '"E"') + "select -all\n")
    assert found.labels == ("H", "E")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("-endTime 2", "", "ha.fxl:3: None is not a time"),
        ("-endIndex 1", "-endIndex 2", "ha.fxl:4: '2' is not the number of a phoneme"),
        ('"A"', '"A', "ha.fxl:3: a quotation mark is not closed"),
        ("-startIndex 0 -endIndex 1", "-startIndex 1 -endIndex 0", "ha.fxl:4: a group from 1 to 0"),
        ("%phonlist -append", "select", "ha.fxl:4: '0' is not .* phoneme; there is none above"),
    ],
)
def test_a_mistake_of_facefx_has_its_line(read, old, new, said):
    with pytest.raises(ScheduleError, match=said):
        read("ha.fxl", FACEFX.replace(old, new))


def test_the_flap_and_the_short_silence_of_facefx_have_mouths(read, performer):
    table = "phoneme,start,end\nAH,0,.1\nFLAP,.1,.15\nER,.15,.3\nSHORTSIL,.3,.35\nM,.35,.5\n"
    assert heard(performer, read("line.csv", table)) == ["ax", "d", "er", "_", "bmp"]


def test_the_parts_of_cereproc_follow_each_other(read, performer):
    found = read("events.txt", CEREPROC)
    assert found.labels == ("sil", "@", "m", "ae", "p")
    assert_allclose(found.times, [0, 0.05, 0.25, 0.35, 0.45, 0.55])
    assert [(word.text, word.first, word.stop) for word in found.words] == [
        ("a", 1, 2),
        ("map", 2, 5),
    ]
    assert heard(performer, found) == ["_", "ax", "bmp", "ae", "bmp"]
    with pytest.raises(ScheduleError, match=r"events.txt:3: .* ends before it starts"):
        read("events.txt", CEREPROC.replace("0.050 0.250 a", "0.350 0.250 a"))


@pytest.mark.parametrize("time", ["nan", "x", "1,5"])
def test_an_event_of_cereproc_without_a_time_is_refused(read, time):
    with pytest.raises(ScheduleError, match=rf"events.txt:4: '?{time}'? is not a time"):
        read("events.txt", CEREPROC.replace("0.050 0.250 @", f"0.050 {time} @"))


def test_sapi_numbers_its_phonemes(read, performer):
    found = read("hello.json", numbered([(7, 50), *HELLO, (7, 100)]))
    assert found.labels == ("_", "26", "21", "31", "35", "_")
    assert_allclose(found.times, [0, 0.05, 0.13, 0.21, 0.29, 0.47, 0.57])
    assert found.stress == (None, None, None, None, 1, None)
    assert heard(performer, found) == ["_", "h", "eh", "l", "ow", "_"]
    lines = "\n".join(map(json.dumps, numbered(HELLO)))
    assert read("hello.jsonl", lines).labels == ("26", "21", "31", "35")


def test_sapi_states_stress_by_a_feature(read):
    assert read("ow.json", numbered([(35, 180)], Feature=1)).stress == (1,)
    assert read("ow.json", numbered([(35, 180)], Feature=2)).stress == ()


def test_phonemes_of_dotnet_are_ipa_with_marks(read, performer):
    said = ("", "h", "ɛ", "-", "l", "oʊ", "1", "_")
    events = [
        {"AudioPosition": {"Ticks": at * 10**6}, "Duration": {"Ticks": 10**6}, "Phoneme": text}
        for at, text in enumerate(said)
    ]
    found = read(
        "hello.json",
        [
            *events,
            {name: events[0][name] for name in ("AudioPosition", "Duration")} | {"Viseme": 3},
        ],
    )
    assert heard(performer, found) == ["_", "h", "eh", "_", "l", "ow", "_"]
    assert found.stress[-2:] == (1, None)


def test_a_table_may_have_the_symbols_and_marks_of_sapi(read, performer):
    said = ("h", "eh", "-", "l", "ow", "1")
    rows = "".join(f"{one},{at / 10},{at / 10 + 0.1}\n" for at, one in enumerate(said))
    found = read("hello.csv", "phoneme,start,end\n" + rows)
    assert heard(performer, found) == ["h", "eh", "l", "ow"]


@pytest.mark.parametrize("number", [-1, 1.5, "26", None, True, 70_000])
def test_a_number_that_is_no_phoneme_is_refused(read, number):
    with pytest.raises(ScheduleError, match="is not the number of a phoneme; they are 0 to 65535"):
        read("hello.json", numbered([(number, 80)]))
    lines = "\n".join(map(json.dumps, numbered([(26, 80), (26, "x")])))
    with pytest.raises(ScheduleError, match=r"hello.jsonl:2: 'x' is not a time"):
        read("hello.jsonl", lines)


@pytest.mark.parametrize("name", ["Viseme", "Phoneme", "CurrentPhoneId"])
def test_a_sound_of_sapi_cannot_end_before_it_starts(read, name):
    positioned = {"AudioPosition": {"Ticks": 0}, "Duration": {"Ticks": -(10**7)}}
    event = {"Duration": -1} if name == "CurrentPhoneId" else positioned
    line = json.dumps(event | {name: "a" if name == "Phoneme" else 10})
    with pytest.raises(ScheduleError, match=r"hello.jsonl:2: a Duration of -1 is below 0"):
        read("hello.jsonl", f"{line.replace('-', '')}\n{line}\n")
