"""Files of mouth shapes: Rhubarb, Papagayo, Polly, Azure, SAPI, SmartBody."""

import json

import numpy as np
import pytest
from timing_texts import spoken

import lipsync_lang as ll
from lipsync_lang.base.errors import ScheduleError


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "facefx")


def guessed(schedule):
    """Remark on an end that is missing from the file."""
    return [told for told in schedule.remarks if "it is given 0.08 s" in told]


# Rhubarb

TIMES = (0.0, 0.05, 0.27, 0.31, 0.43, 0.47)
CUES = list(zip("XDCBX", TIMES, TIMES[1:], strict=False))
RHUBARB = {
    ".tsv": "".join(f"{at:.2f}\t{shape}\n" for shape, at, _ in CUES) + "0.47\tX\n",
    ".json": json.dumps(
        {
            "metadata": {"soundFile": "hi.wav", "duration": 0.47},
            "mouthCues": [{"start": at, "end": end, "value": shape} for shape, at, end in CUES],
        },
        indent=2,
    ),
    ".xml": (
        '<?xml version="1.0" encoding="utf-8"?>\n<rhubarbResult>\n<metadata>'
        "<soundFile>hi.wav</soundFile><duration>0.47</duration></metadata>\n<mouthCues>\n"
        + "".join(
            f'<mouthCue start="{at}" end="{end}">{shape}</mouthCue>\n' for shape, at, end in CUES
        )
        + "</mouthCues>\n</rhubarbResult>\n"
    ),
}


@pytest.mark.parametrize("suffix", RHUBARB)
def test_rhubarb_says_the_same_in_all_its_forms(read, performer, suffix):
    schedule = read(f"line{suffix}", RHUBARB[suffix])
    assert schedule.labels == ("X", "D", "C", "B", "X")
    np.testing.assert_allclose(schedule.times, TIMES)
    assert schedule.notation == "rhubarb"
    assert not guessed(schedule)
    numbers, _, _ = performer.common_phonemes(schedule)
    assert [performer.compiled.phonemes[n] for n in numbers] == ["_", "aa", "eh", "s", "_"]


@pytest.mark.parametrize("form", ['{{"start": {}, "end": {}, "value": "{}"}}', "xml"])
def test_a_shape_that_overlaps_lasts_until_the_next_starts(read, form):
    cues = [(0.0, 0.37, "X"), (0.37, 0.52, "E"), (0.45, 0.52, "B"), (0.52, 0.6, "X")]
    if form == "xml":
        rows = (f'<mouthCue start="{at}" end="{end}">{name}</mouthCue>' for at, end, name in cues)
        schedule = read("line.xml", f"<rhubarbResult>{''.join(rows)}</rhubarbResult>")
    else:
        rows = ", ".join(form.format(*cue) for cue in cues)
        schedule = read("line.json", f'{{"mouthCues": [{rows}]}}')
    assert schedule.labels == ("X", "E", "B", "X")
    np.testing.assert_allclose(schedule.times, [0, 0.37, 0.45, 0.52, 0.6])
    assert any("overlap the next one (1) last until it starts" in told for told in schedule.remarks)


def test_of_two_shapes_at_one_time_the_last_is_shown(read):
    cues = [{"start": 0, "end": 0.2, "value": one} for one in "AD"]
    assert read("line.json", {"mouthCues": cues}).labels == ("D",)


@pytest.mark.parametrize(
    ("suffix", "text", "told"),
    [
        (".tsv", "0.00\tX\n0.1 B\n", r"tsv:2: '0.1 B' is not a time, a tab and a shape"),
        (".tsv", "0.00\tX\n", "has no phonemes"),
        (".json", '{"mouthCues": [{"start": 0, "end": 1}]}', "a cue has no value; the form is"),
        (".json", '{"mouthCues": [{"value": "A", "start": "x"}]}', "'x' is not a time"),
        (".xml", '<rhubarbResult><mouthCue start="0">A</mouthCue></rhubarbResult>', "None is not"),
        (
            ".xml",
            '<rhubarbResult><mouthCue start="0" end="nan"/></rhubarbResult>',
            "nan is not a",
        ),
        (".xml", "<rhubarbResult><mouthCues>", r"xml:1: not XML"),
    ],
)
def test_damaged_cues_are_refused(read, suffix, text, told):
    with pytest.raises(ScheduleError, match=told):
        read(f"line{suffix}", text)


# Amazon Polly

