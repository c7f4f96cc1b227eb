"""Files for engines: the forms that other programs read, and refusals."""

import csv
import json
import re
from dataclasses import replace
from io import StringIO
from itertools import pairwise
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from face_models import ARKIT, OCULUS, face
from file_bytes import bytes_of
from lanes import swept
from small_models import glb

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.animations.animation_writers import WRITERS, find_writer
from lipsync_lang.animations.fixed import names
from lipsync_lang.animations.keys import ERROR, KeyedCurve
from lipsync_lang.base.errors import OutputError
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.packs.yaml.events import load_yaml
from lipsync_lang.plugins.programs.azure import AZURE_NAMES
from lipsync_lang.plugins.programs.live2d import _segments
from lipsync_lang.plugins.programs.live_link_take import fits, read_live_link

DENSE, SPARSE = 1e-5, ERROR + 1e-9

SCHEDULE = ll.Schedule(
    ("HH", "AH0", "L", "OW1", "_", "P", "AA1", "F", "UW1", "M"),
    np.cumsum([0, 0.1, 0.08, 0.12, 0.2, 0.1, 0.05, 0.2, 0.07, 0.3, 0.02]),
    words=(ll.Word("hello", 0, 4), ll.Word("p<a>&f\u0000 \U0001f600", 5, 10)),
    notation="arpabet",
    language="english",
)


def performed(character="arkit", fps=60):
    return ll.resolve("english", character).perform(SCHEDULE, fps=fps)


def remarks(name, animation):
    return list(WRITERS[name].remarks(animation))


# Reading back: seconds of the sound, and values, of each shape


def from_live_link(content, animation):
    head, *rows = csv.reader(content.decode().splitlines())
    rate = round(animation.fps)
    codes = [row[0].split(":") for row in rows]
    frames = [((int(h) * 60 + int(m)) * 60 + int(s)) * rate + float(f) for h, m, s, f in codes]
    times = np.array(frames) / animation.fps - animation.begins
    table = np.array([row[2:] for row in rows], float)
    shapes = [name[0].lower() + name[1:] for name in head[2:]]
    return {name: (times, column) for name, column in zip(shapes, table.T, strict=True)}


def first(animation):
    """First frame in files that count frames from their start."""
    return round((animation.times[0] + animation.begins) * animation.fps)


def from_azure(content, animation):
    document = json.loads(content)
    table = np.array(document["BlendShapes"])
    assert document["FrameIndex"] == first(animation)
    times = animation.times[0] + np.arange(len(table)) / 60
    listed = [*names(AZURE_NAMES).shapes, *names(AZURE_NAMES).turns]
    return {name: (times, column) for name, column in zip(listed, table.T, strict=True)}


def from_audio2face(content, animation):
    document = json.loads(content)
    table = np.array(document["weightMat"])
    assert table.shape == (document["numFrames"], document["numPoses"])
    times = animation.times[0] + (np.arange(len(table)) - first(animation)) / document["exportFps"]
    shapes = document["facsNames"]
    return {name: (times, column) for name, column in zip(shapes, table.T, strict=True)}


def from_unreal(content, animation):
    assert content.count(b"\r\n") == content.count(b"\n")
    (_, *times), *rows = csv.reader(StringIO(content.decode()))
    seconds = np.array(times, float) - animation.offset
    assert (np.diff(np.array(times, np.float32)) > 0).all(), "no time comes twice"
    return {name: (seconds, np.array(values, float)) for name, *values in rows}


def clip_of(content):
    """Clip of a Unity file, without the directive that YAML parsers may not know."""
    head, tag, start, text = content.decode("ascii").split("\n", 3)
    assert head == "%YAML 1.1"
    assert tag == "%TAG !u! tag:unity3d.com,2011:"
    assert start == "--- !u!74 &7400000"
    return load_yaml(text)["AnimationClip"]


