"""Bones in GLB: they turn and move from where they rest."""

import math
from dataclasses import replace

import numpy as np
import pytest
from glb_files import JAW, POSES, SLIDE, parts, save, tracks, with_jaw
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.base.errors import ModelError
from lipsync_lang.faces.rigs.channel import Channel


def rotated(quaternion, vector):
    """Return vectors turned by (T, 4) quaternions."""
    xyz, w = quaternion[:, :3].astype(float), quaternion[:, 3:].astype(float)
    return vector + 2 * np.cross(xyz, np.cross(xyz, vector) + w * vector)


def test_a_bone_turns_about_its_axis_in_degrees(animate):
    animation = animate(with_jaw(), columns=JAW)
    turn = tracks(save(animation))[2]["Jaw", "rotation"]
    angle = np.radians(animation["jaw"])
    there = np.column_stack([0 * angle, np.cos(angle), np.sin(angle)])
    np.testing.assert_allclose(rotated(turn, np.array([0, 1, 0])), there, atol=1e-6)


def test_a_model_of_bones_alone_is_animated(animate):
    document = with_jaw()
    for one in document["meshes"]:
        one.pop("extras", None)
        for part in one["primitives"]:
            part.pop("targets", None)
    animation = animate(document, columns=JAW)
    assert list(tracks(save(animation))[2]) == [("Jaw", "rotation")]
    with pytest.raises(ModelError, match="no mesh has morph targets"):
        save(animate(document))


def test_what_a_model_does_not_show_is_told(animate):
    columns = (Channel("wide"), Channel("nowhere"), Channel("tail", node="Tail"), *JAW)
    animation = animate(with_jaw(), columns=columns)
    save(animation)
    assert list(WRITERS["glb"].remarks(animation)) == [
        f"{animation.model} has nothing for nowhere, Tail"
    ]
    still = replace(animation, weights=animation.weights * 0)
    assert not list(WRITERS["glb"].remarks(still))


def test_a_face_that_would_leave_its_eyes_behind_is_told_the_way_out(animate):
    document = with_jaw()
    document["nodes"].append({"name": "eyes", "mesh": 0})
    document["nodes"][0]["name"] = "Head"
    animation = animate(document, columns=(*JAW, Channel("nod", node="Head")))
    told = [*WRITERS["glb"].remarks(animation)]
    assert told[0] == f"{animation.model} has nothing for Head"
    assert "a turn of Head would leave other meshes behind" in told[1]


def test_a_bone_turns_about_the_axis_as_it_rests(animate):
    quarter = math.sqrt(0.5)  # a quarter turn about z takes x to y
    animation = animate(with_jaw(rotation=[0, 0, quarter, quarter]), columns=JAW)
    turn = tracks(save(animation))[2]["Jaw", "rotation"]
    still = np.tile([0, 1, 0], (20, 1))
    np.testing.assert_allclose(rotated(turn, np.array([1, 0, 0])), still, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(turn, axis=1), 1, atol=1e-6)


def test_a_bone_moves_from_where_it_rests(animate):
    animation = animate(with_jaw(translation=[1, 2, 3]), columns=SLIDE)
    _, _, found = tracks(save(animation))
    expected = [1, 2, 3] + animation["jaw"][:, None] * [0, -0.5, 1]
    assert set(found) == {("Jaw", "translation")}
    np.testing.assert_allclose(found["Jaw", "translation"], expected, atol=1e-6)


def test_two_channels_may_turn_and_move_one_bone(animate):
    columns = (
        *JAW[1:],
        Channel("side", node="Jaw", rotation=(0, 1, 0)),
        Channel("out", node="Jaw", translation=(1, 0, 0)),
        Channel("down", node="Jaw", translation=(0, 1, 0)),
    )
    animation = animate(with_jaw(), columns=columns)
    _, _, found = tracks(save(animation))
    moved = np.column_stack([animation["out"], animation["down"], np.zeros(20)])
    np.testing.assert_allclose(found["Jaw", "translation"], moved, atol=1e-6)
    assert found["Jaw", "rotation"].shape == (20, 4)


def matrix_of(quaternion, scale, translation):
    axes = [rotated(np.array([quaternion]), np.eye(3)[n])[0] * scale[n] for n in range(3)]
    return [*axes[0], 0, *axes[1], 0, *axes[2], 0, *translation, 1]


@given(
    st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: math.hypot(*q) > 0.1),
    st.lists(st.floats(0.1, 10), min_size=3, max_size=3),
    st.booleans(),
)
def test_a_bone_with_a_matrix_is_parted(quaternion, scale, mirrored):
    from lipsync_lang.faces.rigs.transforms import parts as part

    unit = np.array(quaternion) / math.hypot(*quaternion)
    scale[0] *= -1 if mirrored else 1
    matrix = np.reshape(matrix_of(unit, scale, [1, 2, 3]), (4, 4))
    found = part(matrix)
    again = matrix_of(found["rotation"], found["scale"], found["translation"])
    np.testing.assert_allclose(np.ravel(matrix), again, atol=1e-9)


def test_a_parted_bone_is_kept_in_meaning(animate):
    matrix = matrix_of(np.array([0, 0, math.sqrt(0.5), math.sqrt(0.5)]), [2, 2, 2], [1, 2, 3])
    animation = animate(with_jaw(matrix=matrix, extras={"a": 1}), columns=JAW)
    document, _ = parts(save(animation))
    node = document["nodes"][2]
    assert "matrix" not in node
    assert node["extras"] == {"a": 1}
    assert node["translation"] == [1, 2, 3]
    np.testing.assert_allclose(node["scale"], [2, 2, 2])
    untouched, _ = parts(save(animate(with_jaw(matrix=matrix))))
    assert untouched["nodes"][2]["matrix"] == matrix


SHEARED = [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
FLAT = [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


@pytest.mark.parametrize(
    ("pose", "columns", "message"),
    [
        ({"matrix": SHEARED}, JAW, "node 'Jaw' is sheared or flat, .*; apply its transform"),
        ({"matrix": FLAT}, SLIDE, "node 'Jaw' is sheared or flat, .*; apply its transform"),
        ({"matrix": [1]}, JAW, "matrix of node 'Jaw': not a list of 16 numbers; .* export"),
        ({"matrix": "x"}, JAW, "matrix of node 'Jaw': not a list of 16 numbers; .* export"),
        ({"rotation": [0, 0, 0, 0]}, JAW, "rotation of node 'Jaw': is 0 throughout; .* export"),
        ({"rotation": [0, 0, True, 1]}, JAW, "rotation of node 'Jaw': not a list of 4 numbers"),
        ({"translation": [0, None, 1]}, SLIDE, "translation of node 'Jaw': not a list of 3"),
        ({"mesh": 0, "weights": [1]}, POSES, "weights of node 2: not a list of 3 numbers"),
    ],
)
def test_bones_that_cannot_be_driven_are_told(pose, columns, message, animate):
    with pytest.raises(ModelError, match=rf"model\.glb: {message}"):
        save(animate(with_jaw(**pose), columns=columns))
