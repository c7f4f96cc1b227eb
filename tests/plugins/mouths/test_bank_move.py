"""A moved bank shows the same mouths, reports its losses, and refuses faulty input."""

import json

import numpy as np
import pytest
import yaml
from face_models import ARKIT, face
from hypothesis import given
from hypothesis import strategies as st
from lanes import costly, full
from places import ROOT
from shipped import LIBRARY

from lipsync_lang.base.errors import LipsyncError, PackError
from lipsync_lang.faces.rigs import read_outs
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.pipeline.curve import bspline
from lipsync_lang.plugins.mouths.bank_move import AT, MOST_KNOTS, move_bank
from lipsync_lang.plugins.mouths.measured_face import MeasuredFace

CRAB = ROOT / "posesets" / "crab" / "model.glb"

DRAWN = {
    "w-iy": {
        "open": [[0, 0], [0.35, 0.05], [0.5, 0.1], [0.65, 0.47], [0.85, 0.32], [1, 0]],
        "W": [[0, 0], [0.15, 0.67], [0.35, 1], [0.5, 0.39], [0.65, 0]],
    },
    "bmp-aa": {
        "open": [[0.4, 0], [0.65, 0.76], [0.85, 0.64], [1, 0]],
        "PBM": [[0, 0], [0.15, 0.63], [0.35, 0.98], [0.5, 0.8], [0.65, 0]],
    },
    "kg-ow": {
        "open": [[0, 0], [0.35, 0.3], [0.65, 0.6], [1, 0]],
        "W": [[0.3, 0], [0.65, 0.5], [0.85, 0.9], [1, 0]],
        "tBack": [[0, 0], [0.2, 1], [0.4, 1], [0.6, 0]],
        "tTeeth": [[0, 0], [0.2, 0.4], [0.4, 0.4], [0.6, 0]],
    },
}
"""Bigrams over the poses of facefx; each curve has times of its own."""


def bank(path, bigrams, poseset="facefx", **rest):
    """Write a bank."""
    own = {name: {"curves": curves} for name, curves in bigrams.items()}
    head = {"kind": "bank", "format": 1, "name": path.stem, "poseset": poseset}
    path.write_text(yaml.safe_dump(head | {"bigrams": own} | rest, sort_keys=False), "utf-8")
    return path


def course(face, curves):
    """Return the measures (3, n) of a bigram on a face; lips do not pass each other."""
    drawn = {pose: bspline(np.array([points], float), AT)[0] for pose, points in curves.items()}
    weights = np.array([drawn.get(pose, 0 * AT) for pose in face.poses])
    measures = face.gains @ weights
    measures[0] = np.maximum(0.0, measures[0])
    return measures


@st.composite
def bigrams(draw):
    """Draw curves of some poses of facefx, each with its own times."""
    poses = draw(st.lists(st.sampled_from(["open", "W", "PBM", "wide", "tRoof"]), min_size=1))
    tenths = st.lists(st.integers(0, 10), min_size=2, max_size=6, unique=True).map(sorted)
    weight = st.integers(0, 100).map(lambda one: one / 100)
    return {pose: [[t / 10, draw(weight)] for t in draw(tenths)] for pose in poses}


@costly()
@given(curves=bigrams())
def test_a_bank_that_moves_to_its_own_face_keeps_its_curves(tmp_path_factory, curves):
    path = bank(tmp_path_factory.mktemp("bank") / "own.yaml", {"w-iy": curves})
    moved = move_bank(LIBRARY, path, None, "facefx")
    for pose, points in moved.bank["bigrams"]["w-iy"]["curves"].items():
        assert points == [[float(t), float(v)] for t, v in curves.get(pose, ())], pose
    assert {*moved.bank["bigrams"]["w-iy"]["curves"]} == {*curves}
    assert max(one.loss for one in moved.losses) < 1e-9


@pytest.fixture
def there(folder):
    """Move the drawn bank to the model of the crab."""
    return move_bank(Library(), bank(folder / "drawn.yaml", DRAWN), None, str(CRAB))