def from_unity(content, animation):
    found = {}
    for row in clip_of(content)["m_FloatCurves"]:
        keys = row["curve"]["m_Curve"]
        times = np.array([key["time"] for key in keys]) - animation.begins
        values = np.array([key["value"] for key in keys]) / 100
        found[row["attribute"].removeprefix("blendShape.")] = times, values
    return found


def take_of(content):
    """Content of a script for Blender."""
    text = content.decode("ascii")
    compile(text, "line.py", "exec")
    return json.loads(text.split('json.loads(r"""\n')[1].split('\n"""')[0])


def from_blender(content, animation):
    take = take_of(content)
    rate = take["fps"] / take["fps_base"]
    assert rate == pytest.approx(animation.fps)
    return {
        row["names"][0]: (
            (np.array(row["frames"]) - 1) / rate - animation.offset,
            np.array(row["values"]),
        )
        for row in take["channels"]
    }


def from_smartbody(content, animation):
    found = {}
    for curve in ET.fromstring(content).findall("curves/curve"):  # noqa: S314 our own
        keys = np.array(curve.text.split(), float).reshape(-1, 4)
        assert len(keys) == int(curve.get("num_keys"))
        found[curve.get("name")] = keys[:, 0] - animation.offset, keys[:, 1]
    return found


MAYA_RATES = {"game": 15, "film": 24, "pal": 25, "ntsc": 30, "show": 48, "palf": 50, "ntscf": 60}


def from_maya(content, animation):
    """Curves of straight lines; the tests of keys read those with tangents."""
    head, *curves = re.split(r"^anim (\w+) .*$", content.decode("ascii"), flags=re.MULTILINE)
    unit = re.search(r"^timeUnit (\w+);$", head, re.MULTILINE)[1]
    rate = MAYA_RATES.get(unit, animation.fps)
    assert rate == animation.fps
    per_second = 1 if unit == "sec" else rate
    found = {}
    for name, curve in zip(curves[::2], curves[1::2], strict=True):
        keys = re.findall(r"^    (\S+) (\S+) linear linear 1 1 0;$", curve, re.MULTILINE)
        assert len(keys) == curve.count(" 1 1 0;")
        table = np.array(keys, float)
        times = table[:, 0] / per_second - 1 / animation.fps - animation.offset
        found[name] = times, table[:, 1]
    return found


def from_live2d(content, animation):
    document = json.loads(content)
    meta, found = document["Meta"], {}
    assert (document["Version"], meta["Loop"]) == (3, False)
    assert (meta["FadeInTime"], meta["FadeOutTime"]) == (0, 0)
    points = segments = 0
    for curve in document["Curves"]:
        row, at = curve["Segments"], 2
        path = [row[:2]]
        while at < len(row):
            width = {0: 2, 1: 6}[row[at]]
            path.append(row[at + width - 1 : at + width + 1])
            at, points, segments = at + width + 1, points + width // 2, segments + 1
        points += 1
        times, values = np.transpose(path)
        found[curve["Id"]] = (times - animation.begins, values)
    totals = (meta["CurveCount"], meta["TotalSegmentCount"], meta["TotalPointCount"])
    assert totals == (len(found), segments, points)
    return found


def test_a_rise_between_level_ends_is_rounded_in_live2d():
    zero = np.zeros(3)
    times, values = np.arange(3.0), np.array([0, 1, 1])
    curve = KeyedCurve("jaw", np.arange(3), times, values, zero, zero, cubic=True)
    row, segments, points = _segments(curve, 1 / 60)
    assert row[:9] == [0, 0, 1, 0.333333, 0, 0.666667, 1, 1, 1]
    assert row[9:] == [0, 2, 1]
    assert (segments, points) == (2, 5)


READERS = {
    "audio2face": (from_audio2face, DENSE),
    "azure": (from_azure, DENSE),
    "blender": (from_blender, SPARSE),
    "live-link-face": (from_live_link, DENSE),
    "live2d": (from_live2d, SPARSE),
    "maya": (from_maya, SPARSE),
    "smartbody": (from_smartbody, SPARSE),
    "unity": (from_unity, SPARSE),
    "unreal": (from_unreal, DENSE),
}
"""Reader of a writer's file, and the largest deviation it may show."""

