"""Expressions of VRM avatars: they move shapes whose names say nothing."""

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from face_models import OPENINGS, face
from lanes import needs_plug_ins, of_plug_in
from shipped import LIBRARY
from small_models import glb

import lipsync_lang as ll
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.animations.moving_shapes import unbound
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.faces.rigs.recognise import recognise

SHAPES = ("s0", "s1", "s2")
MOUTHS = {
    "aa": {0: 0.5, 1: 0.25},
    "ih": {1: 0.5},
    "ou": {2: 1.0},
    "ee": {1: 0.75},
    "oh": {0: 0.25, 2: 0.5},
}
SCHEDULE = ll.Schedule(
    ("M", "AA1", "P", "OW1", "_"), (0, 0.1, 0.5, 0.6, 1, 1.2), notation="arpabet"
)


def expressed(mouths, **stated):
    """Return expressions by name; `stated` has further fields of them."""
    return {
        name: {
            "morphTargetBinds": [
                {"node": 0, "index": index, "weight": weight} for index, weight in own.items()
            ],
            **stated.get(name, {}),
        }
        for name, own in mouths.items()
    }


def vrm1(path, mouths=MOUTHS, shapes=SHAPES, kind="preset", **stated):
    expressions = {kind: expressed(mouths, **stated)}
    extensions = {"VRMC_vrm": {"specVersion": "1.0", "expressions": expressions}}
    return glb(path, *shapes, extensions=extensions)


def vrm0(path):
    groups = [
        {
            "name": f"Mouth {name}",
            "presetName": name,
            "binds": [{"mesh": 0, "index": n, "weight": 100 * share} for n, share in own.items()],
        }
        for name, own in zip(
            "aiueo", (MOUTHS[n] for n in ("aa", "ih", "ou", "ee", "oh")), strict=True
        )
    ]
    extension = {"blendShapeMaster": {"blendShapeGroups": groups}}
    return glb(path, *SHAPES, extensions={"VRM": extension})


def performed(path):
    return ll.resolve("english", path).perform(SCHEDULE, fps=30)


@pytest.mark.parametrize("write", [vrm1, vrm0])
def test_shapes_move_as_the_expressions_bind_them(tmp_path, write):
    animation = performed(write(tmp_path / "face.vrm"))
    poses = animation.poses[:5]
    shares = np.zeros((5, 3))
    for row, own in zip(shares, MOUTHS.values(), strict=True):
        row[[*own]] = [*own.values()]
    moved = unbound(animation)
    assert [one for one in moved.poses if one in SHAPES] == ["s0", "s1", "s2"]
    wanted = np.column_stack([animation[pose] for pose in poses]) @ shares
    shown = np.column_stack([moved[name] for name in SHAPES])
    np.testing.assert_allclose(shown, wanted, atol=1e-12)
    out = BytesIO()
    WRITERS["csv"].write(animation, out)
    assert out.getvalue().decode().splitlines()[0].startswith("time_s,s0,s1,s2")


def test_a_name_that_says_enough_needs_no_expression(tmp_path):
    face = glb(tmp_path / "plain.vrm", "aa", "ih", "ou", "ee", "oh")
    own = {name: {n: 1.0} for n, name in enumerate(MOUTHS)}
    bound = vrm1(tmp_path / "bound.vrm", own, tuple(MOUTHS))
    one, other = performed(face), performed(bound)
    np.testing.assert_array_equal(one.weights, unbound(other).weights)


@pytest.mark.parametrize(("customs", "chosen"), [(False, "vrm"), (True, "arkit")])
def test_shapes_that_no_player_moves_choose_no_pose_set(tmp_path, customs, chosen):
    """An avatar may have the shapes of a face and no expressions of them."""
    own = [name for name in OPENINGS if name.startswith("viseme")]
    shapes = (*LIBRARY.poseset("arkit").model.poses, *own)
    binds = dict(zip(MOUTHS, ({shapes.index(name): 1.0} for name in (*own, own[0])), strict=True))
    expressions = {"preset": expressed(binds)}
    if customs:
        expressions["custom"] = expressed({name: {n: 1.0} for n, name in enumerate(shapes)})
    extensions = {"VRMC_vrm": {"specVersion": "1.0", "expressions": expressions}}
    model = face(tmp_path / "face.vrm", *shapes, above=(), extensions=extensions)
    [best, *_] = recognise(LIBRARY, read_model(model))
    assert best.poseset == chosen