def test_the_course_follows_and_each_loss_is_true(there):
    told = {(one.bigram, one.measure): one for one in there.losses}
    for name, curves in DRAWN.items():
        asked = course(there.source, curves)
        reached = course(there.goal, there.bank["bigrams"][name]["curves"])
        assert np.corrcoef(asked[0], reached[0])[0, 1] > 0.9, name
        for number, measure in enumerate(("aperture", "width", "protrusion")):
            miss = np.abs(asked[number] - reached[number]).max()
            assert told[name, measure].loss == pytest.approx(miss, abs=2e-4)
    assert [one.loss for one in there.losses] == sorted(
        (o.loss for o in there.losses), reverse=True
    )


def test_there_and_back_loses_no_more_than_both_moves_tell(folder, there):
    path = folder / "moved.yaml"
    path.write_text(there.yaml("moved"), "utf-8")
    back = move_bank(Library(), path, "crab", "facefx")
    lost = {(one.bigram, one.measure): one.loss for one in there.losses}
    for one in back.losses:
        lost[one.bigram, one.measure] += one.loss
    for name, curves in DRAWN.items():
        away = course(there.source, curves) - course(
            there.source, back.bank["bigrams"][name]["curves"]
        )
        for number, measure in enumerate(("aperture", "width", "protrusion")):
            assert np.abs(away[number]).max() <= lost[name, measure] + 1e-3


def test_a_moved_bank_is_sound_and_keeps_its_times_and_its_facts(folder):
    drawn = bank(folder / "drawn.yaml", DRAWN, style="angry", interpolation="linear")
    content = yaml.safe_load(drawn.read_text("utf-8"))
    facts = {"boundary": 0.4, "contact": "free", "why": "he mumbles", "status": "approved"}
    content["bigrams"]["kg-ow"].update(facts)
    drawn.write_text(yaml.safe_dump(content), "utf-8")
    moved = folder / "posesets" / "crab" / "banks" / "moved.yaml"
    moved.parent.mkdir(parents=True)
    moved.write_text(move_bank(Library(), drawn, None, "crab").yaml("moved"), "utf-8")
    assert not validate(Library(), [moved])
    made = yaml.safe_load(moved.read_text("utf-8"))
    assert (made["style"], made["interpolation"], made["poseset"]) == ("angry", "linear", "crab")
    own = made["bigrams"]["kg-ow"]
    assert {key: own[key] for key in facts} == facts | {"status": "edited"}
    times = {t for curve in DRAWN["kg-ow"].values() for t, _ in curve}
    assert {t for curve in own["curves"].values() for t, _ in curve} <= times


def test_curves_with_many_knots_stay_editable(folder):
    at = np.linspace(0, 1, 60)
    points = np.column_stack([at, 0.5 * np.sin(np.pi * at) ** 2]).tolist()
    moved = move_bank(Library(), bank(folder / "a.yaml", {"w-iy": {"open": points}}), None, "crab")
    curves = moved.bank["bigrams"]["w-iy"]["curves"]
    assert curves
    assert all(len(curve) <= MOST_KNOTS for curve in curves.values())
    asked, reached = course(moved.source, {"open": points}), course(moved.goal, curves)
    assert np.corrcoef(asked[0], reached[0])[0, 1] > 0.95


def test_reach_scales_what_is_asked(folder):
    face = folder / "characters" / "toon.yaml"
    face.parent.mkdir()
    text = "kind: character\nformat: 1\nname: toon\nposeset: crab\nreach: 1.6\n"
    face.write_text(text, "utf-8")
    drawn = bank(folder / "drawn.yaml", DRAWN)
    plain, wide = (move_bank(Library(), drawn, None, name) for name in ("crab", "toon"))
    peaks = [
        course(one.goal, one.bank["bigrams"]["kg-ow"]["curves"])[0].max() for one in (plain, wide)
    ]
    assert peaks[1] > 1.3 * peaks[0]