every_engine = pytest.mark.parametrize("name", READERS)


def shown(name, content, animation):
    """Return the values of a file at each frame of the animation, (T, P); 0 for missing shapes."""
    read, _ = READERS[name]
    curves = read(content, animation)
    nothing = (animation.times, np.zeros(len(animation.times)))
    found = [np.interp(animation.times, *curves.get(pose, nothing)) for pose in animation.poses]
    return np.column_stack(found)


def holds(name):
    def check(content, animation):
        curves = READERS[name][0](content, animation)
        present = [pose in curves for pose in animation.poses]
        assert any(present)
        strays = np.abs(shown(name, content, animation) - animation.weights)[:, present]
        assert strays.max() <= READERS[name][1]

    return check


READ_BACK = {name: holds(name) for name in READERS}


@every_engine
@pytest.mark.parametrize("offset", swept([0.0, 0.1, 3600.0, 1.0037], quick=[1.0037]))
def test_every_shape_is_where_it_was_performed(name, offset):
    animation = replace(performed(), export=ExportSettings(offset=offset))
    for one in (animation, animation.cut()):
        content = bytes_of(name, one)
        curves = READERS[name][0](content, one)
        assert set(one.poses) <= set(curves)
        assert np.abs(shown(name, content, one) - one.weights).max() <= READERS[name][1]


@every_engine
def test_an_error_of_lines_that_is_asked_for_is_kept(name):
    _, suits = READERS[name]
    sparse = suits == SPARSE or name == "unreal"
    for error in (0.0, 1e-3, 0.05):
        animation = replace(performed(), export=ExportSettings(key_error=error, key_lines=True))
        strays = np.abs(shown(name, bytes_of(name, animation), animation) - animation.weights)
        assert strays.max() <= (max(error, DENSE) + 1e-9 if sparse else DENSE)


@every_engine
def test_a_suffix_names_the_format(name, tmp_path):
    path = tmp_path / f"line{WRITERS[name].suffix}"
    assert find_writer(path).name == name


@every_engine
def test_numbers_and_names_are_written_without_a_locale(name):
    content = bytes_of(name, performed()).decode("utf-8")
    assert "nan" not in content.lower().replace("nan.", "")
    assert "-0.000000" not in content
    assert content.endswith("\n")


DELAYS = {"audio2face", "azure", "live-link-face", "live2d", "unity"}
"""Formats without time below zero."""


@every_engine
def test_it_is_said_where_the_sound_begins_later_than_asked(name):
    animation = performed()
    told = [text for text in remarks(name, animation) if "sound begins" in text]
    assert len(told) == (name in DELAYS)
    assert all(f"{animation.begins:.3f} s" in text for text in told)
    assert not remarks(name, animation.cut())
    assert not remarks(name, replace(animation, export=ExportSettings(offset=1.0)))


def with_bone(animation):
    """Return an animation with shapes and a moving bone."""
    columns = (*animation.columns, Channel("nod", node="neck", rotation=(1, 0, 0)))
    weights = np.column_stack([animation.weights, np.linspace(0, 8, len(animation.times))])
    poses = (*animation.poses, "nod")
    return replace(animation, poses=poses, weights=weights, channels=columns, model=None)


@pytest.mark.parametrize("name", [name for name in READERS if name != "unreal"])
def test_bones_are_left_out_and_that_is_told(name):
    animation = with_bone(performed().cut())
    assert remarks(name, animation) == [f"{TITLES[name]} has nothing for nod"]
    content = bytes_of(name, animation)
    assert "nod" not in READERS[name][0](content, animation)


TITLES = {
    "audio2face": "Audio2Face",
    "azure": "Azure",
    "blender": "Blender",
    "live-link-face": "Live Link Face",
    "live2d": "Live2D",
    "maya": "Maya",
    "smartbody": "SmartBody",
    "unity": "Unity",
}