MARY = """\
{"time":0,"type":"sentence","start":0,"end":23,"value":"Mary had."}
{"time":6,"type":"word","start":0,"end":4,"value":"Mary"}
{"time":6,"type":"viseme","value":"p"}
{"time":73,"type":"viseme","value":"E"}
{"time":180,"type":"viseme","value":"r"}
{"time":292,"type":"viseme","value":"i"}
{"time":373,"type":"word","start":5,"end":8,"value":"had"}
{"time":373,"type":"viseme","value":"k"}
{"time":460,"type":"viseme","value":"a"}
{"time":521,"type":"viseme","value":"t"}
{"time":604,"type":"viseme","value":"sil"}
"""


def test_speech_marks_last_until_the_next_one(read):
    schedule = read("line.marks", MARY)
    assert schedule.labels == ("_", "p", "E", "r", "i", "k", "a", "t")
    np.testing.assert_allclose(schedule.times[-3:], [0.46, 0.521, 0.604])
    assert spoken(schedule) == [("Mary", ("p", "E", "r", "i")), ("had", ("k", "a", "t"))]
    assert schedule.lines[1] == 3
    assert not guessed(schedule)
    paused = '{"time":300,"type":"viseme","value":"sil"}'
    paused = MARY.replace('{"time":373,"type":"word"', f'{paused}\n{{"time":373,"type":"word"')
    assert spoken(read("line.marks", paused))[0] == ("Mary", ("p", "E", "r", "i"))


def test_speech_marks_may_be_in_one_list_and_in_any_file(read):
    marks = [json.loads(line) for line in MARY.splitlines()]
    assert read("line.json", marks).labels == read("line.txt", MARY).labels


def test_an_end_that_no_file_has_is_guessed_and_said(read):
    schedule = read("line.marks", MARY.rsplit("\n", 2)[0])
    assert schedule.end == pytest.approx(0.521 + 0.08)
    assert "its last label, 't', ends; it is given 0.08 s" in guessed(schedule)[0]
    assert spoken(schedule)[-1] == ("had", ("k", "a", "t"))


def test_of_marks_at_one_time_the_last_is_seen(read):
    text = MARY.replace('"time":460', '"time":521')
    assert read("line.marks", text).labels[-2:] == ("k", "t")


def test_marks_without_visemes_say_how_to_ask_for_them(read):
    text = "".join(line for line in MARY.splitlines(keepends=True) if "viseme" not in line)
    with pytest.raises(ScheduleError, match=r"has no visemes; request them .*--speech-mark-types"):
        read("line.marks", text)
    with pytest.raises(ScheduleError, match=r"marks:12: a speech mark needs time, type and value"):
        read("line.marks", MARY + '{"time": 1}\n')
    with pytest.raises(ScheduleError, match=r"marks:12:9: not JSON: "):
        read("line.marks", MARY + '{"time":\n')


# Azure and SAPI

SPELLINGS = [
    ("AudioOffset", "VisemeId"),
    ("audioOffset", "visemeId"),
    ("audio_offset", "viseme_id"),
    ("privAudioOffset", "privVisemeId"),
]


@pytest.mark.parametrize(("offset", "viseme"), SPELLINGS)
@pytest.mark.parametrize("lines", [False, True])
def test_azure_events_are_read_as_every_sdk_spells_them(read, offset, viseme, lines):
    events = [{offset: at, viseme: n} for at, n in ((500_000, 0), (1_000_000, 21), (2_000_000, 0))]
    text = "\n".join(map(json.dumps, events)) if lines else events
    schedule = read("line.json", text)
    assert schedule.labels == ("_", "0", "21")
    np.testing.assert_allclose(schedule.times, [0, 0.05, 0.1, 0.2])
    assert schedule.notation == "azure"


def test_the_times_of_azure_may_be_in_other_units(read):
    schedule = read("line.json", [{"offset": 50, "visemeId": 6}], rate=1000)
    np.testing.assert_allclose(schedule.times, [0, 0.05, 0.13])


def test_a_session_ends_the_last_viseme(read):
    metadata = [
        {"Type": "Viseme", "Data": {"Offset": 0, "VisemeId": 6}},
        {"Type": "SessionEnd", "Data": {"Offset": 4_000_000}},
    ]
    schedule = read("line.json", {"Metadata": metadata})
    assert schedule.end == pytest.approx(0.4)
    assert not guessed(schedule)