def test_what_no_pose_shows_is_named_and_what_stands_for_a_pose_too(there, folder):
    assert "tongueBack" in there.stands["tBack"]
    assert not there.lost
    small = {"kind": "poseset", "format": 1, "name": "lips", "model": str(CRAB)}
    small |= {"poses": {"mouthOpen": {}}, "targets": {"aa": {"mouthOpen": 0.8}}}
    path = folder / "posesets" / "lips" / "poseset.yaml"
    path.parent.mkdir(parents=True)
    path.with_name("model.glb").write_bytes(CRAB.read_bytes())
    path.write_text(yaml.safe_dump(small | {"model": "model.glb"}), "utf-8")
    moved = move_bank(Library(), folder / "drawn.yaml", None, "lips")
    assert {(one.pose, one.bigrams) for one in moved.lost} == {
        ("tBack", ("kg-ow",)), ("tTeeth", ("kg-ow",)),
    }  # fmt: skip
    assert "not moved: tBack of kg-ow" in moved.told()


def test_the_command_writes_the_bank_and_tells_the_worst_first(folder, cli):
    bank(folder / "drawn.yaml", DRAWN)
    ended = cli("bank", "move", "drawn.yaml", "--to", "crab", "-o", "moved.yaml", "--json")
    told = json.loads(ended.out)
    assert told["moved"] == [*DRAWN]
    losses = [one["loss"] for one in told["losses"]]
    assert losses == sorted(losses, reverse=True)
    assert len(losses) == 3 * len(DRAWN)
    assert yaml.safe_load((folder / "moved.yaml").read_text("utf-8"))["name"] == "moved"
    assert "no character uses the file yet; state `banks: [moved.yaml]` in its file" in ended.err
    again = cli("bank", "move", "drawn.yaml", "--to", "crab", "-o", "moved.yaml")
    assert again.code == 2
    assert "already there" in again.err
    home = "posesets/crab/banks/moved.yaml"
    ended = cli("bank", "move", "drawn.yaml", "--to", "crab", "-o", home)
    assert ended.err == f"wrote {home}\n"
    (folder / "characters").mkdir()
    who = "kind: character\nformat: 1\nname: anna\nposeset: crab\n"
    (folder / "characters/anna.yaml").write_text(who)
    ended = cli("bank", "move", "drawn.yaml", "--to", "anna", "-o", "own.yaml")
    assert "state `banks: [../own.yaml]` in characters/anna.yaml" in ended.err


def test_bad_input_is_refused_with_its_place(folder, monkeypatch):
    library = Library()
    drawn = bank(folder / "drawn.yaml", DRAWN)
    bad = bank(folder / "bad.yaml", {"l-ow": {"opn": [[0, 0], [1, 0]]}})
    with pytest.raises(PackError, match=r"bad\.yaml:\d+:\d+: P201 unknown pose 'opn'"):
        move_bank(library, bad, None, "crab")
    with pytest.raises(
        LipsyncError, match=r"drawn\.yaml:\d+:\d+: the bank moves the poses of facefx"
    ):
        move_bank(library, drawn, "crab", "facefx")
    with pytest.raises(LipsyncError, match="arkit has no model, so its mouth cannot be measured"):
        move_bank(library, drawn, None, "arkit")
    face(folder / "head.glb", *ARKIT)
    monkeypatch.setattr(read_outs, "MAX_MEASURED_POINTS", 9)
    with pytest.raises(LipsyncError, match=r"measured: .* points are too many to find a mouth in"):
        move_bank(library, drawn, None, str(folder / "head.glb"))
    with pytest.raises(LipsyncError, match=r"nothing\.glb: cannot be read"):
        move_bank(library, drawn, None, "nothing.glb")


@full
def test_on_a_human_head_the_aperture_follows(folder, data):
    head = str(data / "rigs/head_arkit52_oculus15.glb")
    moved = move_bank(Library(), bank(folder / "drawn.yaml", DRAWN), None, head)
    assert moved.goal.poseset.name == "arkit"
    for name, curves in DRAWN.items():
        reached = course(moved.goal, moved.bank["bigrams"][name]["curves"])
        assert np.corrcoef(course(moved.source, curves)[0], reached[0])[0, 1] > 0.9, name
    assert MeasuredFace.open(Library(), head).gains[0].max() > 0.3