@pytest.mark.parametrize("name", ["audio2face", "blender", "live2d", "maya", "smartbody", "unity"])
def test_bones_alone_are_refused(name):
    animation = with_bone(performed())
    alone = replace(
        animation,
        poses=animation.poses[-1:],
        channels=animation.channels[-1:],
        weights=animation.weights[:, -1:],
    )
    with pytest.raises(OutputError, match="only bones move"):
        bytes_of(name, alone)


# Formats with shapes of their own


@pytest.mark.parametrize("name", ["azure", "live-link-face"])
def test_a_face_without_those_shapes_is_told_who_has_them(name):
    with pytest.raises(OutputError, match=r"ARKit's shapes alone .* and here are open, W, "):
        bytes_of(name, performed("facefx"))


@pytest.mark.parametrize("name", ["azure", "live-link-face"])
def test_what_moves_and_has_no_shape_there_is_told(name):
    animation = performed().cut()
    odd = replace(animation, channels=(), poses=("chin", *animation.poses[1:]))
    assert remarks(name, odd) == [f"{TITLES[name]} has nothing for chin"]
    assert not shown(name, bytes_of(name, odd), odd)[:, 0].any()


@pytest.mark.parametrize("name", ["azure", "live-link-face"])
def test_shapes_are_found_in_any_spelling_and_on_both_sides(name):
    animation = performed()
    one = animation["mouthPressLeft"]
    loud = replace(
        animation,
        poses=("JAW_OPEN", "Mouth_Press", "mouth.roll.lower"),
        weights=np.column_stack([animation["jawOpen"] * 5, one, one - 0.2]),
        channels=(),
    )
    curves = READERS[name][0](bytes_of(name, loud), loud)
    times = loud.times
    for side in ("mouthPressLeft", "mouthPressRight"):
        np.testing.assert_allclose(np.interp(times, *curves[side]), one, atol=DENSE)
    assert max(curves["jawOpen"][1]) == 1, "weights are clipped"
    assert min(curves["mouthRollLower"][1]) == 0


@pytest.mark.parametrize("name", ["azure", "live-link-face"])
def test_of_two_sides_for_one_shape_the_larger_counts(name):
    animation = performed()
    opened, pressed = animation["jawOpen"], animation["mouthPressLeft"]
    weights = np.column_stack([opened, pressed])
    both = replace(animation, poses=("jawOpenLeft", "jawOpenRight"), weights=weights, channels=())
    curves = READERS[name][0](bytes_of(name, both), both)
    found = np.interp(both.times, *curves["jawOpen"])
    np.testing.assert_allclose(found, np.maximum(opened, pressed), atol=DENSE)
    assert not any(values.any() for key, (_, values) in curves.items() if "eye" in key)


def test_azure_has_sixty_frames_a_second():
    with pytest.raises(OutputError, match=r"is 23\.976; perform it with `fps=60`"):
        bytes_of("azure", performed(fps=23.976))


def test_azure_has_55_numbers_a_frame():
    document = json.loads(bytes_of("azure", performed()))
    assert document["FrameIndex"] == 0
    assert {len(row) for row in document["BlendShapes"]} == {55}


def test_a_take_has_the_columns_of_the_app():
    head, first, *_ = bytes_of("live-link-face", performed()).decode().split("\n")
    columns = head.split(",")
    assert columns[:3] == ["Timecode", "BlendShapeCount", "EyeBlinkLeft"]
    assert head.count("MouthPucker,MouthRight,MouthLeft,MouthSmileLeft") == 1
    assert head.count("JawForward,JawRight,JawLeft,JawOpen") == 1
    assert columns[-9:-6] == ["HeadYaw", "HeadPitch", "HeadRoll"]
    assert len(columns) == len(set(columns)) == 63
    assert first.startswith("00:00:00:00.000,61,0.000000,")


