"""Read-outs: the mouth is found without names, and each shape moves it as its pose set says."""

from dataclasses import asdict, replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from face_models import OCULUS, POINTS, face, moved
from hypothesis import assume, given
from hypothesis import strategies as st
from places import ROOT
from small_models import glb

import lipsync_lang as ll
from lipsync_lang.base.errors import ModelError
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.faces.rigs.placing import placed
from lipsync_lang.faces.rigs.read_outs import (
    CORNER_SLOPE,
    NEAR_SHARE,
    PARTED_SHARE,
    SKIN_STRETCH,
    SOUND_MEASURES,
    find_mouth,
    read_outs,
    still_shapes,
)
from lipsync_lang.faces.rigs.read_outs import _lip_pairs as find_pairs
from lipsync_lang.packs import models


def measured(name):
    return read_outs(read_model(ROOT / "posesets" / name / "model.glb"))


def test_mouths_of_models_are_measured_as_those_of_sounds():
    assert SOUND_MEASURES == models.MOUTH_MEASURES


def test_each_pose_of_the_head_moves_what_its_title_says():
    found = measured("facefx")
    assert found["open"].aperture > 0.4
    assert found["open"].jaw > 0.3
    assert found["W"].width < -0.15
    assert found["W"].protrusion > 0.1
    assert found["wide"].width > 0.2
    assert found["PBM"].aperture <= 0
    assert found["tTeeth"].tongue_out > 0.3
    assert found["tRoof"].tongue_up > 0.3
    assert max(found[pose].tongue_out for pose in ("open", "PBM", "FV", "wide")) == 0
    assert max(map(abs, asdict(replace(found["blink"], aside=0)).values())) < 1e-3


@pytest.mark.parametrize("name", ["facefx", "crab"])
def test_shapes_of_gestures_move_and_leave_the_mouth_alone(name):
    own = ll.resolve("english", name)
    found = measured(name)
    assert not still_shapes(read_model(own.model))
    for channel in own.gesture_channels:
        if channel.node is None:
            assert max(map(abs, asdict(replace(found[channel.name], aside=0)).values())) < 0.01


def test_a_mouth_of_any_form_is_found():
    found = measured("crab")
    assert max(found, key=lambda pose: found[pose].aperture) == "mouthOpen"
    assert max(found, key=lambda pose: found[pose].tongue_out) == "tongueOut"
    assert max(found, key=lambda pose: found[pose].protrusion) == "mouthOO"


def test_a_model_without_a_mouth_is_refused(tmp_path):
    model = read_model(glb(tmp_path / "cube.glb", "big"))
    with pytest.raises(ModelError, match=r"cube\.glb: no shape opens a mouth"):
        read_outs(model)


def test_an_offset_that_is_no_number_is_refused_with_its_shape(tmp_path):
    path = face(tmp_path / "head.glb", "jawOpen", "viseme_aa")
    path.write_bytes(path.read_bytes()[:-4] + np.float32(np.nan).tobytes())
    with pytest.raises(ModelError, match=r"head\.glb: an offset of viseme_aa is not"):
        read_outs(read_model(path))


def test_an_aperture_is_read_where_the_lips_touch_and_not_between_their_fronts():
    # A head as in heads of scans: lips that purse part their fronts, and their inner edges meet.
    across = np.linspace(-0.5, 0.5, 11)
    heights = (0.02, 0.005, -0.005, -0.02, -0.02, 0.02)
    rows = [*zip(heights, (0.03, -0.07, -0.07, 0.03, -0.3, -0.3), strict=True)]
    points = np.concatenate([
        np.stack([across, np.full(11, y), np.full(11, z)], axis=1) for y, z in rows
    ])  # fmt: skip
    row = np.repeat(np.arange(len(rows)), 11)
    jaw, pucker = np.zeros_like(points), np.zeros_like(points)
    jaw[(row == 2) | (row == 3) | (row == 4), 1] = -0.5
    pucker[row == 0, 1], pucker[row == 3, 1] = 0.1, -0.1
    mouth = find_mouth(points, {"jaw": jaw, "pucker": pucker}, Path("head.glb"))
    assert mouth.measure(jaw).aperture == pytest.approx(0.5)
    assert mouth.measure(pucker).aperture == 0


def test_the_corners_of_a_mouth_are_seen_from_the_front():
    # As in heads of scans, a wider bag goes on behind the corners and parts as well.
    lips = np.linspace(-0.5, 0.5, 11)
    bag = np.array([-0.8, -0.7, -0.6, 0.6, 0.7, 0.8])
    skin = np.array([-0.6, 0.6])
    across = np.concatenate([lips, bag, skin])
    depth = np.concatenate([-0.3 * lips**2, np.full(6, -1.0), np.full(2, -0.1)])
    height = np.concatenate([np.full(17, 0.005), np.full(2, 0.02)])
    above = np.column_stack([across, height, depth])
    rest = np.concatenate([above, above * (1, -1, 1)])
    jaw, pucker = np.zeros_like(rest), np.zeros_like(rest)
    jaw[len(across) :, 1] = np.concatenate([np.full(17, -0.4), np.full(2, -0.07)])
    pucker[:, 0] = np.concatenate([-0.2 * lips, np.zeros(8)] * 2)
    mouth = find_mouth(rest, {"jaw": jaw, "pucker": pucker}, Path("head.glb"))
    assert mouth.width == pytest.approx(1.0)
    assert mouth.measure(pucker).width == pytest.approx(-0.2)
    assert mouth.measure(jaw).aperture == pytest.approx(0.4)


