"""Faces of pages: points as in the pictures, and remarks on parts that a page leaves out."""

import json
import os
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from glb_files import document_of, mesh, model_of
from lanes import full
from places import TESTS
from test_line_page import STATIC, data_of, node, performed
from test_video import boned, textured

from lipsync_lang.render.model.camera import close_up, framed
from lipsync_lang.render.staging import staged, sweep
from lipsync_lang.studio.face_data import page_scene
from lipsync_lang.studio.line_page import line_page

BROWSER = TESTS / "browser"


def shipped(_):
    return performed("facefx")


def turned(tmp_path):
    return boned(tmp_path, 0.0, 90.0, 45.0)


def hung(tmp_path):
    """Return a face bound to a bone that turns and moves."""
    animation = turned(tmp_path)
    (jaw,) = animation.channels
    channels = (jaw, jaw._replace(name="slide", rotation=None, translation=(0.0, 0.5, 1.0)))
    weights = np.hstack([animation.weights, animation.weights / 90])
    return replace(animation, poses=("jaw", "slide"), channels=channels, weights=weights)


@pytest.mark.parametrize("make", [shipped, turned, hung])
def test_a_page_moves_the_points_of_the_pictures(make, tmp_path):
    animation = make(tmp_path)
    path = tmp_path / "line.html"
    path.write_text(line_page(animation), "utf-8")
    scene = staged(animation)
    begins = float(animation.times[0]) - float(animation.timeline[0])
    seconds = np.linspace(*animation.times[[0, -1]], 5).tolist()
    told = node(BROWSER / "points.mjs", STATIC, path, *seconds)
    size = float(np.ptp(scene.rest))
    for moment, points in zip(seconds, told, strict=True):
        expected = scene.points(moment - begins)
        np.testing.assert_allclose(np.reshape(points, (-1, 3)), expected, atol=2e-4 * size)


def test_primitives_that_touch_share_their_points_on_the_page(tmp_path):
    animation = shipped(tmp_path)
    path = tmp_path / "line.html"
    path.write_text(line_page(animation), "utf-8")
    scene = staged(animation)
    begins = float(animation.times[0]) - float(animation.timeline[0])
    seconds = np.linspace(*animation.times[[0, -1]], 7).tolist()
    told = np.reshape(node(BROWSER / "points.mjs", STATIC, path, *seconds), (7, -1, 3))
    exact = np.stack([scene.points(moment - begins) for moment in seconds], axis=1)
    part = np.repeat(np.arange(len(scene.parts)), [len(one.base) for one in scene.parts])
    _, same = np.unique(exact.round(9).reshape(len(exact), -1), axis=0, return_inverse=True)
    order = np.argsort(same, kind="stable")
    pairs = [
        (one, other) for one, other in pairwise(order)
        if same[one] == same[other] and part[one] != part[other]
    ]  # fmt: skip
    assert len(pairs) > 50
    assert all(np.array_equal(told[:, one], told[:, other]) for one, other in pairs)


def test_a_page_has_the_cameras_of_the_pictures():
    animation = performed("facefx")
    (face,) = data_of(line_page(animation))["faces"]
    swept = staged(sweep(animation))
    for name, camera in (("camera", framed(swept)), ("close", close_up(swept))):
        assert face[name]["half"] == camera.half
        assert face[name]["middle"] == camera.middle.tolist()
    assert face["close"]["half"] < face["camera"]["half"] / 2


@full
def test_lines_share_the_scene_of_a_model_until_it_changes(tmp_path):
    one = shipped(tmp_path)
    other = replace(one, weights=one.weights / 2)
    assert page_scene(one) is page_scene(other)
    bones = turned(tmp_path)
    farther = replace(bones, weights=bones.weights * 2)
    assert page_scene(bones) is not page_scene(farther), "a bone turns as far as in the line"
    before = page_scene(bones)
    os.utime(bones.model, ns=(1, 1))
    assert page_scene(bones) is not before, "somebody exported the model again"


def test_the_camera_stays_where_it_is_for_every_line():
    faces = [data_of(line_page(performed("facefx", *said)))["faces"][0] for said in (("a",), ())]
    assert faces[0]["camera"] == faces[1]["camera"]


def test_a_texture_is_sent_as_it_is(tmp_path):
    animation = textured(tmp_path)
    (face,) = data_of(line_page(animation))["faces"]
    (material,) = face["materials"]
    assert bytes(material["image"]).startswith(b"\x89PNG")
    assert len(face["places"]) == 2 * face["count"]
    assert face["unshown"] == []


def test_what_is_not_shown_of_a_model_is_told(tmp_path):
    animation = textured(
        tmp_path, normalTexture={"index": 0}, alphaMode="BLEND", emissiveTexture={"index": 0}
    )
    (face,) = data_of(line_page(animation))["faces"]
    (told,) = face["unshown"]
    assert told.startswith("parts of the model that are not shown: ")
    for what in ("normal maps", "glowing textures", "transparency"):
        assert what in told


def test_a_point_that_moves_out_of_sight_is_told(tmp_path):
    animation = boned(tmp_path, 0.0, 90.0)
    (jaw,) = animation.channels
    far = replace(animation, channels=(jaw._replace(rotation=None, translation=(1e30, 0, 0)),))
    far = replace(far, weights=far.weights * 1e300)
    (face,) = data_of(line_page(far))["faces"]
    assert list(face) == ["unshown"]


def test_a_model_that_no_pose_moves_is_told(tmp_path):
    model = tmp_path / "other.glb"
    model.write_bytes(model_of(document_of(mesh("Face", ("elsewhere",)))))
    (face,) = data_of(line_page(replace(performed("facefx"), model=model)))["faces"]
    assert list(face) == ["unshown"]
    assert json.dumps(face["unshown"]).count("elsewhere") == 1