@pytest.mark.parametrize("offset", [0.0, 36000.0, 59.99])
def test_our_own_reader_takes_a_take_for_what_it_is(offset, tmp_path):
    animation = replace(performed(), export=ExportSettings(offset=offset))
    content = bytes_of("live-link-face", animation)
    assert fits(content)
    recording = read_live_link(tmp_path / "take.csv", content)
    np.testing.assert_allclose(recording.times, animation.times - animation.times[0], atol=1e-5)
    columns = [recording.names.index(pose) for pose in animation.poses]
    np.testing.assert_allclose(recording.values[:, columns], animation.weights, atol=DENSE)


def test_a_take_has_the_turns_of_the_head_in_radians(tmp_path):
    animation = ll.resolve("english", "arkit").perform(SCHEDULE, gestures="all")
    degrees = {"nod": 4, "lift": 1, "turn": -7, "tilt": 2}
    for pose, most in degrees.items():
        animation[pose][:] = most * np.sin(animation.times)
    recording = read_live_link(tmp_path / "take.csv", bytes_of("live-link-face", animation))
    angles = {"headYaw": -7, "headPitch": 4 - 1, "headRoll": 2}
    for name, most in angles.items():
        shown = np.degrees(recording.values[:, recording.names.index(name)])
        # angles add up but for the turns of one another's axes
        np.testing.assert_allclose(shown, most * np.sin(animation.times), atol=0.5)
    assert not recording.values[:, -6:].any(), "eyes do not turn"
    assert not any("has nothing for" in told for told in remarks("live-link-face", animation))


@pytest.mark.parametrize(
    ("seconds", "fps", "code"),
    [
        (0.25, 60, "00:00:00:15.000"),
        (3661.5, 30, "01:01:01:15.000"),
        (1 + 1 / 120, 60, "00:00:01:00.500"),
        (1000 * 1001 / 24000, 24000 / 1001, "00:00:41:16.000"),
        (0.9999999, 25, "00:00:01:00.000"),
    ],
)
def test_timecodes_count_frames_and_thousandths_of_one(seconds, fps, code):
    animation = performed(fps=fps).cut()
    content = bytes_of(
        "live-link-face", replace(animation, export=ExportSettings(offset=seconds))
    ).decode()
    assert content.split("\n")[1].split(",")[0] == code


# Unity


CLIP = [
    "m_ObjectHideFlags",
    "m_CorrespondingSourceObject",
    "m_PrefabInstance",
    "m_PrefabAsset",
    "m_Name",
    "serializedVersion",
    "m_Legacy",
    "m_Compressed",
    "m_UseHighQualityCurve",
    "m_RotationCurves",
    "m_CompressedRotationCurves",
    "m_EulerCurves",
    "m_PositionCurves",
    "m_ScaleCurves",
    "m_FloatCurves",
    "m_PPtrCurves",
    "m_SampleRate",
    "m_WrapMode",
    "m_Bounds",
    "m_ClipBindingConstant",
    "m_AnimationClipSettings",
    "m_EditorCurves",
    "m_EulerEditorCurves",
    "m_HasGenericRootTransform",
    "m_HasMotionFloatCurves",
    "m_Events",
]
"""The fields of a clip as Unity 2019 stores it, in order."""

SETTINGS = [
    "serializedVersion",
    "m_AdditiveReferencePoseClip",
    "m_AdditiveReferencePoseTime",
    "m_StartTime",
    "m_StopTime",
    "m_OrientationOffsetY",
    "m_Level",
    "m_CycleOffset",
    "m_HasAdditiveReferencePose",
    "m_LoopTime",
    "m_LoopBlend",
    "m_LoopBlendOrientation",
    "m_LoopBlendPositionY",
    "m_LoopBlendPositionXZ",
    "m_KeepOriginalOrientation",
    "m_KeepOriginalPositionY",
    "m_KeepOriginalPositionXZ",
    "m_HeightFromFeet",
    "m_Mirror",
]

KEY = [
    "serializedVersion",
    "time",
    "value",
    "inSlope",
    "outSlope",
    "tangentMode",
    "weightedMode",
    "inWeight",
    "outWeight",
]


