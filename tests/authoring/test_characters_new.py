"""Characters drafted from models: recognition, files, and speech."""

import json
from pathlib import Path

import face_models
import pytest
from lanes import full
from packs_tree import plant
from shipped import LIBRARY, POSESETS
from small_models import glb

from lipsync_lang.faces.rigs.face_on_model import find
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.faces.rigs.recognise import recognise
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models.rig_models import channels_of
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.schedules import read_schedule

SETS = {name: LIBRARY.poseset(name).model for name in POSESETS}
RIGS = [(name, rig) for name in SETS for rig in LIBRARY.rigs(name)]
assert SETS, "a sweep over nothing passes"
assert RIGS, "a sweep over nothing passes"

LINE = [
    {"label": label, "start": n / 10, "end": (n + 1) / 10}
    for n, label in enumerate(["HH", "AH", "L", "OW", "F", "AA", "DH", "ER", "P"])
]


def new(cli, *arguments):
    """Make a character, and return the messages and the pack."""
    ended = cli("characters", "new", *arguments)
    assert ended.code == 0, ended.err
    return ended.err, Library().character(arguments[0]).model


def speak(cli, name):
    """Animate the model of a character, and return the moving shapes and bones."""
    Path("line.json").write_text(json.dumps(LINE), "utf-8")
    ended = cli("validate", *(f for f in ("characters", "posesets") if Path(f).exists()))
    assert (ended.code, ended.out) == (0, ""), ended.out
    out = Path(f"{name}-line.glb")
    ended = cli("run", "--schedule", "line.json", "-l", "english", "-c", name, "-o", out)
    assert ended.code == 0, ended.err
    return read_model(out)


def moved(model):
    """The targets of a model's animation."""
    nodes = model.document["nodes"]
    return {
        (nodes[channel["target"]["node"]]["name"], channel["target"]["path"])
        for animation in model.document["animations"]
        for channel in animation["channels"]
    }


# What fits is taken


PARTED_WIDTH = 0.8
"""Distance between the outermost points of the small head whose lips come apart."""


@pytest.mark.parametrize(("widths", "level"), [(0.55, None), (0.7, 0.79), (0.4, 1.38), (0.1, 1.6)])
def test_a_mouth_opens_as_far_as_a_set_of_declared_targets_expects(
    cli, folder, monkeypatch, widths, level
):
    monkeypatch.setitem(face_models.OPENINGS, "jawOpen", widths * PARTED_WIDTH)
    face_models.face(folder / "head.glb", *face_models.ARKIT)
    plain = folder / "posesets" / "plain" / "poseset.yaml"
    plain.parent.mkdir(parents=True)
    head = "kind: poseset\nformat: 1\nname: plain\nextends: arkit\n"
    plain.write_text(f"{head}poses: {{jawOpen: {{}}}}\nmouth: declared\n", "utf-8")
    told, character = new(cli, "hero", "--model", folder / "head.glb", "--poseset", "plain")
    found = character.dials.get("jaw")
    assert (found and found[0][1]) == level
    assert ("measured: the mouth opens" in told) == (level is not None)
    Path("line.json").write_text(json.dumps(LINE), "utf-8")
    hero, usual = (
        resolve("english", name).perform(read_schedule(Path("line.json")))["jawOpen"].max()
        for name in ("hero", "plain")
    )
    if widths > 0.3:  # a mouth that hardly opens is not forced
        assert hero * widths == pytest.approx(usual * 0.55, rel=0.06)


def test_a_mouth_of_solved_targets_needs_no_dial(cli, folder, monkeypatch):
    Path("line.json").write_text(json.dumps(LINE), "utf-8")
    opened = []
    for number, widths in enumerate((0.4, 0.55, 0.7)):
        monkeypatch.setitem(face_models.OPENINGS, "jawOpen", widths * PARTED_WIDTH)
        face_models.face(folder / f"head{number}.glb", *face_models.ARKIT)
        _, character = new(cli, f"hero{number}", "--model", folder / f"head{number}.glb")
        assert not character.dials
        schedule = read_schedule(Path("line.json"))
        made = resolve("english", f"hero{number}").perform(schedule)
        opened.append(made["jawOpen"].max() * widths)
    assert opened == pytest.approx([opened[0]] * 3, rel=0.15)


