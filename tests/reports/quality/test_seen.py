"""The mouth as a viewer sees it, on heads that are made in code."""

from dataclasses import replace

import face_models
import numpy as np
import pytest
from face_models import ARKIT, OCULUS, face
from places import ROOT

import lipsync_lang as ll
from lipsync_lang.reports.quality.check_animation import check, check_all
from lipsync_lang.reports.quality.face_columns import face_of

LABELS = "DH AH K AE T S AE T DH EH R AE N D N OW B AA D IY EH L S M EY D K IY P M AH N IY"
LABIALS_SECONDS = 2.2
"""Sounds with shut lips, and their neighbours, are after this."""

ROUNDED = "CH UW Z B L UW M UW N Z F ER Y UW AE T W AH N"

FLAPPING = ("viseme_DD", "viseme_kk", "viseme_nn", "viseme_CH")


def line(labels=LABELS):
    labels = labels.split()
    return ll.Schedule(("_", *labels, "_"), [0, *0.3 + 0.1 * np.arange(len(labels) + 1), 4])


@pytest.fixture
def judged(tmp_path):
    """Return a function that judges the line on a head with these shapes."""

    def judge(shapes, poseset, more="", labels=LABELS):
        face(tmp_path / "head.glb", *shapes)
        text = f"kind: character\nformat: 1\nname: anna\nposeset: {poseset}\nmodel: head.glb\n"
        (tmp_path / "characters").mkdir(exist_ok=True)
        (tmp_path / "characters" / "anna.yaml").write_text(text.replace("head", "../head") + more)
        performer = ll.resolve("english", "anna", paths=[tmp_path])
        return check(performer.perform(line(labels), 60))

    return judge


def failed(quality):
    return [figure.name for figure in quality.failed if figure.name.startswith("seen")]


@pytest.mark.parametrize(("shapes", "poseset"), [(ARKIT, "arkit"), (OCULUS, "oculus")])
def test_a_solved_head_opens_as_filmed_people_do(judged, shapes, poseset):
    quality = judged(shapes, poseset)
    assert failed(quality) == []
    opening, film = quality["seen_opening"].parts.values()
    assert film / 1.5 < opening < film * 1.5
    assert quality["seen_flaps"].value == quality["seen_gaps"].value == 0
    assert quality.remarks == ("judged on the mesh of head.glb",)


def test_a_jaw_that_opens_too_little_fails(judged, monkeypatch):
    monkeypatch.setitem(face_models.OPENINGS, "jawOpen", 0.12)
    quality = judged(ARKIT, "arkit")
    assert failed(quality) == ["seen_opening"]
    opening, film = quality["seen_opening"].parts.values()
    assert opening < film / 2.3


def test_a_jaw_that_opens_half_as_far_as_people_fails(judged, monkeypatch):
    monkeypatch.setitem(face_models.OPENINGS, "jawOpen", 0.2)
    quality = judged(ARKIT, "arkit")
    opening, film = quality["seen_opening"].parts.values()
    assert film / 2.3 < opening < film / 1.77
    assert failed(quality) == ["seen_opening"]


@pytest.mark.parametrize(("jaw", "more"), [(1.6, ""), (0.12, "mouth: declared\n")])
def test_rules_judge_the_mesh_and_not_the_strength_of_its_shapes(judged, monkeypatch, jaw, more):
    monkeypatch.setitem(face_models.OPENINGS, "jawOpen", jaw)
    quality = judged(ARKIT, "arkit", more)
    assert quality["rules opens"].passed is (jaw > 1)
    assert quality["rules sibilants"].passed


def test_consonants_that_open_as_far_as_vowels_fail_and_are_named(judged, monkeypatch):
    for shape in FLAPPING:
        monkeypatch.setitem(face_models.OPENINGS, shape, 0.4)
    quality = judged(OCULUS, "oculus", "mouth: declared\n")
    assert failed(quality) == ["seen_flaps"]
    assert any(
        one.what.startswith("K opens the mouth to") for one in quality["seen_flaps"].findings
    )