def test_a_clip_has_the_fields_that_unity_stores():
    animation = performed(fps=23.976)
    clip = clip_of(bytes_of("unity", animation))
    assert list(clip) == CLIP
    assert list(clip["m_AnimationClipSettings"]) == SETTINGS
    assert clip["m_SampleRate"] == pytest.approx(24000 / 1001)
    stop = clip["m_AnimationClipSettings"]["m_StopTime"]
    assert stop == pytest.approx(animation.timeline[-1], abs=1e-6)
    assert [row["attribute"] for row in clip["m_FloatCurves"]] == [
        f"blendShape.{pose}" for pose in animation.poses
    ]
    for row in clip["m_FloatCurves"]:
        assert list(row) == ["curve", "attribute", "path", "classID", "script"]
        assert (row["path"], row["classID"], row["script"]) == (None, 137, {"fileID": 0})
        assert row["curve"].items() >= {"m_PreInfinity": 2, "m_PostInfinity": 2}.items()
        assert all(list(key) == KEY for key in row["curve"]["m_Curve"])


def test_slopes_are_those_of_the_lines_between_keys():
    for row in clip_of(bytes_of("unity", performed()))["m_FloatCurves"]:
        keys = row["curve"]["m_Curve"]
        assert {key["tangentMode"] for key in keys} == {69}, "broken, and linear on both sides"
        assert keys[0]["inSlope"] == keys[-1]["outSlope"] == 0
        for one, then in pairwise(keys):
            rise = (then["value"] - one["value"]) / (then["time"] - one["time"])
            assert one["outSlope"] == then["inSlope"] == pytest.approx(rise, rel=1e-6, abs=1e-6)


def test_a_clip_names_the_shapes_of_the_model_mesh_by_mesh(tmp_path):
    animation = replace(performed(), channels=())
    one = glb(tmp_path / "one.glb", "JAW_OPEN", "Mouth_Press")
    two = glb(tmp_path / "two.glb", Head=["jawOpen", "frown"], Teeth=["jawOpen"])

    def bound(model):
        rows = clip_of(bytes_of("unity", replace(animation, model=model)))["m_FloatCurves"]
        return [(row["path"], row["attribute"]) for row in rows]

    assert bound(one) == [(None, "blendShape.JAW_OPEN"), (None, "blendShape.Mouth_Press")]
    assert bound(two) == [("Head", "blendShape.jawOpen"), ("Teeth", "blendShape.jawOpen")]


def test_a_clip_follows_the_nodes_of_the_model_and_leaves_still_eyes_out(tmp_path):
    model = face(
        tmp_path / "eyes.glb",
        "jawOpen",
        "mouthFunnel",
        meshes=("Wolf3D_Head", "Eye"),
        still={"Eye"},
    )
    rows = clip_of(bytes_of("unity", replace(performed(), model=model)))["m_FloatCurves"]
    assert {row["path"] for row in rows} == {"Armature/Wolf3D_Head"}
    one = face(tmp_path / "one.glb", "jawOpen", above=("Root", "Body"), meshes=("Face",))
    rows = clip_of(bytes_of("unity", replace(performed(), model=one)))["m_FloatCurves"]
    assert [row["path"] for row in rows] == ["Root/Body/Face"]


@pytest.mark.parametrize(
    ("above", "beside", "path"),
    [((), (), None), ((), ("Lamp",), "Face"), (("Armature",), ("Lamp",), "Armature/Face")],
)
def test_a_clip_finds_a_face_at_the_top_of_a_model(above, beside, path, tmp_path):
    chain = [{"name": name, "children": [n + 1]} for n, name in enumerate(above)]
    nodes = [*chain, {"name": "Face", "mesh": 0}, *({"name": name} for name in beside)]
    model = face(tmp_path / "x.glb", "jawOpen", above=above, meshes=("Head",), nodes=nodes)
    rows = clip_of(bytes_of("unity", replace(performed(), model=model)))["m_FloatCurves"]
    assert {row["path"] for row in rows} == {path}


# Files of bare columns