@pytest.mark.parametrize("name", SETS)
def test_every_pose_set_is_recognised_by_its_own_names(name, tmp_path):
    model = read_model(glb(tmp_path / "face.glb", *SETS[name].poses))
    best = recognise(LIBRARY, model)[0]
    assert (best.poseset, best.rig, best.shown) == (name, None, len(SETS[name].poses))
    assert best.complete
    assert not best.left
    assert not best.losses


@pytest.mark.parametrize(("poseset", "rig"), RIGS, ids=[rig.model.name for _, rig in RIGS])
def test_every_rig_is_recognised_by_its_own_names(poseset, rig, tmp_path):
    channels = channels_of(rig.model)
    shapes = [name for name, channel in channels.items() if channel.node is None]
    bones = [channel.node for channel in channels.values() if channel.node is not None]
    model = read_model(glb(tmp_path / "face.glb", *shapes, bones=bones))
    match = next(m for m in recognise(LIBRARY, model) if m.rig == rig.model.name)
    assert match.poseset == poseset
    assert match.complete


HEADS_OF_MAKERS = json.loads(Path(__file__).with_name("heads_of_makers.json").read_text("utf-8"))
"""Shapes of heads, with their pose set and rig, and the number of its poses that are shown."""


@pytest.mark.parametrize("kind", HEADS_OF_MAKERS)
def test_heads_of_well_known_makers_get_their_sets(kind, tmp_path):
    shapes, poseset, rig, shown = HEADS_OF_MAKERS[kind]
    best = recognise(LIBRARY, read_model(glb(tmp_path / "head.glb", *shapes)))[0]
    assert (best.poseset, best.rig, best.shown) == (poseset, rig, shown), str(best)
    assert best.enough
    assert not best.found.doubts


@pytest.mark.parametrize("name", ["007", "no", "1e5"])
def test_names_that_yaml_would_misread_are_quoted(cli, folder, name):
    glb(folder / "x.glb", "MouthOpen", "LowerLipIn", "UpperLipIn", "TongueUp", "LowerLipOut")
    assert cli("posesets", "new", name, "a", "b").code == 0
    assert cli("characters", "new", name, "--model", "x.glb", "--poseset", "facefx").code == 0
    (folder / "sounds.txt").write_text("p a t i k u\n")
    assert cli("languages", "new", name, "--inventory", "sounds.txt", "--tag", "art-x-a").code == 0
    ended = cli("validate", "--no-tests")
    assert (ended.code, ended.out.count(" P")) == (0, 0), ended.out


def test_a_set_that_suits_a_head_badly_is_doubted(cli, folder):
    glb(folder / "x.glb", "MouthOpen", "Smile", "Frown")
    err, _ = new(cli, "x", "--model", "x.glb", "--poseset", "crab")
    assert "doubtful: the head has 3 of 8 poses of crab" in err


def test_a_character_of_a_model_with_known_names(cli, folder):
    glb(folder / "face.glb", *SETS["crab"].poses)
    said, made = new(cli, "anna", "--model", "face.glb", "--title", "  Anna  B ")
    assert (made.poseset, made.rig, made.model, made.title) == (
        "crab", None, "../face.glb", "Anna B",
    )  # fmt: skip
    assert "8 shapes in one mesh; 8 of 8 poses of crab\n" in said
    assert "-c anna -o anna.glb" in said
    assert moved(speak(cli, "anna")) == {("head", "weights")}


