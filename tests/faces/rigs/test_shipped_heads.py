"""The models of the built-in sets: small, and without holes where their parts meet."""

import numpy as np
import pytest
from places import ROOT

from lipsync_lang.faces.rigs.accessors import Accessors
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.faces.rigs.read_outs import moved_points

NEAR_METRES = 2e-5
"""Points of two parts that lie so close belong together."""


@pytest.mark.parametrize("name", ["facefx", "crab"])
def test_parts_that_meet_stay_together_in_every_shape(name):
    path = ROOT / "posesets" / name / "model.glb"
    assert path.stat().st_size <= 1e6
    model = read_model(path)
    rest, shapes = moved_points(model)
    part = part_of_points(model)
    moves = np.hstack([rest, *shapes.values()])
    meeting = spread_over_parts(np.round(rest / NEAR_METRES), part)
    assert meeting.sum() > 50
    assert (spread_over_parts(moves, part) >= meeting).all()


def part_of_points(model):
    """Return the number of the part of each of V points."""
    arrays, counts = Accessors(model), []
    for mesh in model.meshes:
        for primitive in model.document["meshes"][mesh.number]["primitives"]:
            arrays.unpack(primitive)
            counts.append(len(arrays[primitive["attributes"]["POSITION"]]))
    return np.repeat(np.arange(len(counts)), counts)


def spread_over_parts(rows, part):
    """Return the (V,) rows that are in more than one part."""
    _, group = np.unique(rows, axis=0, return_inverse=True)
    group = group.ravel()
    low, high = np.full(len(rows), len(rows)), np.zeros(len(rows), int)
    np.minimum.at(low, group, part)
    np.maximum.at(high, group, part)
    return (low < high)[group]
