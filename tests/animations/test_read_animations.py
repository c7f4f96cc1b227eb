"""Animations of other programs: reading, transfer to a face, and refusals."""

import json
import struct
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from lanes import needs_plug_ins

from lipsync_lang import LipsyncError, Schedule, resolve
from lipsync_lang.animations.animation_readers import (
    ANIMATION_READERS,
    Recording,
    read_animation,
)
from lipsync_lang.base.errors import AnimationError
from lipsync_lang.reports.quality.check_animation import check
from lipsync_lang.reports.quality.fitting import fit, read_for

assert ANIMATION_READERS, "a sweep over nothing passes"

LINE = Schedule(("P", "AA", "F", "S"), np.array([0.0, 0.1, 0.4, 0.5, 0.7]), notation="arpabet")


@cache
def performer(character="facefx"):
    return resolve("english", character, cache=False)


@cache
def performed(character="facefx"):
    return performer(character).perform(LINE)


def written(tmp_path, name, text):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


# Ours, back again


@pytest.mark.parametrize("suffix", sorted({reader.suffix for reader in ANIMATION_READERS.values()}))
def test_what_we_write_is_read_back_as_it_was(suffix, tmp_path):
    there, path = performed(), tmp_path / f"line{suffix}"
    there.save(path)
    here, remarks = read_for(performer(), path, LINE)
    assert here.poses == there.poses
    assert here.fps == pytest.approx(60)
    assert remarks == ()
    np.testing.assert_allclose(here.times, there.times, atol=1e-5)
    np.testing.assert_allclose(here.weights, there.weights, atol=1e-5)
    before, after = check(there), check(here, performer=performer())
    for one, other in zip(before.figures, after.figures, strict=True):
        assert other.verdict == one.verdict, one.name


def test_json_tells_what_was_said(tmp_path):
    performed().save(tmp_path / "line.json")
    here, _ = read_for(performer(), tmp_path / "line.json")
    assert here.schedule.labels == LINE.labels
    np.testing.assert_allclose(here.schedule.times, LINE.times)


def test_channels_of_a_rig_are_found_in_a_file(tmp_path):
    folder = tmp_path / "characters"
    folder.mkdir()
    text = "kind: character\nformat: 1\nname: max\nposeset: facefx\nrig: facefx-to-arkit\n"
    (folder / "max.yaml").write_text(text, "utf-8")
    rigged = resolve("english", "max", paths=[tmp_path])
    there = rigged.rigged(rigged.perform(LINE))
    there.save(tmp_path / "line.csv")
    for channels in (False, True):
        here, _ = read_for(rigged, tmp_path / "line.csv", LINE, channels=channels)
        assert here.poses == there.poses
        assert check(here, performer=rigged).passed


# CSV of anybody


def test_columns_may_be_spelled_otherwise_and_be_fewer(tmp_path):
    path = written(tmp_path, "a.csv", "Time (ms);JAW_OPEN;x\n0;0.1;9\n20;0.5;9\n40;0.2;9\n")
    here, remarks = read_for(performer("arkit"), path, LINE)
    assert here["jawOpen"].tolist() == [0.1, 0.5, 0.2]
    assert here.fps == 50
    assert here.weights.sum() == pytest.approx(0.8)
    assert any("has no column for" in remark and "stay at rest" in remark for remark in remarks)


def test_uneven_frames_are_laid_out_anew():
    times = np.array([0.0, 0.1, 0.2, 0.35, 0.4])
    recording = Recording("x", times, ("open",), np.array([[0.0], [1], [0], [1.5], [0]]))
    here, _ = fit(recording, performer(), LINE)
    assert here.fps == 10
    np.testing.assert_allclose(np.diff(here.times), 0.1)
    assert here["open"][3] == pytest.approx(1.0)


def test_percent_are_told_from_shares():
    recording = Recording("x", np.arange(3) / 60, ("open",), np.array([[0.0], [50], [100]]))
    here, remarks = fit(recording, performer(), LINE)
    assert here["open"].tolist() == [0, 0.5, 1]
    assert "read as percentages" in remarks[0]


# Live Link Face


def take(codes, names=("JawOpen", "MouthPressRight", "MouthPressLeft")):
    head = ",".join(("Timecode", "BlendShapeCount", *names))
    rows = (f"{code},61,{n / 100},0.2,0.3" for n, code in enumerate(codes))
    return "\n".join((head, *rows)) + "\n"


