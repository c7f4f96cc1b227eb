"""Expressions on top of speech: weights add up, and no contact or constraint is broken."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full
from strategies import undisturbed

import lipsync_lang as ll
from lipsync_lang import Schedule
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.pipeline.prepare import GIVEN

LABELS = ("M", "AA", "B", "IY", "F", "UW", "P", "AA")


def said(seconds=0.12):
    return Schedule(LABELS, np.arange(9) * seconds, notation="arpabet")


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "arkit")


def test_a_shape_that_speech_does_not_move_keeps_the_expression(performer):
    spoken = performer.perform(said())
    smiling = performer.with_expression(spoken, {"mouthSmileLeft": [(0, 0.2), (0.5, 0.6)]})
    assert smiling.poses == (*spoken.poses, "mouthSmileLeft")
    assert smiling.columns[-1].name == "mouthSmileLeft"
    assert smiling["mouthSmileLeft"][[0, -1]] == pytest.approx([0.2, 0.6])
    assert np.array_equal(smiling.weights[:, :-1], spoken.weights)


def test_shapes_of_speech_add_up_to_one_at_most(performer):
    spoken = performer.perform(said())
    smiling = performer.with_expression(spoken, {"TONGUEOUT": 0.0, "mouthLowerDownLeft": 1.0})
    assert smiling.poses == spoken.poses
    assert smiling["mouthLowerDownLeft"].max() == 1
    assert smiling["mouthLowerDownLeft"][0] == 1


def test_lips_that_shut_stay_shut_and_fade_a_bared_smile_smoothly(performer):
    spoken = performer.perform(said(), 120)
    smiling = performer.with_expression(spoken, {"mouthUpperUpLeft": 0.4})
    lips = performer.compiled.tables.contacts[performer.compiled.contact_names.index("lips")]
    shut = (spoken.weights >= lips.floor - GIVEN).all(axis=1)
    assert shut.any()
    assert np.array_equal(smiling["mouthUpperUpLeft"][shut], spoken["mouthUpperUpLeft"][shut])
    assert np.abs(np.diff(smiling["mouthUpperUpLeft"])).max() < 0.2


def test_an_expression_adds_to_gestures_and_to_another_expression(performer):
    nod = {"gesture": "nod", "at": 1}
    spoken = performer.perform(said(0.3), gestures="all", placed=[nod])
    shapes = {"mouthSmileLeft": 0.5, "browInnerUp": 0.2, "nod": 0.2}
    smiling = performer.with_expression(spoken, shapes)
    assert spoken["nod"].max() > 1  # degrees
    assert smiling["nod"] == pytest.approx(spoken["nod"] + 0.2)
    assert smiling.poses == (*spoken.poses, "mouthSmileLeft")
    assert smiling["browInnerUp"] == pytest.approx(np.minimum(spoken["browInnerUp"] + 0.2, 1))
    more = performer.with_expression(smiling, {"mouthSmileLeft": 0.2})
    assert more["mouthSmileLeft"] == pytest.approx(0.7)
    assert np.array_equal(more.without_gestures()["jawOpen"], spoken["jawOpen"])


def test_an_animation_of_other_poses_is_refused():
    rigged = ll.resolve("english", "facefx")
    other = ll.resolve("english", "arkit").perform(said())
    with pytest.raises(LipsyncError, match="adds to poses; add it before you convert"):
        rigged.with_expression(other, {"wide": 0.2})


@pytest.mark.parametrize("wrong", [1.1, -0.1, float("nan"), [(1, 0.2), (0, 0.3)]])
def test_a_weight_that_is_none_is_told(performer, wrong):
    with pytest.raises(LipsyncError, match="expression mouthSmileLeft: "):
        performer.with_expression(performer.perform(said()), {"mouthSmileLeft": wrong})


@full
@given(
    st.sampled_from(["facefx", "arkit", "crab", "oculus", "vrm", "three-mouths"]),
    st.data(),
    st.floats(0.03, 0.3),
    st.sampled_from([24, 60, 120]),
)
def test_no_expression_breaks_a_contact_or_a_constraint(poseset, data, seconds, fps):
    performer = ll.resolve("english", poseset)
    spoken = performer.perform(said(seconds), fps)
    shapes = st.dictionaries(st.sampled_from(spoken.poses), st.floats(0, 1))
    smiling = performer.with_expression(spoken, data.draw(shapes))
    performance = performer.performance(said(seconds), fps)
    tables, weights, before = performance.tables, smiling.weights, spoken.weights
    assert (weights >= before).all()
    assert weights.max() <= 1
    for contact, frames in undisturbed(performance):
        met = frames & (before >= contact.floor - GIVEN - 1e-9).all(axis=1)
        down = contact.ceiling < 1
        assert np.array_equal(weights[met][:, down], before[met][:, down])
    for low, high, threshold in tables.caps:
        most = np.maximum(before[:, low] + before[:, high], threshold)
        assert (weights[:, low] + weights[:, high] <= most + 1e-9).all()
    for pose, other in tables.at_most:
        assert (weights[:, pose] <= weights[:, other] + 1e-9).all()