HEADS = {
    "oculus": OCULUS,
    "arkit": tuple(f"blendShape1.{name}" for name in ARKIT),
    "vrm": ("あ", "い", "う", "え", "お"),
}


@pytest.mark.parametrize("poseset", HEADS)
def test_bare_columns_have_the_names_of_the_model(poseset, tmp_path):
    shapes = HEADS[poseset]
    model = face(tmp_path / "x.glb", *shapes, meshes=("Head", "Teeth"))
    animation = replace(ll.resolve("english", poseset).perform(SCHEDULE), model=model)
    told = json.loads(bytes_of("json", animation))
    table = [*csv.reader(bytes_of("csv", animation).decode().splitlines())]
    curves = [*csv.reader(bytes_of("unreal", animation).decode().splitlines())]
    assert table[0] == ["time_s", *told["poses"]]
    assert [row[0] for row in curves[1:]] == told["poses"]
    clip = clip_of(bytes_of("unity", animation))["m_FloatCurves"]
    moving = {row["attribute"].removeprefix("blendShape.") for row in clip}
    assert len(moving) >= 5
    assert moving == set(told["poses"]) & set(shapes)


def test_a_column_of_two_shapes_is_written_twice_and_two_of_one_shape_once(tmp_path):
    model = face(tmp_path / "x.glb", "smileLeft", "smileRight", "jaw", meshes=("Head", "Teeth"))
    columns = (
        Channel("smile"), Channel("jawOpen", ("jaw",), "Head"), Channel("low", ("jaw",), "Teeth"),
        Channel("b"),
    )  # fmt: skip
    weights = np.array([[0.1, 0.2, 0.3, 0.4], [0.4, 0.3, 0.2, 0.1]])
    animation = Animation(
        np.arange(2) / 30, tuple(one.name for one in columns), weights, 30, SCHEDULE,
        channels=columns, model=model,
    )  # fmt: skip
    told = json.loads(bytes_of("json", animation))
    assert dict(zip(told["poses"], zip(*told["frames"], strict=True), strict=True)) == {
        "smileLeft": (0.1, 0.4), "smileRight": (0.1, 0.4), "jaw": (0.3, 0.3), "b": (0.4, 0.1),
    }  # fmt: skip


def test_a_rig_may_say_the_path():
    animation = performed()
    channels = tuple(Channel(pose, mesh="Body/Face") for pose in animation.poses)
    clip = clip_of(bytes_of("unity", replace(animation, channels=channels)))
    assert {row["path"] for row in clip["m_FloatCurves"]} == {"Body/Face"}


@pytest.mark.parametrize(
    "name", ["口: 開", "no", "yes", "- a", "x # y", 'a"b\\c', "\U0001f600", "null", "12", "a "]
)
def test_names_that_yaml_would_misread_are_quoted(name):
    animation = performed()
    channels = tuple(Channel(name, mesh=name) for _ in animation.poses[:1])
    few = replace(animation, poses=(name,), channels=channels, weights=animation.weights[:, :1])
    words = replace(SCHEDULE, words=(ll.Word(name, 0, 1),))
    clip = clip_of(bytes_of("unity", replace(few, schedule=words)))
    [row] = clip["m_FloatCurves"]
    assert row["path"] == name
    assert row["attribute"] == f"blendShape.{name}"
    assert clip["m_Name"] == name.strip()


# Unreal Engine


def test_a_curve_table_has_a_row_for_each_curve_and_times_of_the_sound():
    animation = performed()
    rows = list(csv.reader(StringIO(bytes_of("unreal", animation).decode())))
    assert [row[0] for row in rows] == ["Name", *animation.poses]
    assert {len(row) for row in rows} == {1 + len(animation.times)}
    assert float(rows[0][1]) == pytest.approx(animation.times[0])


def test_names_that_unreal_does_not_tell_apart_are_refused():
    animation = performed()
    poses = ("Open", "open", *animation.poses[2:])
    with pytest.raises(OutputError, match="does not distinguish Open and open; rename one"):
        bytes_of("unreal", replace(animation, poses=poses, channels=()))