@full
def test_a_model_elsewhere_is_copied_and_a_copy_is_used_again(cli, folder, tmp_path_factory):
    model = glb(tmp_path_factory.mktemp("other") / "face.glb", *SETS["vrm"].poses)
    said, made = new(cli, "anna", "--model", model)
    assert made.model == "face.glb"
    assert "face.glb: a copy of " in said
    assert (folder / "characters/face.glb").read_bytes() == model.read_bytes()
    said, made = new(cli, "bea", "--model", model)
    assert made.model == "face.glb"
    assert "a copy of" not in said
    speak(cli, "bea")
    glb(model, *SETS["crab"].poses)
    ended = cli("characters", "new", "cleo", "--model", model)
    assert ended.code == 2
    assert "face.glb: already exists and differs; use that model, or move it" in ended.err
    assert not (folder / "characters/cleo.yaml").exists()


def test_the_model_itself_is_not_proposed_to_be_written(cli, folder):
    glb(folder / "anna.glb", *SETS["vrm"].poses)
    said, _ = new(cli, "anna", "--model", "anna.glb")
    assert "-o anna-line.glb" in said


@full
def test_a_head_with_two_sets_of_shapes(cli, folder, data):
    model = data / "rigs/head_arkit52_oculus15.glb"
    said, made = new(cli, "anna", "--model", model)
    assert (made.poseset, made.rig) == ("arkit", None)
    assert "67 shapes in 6 meshes; 17 of 17 poses of arkit\n" in said
    assert "or 14 of 14 poses of oculus: --poseset oculus\n" in said
    assert len(moved(speak(cli, "anna"))) == 6
    said, made = new(cli, "bea", "--model", model, "--poseset", "facefx")
    assert made.rig in {rig.model.name for _, rig in RIGS}
    assert not (folder / "posesets").exists()
    speak(cli, "bea")
    said, made = new(cli, "cleo", "--model", model, "--rig", "facefx-to-arkit")
    assert (made.poseset, made.rig) == ("facefx", "facefx-to-arkit")
    assert "lost: tRoof: " in said


# What fits in part gets a rig of its own


@full
def test_only_some_shapes(cli, folder):
    glb(folder / "face.glb", "Jaw_Open", "Mouth_Pucker", "Mouth_Funnel", "Mouth_Close", "Blink")
    said, made = new(cli, "anna", "--model", "face.glb", "--poseset", "arkit")
    assert (made.poseset, made.rig) == ("arkit", "anna")
    assert "4 of 17 poses of arkit" in said
    assert "not used: Blink\n" in said
    rig = Library().rigs("arkit")[0].model
    assert channels_of(rig)["Jaw_Open"].gains == {"jawOpen": 1}
    assert len(rig.channels) == 4
    assert len(rig.lost) == 13
    assert all(f"{pose}, " in said or f"{pose}\n" in said for pose in rig.lost)
    speak(cli, "anna")


@full
def test_pairs_that_are_one_shape(cli, folder):
    shapes = dict.fromkeys(
        pose.removesuffix("Left").removesuffix("Right") for pose in SETS["arkit"].poses
    )
    glb(folder / "face.glb", *shapes)
    said, made = new(cli, "anna", "--model", "face.glb")
    assert made.rig == "anna"
    assert "approximate: mouthPressLeft and mouthPressRight share one shape, mouthPress\n" in said
    channels = channels_of(Library().rigs("arkit")[0].model)
    assert channels["mouthPress"].gains == {"mouthPressLeft": 0.5, "mouthPressRight": 0.5}
    assert set(channels) == set(shapes)
    speak(cli, "anna")


@full
def test_shapes_that_are_pairs_are_found_without_a_rig(cli, folder):
    some = [pose for pose in SETS["arkit"].poses if pose != "mouthPucker"]
    glb(folder / "face.glb", *some, "MOUTH_PUCKER_L", "MOUTH_PUCKER_R")
    _, made = new(cli, "anna", "--model", "face.glb")
    assert (made.poseset, made.rig) == ("arkit", None)
    speak(cli, "anna")


