"""VRM animations: a GLB of expressions, read as its extension says."""

import json
import struct
from dataclasses import replace

import numpy as np
import pytest
from file_bytes import bytes_of

import lipsync_lang as ll
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.animations.keys import ERROR
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.transforms import HeadTurn
from lipsync_lang.plugins.programs.vrma import HUMANOID, TURN_ERROR

SCHEDULE = ll.Schedule(
    ("M", "AA1", "P", "OW1", "_"), (0, 0.1, 0.5, 0.6, 1.0, 1.2), notation="arpabet"
)


def from_vrma(content, _):
    """Return times of the sound and values of each expression and bone: {name: (times, values)}."""
    (length,) = struct.unpack_from("<I", content, 12)
    document, data = json.loads(content[20 : 20 + length]), content[28 + length :]
    extension = document["extensions"]["VRMC_vrm_animation"]
    assert extension["specVersion"] == "1.0"
    bones = extension.get("humanoid", {}).get("humanBones", {})
    named = {
        node["node"]: name
        for own in (bones, *extension["expressions"].values())
        for name, node in own.items()
    }

    def values(number):
        row = document["accessors"][number]
        view = document["bufferViews"][row["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[row["type"]]
        found = np.frombuffer(data, "<f4", row["count"] * width, view["byteOffset"])
        return found.reshape(row["count"], width).astype(float)

    (take,) = document["animations"]
    start = take["extras"]["audio_start"]
    found = {}
    for channel in take["channels"]:
        sampler, target = take["samplers"][channel["sampler"]], channel["target"]
        times, shown = values(sampler["input"])[:, 0], values(sampler["output"])
        if target["node"] not in [bone["node"] for bone in bones.values()]:
            assert target["path"] == "translation"
            assert not shown[:, 1:].any()
            shown = shown[:, 0]
        found[named[target["node"]]] = (times - start, shown)
    return found


def as_vrma(content, animation):
    found = from_vrma(content, animation)
    assert len(found) == len(animation.poses)
    for pose, own in zip(animation.poses, found.values(), strict=True):
        shown = np.interp(animation.times, *own)
        np.testing.assert_allclose(shown, animation[pose].clip(0, 1), atol=ERROR + 1e-4)


READ_BACK = {"vrma": as_vrma}


def test_mouths_of_vrm_are_presets_and_other_shapes_are_custom():
    animation = ll.resolve("english", "vrm").perform(SCHEDULE)
    content = bytes_of("vrma", animation)
    as_vrma(content, animation)
    (length,) = struct.unpack_from("<I", content, 12)
    document = json.loads(content[20 : 20 + length])
    kinds = document["extensions"]["VRMC_vrm_animation"]["expressions"]
    assert [*kinds] == ["preset"]
    assert [*kinds["preset"]] == ["aa", "ih", "ou", "ee", "oh"]
    own = bytes_of("vrma", ll.resolve("english", "arkit").perform(SCHEDULE))
    assert b'"custom"' in own
    assert b'"preset"' not in own


def test_a_bone_is_left_out_and_that_is_told():
    animation = ll.resolve("english", "vrm").perform(SCHEDULE)
    channels = (Channel("aa", node="Jaw", rotation=(1, 0, 0)), *animation.columns[1:])
    boned = replace(animation, channels=channels)
    assert "a .vrma has nothing for aa" in [*WRITERS["vrma"].remarks(boned)]
    assert "aa" not in from_vrma(bytes_of("vrma", boned), boned)


@pytest.mark.parametrize("keys", [None, 0.02])
def test_keys_are_joined_by_straight_lines(keys):
    animation = ll.resolve("english", "vrm").perform(SCHEDULE)
    export = replace(animation.export, key_error=keys)
    found = from_vrma(bytes_of("vrma", replace(animation, export=export)), animation)
    shown = np.interp(animation.times, *found["aa"])
    assert np.abs(shown - animation["aa"]).max() <= (keys or ERROR) + 1e-4


@pytest.mark.parametrize("name", ["vrm", "vrm0", "arkit"])
def test_the_head_turns_as_its_poses_say(name):
    animation = ll.resolve("english", name).perform(SCHEDULE, gestures="all")
    axes = {"nod": (1, 0, 0), "turn": (0, 1, 0), "tilt": (0, 0, 1), "lift": (-1, 0, 0)}
    moving = [(axes[pose], animation.poses.index(pose)) for pose in axes if pose in animation.poses]
    wanted = HeadTurn(np.array([axis for axis, _ in moving]), tuple(n for _, n in moving))
    content = bytes_of("vrma", animation)
    times, turns = from_vrma(content, animation)["head"]
    shown = np.column_stack([np.interp(animation.times, times, one) for one in turns.T])
    assert np.ptp(turns, axis=0).max() > 0.03
    np.testing.assert_allclose(shown, wanted(animation.weights), atol=TURN_ERROR + 1e-4)
    assert not any("has nothing for" in one for one in WRITERS["vrma"].remarks(animation))


def test_the_bones_that_vrm_requires_stand_upright_under_the_head():
    bones = json.loads(HUMANOID.read_text("utf-8"))
    above = {child: n for n, bone in enumerate(bones) for child in bone.get("children", ())}
    places = {}
    for number, bone in enumerate(bones):
        base = places[bones[above[number]]["name"]] if number else np.zeros(3)
        places[bone["name"]] = base + bone["translation"]
    assert len(places) == 15
    assert max(places, key=lambda name: places[name][1]) == "head"
    for side in ("left", "right"):
        arm = [places[f"{side}{part}"] for part in ("UpperArm", "LowerArm", "Hand")]
        assert len({place[1] for place in arm}) == 1
        assert (arm[2][0] > arm[0][0]) == (side == "left")
        assert places[f"{side}Foot"][1] > 0


def test_without_gestures_there_is_no_humanoid():
    animation = ll.resolve("english", "vrm").perform(SCHEDULE)
    assert b"humanoid" not in bytes_of("vrma", animation)


@pytest.mark.parametrize("character", ["vrm", "vrm0"])
def test_the_mouths_of_both_versions_are_presets(character):
    animation = ll.resolve("english", character).perform(SCHEDULE, fps=30)
    content = bytes_of("vrma", animation)
    (length,) = struct.unpack_from("<I", content, 12)
    extension = json.loads(content[20 : 20 + length])["extensions"]["VRMC_vrm_animation"]
    assert list(extension["expressions"]) == ["preset"]
    assert list(extension["expressions"]["preset"]) == ["aa", "ih", "ou", "ee", "oh"]
    assert not [told for told in WRITERS["vrma"].remarks(animation) if "preset of VRM" in told]


def test_poses_that_no_avatar_has_as_presets_are_named_as_such():
    animation = ll.resolve("english", "facefx").perform(SCHEDULE, fps=30)
    (told,) = [one for one in WRITERS["vrma"].remarks(animation) if "preset of VRM" in one]
    assert told.endswith("take a pose set of presets")
