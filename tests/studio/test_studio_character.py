"""The studio's routes of the character: mixes of poses, a copy of its pose set, models."""

import shutil
import struct
from pathlib import Path
from tempfile import gettempdir

import numpy as np
import pytest

pytest.importorskip("starlette", reason="the studio needs Starlette")

from face_models import ARKIT, face
from shipped import LIBRARY
from studio_calls import Caller

import lipsync_lang as ll
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.packs.library import Library
from lipsync_lang.studio.workshop import Workshop

LINE = ll.Schedule(("B", "AA", "W", "S", "TH", "OW", "M"), [0, 0.1, 0.3, 0.4, 0.5, 0.6, 0.8, 0.9])


def opened(folder, character="crab"):
    workshop = Workshop(folder, engine="none")
    workshop.open("english", character)
    return workshop, Caller(workshop)


@pytest.fixture(scope="module")
def crab(tmp_path_factory):
    return opened(tmp_path_factory.mktemp("crab"))


def shipped(poseset):
    return LIBRARY.find("poseset", poseset).parent


def bits(workshop):
    return workshop.performer.perform(LINE).weights.tobytes()


def test_the_pose_set_is_told_as_it_is_stated(crab):
    told = crab[1].api("character").json
    assert (told["poseset"], told["own"], told["rig"]) == ("crab", False, None)
    assert told["model"] == "model.glb"
    assert told["stated"]["targets"]["aa"] == {"mouthOpen": 0.75}
    assert told["stated"]["priority"][0] == "smile"
    phonemes = {one["name"]: one for one in told["phonemes"]}
    assert phonemes["bmp"]["contact"] == "shut"
    assert phonemes["iy"]["like"] == "ih"
    assert {*told["stated"]["targets"]} <= {*phonemes}


def test_a_mix_is_kept_within_the_constraints_and_the_rule_is_told(crab):
    mix = {"mouthOO": 0.7, "smile": 0.6, "tongueOut": 0.5, "mouthOpen": 0.2}
    poses = crab[0].performer.poses
    free, kept = (
        crab[1].post("pose", {"mixes": [mix, {}], "within": within}).json["rows"]
        for within in (False, True)
    )
    assert dict(zip(poses, free[0]["weights"], strict=True)) == dict.fromkeys(poses, 0) | mix
    assert free[0]["channels"] == free[0]["weights"]
    assert free[0]["acts"] == []
    got = dict(zip(poses, kept[0]["weights"], strict=True))
    assert got["smile"] == pytest.approx(0.1)
    assert got["tongueOut"] == pytest.approx(0.2)
    assert got["mouthOO"] == 0.7
    assert kept[0]["acts"] == [
        {"pose": "smile", "other": "mouthOO", "why": "together at most 0.8"},
        {"pose": "tongueOut", "other": "mouthOpen", "why": "never above it"},
    ]
    assert kept[1]["acts"] == []


@pytest.mark.parametrize(
    "mixes",
    [{}, [1], [{"nose": 1}], [{"smile": 2}], [{"smile": True}], [{"smile": "1"}], [{}] * 401],
)
def test_a_mix_that_is_none_is_refused(crab, mixes):
    assert crab[1].post("pose", {"mixes": mixes}).status == 422