def head_with_lids(shapes):
    """Return points and shapes of a head with lids: `blink` lowers more points than the others."""
    across = np.concatenate([np.linspace(-0.7, -0.2, 11), np.linspace(0.2, 0.7, 11)])
    skin, lid = (np.column_stack([across, np.full(22, y), np.full(22, 0.3)]) for y in (0.9, 0.88))
    rest = np.concatenate([POINTS, skin, lid, np.repeat(lid, 4, axis=0)])
    still = np.zeros((len(rest) - len(POINTS), 3))
    closed = np.zeros_like(rest)
    closed[len(POINTS) + 22 :, 1] = -0.4
    opened = {name: np.concatenate([moved(name), still]) for name in shapes}
    return rest, {"blink": closed, **opened}


def test_lids_are_no_mouth():
    rest, shapes = head_with_lids(OCULUS)
    assert min(shapes, key=lambda name: shapes[name][:, 1].sum()) == "blink"
    mouth = find_mouth(rest, shapes, Path("head.glb"))
    assert set(mouth.lips.flat) <= set(range(22))
    assert mouth.measure(shapes["viseme_aa"]).aperture > 0.5
    assert mouth.measure(shapes["blink"]).aperture == 0.0


def test_a_fold_that_many_shapes_part_a_little_is_no_mouth():
    across = np.linspace(-0.5, 0.5, 11)
    fold = np.concatenate(
        [np.column_stack([across, np.full(11, y), across**0]) for y in (0.4, 0.38)]
    )
    rest, shapes = np.concatenate([POINTS, fold]), {}
    shapes["open"] = np.concatenate([moved("viseme_aa"), np.zeros_like(fold)])
    for number in range(7):
        shapes[f"frown {number}"] = np.zeros_like(rest)
        shapes[f"frown {number}"][-11:, 1] = -0.03
    mouth = find_mouth(rest, shapes, Path("head.glb"))
    assert mouth.measure(shapes["open"]).aperture == pytest.approx(0.5 / mouth.width)
    assert mouth.measure(shapes["frown 0"]).aperture == 0


def test_a_shape_that_curls_the_lips_opens_the_mouth_behind_their_fronts():
    across = np.linspace(-0.5, 0.5, 11)
    # height, depth, and the way upwards of each row of points
    rows = [(y, z, way) for y, z, way in ((0.03, 0.04, 0.05), (0.02, 0.05, 0.1), (0.005, 0, 0.1))]
    rows += [(-y, z, -way) for y, z, way in rows]
    rest = np.concatenate(
        [np.column_stack([across, across**0 * y, across**0 * z]) for y, z, _ in rows]
    )
    funnel = np.zeros_like(rest)
    funnel[:, 1] = np.repeat([way for *_, way in rows], 11)
    mouth = find_mouth(rest, {"funnel": funnel}, Path("head.glb"))
    assert mouth.measure(funnel).aperture == pytest.approx(0.2 / mouth.width)


def test_a_frown_on_one_side_is_no_mouth():
    frown = np.zeros_like(POINTS)
    left = POINTS[:, 0] > 0.1
    frown[11:22, 1][left[11:22]] = -0.2
    rest = POINTS * (1, 0.5, 1)
    assert find_pairs(rest, frown).size
    with pytest.raises(ModelError, match="no shape opens a mouth"):
        find_mouth(rest, {"mouthFrownLeft": frown}, Path("head.glb"))


@pytest.mark.filterwarnings("error")
def test_points_of_one_column_are_no_mouth():
    one = np.zeros_like(POINTS)
    one[0, 1] = -1.0
    with pytest.raises(ModelError, match="no shape opens a mouth"):
        find_mouth(POINTS, {"drop": one}, Path("head.glb"))


def fronts_of(rest, apart, columns):
    """Return the frontmost of some pairs of points in each column that has some."""
    found = []
    for column in np.unique(columns):
        here = np.argwhere(apart & (columns == column)[:, None]).tolist()
        if here:
            found.append(max(here, key=lambda pair: (rest[pair, 2].sum(), -pair[0], -pair[1])))
    return [tuple(pair) for pair in found]