def test_only_what_azure_calls_a_word_is_one(read):
    def boundary(kind, text, at):
        text = {"Text": text, "Length": len(text), "BoundaryType": kind}
        return {"Type": f"{kind}Boundary", "Data": {"Offset": at, "Duration": 10**6, "text": text}}

    metadata = [
        {"Type": "Viseme", "Data": {"Offset": 0, "VisemeId": 6}},
        boundary("Word", "hi", 0),
        {"Type": "Viseme", "Data": {"Offset": 10**6, "VisemeId": 7}},
        boundary("Punctuation", ".", 10**6),
    ]
    assert spoken(read("line.json", {"Metadata": metadata})) == [("hi", ("6",))]


@pytest.mark.parametrize("number", [22, -1, 1.5, "22", None, True])
def test_a_number_that_is_no_viseme_is_refused(read, number):
    with pytest.raises(ScheduleError, match="is not a viseme; visemes are numbered 0 to 21"):
        read("line.json", [{"AudioOffset": 0, "VisemeId": number}])


def test_sapi_writes_spans_of_time(read):
    events = [
        {"AudioPosition": "00:00:00", "Duration": "00:00:00.1000000", "Viseme": 0},
        {"AudioPosition": {"Ticks": 1_000_000}, "Duration": {"Ticks": 500_000}, "Viseme": 17},
        {"AudioPosition": "00:01:00.15", "Duration": "00:00:00", "Viseme": 3},
        {"AudioPosition": "0.00:01:00.15", "Duration": "00:00:01", "Viseme": 21},
    ]
    schedule = read("line.json", events)
    assert schedule.labels == ("0", "17", "_", "21")
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.15, 60.15, 61.15])
    for span in ("1:00", 5, None, [], "00:00:0x"):
        with pytest.raises(ScheduleError, match="is not a span of time such as"):
            read("line.json", [{**events[0], "Duration": span}])
    with pytest.raises(ScheduleError, match="more than a day"):
        read("line.json", [{**events[0], "Duration": "1.00:00:01"}])
    with pytest.raises(ScheduleError, match="needs AudioPosition, Duration and a Viseme from 0"):
        read("line.json", [{**events[0], "Viseme": 22}])


# Papagayo

PGO = """\
lipsync version 1
hi.wav
24
40
1
\tVoice 1
\tHi there.|Oh
\t2
\t\tHi there.
\t\t1
\t\t18
\t\t2
\t\t\tHi 1 7 2
\t\t\t\t1 etc
\t\t\t\t3 AI
\t\t\tthere. 9 18 2
\t\t\t\t9 etc
\t\t\t\t12 E
\t\tOh
\t\t24
\t\t29
\t\t1
\t\t\tOh 24 29 1
\t\t\t\t24 O
"""


def pg2(phoneme_set, labels, **rest):
    words = [
        {"id": 0, "text": "hi", "start_frame": 2, "end_frame": 5, "tags": [], "phonemes": [
            {"id": n, "text": label, "frame": 2 + n, "tags": []} for n, label in enumerate(labels)
        ]}
    ]  # fmt: skip
    phrases = [
        {"id": 0, "text": "hi", "start_frame": 2, "end_frame": 5, "tags": [], "words": words}
    ]
    voice = {"name": "Voice 1", "text": "hi", "num_children": 3, "phrases": phrases}
    return {"version": 2, "sound_path": "hi.wav", "fps": 10, "sound_duration": 9, "num_voices": 1,
            "phoneme_set": phoneme_set, "voices": [voice]} | rest  # fmt: skip


def test_papagayo_counts_frames_and_rests_between_words(read):
    schedule = read("line.pgo", PGO)
    assert schedule.labels == ("_", "etc", "AI", "_", "etc", "E", "_", "O")
    np.testing.assert_allclose(schedule.times * 24, [0, 1, 3, 8, 9, 12, 19, 24, 30])
    assert [word.text for word in schedule.words] == ["Hi", "there.", "Oh"]
    assert schedule.lines[1:3] == (14, 15)
    assert schedule.notation == "preston-blair"


def test_a_word_of_papagayo_ends_where_the_next_one_starts(read):
    schedule = read("line.pgo", PGO.replace("Hi 1 7 2", "Hi 1 9 2"))
    np.testing.assert_allclose(schedule.times[:4] * 24, [0, 1, 3, 9])
    assert spoken(schedule)[:2] == [("Hi", ("etc", "AI")), ("there.", ("etc", "E"))]


