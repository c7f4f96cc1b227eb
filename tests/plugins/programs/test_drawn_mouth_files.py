"""Files of drawings that replace each other: the three of Rhubarb, and that of Moho."""

import json
from dataclasses import replace
from io import StringIO
from itertools import pairwise, product
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from file_bytes import bytes_of
from hypothesis import given
from hypothesis import strategies as st
from lanes import needs_plug_ins

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.animations.animation_writers import WRITERS, find_writer
from lipsync_lang.animations.held import HOLD_SECONDS, REST_WEIGHT, held, strongest
from lipsync_lang.base.errors import OutputError
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.plugins.programs.moho import unstated_rate, write_moho

RHUBARB = ("rhubarb-tsv", "rhubarb-xml", "rhubarb-json")
every_form = pytest.mark.parametrize("name", RHUBARB)
NOISE = np.zeros(16000, np.int16)

SCHEDULE = ll.Schedule(
    ("HH", "AH0", "L", "OW1", "_", "P", "AA1", "F", "UW1", "M"),
    np.cumsum([0, 0.1, 0.08, 0.12, 0.2, 0.1, 0.05, 0.2, 0.07, 0.3, 0.02]),
    words=(ll.Word("hello", 0, 4),),
    notation="arpabet",
    language="english",
)


def performed(character="rhubarb", fps=60, **rest):
    schedule = replace(SCHEDULE, **rest)
    return ll.resolve("english", character).perform(schedule, fps=fps)


def plain(weights, fps=20, start=0.0, end=None, *, poses=None, offset=0.0, **rest):  # noqa: PLR0913 of an animation
    """Return an animation of some weights, (T, P), with a sound of the same length."""
    weights = np.array(weights, float)
    times = start + np.arange(len(weights)) / fps
    end = times[-1] + 1 / fps if end is None else end
    poses = poses or tuple(f"pose{n}" for n in range(weights.shape[1]))
    export = ExportSettings(offset)
    schedule = ll.Schedule(("_",), (0.0, end))
    return Animation(times, poses, weights, fps, schedule, export=export, **rest)


# Reading back: (start, end, shape)


def from_tsv(content):
    *rows, (end, last) = [line.split("\t") for line in content.decode().splitlines()]
    assert last == "X"
    times = [float(start) for start, _ in rows] + [float(end)]
    return [
        (start, stop, shape)
        for (_, shape), (start, stop) in zip(rows, pairwise(times), strict=True)
    ]


def from_xml(content):
    root = ET.fromstring(content)  # noqa: S314 our own
    assert root.tag == "rhubarbResult"
    cues = root.findall("mouthCues/mouthCue")
    assert root.find("metadata/duration").text == cues[-1].get("end")
    return [(float(cue.get("start")), float(cue.get("end")), cue.text) for cue in cues]


def from_json(content):
    document = json.loads(content)
    assert set(document) == {"metadata", "mouthCues"}
    assert document["metadata"]["duration"] == document["mouthCues"][-1]["end"]
    return [(cue["start"], cue["end"], cue["value"]) for cue in document["mouthCues"]]


def moho_rate(animation):
    """Frames per second of Moho's, unless the animation has another than the usual rate."""
    return 24 if animation.fps == 60 else animation.fps


def from_moho(content, animation):
    head, *rows = content.decode().splitlines()
    assert head == "MohoSwitch1"
    cues = [row.split(" ", 1) for row in rows]
    frames = [int(frame) for frame, _ in cues]
    assert frames[0] == 1
    times = [(frame - 1) / moho_rate(animation) for frame in frames]
    return [
        (start, stop, name)
        for (_, name), (start, stop) in zip(cues[:-1], pairwise(times), strict=True)
    ]


def from_spine(content):
    """Return the keys of the slot; each name is an attachment of the skin."""
    document = json.loads(content)
    assert document["skeleton"]["spine"].startswith("4.2.")
    (skin,) = document["skins"]
    (line,) = document["animations"].values()
    keys = line["slots"]["mouth"]["attachment"]
    assert {key["name"] for key in keys} <= set(skin["attachments"]["mouth"])
    assert document["slots"][0]["attachment"] == keys[-1]["name"]
    return [(key["time"], after["time"], key["name"]) for key, after in pairwise(keys)]


def from_renpy(content):
    """Return the pictures of the image and the seconds for which each stays."""
    image, label = content.decode().split("\n\n")
    head, *rows = image.split("\n")
    name = head.removeprefix("image ").removesuffix(":")
    assert f"    show {name}\n" in label
    found, at = [], 0.0
    for row, wait in zip(rows[:-1:2], rows[1::2], strict=True):
        picture = row.strip()[1:-1].removeprefix("images/mouth/").removesuffix(".png")
        found.append((at, at := at + float(wait), picture))
    return found