def test_a_rig_turns_poses_into_its_channels(tmp_path):
    (tmp_path / "characters").mkdir()
    text = "kind: character\nformat: 1\nname: rigged\nposeset: facefx\nrig: facefx-to-arkit\n"
    (tmp_path / "characters/rigged.yaml").write_text(text)
    workshop, caller = opened(tmp_path, "rigged")
    assert caller.api("character").json["rig"] == "facefx-to-arkit"
    row = caller.post("pose", {"mixes": [{"open": 0.6, "wide": 0.4}]}).json["rows"][0]
    performer = workshop.performer
    held = performer.perform(LINE)
    still = np.tile(row["weights"], (len(held), 1))
    rigged = performer.rigged(held.__class__(held.times, held.poses, still, held.fps, LINE))
    assert row["channels"] == pytest.approx(rigged.weights[len(still) // 2].tolist())
    assert len(row["channels"]) > len(performer.poses)


@pytest.mark.parametrize("poseset", ["crab", "facefx", "vrm", "vrm0"])
def test_a_copy_of_a_pose_set_performs_bit_for_bit_as_the_original(tmp_path, poseset):
    workshop, caller = opened(tmp_path, poseset)
    before = bits(workshop)
    told = caller.post("own").json
    home = tmp_path / "posesets" / poseset
    original = {p.relative_to(shipped(poseset)): p for p in shipped(poseset).rglob("*")}
    for part, path in original.items():
        assert path.is_dir() or (home / part).read_bytes() == path.read_bytes()
    assert {*told["wrote"]} == {
        f"posesets/{poseset}/{part.as_posix()}" for part, p in original.items() if p.is_file()
    }
    assert caller.api("character").json["own"]
    assert workshop.performer.model in {None, home / "model.glb"}
    assert bits(workshop) == before


def test_a_pose_set_that_extends_another_is_told_whole_and_edited_in_its_own_file(tmp_path):
    workshop, caller = opened(tmp_path, "vrm0")
    stated = caller.api("character").json["stated"]
    model = LIBRARY.poseset("vrm0").model
    assert stated["targets"]["aa"][0]["weights"] == dict(model.targets["aa"][0].weights)
    assert stated["constraints"]["pairs"][0]["between"] == ["u", "i"]
    caller.post("own")
    pairs = [{**pair, "threshold": 1.5} for pair in stated["constraints"]["pairs"]]
    edits = [
        {"file": "poseset", "at": ["targets", "aa"], "value": {"weights": {"a": 0.5}}},
        {"file": "poseset", "at": ["constraints", "pairs"], "value": pairs},
    ]
    assert caller.post("edit", {"title": "Edit", "edits": edits}).status == 200
    caller.post("save")
    made = Library([tmp_path]).poseset("vrm0").model
    assert made.targets["aa"][0].weights == {"a": 0.5}
    assert {pair.threshold for pair in made.constraints.pairs} == {1.5}
    assert {**made.targets, "aa": ()} == {**model.targets, "aa": ()}
    assert workshop.performer.poses == tuple(model.poses)


def test_banks_of_the_project_come_first_after_the_copy_too(tmp_path):
    banks = tmp_path / "posesets/crab/banks"
    banks.mkdir(parents=True)
    curves = "{mouthOpen: [[0, 0.3], [0.5, 1], [1, 0.2]]}"
    head = "kind: bank\nformat: 1\nname: common\nposeset: crab\n"
    text = f"{head}bigrams:\n  bmp-aa: {{curves: {curves}}}\n"
    (banks / "common.yaml").write_text(text)
    workshop, caller = opened(tmp_path)
    before = bits(workshop)
    assert caller.post("own").status == 200
    assert (banks / "common.yaml").read_text() == text
    assert (banks / "z-common.yaml").is_file()
    assert bits(workshop) == before


def test_a_copy_never_overwrites(tmp_path):
    _, caller = opened(tmp_path)
    home = tmp_path / "posesets/crab"
    home.mkdir(parents=True)
    (home / "model.glb").write_bytes(b"mine")
    refused = caller.post("own")
    assert refused.status == 422
    assert "model.glb" in refused.json["error"]
    assert [path.name for path in home.rglob("*")] == ["model.glb"]
    (home / "model.glb").unlink()
    assert caller.post("own").status == 200
    assert "this pose set" in caller.post("own").json["error"]


def test_a_copy_that_would_not_be_used_is_refused(tmp_path):
    shutil.copytree(shipped("crab"), tmp_path / "first/posesets/crab")
    workshop = Workshop(tmp_path / "project", [tmp_path / "first"], engine="none")
    workshop.open("english", "crab")
    assert "precedence" in Caller(workshop).post("own").json["error"]
    assert not (tmp_path / "project").exists()


def glb(change, poseset="crab"):
    """Return the model of a pose set, with its JSON changed."""
    content = (shipped(poseset) / "model.glb").read_bytes()
    length = struct.unpack_from("<I", content, 12)[0]
    document = change(content[20 : 20 + length].rstrip(b" "))
    document += b" " * (-len(document) % 4)
    rest = content[20 + length :]
    head = struct.pack(
        "<4sIIII", b"glTF", 2, 20 + len(document) + len(rest), len(document), 0x4E4F534A
    )
    return head + document + rest


LIES = {
    "of the whole": lambda: glb(bytes)[:8] + b"\xff\xff\xff\x7f" + glb(bytes)[12:],
    "of a chunk": lambda: glb(bytes)[:12] + b"\xff\xff\xff\x7f" + glb(bytes)[16:],
    "cut off": lambda: glb(bytes)[:5000],
    "of a view": lambda: glb(lambda text: text.replace(b'"byteLength":', b'"byteLength":9', 3)),
    "of an accessor": lambda: glb(lambda text: text.replace(b'"count":', b'"count":99999999', 2)),
    "no model": lambda: b"<!DOCTYPE html>",
    "empty": lambda: b"",
}


@pytest.mark.parametrize("lie", LIES)
def test_a_model_that_lies_about_its_lengths_is_refused(tmp_path, lie):
    for route in ("model", "drafted"):
        answer = opened(tmp_path)[1].post(route, LIES[lie](), {"name": "lying.glb"})
        assert answer.status == 422
        assert "lying.glb" in answer.json["error"]
        assert str(Path(gettempdir())) not in answer.json["error"]
    assert not [*tmp_path.rglob("*.glb")]


def test_a_model_is_put_beside_the_character_and_never_over_another(tmp_path):
    _, caller = opened(tmp_path)
    told = caller.post("model", glb(bytes), {"name": "../my crab.glb"}).json
    assert told == {"name": "my-crab.glb", "shown": 8, "channels": 8, "missing": []}
    assert (tmp_path / "characters/my-crab.glb").read_bytes() == glb(bytes)
    assert caller.post("model", glb(bytes), {"name": "my crab.glb"}).status == 200
    other = glb(lambda text: text + b"  ")
    assert (
        "another model with this name"
        in caller.post("model", other, {"name": "my crab.glb"}).json["error"]
    )
    assert "as GLB" in caller.post("model", b"{}", {"name": "my.gltf"}).json["error"]


def test_a_model_without_these_poses_is_refused_and_a_character_is_drafted_from_it(tmp_path):
    _, caller = opened(tmp_path, "facefx")
    assert caller.post("model", glb(bytes), {"name": "crab.glb"}).status == 422
    told = caller.post("drafted", glb(bytes), {"name": "crab.glb", "as": "krabbe"}).json
    assert told["match"] == "8 of 8 poses of crab"
    assert {*told["wrote"]} == {"characters/krabbe.yaml", "characters/crab.glb"}
    assert Library(project=tmp_path).character("krabbe").model.poseset == "crab"


def test_a_model_is_shown_as_it_is_and_an_edit_says_how_to_make_a_character(tmp_path, monkeypatch):
    shutil.copy(shipped("crab") / "model.glb", tmp_path / "my.glb")
    monkeypatch.chdir(tmp_path)
    workshop, caller = opened(tmp_path, "my.glb")
    assert workshop.performer.poses
    assert caller.post("warm").status == 200
    edit = {"file": "character", "at": ["targets", "aa"], "value": {"mouthOpen": 0.5}}
    told = caller.post("edit", {"title": "Edit", "edits": [edit]})
    assert (told.status, "characters new" in told.json["error"]) == (422, True)


def renamed(model, rig):
    """Return a change of a model's JSON: its shapes get the names of a rig's channels."""
    names = dict(zip(model.shape_names, rig.channels, strict=False))

    def change(text):
        for old, new in names.items():
            text = text.replace(f'"{old}"'.encode(), f'"{new}"'.encode())
        return text

    return change


def test_a_rig_is_offered_for_a_model_before_anything_is_written(tmp_path):
    _, caller = opened(tmp_path, "facefx")
    rig = LIBRARY.load(shipped("facefx") / "rigs/facefx-to-oculus.yaml", "rig").model
    head = glb(renamed(read_model(shipped("facefx") / "model.glb"), rig), "facefx")
    offer = caller.post("model", head, {"name": "head.glb"}).json["offer"]
    assert offer["rig"] == "facefx-to-oculus"
    assert 0 < offer["shown"] <= offer["poses"]
    assert not [*tmp_path.rglob("*.glb")]
    assert caller.post("model", head, {"name": "head.glb", "rig": ""}).status == 422  # declined
    told = caller.post("model", head, {"name": "head.glb", "rig": offer["rig"]}).json
    assert told["name"] == "head.glb"
    edits = [
        {"file": "character", "at": ["model"], "value": told["name"]},
        {"file": "character", "at": ["rig"], "value": offer["rig"]},
    ]
    assert caller.post("edit", {"title": "Model", "edits": edits}).status == 200
    assert caller.api("character").json["rig"] == "facefx-to-oculus"
    again = caller.post("model", head, {"name": "head.glb"}).json
    assert "offer" not in again


def test_a_mouth_of_the_character_is_solved_again_and_undone(tmp_path):
    (tmp_path / "characters").mkdir()
    face(tmp_path / "characters" / "head.glb", *ARKIT)
    text = "kind: character\nformat: 1\nname: anna\nposeset: arkit\nmodel: head.glb\n"
    (tmp_path / "characters" / "anna.yaml").write_text(text)
    workshop, caller = opened(tmp_path, "anna")

    def shown():
        told = {one["name"]: one for one in caller.api("character").json["mouths"]}
        return told["aa"]["own"], told["aa"]["steps"], len(told["ow"]["steps"])

    usual, before = [{"aperture": 0.24, "width": -0.009, "firm": 1.2}], bits(workshop)
    assert shown() == (False, usual, 2)
    wide = {"aperture": 0.5, "width": 0.02}
    edit = {"file": "character", "at": ["mouths", "aa"], "value": wide}
    assert caller.post("edit", {"title": "Mouth of aa", "edits": [edit]}).status == 200
    assert shown() == (True, [wide], 2)
    assert bits(workshop) != before
    assert caller.post("undo", {}).status == 200
    assert shown() == (False, usual, 2)
    assert bits(workshop) == before