def test_the_json_of_papagayo_names_its_set(read, performer):
    shapes = read("line.pg2", pg2("preston_blair", ["etc", "AI"]))
    np.testing.assert_allclose(shapes.times, [0, 0.2, 0.3, 0.6])
    assert shapes.notation == "preston-blair"
    assert spoken(shapes) == [("hi", ("etc", "AI"))]
    assert read("line.pg2", pg2("fleming_dobbs", ["EHSZ", "AA"])).notation == "fleming-dobbs"
    sounds = read("line.pg2", pg2("CMU_39", ["HH", "AY"]))
    assert sounds.notation is None
    assert not sounds.remarks
    assert performer.perform(sounds).weights.any()


@pytest.mark.parametrize("shapes", ["CMU_39", "preston_blair", "fleming_dobbs"])
def test_papagayo_rests_in_every_set(read, performer, shapes):
    sounds = read("line.pg2", pg2(shapes, ["HH" if shapes == "CMU_39" else "O", "rest"]))
    animation = performer.perform(sounds)
    assert not animation.weights[animation.times > sounds.times[-1] - 0.05].max() > 0.35


def test_one_voice_is_read(read):
    whole = pg2("CMU_39", ["HH"])
    (voice,) = whole["voices"]
    whole["voices"] = [voice, {**voice, "name": "Bob"}]
    assert read("line.pg2", whole, tier="Bob").labels == ("_", "HH")
    with pytest.raises(ScheduleError, match=r"2 voices: 'Voice 1', 'Bob'; choose one"):
        read("line.pg2", whole)
    with pytest.raises(ScheduleError, match=r"no tier is named 'Rob'; did you mean 'Bob'\?"):
        read("line.pg2", whole, tier="Rob")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (PGO[:-20], r"pgo:\d+: ends too early|needs 4 parts|is not a number"),
        (PGO.replace("\t\t\t\t3 AI", "\t\t\t\tAI"), "pgo:15: needs 2 parts, but has 1"),
        (PGO.replace("\n24\n40", "\n0\n40"), "pgo:3: has 0 frames per second"),
        (PGO.replace("\n24\n40", "\n2x\n40"), "pgo:3: '2x' is not a number of frames"),
    ],
)
def test_damaged_frames_are_refused(read, text, told):
    with pytest.raises(ScheduleError, match=told):
        read("line.pgo", text)
    for bad in (0, -1, "ten", None, float("inf")):
        with pytest.raises(ScheduleError, match=r"is not a time|must be above 0"):
            read("line.pg2", pg2("CMU_39", ["HH"], fps=bad))
    with pytest.raises(ScheduleError, match="`voices` must be a list of objects"):
        read("line.pg2", pg2("CMU_39", ["HH"], voices=[1]))


# SmartBody

REPLY = """\
<?xml version="1.0" encoding="UTF-8"?>
<speak><soundFile name="hi.wav"/><viseme start="0" type="_"/><mark name="T0" time="0.1"/>
<word start="0.1" end="0.4"><viseme start="0.1" type="H"/>
<viseme start="0.2" type="Ih" articulation="0.4"/><viseme start="0.2" type="Ay" articulation="0.9"/>
</word></speak>
"""


def test_a_reply_is_read_by_its_strongest_shapes(read, performer):
    schedule = read("reply.xml", REPLY)
    assert schedule.labels == ("_", "H", "Ay")
    np.testing.assert_allclose(schedule.times, [0, 0.1, 0.2, 0.4])
    assert "1 weaker shapes start with a stronger one and are left out" in schedule.remarks[1]
    assert performer.perform(schedule).weights.any()


def test_lips_say_both_ends_and_syncs_the_words(read):
    text = (
        '<bml><sync id="T0" time="0.1" />hi<sync id="T1" time="0.3" /><sync id="T2" time="0.5" />'
        '<lips viseme="open" articulation="1" start="0.1" ready="0.1" relax="0.3" end="0.3" />'
        '<lips viseme="PBM" start="0.35" end="0.5" /></bml>'
    )
    schedule = read("line.bml", text)
    assert schedule.labels == ("_", "open", "_", "PBM")
    assert spoken(schedule) == [("hi", ("open",))]
    with pytest.raises(ScheduleError, match="a <lips> has no `viseme`; export it again"):
        read("line.bml", text.replace("viseme=", "name="))
    with pytest.raises(ScheduleError, match="overlap"):
        read("line.bml", text.replace('start="0.35"', 'start="0.2"'))


def test_finished_curves_are_no_timings(read):
    with pytest.raises(ScheduleError, match="has finished curves, not visemes"):
        read("line.bml", '<bml><curve name="open" num_keys="1">0 0</curve></bml>', read_as="bml")