@full
def test_a_rig_in_part_keeps_its_gains_limits_and_reasons(cli, folder):
    known = next(rig.model for _, rig in RIGS if rig.model.name == "facefx-to-arkit")
    shapes = [f"head_{name}" for name in channels_of(known) if name != "tongueOut"]
    glb(folder / "face.glb", *shapes)
    said, made = new(cli, "anna", "--model", "face.glb", "--poseset", "facefx")
    assert made.rig == "anna"
    assert "that the model lacks: tongueOut\n" in said
    text = Path("posesets/facefx/rigs/anna.yaml").read_text("utf-8")
    assert '"head_mouthPress{Left,Right}": ' in text
    rig = next(rig.model for rig in Library().rigs("facefx") if rig.model.name == "anna")
    channels, whole = channels_of(rig), channels_of(known)
    assert channels["head_mouthClose"].at_most == "head_jawOpen"
    assert [*channels] == shapes
    for name in shapes:
        assert channels[name].gains == whole[name.removeprefix("head_")].gains
    assert rig.lost["tRoof"] == known.lost["tRoof"]
    assert "tTeeth" in rig.lost
    speak(cli, "anna")


RIG = """\
kind: rig
format: 1
name: bony
title: Bony
poseset: crab
channels:
  jaw: {node: Jaw, rotation: [1, 0, 0], gains: {mouthOpen: 12}}
  round: {gains: {mouthOO: 1}, at_most: jaw}
  gone: {node: Gone, translation: [0, 1, 0], gains: {smile: 1}}
lost: {frown: none, bareTeeth: none, tongueTip: none, tongueBack: none, tongueOut: none}
"""


def test_bones_of_a_rig_are_found_by_their_nodes(cli, folder):
    rig = folder / "posesets/crab/rigs/bony.yaml"
    rig.parent.mkdir(parents=True)
    rig.write_text(RIG, "utf-8")
    glb(folder / "face.glb", "Round", bones=["Jaw", "Neck"])
    said, made = new(cli, "anna", "--model", "face.glb", "--rig", "bony")
    assert made.rig == "anna"
    assert "that the model lacks: gone\n" in said
    made = next(r.model for r in Library().rigs("crab") if r.model.name == "anna")
    assert made.channels["jaw"].node == "Jaw"
    assert made.channels["jaw"].gains == {"mouthOpen": 12}
    assert set(made.channels) == {"jaw", "Round"}
    assert made.lost["smile"]
    assert moved(speak(cli, "anna")) == {("head", "weights"), ("Jaw", "rotation")}


@full
def test_a_bone_called_like_a_region_is_shown_as_an_example(cli, folder):
    glb(folder / "face.glb", "mouthClose", "mouthPucker", "mouthFunnel", "tongueOut",
        bones=["CC_Base_JawRoot"])  # fmt: skip
    new(cli, "anna", "--model", "face.glb", "--poseset", "arkit")
    path = Path("posesets/arkit/rigs/anna.yaml")
    text = path.read_text("utf-8")
    line = next(line for line in text.splitlines() if "JawRoot" in line)
    text = text.replace("lost:\n", f"{line.replace('#', '', 1)[1:]}\nlost:\n")
    text = "\n".join(row for row in text.splitlines() if not row.startswith("  jawOpen:"))
    path.write_text(text + "\n", "utf-8")
    assert ("CC_Base_JawRoot", "rotation") in moved(speak(cli, "anna"))


@full
def test_meshes_may_have_prefixes_of_their_own(cli, folder):
    poses = [*SETS["crab"].poses]
    meshes = {mesh: [f"{mesh}_geo_{pose}" for pose in poses] for mesh in ("shell", "teeth")}
    glb(folder / "face.glb", **meshes)
    said, made = new(cli, "anna", "--model", "face.glb")
    assert (made.poseset, made.rig) == ("crab", None)
    assert "16 shapes in 2 meshes" in said
    assert len(moved(speak(cli, "anna"))) == 2