READERS = {
    "moho": from_moho,
    "renpy": lambda content, _: from_renpy(content),
    "spine": lambda content, _: from_spine(content),
    "rhubarb-json": lambda content, _: from_json(content),
    "rhubarb-tsv": lambda content, _: from_tsv(content),
    "rhubarb-xml": lambda content, _: from_xml(content),
}


def holds(name):
    def check(content, animation):
        near = 0.5 / moho_rate(animation) if name == "moho" else 0.005
        found, wanted = READERS[name](content, animation), held(animation, "rest")
        assert [shape for _, _, shape in found] == [shape.name for shape in wanted]
        for (start, end, _), shape in zip(found, wanted, strict=True):
            assert start == pytest.approx(shape.start, abs=near + 1e-6)
            assert end == pytest.approx(shape.end, abs=near + 1e-6)

    return check


READ_BACK = {name: holds(name) for name in READERS}

# What is shown

weights = st.integers(1, 3).flatmap(
    lambda poses: st.lists(
        st.lists(st.floats(0, 1), min_size=poses, max_size=poses), min_size=1, max_size=40
    )
)


def runs(values):
    cuts = [0, *(np.flatnonzero(np.diff(values)) + 1).tolist(), len(values)]
    return [(int(values[low]), low, high) for low, high in pairwise(cuts)]


@given(weights, st.integers(1, 8))
def test_no_shape_is_shorter_than_the_hold_except_a_whole_that_is(rows, frames):
    shown = runs(strongest(np.array(rows), [], frames))
    assert len(shown) == 1 or all(high - low >= frames for _, low, high in shown)


few = st.lists(st.tuples(st.floats(0, 1), st.floats(0, 1)), min_size=1, max_size=6)


@given(few, st.integers(1, 4))
def test_nothing_else_that_is_held_as_long_weighs_more(rows, frames):
    score = np.column_stack([np.array(rows), np.full(len(rows), REST_WEIGHT)])
    count = len(rows)

    def weigh(shown):
        return score[np.arange(count), list(shown)].sum()

    allowed = [
        one
        for one in product(range(score.shape[1]), repeat=count)
        if len(runs(one)) == 1 or all(high - low >= frames for _, low, high in runs(one))
    ]
    best = max(weigh(one) for one in allowed)
    assert weigh(strongest(np.array(rows), [], frames)) == pytest.approx(best)


@given(st.integers(0, 39), st.integers(1, 3), st.floats(0.6, 1), weights)
def test_a_contact_is_seen_however_short(at, length, level, rows):
    others = np.resize(np.array(rows), (40, len(rows[0])))
    contact = np.zeros((40, 1))
    contact[at : at + length] = level
    table = np.column_stack([contact, np.where(contact > 0, level / 2, others)])
    shown = strongest(table, [0], 6)
    assert (shown[at : at + length] == 0).any()


@given(weights)
def test_poses_that_are_drawn_one_at_a_time_are_taken_as_they_are(rows):
    table = np.column_stack([np.array(rows), np.full(len(rows), 0.5)])
    alone = np.eye(table.shape[1])[table.argmax(axis=1)]
    animation = plain(alone[:, :-1])
    names = [*animation.poses, "rest"]
    drawn = []
    for shape in held(animation, "rest"):
        drawn += [names.index(shape.name)] * round((shape.end - shape.start) * animation.fps)
    np.testing.assert_array_equal(np.eye(table.shape[1])[drawn], alone)


@given(
    weights,
    st.floats(-0.5, 0.5),
    st.floats(0.05, 3),
    st.floats(0, 2),
    st.sampled_from([12, 24000 / 1001, 60]),
)
def test_shapes_follow_each_other_from_zero_to_the_end_of_the_sound(rows, start, end, offset, fps):
    shapes = held(plain(rows, fps, start, end, offset=offset), "rest")
    assert shapes[0].start == 0
    assert shapes[-1].end == offset + end
    for one, other in pairwise(shapes):
        assert one.start < one.end == other.start
        assert one.name != other.name