@needs_plug_ins
def test_a_take_is_read_by_its_header(tmp_path):
    codes = [f"11:59:{s:02}:{f:02}.500" for s in (58, 59) for f in range(60)][50:]
    codes += ["12:00:00:00.500"]
    recording = read_animation(written(tmp_path, "take.csv", take(codes)))
    assert recording.names == ("jawOpen", "mouthPressRight", "mouthPressLeft")
    np.testing.assert_allclose(recording.times, np.arange(len(codes)) / 60)
    assert recording.values[1].tolist() == [0.01, 0.2, 0.3]
    here, _ = fit(recording, performer("arkit"), LINE)
    assert here.fps == 60
    assert here["mouthPressLeft"][0] == 0.3


@needs_plug_ins
@pytest.mark.parametrize("rate", [24, 30, 60])
def test_timecodes_say_how_many_frames_a_second_has(rate, tmp_path):
    codes = [f"01:00:{s:02}:{f:02}.000" for s in range(3) for f in range(rate)]
    recording = read_animation(written(tmp_path, "take.csv", take(codes)))
    np.testing.assert_allclose(np.diff(recording.times), 1 / rate)
    assert f"{rate} frames a second" in recording.remarks[0]


@needs_plug_ins
def test_frames_that_repeat_a_timecode_are_left_out(tmp_path):
    codes = ["01:00:00:00.000", "01:00:00:01.000", "01:00:00:01.000", "01:00:00:02.000"]
    recording = read_animation(written(tmp_path, "take.csv", take(codes)))
    assert len(recording.times) == 3
    assert "1 frames repeat a timecode" in recording.remarks[1]


# GLB


def glb(interpolation="LINEAR", values=(0, 0, 0.5, 1, 0, 0), times=(0, 0.5, 1), **changes):
    """A model with two shapes and an animation of their weights."""
    data = struct.pack(f"<{len(times)}f", *times) + struct.pack(f"<{len(values)}f", *values)
    size = 4 * len(times)
    document = {
        "asset": {"version": "2.0"},
        "meshes": [
            {
                "primitives": [{"attributes": {}, "targets": [{}, {}]}],
                "extras": {"targetNames": ["jawOpen", "x"]},
            }
        ],
        "nodes": [{"mesh": 0}],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": size},
            {"buffer": 0, "byteOffset": size, "byteLength": len(data) - size},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": len(times), "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": len(values), "type": "SCALAR"},
        ],
        "animations": [
            {
                "channels": [{"sampler": 0, "target": {"node": 0, "path": "weights"}}],
                "samplers": [{"input": 0, "output": 1, "interpolation": interpolation}],
                "extras": {"audio_start": 0.25},
            }
        ],
    } | changes
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    data += b"\0" * (-len(data) % 4)
    chunks = struct.pack("<2I", len(text), 0x4E4F534A) + text
    chunks += struct.pack("<2I", len(data), 0x004E4942) + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def test_weights_are_read_by_the_names_of_the_targets(tmp_path):
    recording = read_animation(written(tmp_path, "a.glb", glb()))
    assert recording.names == ("jawOpen", "x")
    np.testing.assert_allclose(recording.times, [-0.25, 0.25, 0.75])
    np.testing.assert_allclose(recording.values, [[0, 0], [0.5, 1], [0, 0]])


def test_steps_and_splines_are_read_between_their_keys_too(tmp_path):
    stepped = read_animation(written(tmp_path, "a.glb", glb("STEP")))
    at = np.interp([-0.2, 0.2, 0.3, 0.7], stepped.times, stepped.values[:, 0])
    np.testing.assert_allclose(at, [0, 0, 0.5, 0.5])
    values = [9, 9, 0, 0, 9, 9, 9, 9, 0.5, 1, 9, 9, 9, 9, 0, 0, 9, 9]
    spline = read_animation(written(tmp_path, "b.glb", glb("CUBICSPLINE", values)))
    at = np.interp([-0.25, 0.0, 0.25, 0.5, 0.75], spline.times, spline.values[:, 0])
    np.testing.assert_allclose(at, [0, 0.25, 0.5, 0.25, 0], atol=1e-4)  # equal slopes cancel
    rising = [0, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0]
    leaning = read_animation(written(tmp_path, "c.glb", glb("CUBICSPLINE", rising)))
    middle = np.interp(0.0, leaning.times, leaning.values[:, 0])
    assert middle == pytest.approx(0.5 + 2 * 0.5 / 8, abs=1e-4)  # slopes count per second


# What is refused, and where


def field(rows, number, **changes):
    """Return a GLB with fields of one row of a list replaced."""
    return changed(lambda document: document[rows][number].update(changes))


def changed(change):
    content = glb()
    length = struct.unpack_from("<I", content, 12)[0]
    document = json.loads(content[20 : 20 + length])
    change(document)
    return glb(**document)


