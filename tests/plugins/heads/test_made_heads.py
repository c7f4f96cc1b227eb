"""Heads from a face model: in one command, with all shapes, small; bad folders are named."""

import numpy as np
import pytest
from ict_clone import hair_obj, write_clone
from lanes import full

from lipsync_lang.base.errors import LipsyncError, ModelError
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.faces.rigs.read_outs import read_outs
from lipsync_lang.plugins.heads.face_model import FaceModel, read_recipe
from lipsync_lang.plugins.heads.made_head import HeadWish, make_head
from lipsync_lang.plugins.heads.obj_files import obj_points

RECIPE = read_recipe("ict")


@full
def test_a_clone_becomes_a_head_that_speaks(tmp_path):
    model = FaceModel(write_clone(tmp_path / "clone"), RECIPE)
    wish = HeadWish({0: 1.0}, 7, hair_obj(tmp_path / "hair.obj"), {"skin": "#8a5a44"}, 3.0)
    made = make_head(model, wish)
    assert len(made.content) <= 3e6
    assert {"jawOpen", "tongueOut", "tongueUp", "browInnerUp", "eyeBlinkLeft"} <= set(made.shapes)
    assert len(made.shapes) == 53
    path = tmp_path / "head.glb"
    path.write_bytes(made.content)
    read = read_model(path)
    assert "Permission is hereby granted" in read.document["asset"]["extras"]["license"]
    found = read_outs(read)
    assert found["jawOpen"].aperture > 0.4
    assert found["mouthPucker"].width < -0.07  # it moves the lips, and draws back the tongue
    assert found["tongueOut"].tongue_out > 0.3
    assert found["tongueOut"].tongue_up > 0.05  # it passes over the lower teeth
    assert found["tongueUp"].tongue_up > 0.1


@full
def test_one_cannot_see_through_the_pupils(tmp_path):
    points = FaceModel(write_clone(tmp_path / "clone", identities=0), RECIPE).neutral.points
    for rim, side in zip(RECIPE["rims"], (1, -1), strict=True):
        across, up = (points[rim, :2] - np.array(RECIPE["eye"]["center"]) * (side, 1)).T
        turns = np.diff(np.unwrap(np.arctan2(up, across)))
        assert (turns > 0).all()  # against the clock, so the fan faces the front
        assert np.hypot(across, up).max() < RECIPE["eye"]["pupil"] * RECIPE["eye"]["radius"]
        assert points[rim, 2].min() > RECIPE["eye"]["front"]


def test_a_folder_without_the_model_is_told(tmp_path):
    with pytest.raises(
        ModelError, match=r"lacks generic_neutral_mesh\.obj, .* more; get the model"
    ):
        FaceModel(tmp_path, RECIPE)
    with pytest.raises(ModelError, match="is no folder"):
        FaceModel(tmp_path / "absent", RECIPE)


def test_a_damaged_mesh_is_told_with_its_line(tmp_path):
    path = tmp_path / "face.obj"
    path.write_text("# one\nv 0 0 0\nv 1 two 3\n")
    with pytest.raises(ModelError, match=r"face\.obj:3: 'v 1 two 3' does not hold 3 numbers"):
        obj_points(path)
    path.write_text("v 0 0 0\n")
    with pytest.raises(ModelError, match="has 1 points instead of 2"):
        obj_points(path, 2)


@full
def test_colors_and_identities_are_checked(tmp_path):
    model = FaceModel(write_clone(tmp_path / "clone", identities=1), RECIPE)
    with pytest.raises(LipsyncError, match="did you mean 'skin'"):
        make_head(model, HeadWish(colors={"skn": "#8a5a44"}))
    with pytest.raises(LipsyncError, match="write it like"):
        make_head(model, HeadWish(colors={"skin": "brown"}))
    with pytest.raises(LipsyncError, match="identity 5 is unknown"):
        make_head(model, HeadWish(identities={5: 1.0}))