def test_a_name_may_hold_what_parts_cells():
    animation = performed()
    poses = ('a, "b"', *animation.poses[1:])
    odd = replace(animation, poses=poses, channels=())
    assert 'a, "b"' in from_unreal(bytes_of("unreal", odd), odd)


# Audio2Face


def test_audio2face_names_the_shapes_as_they_are():
    document = json.loads(bytes_of("audio2face", performed("facefx", 24)))
    assert list(document) == ["exportFps", "numPoses", "numFrames", "facsNames", "weightMat"]
    assert document["exportFps"] == 24
    assert document["facsNames"][0] == "open"


def test_audio2face_counts_frames_as_slow_as_they_are():
    animation = replace(performed(fps=23.976), export=ExportSettings(offset=1.0))
    document = json.loads(bytes_of("audio2face", animation))
    assert document["exportFps"] == pytest.approx(24000 / 1001)
    rows = document["weightMat"]
    assert document["numFrames"] == len(rows) == 24 + round(animation.times[-1] * 24000 / 1001) + 1
    assert not np.any(rows[: 24 + round(animation.times[0] * 24000 / 1001)])


# SmartBody


def test_words_are_marked_where_they_begin_and_end():
    animation = replace(performed("facefx"), export=ExportSettings(offset=0.5))
    text = ET.fromstring(bytes_of("smartbody", animation)).find("speech/text")  # noqa: S314 our own
    marks = text.findall("sync")
    assert [mark.get("id") for mark in marks] == ["T0", "T1", "T2", "T3"]
    times = SCHEDULE.times[[0, 4, 5, 10]] + 0.5
    np.testing.assert_allclose([float(mark.get("time")) for mark in marks], times, atol=5e-4)
    assert marks[0].tail == "hello"
    assert marks[2].tail == "p<a>&f\ufffd \U0001f600"


# Blender


def test_a_script_knows_other_spellings_and_those_of_the_model(tmp_path):
    animation = performed()
    model = glb(tmp_path / "face.glb", "JAW_OPEN", "mouthPress_L")
    rows = take_of(bytes_of("blender", replace(animation, model=model)))["channels"]
    called = {row["names"][0]: row["names"] for row in rows}
    assert called["jawOpen"] == ["jawOpen", "JAW_OPEN"]
    assert called["mouthPressLeft"] == ["mouthPressLeft", "mouthPress_L"]


def test_a_script_runs_nothing_of_a_name():
    evil = '"""\nimport os\nr"""\\'
    animation = performed()
    odd = replace(animation, poses=(evil, *animation.poses[1:]), channels=())
    content = bytes_of("blender", odd)
    assert take_of(content)["channels"][0]["names"] == [evil]
    assert content.count(b"import os") == 1, "and that is within the text"
    assert b"\nimport os" not in content


def test_the_sound_begins_at_the_first_frame_of_a_scene():
    assert b"sound begins at frame 1:" in bytes_of("blender", performed())
    late = replace(performed(fps=24), export=ExportSettings(offset=1.0))
    assert b"sound begins at frame 25:" in bytes_of("blender", late)
    take = take_of(bytes_of("blender", late))
    assert take["end"] == pytest.approx(1 + (1 + late.times[-1]) * 24, abs=1)
    assert min(take["channels"][0]["frames"]) == 19


def test_a_scene_is_long_enough_and_counts_slow_frames_as_slow():
    animation = replace(performed(fps=23.976), export=ExportSettings(offset=1.01))
    take = take_of(bytes_of("blender", animation))
    last = max(frame for row in take["channels"] for frame in row["frames"])
    assert last <= take["end"] < last + 1
    assert (take["fps"], take["fps_base"]) == (24, pytest.approx(1.001))


def test_a_long_title_ends_without_a_space_in_every_engine():
    long = ll.Word(" ".join(["wordy"] * 20), 0, 10)
    title = replace(performed(), schedule=replace(SCHEDULE, words=(long,))).title
    assert title.endswith("wordy…")
