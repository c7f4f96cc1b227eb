"""Pose sets are chosen by what the shapes of a model do, and a warning names dead shapes."""

import pytest
from face_models import ARKIT, OCULUS, VROID, face

import lipsync_lang as ll
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.faces.rigs.recognise import recognise
from lipsync_lang.packs.library import Library
from lipsync_lang.reports.quality.check_animation import check

SCHEDULE = ll.Schedule(
    ("M", "AA1", "P", "AA1", "_"), (0, 0.1, 0.5, 0.6, 1.0, 1.2), notation="arpabet"
)


@pytest.fixture
def best():
    return lambda path: recognise(Library(), read_model(path))[0]


@pytest.mark.parametrize(
    ("poseset", "shapes"),
    [("arkit", (*ARKIT, *OCULUS)), ("oculus", OCULUS), ("vrm", VROID)],
)
def test_a_face_whose_shapes_all_move_is_chosen_by_its_names(tmp_path, best, poseset, shapes):
    match = best(face(tmp_path / "head.glb", *shapes))
    assert match.name == poseset
    assert not match.found.doubts


def test_a_set_whose_jaw_is_dead_yields_to_one_that_opens_the_mouth(tmp_path, best):
    path = face(tmp_path / "head.glb", *ARKIT, *OCULUS, dead={"jawOpen"})
    assert best(path).name == "oculus"
    performer = ll.resolve("english", path)
    assert performer.compiled.poseset == "oculus"


def test_a_dead_jaw_without_another_set_is_told_and_fails_the_check(tmp_path, best):
    path = face(tmp_path / "head.glb", *ARKIT, dead={"jawOpen"})
    match = best(path)
    assert match.poseset == "arkit"
    assert "on the mesh, nothing moves with jawOpen" in match.found.doubts
    animation = ll.resolve("english", path).perform(SCHEDULE)
    told = [*WRITERS["glb"].remarks(animation)]
    assert f"{path}: on the mesh, nothing moves with jawOpen" in told
    assert check(animation)["unopened"].verdict == "FAIL"
    whole = face(tmp_path / "whole.glb", *ARKIT)
    assert check(ll.resolve("english", whole).perform(SCHEDULE))["unopened"].verdict == "ok"


def test_a_face_without_any_moving_shape_keeps_its_names(tmp_path, best):
    match = best(face(tmp_path / "head.glb", *VROID, dead=VROID))
    assert match.name == "vrm"
    assert match.found.doubts