@given(weights, st.floats(5, 50))
def test_rest_before_and_after_changes_nothing_of_what_is_shown(rows, long):
    animation = plain(rows, end=len(rows) / 20 + 1, offset=1.0)
    longer = plain(rows, end=len(rows) / 20 + 1 + long, offset=1.0 + round(20 * long) / 20)
    one, other = held(animation, "rest"), held(longer, "rest")
    assert [shape.name for shape in one] == [shape.name for shape in other]
    starts = [[shape.start - row[0].end for shape in row[1:]] for row in (one, other)]
    np.testing.assert_allclose(*starts, atol=1e-6)


def test_ages_of_rest_need_no_memory():
    """A frame for each moment would not fit into memory."""
    rest, shape, *_ = held(plain(np.ones((20, 1)), offset=1e9), "rest")
    assert (rest.name, shape) == ("rest", ("pose0", rest.end, pytest.approx(1e9 + 1)))


def test_a_flicker_makes_room_and_a_rest_shows_where_nothing_stands_out():
    rows = np.zeros((20, 2))
    rows[5:10, 0] = 0.9
    rows[7, 1] = 1.0
    shapes = held(plain(rows, poses=("aa", "oo")), "shut")
    assert shapes == [("shut", 0, 0.25), ("aa", 0.25, 0.5), ("shut", 0.5, 1)]
    assert HOLD_SECONDS == 0.1
    closed = held(plain(rows, poses=("aa", "oo"), contacts=("oo",), neutral="idle"), "shut")
    assert [shape.name for shape in closed] == ["idle", "aa", "oo", "aa", "idle"]


def test_bones_are_never_shown():
    rows = np.column_stack([np.full(20, 0.6), np.linspace(0, 9, 20)])
    columns = (Channel("aa"), Channel("nod", node="neck", rotation=(1, 0, 0)))
    animation = plain(rows, poses=("aa", "nod"), channels=columns)
    assert [shape.name for shape in held(animation, "rest")] == ["aa"]


def test_a_sound_that_is_over_before_the_file_begins_is_refused():
    with pytest.raises(OutputError, match=r"`offset=-3`: the sound ends 2 s before the start"):
        held(plain(np.ones((20, 1)), offset=-3.0), "rest")


# The files


@pytest.mark.parametrize("audio", [None, ll.Audio(NOISE, 16000), ll.Audio(NOISE, 8000)])
@pytest.mark.parametrize("name", READERS)
def test_a_file_lasts_as_long_as_its_sound(name, audio):
    animation = performed(audio=audio)
    end = READERS[name](bytes_of(name, animation), animation)[-1][1]
    near = 0.5 / 24 if name == "moho" else 0.005
    assert end == pytest.approx(audio.seconds if audio else SCHEDULE.end, abs=near + 1e-9)


@pytest.mark.parametrize("offset", [0.0, 0.1, 1.0037, 90.0])
@pytest.mark.parametrize("name", READERS)
def test_an_offset_delays_what_is_shown(name, offset):
    animation = performed()
    late = replace(animation, export=ExportSettings(offset=offset))
    rows = READERS[name](bytes_of(name, late), late)
    middles = SCHEDULE.times[:-1] + np.diff(SCHEDULE.times) / 2
    plainly = READERS[name](bytes_of(name, animation), animation)

    def at(cues, seconds):
        return next(shape for start, _, shape in reversed(cues) if start <= seconds)

    for middle in middles:
        near = {at(plainly, middle + d) for d in (-0.017, 0, 0.017)}
        assert at(rows, middle + offset) in near


@needs_plug_ins
@pytest.mark.parametrize("suffix", [".tsv", ".xml", ".rhubarb.json"])
def test_our_own_reader_takes_the_files_for_rhubarbs(suffix, tmp_path):
    animation = performed()
    path = tmp_path / f"line{suffix}"
    animation.save(path)
    schedule = ll.read_schedule(path)
    shapes = held(animation, "rest")
    assert schedule.notation == "rhubarb"
    assert list(schedule.labels) == [shape.name for shape in shapes]
    ends = [shape.start for shape in shapes] + [shapes[-1].end]
    np.testing.assert_allclose(schedule.times, ends, atol=0.005 + 1e-9)


def test_rhubarbs_table_has_its_form():
    wanted = "0.00\tC\n0.20\tX\n0.47\tA\n0.57\tX\n1.00\tX\n"
    rows = np.zeros((100, 9))
    rows[:20, 2] = rows[47:57, 0] = 1
    animation = plain(rows, 100, poses=tuple("abcdefghX"), neutral="x")
    assert bytes_of("rhubarb-tsv", animation).decode() == wanted


