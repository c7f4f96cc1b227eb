"""VRM animations, motions of Live2D and skeletons of Spine, read by other programs."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import test_avatar_expressions
from lanes import full
from test_consumers import HERE, WARNING, found, run

import lipsync_lang as ll
from lipsync_lang.animations.held import held
from lipsync_lang.animations.keys import ERROR
from lipsync_lang.animations.moving_shapes import unbound

pytestmark = full

SCHEDULE = ll.Schedule(
    ("HH", "AH0", "L", "OW1", "_", "P", "AA1", "F", "UW1", "M"),
    np.cumsum([0, 0.1, 0.08, 0.12, 0.2, 0.1, 0.05, 0.2, 0.07, 0.3, 0.02]),
    words=(ll.Word("hello", 0, 4), ll.Word("puff", 5, 10)),
    notation="arpabet",
)


def performed(character, keys=None, gestures=None):
    animation = ll.resolve("english", character).perform(SCHEDULE, fps=60, gestures=gestures)
    return replace(animation, export=replace(animation.export, key_error=keys))


def read(package, kind, path, times):
    node, modules = found(package)
    return run(node, HERE / "avatars.mjs", modules, kind, path, *map(str, times))


@pytest.mark.parametrize(("character", "kind"), [("vrm", "preset"), ("arkit", "custom")])
def test_three_vrm_reads_the_expressions(tmp_path, character, kind):
    animation, path = performed(character), tmp_path / "line.vrma"
    animation.save(path)
    shown = read("@pixiv/three-vrm-animation", "vrma", path, animation.timeline)
    assert [name for name, own in shown.items() if own] == [kind]
    for pose in animation.poses:
        np.testing.assert_allclose(shown[kind][pose], animation[pose], atol=ERROR + 1e-4)


@pytest.mark.parametrize("version", ["vrm1", "vrm0"])
def test_an_avatar_moves_in_three_vrm_as_in_our_own_files(tmp_path, version):
    path = getattr(test_avatar_expressions, version)(tmp_path / "face.vrm")
    animation = ll.resolve("english", path).perform(SCHEDULE, fps=60)
    animation.save(tmp_path / "face.vrma")
    shown = read("@pixiv/three-vrm-animation", "avatar", path, animation.timeline)
    moved = unbound(animation)
    wanted = np.column_stack([moved[name] for name in test_avatar_expressions.SHAPES])
    assert wanted.max(axis=0).min() > 0.1
    # Each of the expressions that share a shape has its own error.
    np.testing.assert_allclose(shown, wanted, atol=2 * ERROR)


@pytest.mark.parametrize("stated", [{}, {"isBinary": True}], ids=["plain", "binary"])
@pytest.mark.parametrize("override", ["block", "blend"])
def test_a_mouth_speaks_in_three_vrm_beside_a_style_that_would_shut_it(tmp_path, override, stated):
    mouths = {**test_avatar_expressions.MOUTHS, "happy": {2: 0.5}}
    own = {"overrideMouth": override, **stated}
    path = test_avatar_expressions.vrm1(tmp_path / "face.vrm", mouths, happy=own)
    animation = ll.resolve("english", path).perform(SCHEDULE, fps=60, styles={"happy": 1.0})
    assert animation["happy"].any()
    animation.save(tmp_path / "face.vrma")
    shown = read("@pixiv/three-vrm-animation", "avatar", path, animation.timeline)
    wanted = np.zeros((len(animation.timeline), 3))
    for pose, shares in test_avatar_expressions.MOUTHS.items():
        for shape, share in shares.items():
            wanted[:, shape] += share * animation[pose]
    assert wanted.max(axis=0).min() > 0.1
    np.testing.assert_allclose(shown, wanted, atol=2 * ERROR)


def test_three_vrm_turns_the_head_forward_by_a_nod(tmp_path):
    animation, path = performed("vrm", gestures="nod"), tmp_path / "line.vrma"
    animation.save(path)
    shown = read("@pixiv/three-vrm-animation", "vrma", path, animation.timeline)
    x, *rest = np.transpose(shown["head"])
    nodded = 2 * np.degrees(np.arcsin(x))
    assert nodded.max() > 3
    np.testing.assert_allclose(nodded, animation["nod"], atol=0.2)
    np.testing.assert_allclose(rest[:2], 0, atol=1e-6)


@pytest.mark.parametrize("gestures", [None, "all"])
def test_the_validator_of_gltf_has_no_fault_to_find_in_a_vrm_animation(tmp_path, gestures):
    node, modules = found("gltf-validator")
    path = tmp_path / "line.vrma"
    performed("vrm", gestures=gestures).save(path)
    issues = run(node, HERE / "validate.mjs", modules, path)
    assert [one for one in issues["messages"] if one["severity"] <= WARNING] == []


@pytest.mark.parametrize("keys", [None, 0.01])
@pytest.mark.parametrize("character", ["live2d", "live2d-vowels"])
def test_the_framework_of_live2d_reads_a_motion(tmp_path, character, keys):
    animation, path = performed(character, keys), tmp_path / "line.motion3.json"
    animation.save(path)
    shown = read("pixi-live2d-display", "live2d", path, animation.timeline)
    meta = json.loads(Path(path).read_text("utf-8"))["Meta"]
    assert (shown["fps"], shown["loop"]) == (60, False)
    assert shown["fades"] == [0, 0]
    counted = (meta["TotalSegmentCount"], meta["TotalPointCount"])
    assert (shown["segments"], shown["points"]) == counted
    for name, values in shown["values"].items():
        wanted = animation[name]
        if f"{name}-" in animation.poses:
            wanted = wanted - animation[f"{name}-"]
        np.testing.assert_allclose(values, wanted, atol=(keys or ERROR) + 1e-3)


def test_the_runtime_of_spine_shows_the_drawings(tmp_path):
    animation, path = performed("rhubarb"), tmp_path / "line.spine.json"
    animation.save(path)
    shapes = held(animation, "rest")
    middles = [(shape.start + shape.end) / 2 for shape in shapes]
    shown = read("@esotericsoftware/spine-core", "spine", path, middles)
    assert shown["version"].startswith("4.2.")
    assert shown["name"] == "hello puff"
    assert shown["names"] == [shape.name for shape in shapes]