def test_a_model_is_performed_as_the_character_that_is_drafted_from_it(cli, folder):
    rigs = set()
    for poseset, rig in RIGS:
        channels = channels_of(rig.model)
        shapes = [name for name, channel in channels.items() if channel.node is None]
        bones = [channel.node for channel in channels.values() if channel.node is not None]
        model = glb(folder / "face.glb", *shapes, bones=bones)
        rigs.add(recognise(LIBRARY, read_model(model))[0].rig)
        new(cli, rig.model.name, "--model", model)
        drafted = speak(cli, rig.model.name)
        out = Path("out.glb")
        ended = cli("run", "--schedule", "line.json", "-l", "english", "-c", model, "-o", out)
        assert ended.code == 0, ended.err
        assert "face.glb: performed with the poses of " in ended.err
        assert moved(read_model(out)) == moved(drafted), poseset
        assert read_model(out).chunks == drafted.chunks
    assert {None} < rigs, "models that need a rig, and models that need none"


def test_a_model_names_its_character_and_is_what_is_drawn(folder):
    path = glb(folder / "FACE.GLB", *SETS["crab"].poses)
    performer = resolve("english", path)
    assert (performer.character, performer.compiled.poseset) == ("FACE", "crab")
    assert performer.model == path.resolve()


@pytest.mark.parametrize(
    ("command", "said"),
    [
        (("run", "Hello", "-c", "odd.glb"), "odd.glb: no pose set knows its shapes (alpha, beta)"),
        (("run", "Hello", "-c", "few.glb"), "few.glb: no pose set knows its shapes (tongueOut"),
        (("run", "Hello", "-c", "none.glb"), "none.glb: cannot be read: No such file"),
        (
            ("bank", "draft", "-c", "face.glb"),
            "make a character of it with `lipsync-lang characters new`",
        ),
    ],
)
def test_a_model_that_cannot_be_performed(command, said, cli, folder):
    glb(folder / "odd.glb", "alpha", "beta")
    glb(folder / "few.glb", "tongueOut", "alpha", "beta", "gamma")
    glb(folder / "face.glb", *SETS["crab"].poses)
    ended = cli(*command, "-l", "english")
    assert (ended.code, ended.out) == (2, "")
    assert said in ended.err


# What does not fit, and what is misused


def test_a_model_that_nobody_knows(cli, folder):
    glb(folder / "face.glb", "alpha", "beta", "tongueOut", "gamma")
    ended = cli("characters", "new", "anna", "--model", "face.glb")
    assert ended.code == 2
    assert "face.glb: no pose set knows its shapes" in ended.err
    assert "It has alpha, beta, tongueOut, gamma" in ended.err
    assert "lipsync-lang posesets new anna --model face.glb" in ended.err
    assert not (folder / "characters").exists()
    assert not (folder / "posesets").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((), "characters new NAME --model FILE"),
        (("anna",), "characters new NAME --model FILE"),
        (("a/b", "--model", "face.glb"), "'a/b' cannot be a pack's name"),
        (("anna", "--model", "none.glb"), "none.glb: cannot be read: No such file"),
        (("anna", "--model", "text.glb"), "text.glb: is not GLB; it seems to be something else"),
        (("anna", "--model", "bare.glb"), "bare.glb: no mesh has morph targets (meshes: head)"),
        (("anna", "--model", "twice.glb"), "'head': several morph targets share a name: a"),
        (("anna", "--model", "blank.glb"), "'head': its morph target 1 has no name"),
        (("anna", "--model", "face.glb", "--poseset", "carb"), "did you mean 'crab'?"),
        (("anna", "--model", "face.glb", "--rig", "facefx-to-arkti"), "mean 'facefx-to-arkit'?"),
        (("anna", "--model", "face.glb", "--poseset", "crab", "--rig", "x"), "unknown rig 'x'"),
        (("anna", "--model", "face.glb", "--poseset", "crab"), "pose set 'crab' knows none of its"),
        (("anna", "--model", "face.glb", "--rig", "facefx-to-arkit"), "knows none of its shapes"),
    ],
)
def test_bad_input_is_told_and_nothing_is_written(arguments, said, cli, folder):
    glb(folder / "face.glb", "Fcl_MTH_A", "Fcl_MTH_I", "Fcl_MTH_U", "Fcl_MTH_E", "Fcl_MTH_O")
    glb(folder / "bare.glb", head=())
    glb(folder / "twice.glb", "a", "a")
    glb(folder / "blank.glb", "a", " ")
    (folder / "text.glb").write_text("hello")
    before = sorted(folder.rglob("*"))
    ended = cli("characters", "new", *arguments)
    assert ended.code == 2
    assert said in ended.err
    assert not ended.out
    assert sorted(folder.rglob("*")) == before