def pairs_of_a_square(rest, opened):
    """Pair points of lips by a look at all pairs of a column."""
    moving = np.abs(opened).max(axis=1) > 0
    near = NEAR_SHARE * np.ptp(rest[moving, 0])
    columns = np.round((rest[:, 0] - np.median(rest[moving, 0])) / near)
    away = np.linalg.norm(rest[:, None] - rest, axis=2)
    parted = opened[:, None, 1] - opened[:, 1]
    parted[(away > near) | (columns[:, None] != columns)] = 0
    parted[~np.isin(columns, columns[moving])] = 0
    apart = parted > PARTED_SHARE * parted.max()
    if not apart.any():
        return np.empty((2, 0), int)
    upright = rest[:, None, 1] >= rest[:, 1]
    fronts = fronts_of(rest, apart, columns)
    if (apart & upright).any() and 2 * sum(upright[pair] for pair in fronts) <= len(fronts):
        apart &= upright
    at = rest[:, None] + rest
    lips = apart & (parted > SKIN_STRETCH * away)
    lips = lips if lips.any() else apart
    ends = []
    for side in (-1, 1):
        far = np.where(lips, side * at[..., 0] + at[..., 2] / CORNER_SLOPE, -np.inf)
        best = np.argwhere(far == far.max()).tolist()
        ends.append(min(best, key=lambda pair: (columns[pair[0]], -at[*pair, 2], *pair)))
    fronts = fronts_of(rest, apart, columns)
    pairs = [one for one in fronts if at[*ends[0], 0] < at[*one, 0] < at[*ends[1], 0]]
    return np.array([ends[0], *pairs, ends[1]], int).T


@given(st.integers(0, 2**32 - 1), st.integers(2, 120), st.sampled_from([1, 6]))
def test_points_near_each_other_in_height_have_all_pairs_of_lips(seed, count, digits):
    # Few digits make many points of one height, and fronts that are equally far to the front.
    chance = np.random.default_rng(seed)
    rest = np.round(chance.normal(size=(count, 3)) * (1, 0.2, 0.2), digits)
    opened = np.zeros((count, 3))
    opened[:, 1] = np.round(-chance.random(count) * (chance.random(count) < 0.6), digits)
    moving = rest[opened[:, 1] != 0, 0]
    assume(moving.size and np.ptp(moving))
    found = find_pairs(rest, opened)
    assert found.tolist() == pairs_of_a_square(rest, opened).tolist()


Z_UP_CENTIMETRES = np.array([[100.0, 0, 0], [0, 0, 100], [0, -100, 0]])
"""A matrix for rows of points: y up in metres becomes z up in centimetres."""


def nodes(turn):
    """Return a root that turns what lies below it by a (3, 3) matrix of row points."""
    matrix = np.eye(4)
    matrix[:3, :3] = turn
    return [
        {"name": "Root", "matrix": matrix.ravel().tolist(), "children": [1]},
        {"name": "Wolf3D_Head", "mesh": 0},
    ]


@pytest.mark.parametrize(
    ("turn", "stated"),
    [
        (Z_UP_CENTIMETRES, {"nodes": nodes(np.linalg.inv(Z_UP_CENTIMETRES))}),
        (np.diag([-1.0, 1.0, -1.0]), {}),
    ],
    ids=["below a node that turns it", "looking to the back"],
)
def test_a_head_is_measured_as_it_stands(turn, stated, tmp_path):
    plain, other = (
        read_outs(read_model(face(tmp_path / name, *OCULUS, **more)))
        for name, more in (("plain.glb", {}), ("turned.glb", {"turn": turn, **stated}))
    )
    assert plain["viseme_aa"].aperture > 0.4
    for name, found in plain.items():
        assert asdict(other[name]) == pytest.approx(asdict(found), abs=2e-3)


def test_the_bone_of_most_points_places_a_skinned_mesh():
    jaw, head = nodes(np.eye(3))[0] | {"name": "jaw", "children": []}, nodes(Z_UP_CENTIMETRES)[0]
    shown = [jaw, head | {"children": []}, {"mesh": 0, "skin": 0, "scale": [9, 9, 9]}]
    document = {"nodes": shown, "skins": [{"joints": [0, 1], "inverseBindMatrices": 2}]}
    inverse = np.stack([np.eye(4), 2 * np.eye(4)])
    arrays = [np.array([[0, 1], [1, 0]]), np.array([[0.2, 0.8], [1.0, 0.0]]), inverse]
    model = SimpleNamespace(document=document, path=Path("head.glb"))
    primitive = {"attributes": {"JOINTS_0": 0, "WEIGHTS_0": 1}}
    found = placed(model, arrays, 0, primitive)
    assert found[:3, :3] == pytest.approx(2 * Z_UP_CENTIMETRES)


def test_a_node_without_a_place_is_refused(tmp_path):
    broken = [{"matrix": [1, 2, 3], "children": [1]}, {"mesh": 0}]
    model = read_model(face(tmp_path / "head.glb", *OCULUS, nodes=broken))
    with pytest.raises(ModelError, match=r"head\.glb: the place of mesh 0 cannot be read"):
        read_outs(model)