def test_lines_at_once_have_the_shares_of_each_alone(judged, monkeypatch, tmp_path):
    for shape in FLAPPING:
        monkeypatch.setitem(face_models.OPENINGS, shape, 0.4)
    texts = LABELS, "K AA N IY T OW F AA"
    alone = [judged(OCULUS, "oculus", "mouth: declared\n", text) for text in texts]
    performer = ll.resolve("english", "anna", paths=[tmp_path])
    both = check_all([performer.perform(line(text), 60) for text in texts], performer)
    assert both == alone
    assert len({one["seen_flaps"].value for one in both} - {0}) == len(texts)


def test_lips_that_stay_apart_fail_although_the_weights_close_them(judged, monkeypatch):
    monkeypatch.setitem(face_models.OPENINGS, "viseme_PP", 0.1)
    quality = judged(OCULUS, "oculus")
    assert failed(quality) == ["seen_gaps"]
    assert quality["contacts lips"].passed
    assert [one.what[0] for one in quality["seen_gaps"].findings] == ["B", "M", "P", "M"]


def test_a_reach_scales_what_film_shows(judged):
    near, far = (judged(ARKIT, "arkit", f"reach: {reach}\n") for reach in (1.0, 1.6))
    assert far["seen_opening"].parts["opening"] > 1.4 * near["seen_opening"].parts["opening"]
    assert far["seen_opening"].value == pytest.approx(near["seen_opening"].value, abs=0.2)


def test_a_mouth_that_is_too_wide_fails_unless_its_reach_says_so(judged, monkeypatch):
    usual = face_models.moved

    def moved(name, dead=()):
        offsets = usual(name, dead)
        if name == "jawOpen":
            offsets[:22, 0] = 3 * face_models.POINTS[:22, 0]
        return offsets

    monkeypatch.setattr(face_models, "moved", moved)
    # of a character's own, so that the reach does not scale them
    drawn = (ROOT / "posesets/arkit/targets.yaml").read_text().partition("\ntargets:")[2]
    declared = f"mouth: declared\nhas: [tongueUp]\ntargets:{drawn}"
    assert "seen_width" in failed(judged(ARKIT, "arkit", declared))
    assert "seen_width" not in failed(judged(ARKIT, "arkit", f"reach: 3\n{declared}"))


@pytest.mark.parametrize(("shapes", "poseset"), [(ARKIT, "arkit"), (OCULUS, "oculus")])
@pytest.mark.parametrize("reach", [0.6, 1.0, 1.6])
def test_lips_that_do_not_round_fail_and_are_named(judged, monkeypatch, shapes, poseset, reach):
    said = f"reach: {reach}\n", ROUNDED
    assert judged(shapes, poseset, *said)["seen_rounding"].value < 1.8
    monkeypatch.setattr(face_models, "NARROWINGS", {})
    quality = judged(shapes, poseset, *said)
    assert failed(quality) == ["seen_rounding"]
    found = [one.what for one in quality["seen_rounding"].findings]
    assert "UW narrows the mouth by 0.00; filmed people by 0.1" in found[1]
    assert len(found) == 7
    own = judged(shapes, poseset, "checks: {seen_rounding: 100}\n", ROUNDED)
    assert own["seen_rounding"].passed


@pytest.mark.parametrize("reach", [0.6, 1.0, 1.6])
def test_rounded_lips_that_shut_are_named(judged, reach):
    said = f"reach: {reach}\n", ROUNDED
    assert judged(ARKIT, "arkit", *said)["seen_slits"].value < 0.2
    shut = "targets: {w: {mouthPucker: 0.7, jawOpen: 0, dominance: {jawOpen: 4}}}\n"
    quality = judged(ARKIT, "arkit", shut + said[0], ROUNDED)
    assert failed(quality) == ["seen_slits"]
    found = [one.what for one in quality["seen_slits"].findings]
    assert len(found) > 2
    assert "UW opens the mouth to 0.0" in found[0]
    assert judged(ARKIT, "arkit")["seen_slits"].why.startswith("fewer than 3 vowels")


def test_rounding_is_asked_of_sounds_and_pose_sets_that_have_it(judged):
    assert judged(ARKIT, "arkit")["seen_rounding"].why.startswith("fewer than 3 sounds")
    for name, limit in (("facefx", 1.2), ("crab", None)):
        found = check(ll.resolve("english", name).perform(line(ROUNDED)))["seen_rounding"]
        assert (found.value is None) == (limit is None)
        assert found.value is None or found.value < limit