def animated(**changes):
    """Return a GLB with fields of its animation replaced."""
    return changed(lambda document: document["animations"][0].update(changes))


BAD = {
    "no suffix": ("line", "", "has no suffix; known: .csv"),
    "unknown": ("line.fbx", "", "no reader for '.fbx'"),
    "empty": ("a.csv", "", "is empty"),
    "no time": ("a.csv", "open,W\n0,1\n", r"a.csv:1: its first column is 'open', not a time"),
    "a short row": ("a.csv", "time,open\n0,1\n1\n", r"a.csv:3: has 1 values for 2 columns"),
    "text": ("a.csv", "time,open\n0,1\n1,much\n", r"a.csv:3: 'much' is not a number"),
    "decimal comma": ("a.csv", "time;open\n0;0,5\n", (r"a.csv:2: '0,5' is not a number; write it "
    r"with")),
    "one frame": ("a.csv", "time,open\n0,1\n", "has 1 frames"),
    "no frames": ("a.csv", "time,open\n", "has 0 frames"),
    "no columns": ("a.csv", "time\n0\n1\n", "has no columns"),
    "a column twice": ("a.csv", "time,W,W\n0,1,1\n1,1,1\n", "two columns called 'W'"),
    "time falls": ("a.csv", "time,W\n0,1\n2,1\n1,1\n", "frame 2: its time does not rise"),
    "nan": ("a.csv", "time,W\n0,1\n2,nan\n", "frame 1: a value is not a number"),
    "latin 1": ("a.csv", b"time,W\n0,\xe9\n", "is not UTF-8 text"),
    "no timecode": ("a.csv", "Timecode,BlendShapeCount,JawOpen\nx,61,0\n", "a.csv:2: 'x' is no"),
    "empty take": ("a.csv", "Timecode,BlendShapeCount,JawOpen\n", "has no frames"),
    "text in a take": (
        "a.csv", "Timecode,BlendShapeCount,J\n0:0:0:0,61,x\n", "a.csv:2: has text in"
    ),
    "broken json": ("a.json", "{", r"a.json:1:2: not JSON"),
    "other json": ("a.json", "{}", "not an animation of this program"),
    "no animation": ("a.glb", glb(animations=[]), "has no animation"),
    "moves nothing": ("a.glb", glb(animations=[{}]), "moves no morph target"),
    "too few weights": ("a.glb", glb(values=(0, 0, 1)), "has 1 weights at each key of .* 2 shapes"),
    "past the end": (
        "a.glb",
        glb(bufferViews=[{"buffer": 0, "byteLength": 12}, {"buffer": 0, "byteOffset": 60}]),
        "past the end",
    ),
    "numbers not there": ("a.glb", glb(accessors=[]), "refers to accessor 0, but has only 0"),
    "no kind": ("a.glb", glb(accessors=[{"sparse": {}}, {}]), "numbers of an unknown type"),
    "a count of bytes that are not there": (
        "a.glb", field("accessors", 1, count=2**40), "accessor 1 states 1099511627776 values in"
    ),
    "a count below 0": ("a.glb", field("accessors", 1, count=-1), "accessor 1 states -1 values"),
    "a count that is true": ("a.glb", field("accessors", 0, count=True), "states True values"),
    "a kind as a list": ("a.glb", field("accessors", 0, componentType=[5126]), "an unknown type"),
    "an offset in text": ("a.glb", field("accessors", 0, byteOffset="0"), "past the end"),
    "an offset below 0": ("a.glb", field("bufferViews", 0, byteOffset=-4), "past the end"),
    "no length": ("a.glb", field("bufferViews", 0, byteLength=None), "past the end"),
    "no view": ("a.glb", field("accessors", 0, bufferView=7), "accessor 0 has no buffer view"),
    "a stride of 0": ("a.glb", field("bufferViews", 0, byteStride=0), "has values 0 bytes apart"),
    "sparse text": ("a.glb", field("accessors", 1, sparse="x"), ("sparse values that are not an "
    "object")),
    "sparse places": (
        "a.glb",
        field("accessors", 1, sparse={
            "count": 1, "indices": {"bufferView": 0, "componentType": 5125, "byteOffset": 4},
            "values": {"bufferView": 1},
        }),
        "replaces value 1056964608, but has only 6",
    ),
    "sampler": ("a.glb", animated(samplers=[1]), "samplers of its animation are not a list"),
    "channels": ("a.glb", animated(channels={"a": 1}), "channels of its animation are not a list"),
    "target": ("a.glb", animated(channels=[{"sampler": 0, "target": 5}]), "has no target"),
    "input": ("a.glb", animated(samplers=[{"input": [0], "output": 1}]), r"to accessor \[0\]"),
    "times that fall": ("a.glb", glb(times=(0, 1, 0.5)), "the times of its animation do not rise"),
    "times of nan": ("a.glb", glb(times=(0, float("nan"), 1)), "times of its animation do not r"),
    "weights of nan": (
        "a.glb", glb(values=(0, 0, float("nan"), 1, 0, 0)), ("a value of its animation is not a "
        "number")
    ),
    "a start in text": ("a.glb", animated(extras={"audio_start": "0"}), "audio_start of its anim"),
    "data as null": ("a.glb", glb(buffers=[{"byteLength": 90, "uri": None}]), "36 bytes of binary"),
    "no glb": ("a.glb", b"Kaydara FBX", "an FBX file"),
}  # fmt: skip


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=needs_plug_ins if "take" in name else ()) for name in BAD]
)
def test_a_bad_file_is_told_where_and_how_to_mend_it(name, tmp_path):
    file, content, message = BAD[name]
    with pytest.raises(LipsyncError, match=message):
        read_animation(written(tmp_path, file, content))