def bound1(stated):
    return {"VRMC_vrm": {"expressions": {"preset": {"aa": {"morphTargetBinds": stated}}}}}


def bound0(*groups):
    return {"VRM": {"blendShapeMaster": {"blendShapeGroups": [*groups]}}}


@pytest.mark.parametrize(
    "extensions",
    [
        {"VRMC_vrm": None},
        {"VRMC_vrm": {"expressions": []}},
        bound1({"node": 0}),
        bound1([{"node": 9, "index": 0}]),
        bound1([{"node": 0, "index": -1}]),
        bound1([{"node": 0, "index": 0, "weight": 0}]),
        bound0(3),
        bound0({"binds": [{"mesh": 0, "index": 0}]}),
        bound0({"presetName": "a", "binds": [{"mesh": 0, "index": 7}]}),
        bound0({"presetName": "a", "binds": [{"mesh": 0, "index": 0, "weight": "x"}]}),
    ],
)
def test_binds_of_nothing_move_nothing(tmp_path, extensions):
    (mesh,) = read_model(glb(tmp_path / "face.vrm", *SHAPES, extensions=extensions)).meshes
    assert mesh.binds == ()


@needs_plug_ins
def test_an_animation_has_the_spelling_of_the_avatar(tmp_path):
    from_vrma = of_plug_in("test_avatar_files", "from_vrma")
    custom = {"JawOpen": {0: 1.0}, "MouthFunnel": {1: 1.0}, "MouthPucker": {2: 1.0}}
    path = vrm1(tmp_path / "face.vrm", custom, ("jawOpen", "mouthFunnel", "mouthPucker"), "custom")
    animation = replace(ll.resolve("english", "arkit").perform(SCHEDULE), model=path)
    out = BytesIO()
    WRITERS["vrma"].write(animation, out)
    assert {"JawOpen", "MouthFunnel", "MouthPucker"} <= {*from_vrma(out.getvalue(), animation)}
    assert not [told for told in WRITERS["vrma"].remarks(animation) if "preset" in told]


@needs_plug_ins
def test_a_mouth_that_is_on_or_off_is_told(tmp_path):
    one = vrm1(tmp_path / "one.vrm", aa={"isBinary": True}, oh={"isBinary": False})
    (told,) = [line for line in WRITERS["vrma"].remarks(performed(one)) if "isBinary" in line]
    assert "'aa' is on or off" in told
    other = vrm1(tmp_path / "other.vrm", aa={"isBinary": [1], "overrideMouth": ["block"]})
    told = "\n".join(WRITERS["vrma"].remarks(performed(other)))
    assert "isBinary" not in told
    assert "overrideMouth" not in told


@needs_plug_ins
@pytest.mark.parametrize("override", ["block", "blend"])
def test_a_style_that_would_shut_the_mouth_is_left_out(tmp_path, override):
    from_vrma = of_plug_in("test_avatar_files", "from_vrma")
    mouths = {**MOUTHS, "happy": {2: 0.5}}
    path = vrm1(tmp_path / "face.vrm", mouths, happy={"overrideMouth": override})
    performer = ll.resolve("english", path)
    smiling = performer.perform(SCHEDULE, fps=30, styles={"happy": 1.0})
    (told,) = [one for one in WRITERS["vrma"].remarks(smiling) if "overrideMouth" in one]
    assert "'happy' shuts a mouth that speaks" in told
    out = BytesIO()
    WRITERS["vrma"].write(smiling, out)
    assert {"aa", "oh"} <= {*from_vrma(out.getvalue(), smiling)}
    assert "happy" not in from_vrma(out.getvalue(), smiling)
    resting = performer.perform(SCHEDULE, fps=30)
    assert not [one for one in WRITERS["vrma"].remarks(resting) if "overrideMouth" in one]
