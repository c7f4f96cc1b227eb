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
from lipsync_lang.rigs.channel import Channel

SCHEDULE = ll.Schedule(
    ("M", "AA1", "P", "OW1", "_"), (0, 0.1, 0.5, 0.6, 1.0, 1.2), notation="arpabet"
)


def from_vrma(content, _):
    """Return the times of the sound and weights of each expression: {name: (times, weights)}."""
    (length,) = struct.unpack_from("<I", content, 12)
    document, data = json.loads(content[20 : 20 + length]), content[28 + length :]
    extension = document["extensions"]["VRMC_vrm_animation"]
    assert extension["specVersion"] == "1.0"
    named = {
        node["node"]: name
        for own in extension["expressions"].values()
        for name, node in own.items()
    }

    def values(number):
        row = document["accessors"][number]
        view = document["bufferViews"][row["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3}[row["type"]]
        found = np.frombuffer(data, "<f4", row["count"] * width, view["byteOffset"])
        return found.reshape(row["count"], width).astype(float)

    (take,) = document["animations"]
    start = take["extras"]["audio_start"]
    found = {}
    for channel in take["channels"]:
        assert channel["target"]["path"] == "translation"
        sampler = take["samplers"][channel["sampler"]]
        times, places = values(sampler["input"])[:, 0], values(sampler["output"])
        assert not places[:, 1:].any()
        found[named[channel["target"]["node"]]] = (times - start, places[:, 0])
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