def ours(**changes):
    good = {
        "format": "lipsync-lang animation 1", "fps": 60, "start": 0, "poses": ["open"],
        "frames": [[0], [1]],
    }  # fmt: skip
    return json.dumps(good | changes)


BAD_JSON = {
    "poses": ({"poses": "open"}, "poses are not a list of names"),
    "fps": ({"fps": "60"}, "`fps` is not a number"),
    "no speed": ({"fps": 0}, "0 frames per second"),
    "frames": ({"frames": {}}, "frames are not a list"),
    "a frame": ({"frames": [[0], [0, 1]]}, "frame 1 is not a list of 1 numbers"),
    "phonemes": ({"phonemes": [{"label": "P"}]}, "its phonemes are invalid"),
}


@pytest.mark.parametrize("name", BAD_JSON)
def test_json_that_is_not_ours_is_told(name, tmp_path):
    changes, message = BAD_JSON[name]
    with pytest.raises(AnimationError, match=message):
        read_animation(written(tmp_path, "a.json", ours(**changes)))


def test_a_file_of_another_face_says_what_it_has_and_what_is_wanted(tmp_path):
    path = written(tmp_path, "a.csv", "time,foo,bar\n0,1,1\n1,1,1\n")
    with pytest.raises(AnimationError, match=r"has nothing of facefx: it has foo, bar; wanted"):
        read_for(performer(), path, LINE)


def test_what_was_said_must_be_known(tmp_path):
    path = written(tmp_path, "a.csv", "time,open\n0,1\n1,1\n")
    with pytest.raises(AnimationError, match="has no spoken text"):
        read_for(performer(), path)


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises(AnimationError, match="cannot be read: No such file"):
        read_animation(tmp_path / "none.csv")


def test_a_bad_animation_is_noticed_in_a_file(tmp_path):
    weights = performed().weights.copy()
    weights[:, performed().poses.index("PBM")] *= 0.5
    replace(performed(), weights=weights).save(tmp_path / "bad.csv")
    here, _ = read_for(performer(), tmp_path / "bad.csv", LINE)
    quality = check(here, performer=performer())
    assert [figure.name for figure in quality.failed] == ["contacts lips"]


ODD = {
    "digits": (ours(start=0).replace('"start": 0', '"start": ' + "9" * 5000), "has a number th"),
    "a start beyond floats": (ours(start=10**400), "`start` is larger than any number"),
    "a weight beyond floats": (ours(frames=[[0], [10**400]]), "larger than any weight"),
    "a time past a day": (ours(start=1e9), "frame 0: its time is later than one day"),
}


@pytest.mark.parametrize("name", ODD)
def test_numbers_that_no_animation_has_are_told(name, tmp_path):
    content, message = ODD[name]
    with pytest.raises(AnimationError, match=message):
        read_animation(written(tmp_path, "a.json", content))


def test_frames_apart_too_unevenly_are_refused_and_seldom_ones_have_a_rate():
    values = np.zeros((4, 1))
    apart = Recording("x", np.array([0.0, 0.01, 0.02, 80_000]), ("open",), values)
    with pytest.raises(AnimationError, match="x: has 4 frames over 80000 s, too uneven"):
        fit(apart, performer(), LINE)
    slow = Recording("x", np.array([0.0, 1000, 2000, 3000]), ("open",), values)
    assert fit(slow, performer(), LINE)[0].fps == pytest.approx(0.001)