def test_lips_that_stay_shut_over_an_open_jaw_are_shut_vowels_and_open_late(tmp_path, monkeypatch):
    monkeypatch.setitem(face_models.OPENINGS, "mouthClose", -0.6)
    face(tmp_path / "head.glb", *ARKIT)
    performer = ll.resolve("english", tmp_path / "head.glb")
    animation = performer.perform(line(), 60)
    assert {check(animation)[name].passed for name in ("shut_vowels", "opening_lag")} == {True}
    weights = animation.weights.copy()
    jaw, shut = (performer.poses.index(name) for name in ("jawOpen", "mouthClose"))
    late = animation.times > LABIALS_SECONDS
    weights[late, shut] = weights[late, jaw]
    quality = check(replace(animation, weights=weights))
    assert {"shut_vowels", "opening_lag"} <= {figure.name for figure in quality.failed}
    assert any("keeps the mouth closed" in one.what for one in quality["shut_vowels"].findings)


def test_a_solved_head_has_no_limits_of_the_look_that_a_pose_set_allows(judged, monkeypatch):
    shipped = ll.resolve("english", "facefx")
    assert {"seen_flaps", "seen_width"} <= shipped.compiled.checks["limits"].keys()
    shapes = [*shipped.poses]
    monkeypatch.setitem(face_models.OPENINGS, "open", 0.6)
    judgements = [
        judged(shapes, "facefx", more)
        for more in ("", "checks: {seen_width: 0.9}\n", "mouth: declared\n")
    ]
    limits = [[one[name].limit for name in ("seen_flaps", "seen_width")] for one in judgements]
    assert limits == [[0.25, 0.36], [0.25, 0.9], [0.5, 0.6]]


def test_weights_are_judged_without_a_mesh_and_the_result_says_so(judged):
    animation = ll.resolve("english", "arkit").perform(line(), 60)
    quality = check(animation)
    assert quality.remarks == ("weights were judged: this character has no model",)
    assert quality["seen_opening"].why == "the mouth is not measured on a mesh"
    blind = judged([name for name in ARKIT if name != "jawOpen"], "arkit")
    assert blind.remarks == ("weights were judged: the mouth of head.glb cannot be measured",)


def test_channels_of_a_rig_move_the_mesh_as_its_poses_do(tmp_path):
    (tmp_path / "characters").mkdir()
    face(tmp_path / "characters" / "head.glb", *ARKIT)
    (tmp_path / "characters" / "anna.yaml").write_text(
        "kind: character\nformat: 1\nname: anna\nposeset: facefx\nrig: facefx-to-arkit\n"
        "model: head.glb\n"
    )
    performer = ll.resolve("english", "anna", paths=[tmp_path])
    poses = performer.perform(line(), 60)
    channels = performer.rigged(poses)
    gains = [face_of(one, performer).seen.gains for one in (poses, channels)]
    assert np.allclose(gains[1] @ performer.driver.rig.gains, gains[0])
    by_poses, by_channels = (check(one, performer=performer) for one in (poses, channels))
    opened = [one["seen_opening"].parts["opening"] for one in (by_poses, by_channels)]
    assert opened[1] == pytest.approx(opened[0], abs=0.03)


def test_short_lines_are_not_judged_by_statistics():
    performer = ll.resolve("english", "facefx")
    short = performer.perform(ll.Schedule(("B", "AA"), [0, 0.1, 0.4]))
    rest = performer.perform(ll.Schedule(("_",), [0, 0.4]))
    for quality in check_all([short, rest], performer):
        assert quality["seen_opening"].value is quality["seen_width"].value is None
        assert quality["seen_flaps"].value is None
    assert check(short)["seen_gaps"].value == 0


def test_drawn_mouths_and_models_of_pose_sets_are_told_apart():
    assert check(ll.resolve("english", "rhubarb").perform(line()))["seen_flaps"].value is None
    facefx = check(ll.resolve("english", "facefx").perform(line()))
    assert facefx.remarks == ("judged on the mesh of model.glb",)
