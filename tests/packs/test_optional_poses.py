"""Optional poses of a pose set move on models that have their shapes, and are absent elsewhere."""

import numpy as np
import pytest
from face_models import ARKIT, face

import lipsync_lang as ll
from lipsync_lang.authoring.character_draft import CharacterWish, draft
from lipsync_lang.base.errors import PackError
from lipsync_lang.packs.library import Library
from lipsync_lang.schedules.schedule import SILENCE

LINE = ll.Schedule(
    (SILENCE, "AA", "D", "AA", SILENCE), (0, 0.2, 0.4, 0.5, 0.8, 1.0), notation="arpabet"
)


@pytest.fixture
def tongued(tmp_path):
    return face(tmp_path / "head.glb", *ARKIT, "Tongue_Tip_Up")


def test_a_model_with_the_shape_raises_its_tongue_and_keeps_its_lips(tongued, tmp_path):
    plain = ll.resolve("english", face(tmp_path / "plain.glb", *ARKIT)).perform(LINE)
    moved = ll.resolve("english", tongued).perform(LINE)
    assert moved.poses == (*plain.poses, "tongueUp")
    assert np.array_equal(moved.weights[:, :-1], plain.weights)
    assert moved.weights[:, -1].max() > 0.5
    assert not moved.weights[[0, -1], -1].any()


def test_a_model_without_the_shape_has_no_column_of_it(tmp_path):
    path = face(tmp_path / "head.glb", *ARKIT)
    assert "tongueUp" not in ll.resolve("english", path).poses


def test_a_drafted_character_names_what_its_model_has(tongued, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    made = draft(Library(), CharacterWish("anna", tongued))
    made.write()
    assert "has: [tongueUp]\n" in made.path.read_text()
    assert ll.resolve("english", "anna").poses[-1] == "tongueUp"


def test_a_pose_set_is_shown_with_them(cli):
    shown = cli("posesets", "show", "arkit").out.splitlines()
    heading = shown.index("poses that few models have")
    assert shown[heading + 1].split()[:2] == ["tongueUp", "tongue"]
    assert any(line.split()[:2] == ["nod", "head"] for line in shown)


def test_a_character_may_only_have_optional_poses_of_its_set(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "characters" / "anna.yaml"
    path.parent.mkdir()
    head = "kind: character\nformat: 1\nname: anna\nposeset:"
    for wrong in (f"{head} arkit\nhas: [tongueUpp]\n", f"{head} crab\nhas: [tongueUp]\n"):
        path.write_text(wrong)
        with pytest.raises(PackError, match="unknown optional pose 'tongueUp"):
            ll.resolve("english", "anna")
    # curves of the pose need the shape
    words = "words: {tale: {curves: {tongueUp: [[0, 0], [1, 0]]}}}\n"
    path.write_text(f"{head} arkit\n{words}")
    with pytest.raises(PackError, match="unknown pose 'tongueUp'"):
        ll.resolve("english", "anna")
    path.write_text(f"{head} arkit\nhas: [tongueUp]\n{words}")
    assert "tongueUp" in ll.resolve("english", "anna").poses


def test_a_pose_is_optional_or_not(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "posesets" / "mouth" / "poseset.yaml"
    path.parent.mkdir(parents=True)
    path.write_text(
        "kind: poseset\nformat: 1\nname: mouth\nposes: {open: }\noptional_poses: {open: }\n"
    )
    with pytest.raises(PackError, match="'open' is a pose of speech already"):
        ll.resolve("english", "mouth")