def test_nothing_is_overwritten(cli, folder):
    glb(folder / "face.glb", "jawOpen", "mouthClose", "mouthPucker", "mouthFunnel")
    new(cli, "anna", "--model", "face.glb", "--poseset", "arkit")
    ended = cli("characters", "new", "anna", "--model", "face.glb")
    assert ended.code == 2
    assert "characters/anna.yaml: already exists; choose another name" in ended.err
    Path("characters/anna.yaml").unlink()
    before = Path("posesets/arkit/rigs/anna.yaml").read_text("utf-8")
    ended = cli("characters", "new", "anna", "--model", "face.glb", "--rig", "facefx-to-arkit")
    assert ended.code == 0  # its rig is one of another pose set
    ended = cli(
        "characters", "new", "facefx-to-vrm", "--model", "face.glb", "--rig", "facefx-to-arkit"
    )
    assert ended.code == 2
    assert "facefx-to-vrm.yaml: already exists; choose another name" in ended.err
    assert Path("posesets/arkit/rigs/anna.yaml").read_text("utf-8") == before


def test_a_rig_is_not_written_where_it_is_not_looked_for(cli, folder):
    plant(folder / "packs")
    glb(folder / "face.glb", "open")
    ended = cli(
        "characters", "new", "zoe", "--model", "face.glb", "--poseset", "face", "--path", "packs"
    )
    assert ended.code == 2
    assert "must be beside pose set 'face'" in ended.err
    assert "change to packs first" in ended.err
    assert not (folder / "characters").exists()


def test_unsound_packs_are_passed_over(folder):
    bad = folder / "posesets/facefx/rigs/bad.yaml"
    bad.parent.mkdir(parents=True)
    bad.write_text(RIG.replace("bony", "bad").replace("crab", "facefx"), "utf-8")
    (folder / "posesets/broken").mkdir()
    (folder / "posesets/broken/poseset.yaml").write_text("kind: [", "utf-8")
    model = read_model(glb(folder / "face.glb", *SETS["facefx"].poses, bones=["Jaw"]))
    found = recognise(Library(), model)
    assert found[0].name == "facefx"
    assert "bad" not in {match.rig for match in found}


@full
def test_json_says_the_same(cli, folder):
    glb(folder / "face.glb", "jawOpen", "mouthClose", "mouthPucker", "mouthFunnel", "extra")
    ended = cli("characters", "new", "anna", "--model", "face.glb", "--poseset", "arkit", "--json")
    told = json.loads(ended.out)
    assert told["rig"] == "anna"
    assert told["wrote"] == ["characters/anna.yaml", "posesets/arkit/rigs/anna.yaml"]
    assert told["match"]["poseset"] == "arkit"
    assert told["match"]["channels"]["jawOpen"] == ["jawOpen"]
    assert told["match"]["left"] == ["extra"]
    assert len(told["match"]["lost"]) == 13
    assert "wrote characters/anna.yaml" in ended.err


def test_nothing_is_found_of_no_channels(tmp_path):
    assert not find((), read_model(glb(tmp_path / "face.glb", "a"))).places