def test_rhubarbs_xml_and_json_have_their_forms():
    rows = np.zeros((47, 1))
    rows[5:27, 0] = 1
    animation = plain(rows, 100, poses=("D",), neutral="X")
    animation = replace(animation, schedule=replace(animation.schedule, source="hi <1>.wav"))
    assert bytes_of("rhubarb-xml", animation).decode() == (
        '<?xml version="1.0" encoding="utf-8"?>\n'
        "<rhubarbResult>\n"
        "  <metadata>\n"
        "    <soundFile>hi &lt;1&gt;.wav</soundFile>\n"
        "    <duration>0.47</duration>\n"
        "  </metadata>\n"
        "  <mouthCues>\n"
        '    <mouthCue start="0.00" end="0.05">X</mouthCue>\n'
        '    <mouthCue start="0.05" end="0.27">D</mouthCue>\n'
        '    <mouthCue start="0.27" end="0.47">X</mouthCue>\n'
        "  </mouthCues>\n"
        "</rhubarbResult>\n"
    )
    assert bytes_of("rhubarb-json", animation).decode() == (
        "{\n"
        '  "metadata": {\n'
        '    "soundFile": "hi <1>.wav",\n'
        '    "duration": 0.47\n'
        "  },\n"
        '  "mouthCues": [\n'
        '    { "start": 0.00, "end": 0.05, "value": "X" },\n'
        '    { "start": 0.05, "end": 0.27, "value": "D" },\n'
        '    { "start": 0.27, "end": 0.47, "value": "X" }\n'
        "  ]\n"
        "}\n"
    )


def test_mohos_switch_data_has_its_form():
    rows = np.zeros((24, 1))
    rows[6:12, 0] = 1
    out = StringIO()
    write_moho(plain(rows, 24, poses=("wide\nopen",)), out)
    assert out.getvalue() == "MohoSwitch1\n1 rest\n7 wide open\n13 rest\n25 rest\n"


def test_the_last_drawing_is_seen_however_late_it_comes():
    rows = np.zeros((20, 1))
    rows[19] = 1
    out = StringIO()
    write_moho(plain(rows, 20, end=0.96, poses=("wide",)), out)
    assert out.getvalue() == "MohoSwitch1\n1 rest\n20 wide\n21 rest\n"


def test_a_face_without_rhubarbs_shapes_is_told_who_has_them():
    with pytest.raises(OutputError, match=r"A, B, .*, X, and open, W, .* \(-c rhubarb\)"):
        bytes_of("rhubarb-tsv", performed("facefx"))


def test_a_rate_of_moho_that_nobody_has_stated_is_told():
    rows = [[0], [1], [1], [0], [0], [0]]
    usual = plain(rows, 60, end=2.0, poses=("wide",))
    assert [*unstated_rate(usual)]
    stated = replace(usual, export=ExportSettings(frame_rate=60))
    assert [*unstated_rate(stated)] == [*unstated_rate(plain(rows, 30, poses=("wide",)))] == []


def test_moho_takes_the_names_of_any_drawings():
    drawn, blended = performed("preston-blair", 24), performed("facefx", 24)
    names = {name for _, _, name in from_moho(bytes_of("moho", drawn), drawn)}
    assert "MBP" in names
    assert names <= {*drawn.poses, "rest"}
    cues = from_moho(bytes_of("moho", blended), blended)
    assert {"PBM", "FV"} <= {name for _, _, name in cues}
    assert all(end - start >= HOLD_SECONDS - 1e-9 for start, end, _ in cues)


@every_form
def test_a_suffix_names_the_form(name, tmp_path):
    assert find_writer(tmp_path / f"line{WRITERS[name].suffix}").name == name
    assert find_writer(tmp_path / "line.json").name == "json"


@pytest.mark.parametrize("name", [*RHUBARB, "moho", "spine", "renpy"])
def test_gestures_are_no_drawings_of_a_mouth(name):
    spoken = performed()
    lids = np.sin(np.arange(len(spoken)))[:, None] ** 2
    alive = replace(
        spoken,
        poses=(*spoken.poses, "blink"),
        weights=np.hstack([spoken.weights, lids]),
        channels=(*spoken.columns, Channel("blink", gesture=True)),
    )
    assert bytes_of(name, alive) == bytes_of(name, spoken)


def test_a_face_that_nods_and_blinks_has_the_mouths_of_one_that_does_not():
    performer = ll.resolve("english", "facefx")
    alive = performer.perform(SCHEDULE, gestures="all")
    alive["nod"][:] = 5
    alive["blink"][:] = 1
    assert held(alive, "rest") == held(performer.perform(SCHEDULE), "rest")
