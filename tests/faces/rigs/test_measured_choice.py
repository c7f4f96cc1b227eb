"""Pose sets are chosen by what the shapes of a model do, and a warning names dead shapes."""

import json
import re
import struct
from pathlib import Path

import face_models
import numpy as np
import pytest
from face_models import ACROSS, ARKIT, OCULUS, VROID, face, moved
from hypothesis import given
from hypothesis import strategies as st

import lipsync_lang as ll
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.faces.rigs.face_on_model import FaceOnModel, without
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.faces.rigs.read_outs import read_outs
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


def test_a_dead_jaw_without_another_set_is_told_and_fails_the_check(tmp_path, monkeypatch, best):
    path = face(tmp_path / "head.glb", *ARKIT, dead={"jawOpen"})
    match = best(path)
    assert match.poseset == "arkit"
    assert "on the mesh, nothing moves with jawOpen" in match.found.doubts
    monkeypatch.chdir(tmp_path)
    Path("lipsync.yaml").write_text("kind: project\nformat: 1\nmouth: declared\n")
    animation = ll.resolve("english", path).perform(SCHEDULE)
    told = [*WRITERS["glb"].remarks(animation)]
    assert f"{path}: on the mesh, nothing moves with jawOpen" in told
    assert check(animation)["unopened"].verdict == "FAIL"
    whole = face(tmp_path / "whole.glb", *ARKIT)
    assert check(ll.resolve("english", whole).perform(SCHEDULE))["unopened"].verdict == "ok"


@pytest.mark.parametrize("shapes", [VROID, ARKIT, ("mine",)])
def test_a_head_all_of_whose_shapes_are_still_is_refused_by_every_command(
    cli, tmp_path, monkeypatch, shapes
):
    monkeypatch.chdir(tmp_path)
    face(tmp_path / "head.glb", *shapes, dead=shapes)
    Path("line.tsv").write_text("0\t0.2\tM\n0.2\t0.4\tAA\n")
    Path("characters").mkdir()
    line = ("-l", "english", "--schedule", "line.tsv")
    for fields, who in (
        ("", "head.glb"),
        ("rig: facefx-to-arkit\nposeset: facefx\n", "anna"),
        ("poseset: arkit\n", "anna"),
        ("mouth: declared\nposeset: vrm\n", "anna"),
    ):
        own = f"kind: character\nformat: 1\nname: anna\nmodel: ../head.glb\n{fields}"
        Path("characters/anna.yaml").write_text(own)
        for command in (
            ("run", *line, "-c", who, "-o", "line.csv"), ("check", *line, "-c", who),
            ("characters", "new", "bea", "--model", "head.glb"),
        ):  # fmt: skip
            ended = cli(*command)
            asked = "declared" in fields and command[0] != "characters"
            assert (ended.code == 2) != asked, (command, fields, ended)
            told = asked or f"on the mesh, nothing moves with {shapes[0]}" in ended.err
            assert told, (command, fields, ended)
        assert Path("line.csv").exists() == ("declared" in fields)
    Path("line.csv").unlink()
    Path("lipsync.yaml").write_text("kind: project\nformat: 1\nmouth: declared\n")
    kept = [cli("run", *line, "-c", who, "-o", "line.csv") for who in ("head.glb", "anna")]
    told = f"head.glb: on the mesh, nothing moves with {shapes[0]}"
    assert [ended.code for ended in kept] == ([2, 0] if shapes == ("mine",) else [0, 0])
    assert told in kept[0].err


VOWELS = {f"viseme_{name}": name for name in ("aa", "O", "E", "I", "U")}
"""Visemes of the scanned head, and the names that avatars of another maker have for them."""


def changed(head, dead, renamed):
    """Return a GLB whose shapes of some names move no point, and others have other names."""
    size = struct.unpack_from("<I", head, 12)[0]
    document = json.loads(head[20 : 20 + size])
    for mesh in document["meshes"]:
        names = mesh["extras"]["targetNames"]
        mesh["extras"]["targetNames"] = [renamed.get(name, name) for name in names]
        for primitive in mesh["primitives"]:
            for name, target in zip(names, primitive["targets"], strict=True):
                if name in dead:
                    target.clear()
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    rest = struct.pack("<I4s", len(text), b"JSON") + text + head[20 + size :]
    return struct.pack("<4sII", b"glTF", 2, 12 + len(rest)) + rest


@pytest.mark.parametrize(
    ("renamed", "dropped", "poseset", "widest"),
    [
        ({}, (), "oculus", ("viseme_aa", 0.35)),
        ({**VOWELS, "viseme_aa": "A"}, (), "vrm0", ("A", 0.35)),
        ({}, OCULUS, "arkit", ("mouthFunnel", 0.4)),
    ],
)
def test_a_scanned_head_with_a_dead_jaw_opens_by_other_shapes(  # noqa: PLR0913, PLR0917
    data, tmp_path, best, renamed, dropped, poseset, widest
):
    path, (name, aperture) = tmp_path / "head.glb", widest
    scanned = (data / "rigs/head_arkit52_oculus15.glb").read_bytes()
    path.write_bytes(changed(scanned, {"jawOpen", *dropped}, renamed))
    found = read_outs(read_model(path))
    assert max(found, key=lambda shape: found[shape].aperture) == name
    assert found[name].aperture == pytest.approx(aperture, abs=0.05)
    assert best(path).name == poseset


def exchanged(path, one, two, *shapes):
    """Write a head on which two shapes have each other's names."""
    other = {one: two, two: one}
    path.write_bytes(changed(face(path, *shapes).read_bytes(), (), other))
    return path


def test_a_jaw_with_the_name_of_another_shape_is_told_by_every_command(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = exchanged(tmp_path / "head.glb", "jawOpen", "mouthFunnel", *ARKIT)
    (tmp_path / "line.tsv").write_text("0\t0.2\tM\n0.2\t0.4\tAA\n")
    line = ("-l", "english", "-c", path, "--schedule", "line.tsv")
    told = f"{path}: on the mesh, jawOpen hardly opens the mouth, but mouthFunnel parts the lips by"
    for command in (
        ("run", *line, "-o", "line.csv"), ("run", *line, "-o", "line.glb"), ("check", *line),
        ("explain", *line, "--at", "0.3"),
    ):  # fmt: skip
        assert cli(*command).err.count(told) == 1, command
    (tmp_path / "characters").mkdir()
    (tmp_path / "characters" / "anna.yaml").write_text(
        "kind: character\nformat: 1\nname: anna\nposeset: arkit\nmodel: ../head.glb\n"
    )
    line = ("-l", "english", "-c", "anna", "--schedule", "line.tsv", "-o", "line.csv")
    assert told in cli("run", *line).err
    assert told in cli("run", *line).err  # from the cache


def test_a_set_whose_jaw_has_the_name_of_another_shape_yields_to_one_that_opens(tmp_path, best):
    path = exchanged(tmp_path / "head.glb", "jawOpen", "mouthSmileLeft", *ARKIT, *OCULUS)
    assert best(path).name == "oculus"


def test_a_head_whose_shapes_move_no_point_is_refused_with_that_reason(tmp_path):
    path = face(tmp_path / "head.glb", *ARKIT, "mine", dead=ARKIT)
    with pytest.raises(
        ll.ModelError, match=r"no pose set knows its shapes \(mine\); no point .*jaw"
    ):
        ll.resolve("english", path)


FACES = {
    "poseset: facefx\nrig: facefx-to-arkit\n": "mouthFunnel, tongueOut",
    "poseset: arkit\nmouth: declared\n": "mouthFunnel, tongueOut",
    "poseset: arkit\nrig: bony\n": "mouthFunnel",
    "poseset: hand-made\n": "mouthFunnel",
}
"""Characters whose targets are declared, or that a rig drives, and their dead shapes by name."""

HAND_MADE = """\
kind: poseset
format: 1
name: hand-made
poses: {jawOpen: {}, mouthFunnel: {}}
targets: {aa: {jawOpen: 0.6}, bmp: {}, w: {mouthFunnel: 0.5}}
measures: {aperture: {jawOpen: 1}}
"""

BONY = """\
kind: rig
format: 1
name: bony
poseset: arkit
channels:
  jaw: {node: Armature, rotation: [1, 0, 0], gains: {jawOpen: 10}}
  mouthFunnel: {gains: {mouthFunnel: 1}}
"""


@pytest.fixture
def anna(tmp_path, monkeypatch):
    """Write a character of some fields, on a head of which some shapes are dead."""
    monkeypatch.chdir(tmp_path)
    for file, text in (("hand-made/poseset", HAND_MADE), ("arkit/rigs/bony", BONY)):
        path = tmp_path / "posesets" / f"{file}.yaml"
        path.parent.mkdir(parents=True)
        path.write_text(text)
    (tmp_path / "characters").mkdir()
    (tmp_path / "line.tsv").write_text("0\t0.2\tM\n0.2\t0.4\tAA\n0.4\t0.6\tW\n")

    def write(fields, *dead, shapes=(*ARKIT, "viseme_aa")):
        text = f"kind: character\nformat: 1\nname: anna\n{fields}model: head.glb\n"
        (tmp_path / "characters" / "anna.yaml").write_text(text)
        return face(tmp_path / "characters" / "head.glb", *shapes, dead=dead)

    return write


@pytest.mark.parametrize("fields", FACES)
def test_dead_shapes_are_named_once_by_every_command_on_every_kind_of_face(cli, anna, fields):
    path = anna(fields, "mouthFunnel", "tongueOut")
    told = f"{path}: on the mesh, nothing moves with {FACES[fields]}\n"
    line = ("-l", "english", "-c", "anna", "--schedule", "line.tsv")
    for command in (
        ("run", *line, "-o", "line.csv"), ("run", *line, "-o", "line.glb"), ("check", *line),
        ("explain", *line, "--at", "0.3"),
    ):  # fmt: skip
        ended = cli(*command)
        assert (ended.err.count("nothing moves"), told in ended.err) == (1, True), (command, ended)
    assert cli("characters", "show", "anna").out.count(told) == 1
    assert json.loads(cli("characters", "show", "anna", "--json").out)["doubts"] == [told.strip()]
    anna(fields)
    assert "nothing moves" not in cli("characters", "show", "anna").out
    assert "nothing moves" not in cli("run", *line, "-o", "line.glb").err


@pytest.mark.parametrize("fields", FACES)
@pytest.mark.parametrize("shapes", [ARKIT, (*ARKIT, "viseme_aa")])
def test_a_head_that_no_pose_opens_is_refused_on_every_kind_of_face(
    cli, tmp_path, anna, fields, shapes
):
    path = anna(fields, "jawOpen", shapes=shapes)
    line = ("run", "-l", "english", "-c", "anna", "--schedule", "line.tsv", "-o", "line.csv")
    ended = cli(*line)
    # A jaw may be a bone, and declared targets may be asked for.
    opens = "bony" in fields or "declared" in fields
    assert ended.code == (0 if opens else 2), ended
    assert (tmp_path / "line.csv").exists() == opens
    if not opens:
        assert f"{path}: no shape" in ended.err
        assert "`mouth: declared` in a character" in ended.err
        anna(f"{fields}mouth: declared\n", "jawOpen", shapes=shapes)
        assert cli(*line).code == 0


SMILE = 0.2
"""How far the shapes of smiles and stretches widen the mouth of a made head, each on its side."""


@pytest.fixture
def human(tmp_path, monkeypatch):
    """Write a made head whose shapes also widen and narrow the mouth; some have others' names."""

    def moves(name, dead=()):
        offsets = moved(name, dead)
        up = {"mouthSmileL": 0.1, "mouthSmileR": 0.1, "mouthFrownL": -0.1, "mouthFrownR": -0.1}
        offsets[:22, 1] += up.get(name[:11], 0.0) * np.tile(2 * np.abs(ACROSS), 2)
        way = {
            "mouthSmile": SMILE,
            "mouthStretch": SMILE,
            "mouthPress": 2 * SMILE,
            "mouthPucker": -SMILE,
        }.get(name.removesuffix("Left").removesuffix("Right"), 0.0)
        sides = [side for side, other in ((1, "Right"), (-1, "Left")) if not name.endswith(other)]
        for side in sides if name not in dead else ():
            offsets[:22, 0] += way * np.tile(np.clip(2 * side * ACROSS, 0, 1), 2) * side
        return offsets

    monkeypatch.setattr(face_models, "moved", moves)

    def write(renamed, *shapes, dead=()):
        path = tmp_path / "head.glb"
        other = renamed | {two: one for one, two in renamed.items()}
        path.write_bytes(changed(face(path, *shapes, dead=dead).read_bytes(), (), other))
        return path

    return write


def test_a_dead_jaw_beside_working_visemes_is_named(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = face(tmp_path / "head.glb", *ARKIT, *OCULUS, dead={"jawOpen"})
    Path("line.tsv").write_text("0\t0.2\tM\n0.2\t0.4\tAA\n")
    told = "on the mesh, nothing moves with jawOpen, so oculus replaces arkit"
    line = ("-l", "english", "-c", "head.glb", "--schedule", "line.tsv")
    for command in (("run", *line, "-o", "line.csv"), ("run", *line, "-o", "line.csv")):
        assert cli(*command).err.count(f"{path}: {told}") == 1
    assert f"doubtful: {told}\n" in cli("characters", "new", "bea", "--model", "head.glb").err
    face(tmp_path / "head.glb", *ARKIT, *OCULUS)
    assert "replaces" not in cli("run", *line, "-o", "line.csv").err


MISNAMED = [
    ({"mouthPucker": "mouthStretchLeft"}, {"mouthPucker", "mouthStretchLeft", "mouthStretchRight"}),
    ({"mouthPucker": "mouthSmileLeft"}, {"mouthPucker"}),
    ({"jawOpen": "mouthFunnel"}, {"jawOpen"}),
    ({}, set()),
]


def test_misnamed_shapes_of_styles_are_named_and_left_out(human):
    shapes = (*ARKIT, "mouthFrownLeft", "mouthFrownRight")
    pairs = {f"mouthSmile{side}": f"mouthFrown{side}" for side in ("Left", "Right")}
    for renamed in ({}, pairs):
        compiled = ll.resolve("english", human(renamed, *shapes)).compiled
        idle = "\n".join(compiled.report.idle)
        assert ("mouthSmileLeft lowers the corners of the mouth by 0.1" in idle) == bool(renamed)
        assert ("mouthFrownRight raises the corners of the mouth by 0.1" in idle) == bool(renamed)
        assert (max(compiled.style_drafts["happy"]["posture"]) > 0.5) == (not renamed)


@pytest.mark.parametrize("fields", [*FACES][:2])
def test_dead_shapes_that_only_styles_move_are_named_once(cli, anna, fields):
    path = anna(fields, "mouthSmileLeft", shapes=(*ARKIT, "mouthFrownLeft"))
    told = f"{path}: on the mesh, nothing moves with mouthSmileLeft\n"
    line = ("-l", "english", "-c", "anna", "--schedule", "line.tsv")
    for command in (("check", *line), ("run", *line, "-o", "line.csv")):
        assert cli(*command).err.count(told) == 1
    assert cli("characters", "show", "anna").out.count(told) == 1


@pytest.mark.parametrize(("renamed", "resting"), MISNAMED)
def test_a_misnamed_shape_is_left_out_and_named(human, tmp_path, monkeypatch, renamed, resting):
    path = human(renamed, *ARKIT)
    performer = ll.resolve("english", path)
    idle = "\n".join(performer.compiled.report.idle)
    assert (f"solved without {', '.join(sorted(resting))}" in idle) == bool(resting)
    for one in resting - {"mouthStretchRight"}:
        assert re.search(rf"on the mesh, {one} (hardly|widens|narrows)", idle), idle
    columns = [performer.poses.index(one) for one in resting]
    tables = performer.compiled.tables
    assert not tables.neutral.curves[..., columns].any()
    assert tables.neutral.curves.any(axis=(0, 1)).sum() > 5 - len(resting)
    # declared targets are kept as they are
    monkeypatch.chdir(tmp_path)
    Path("lipsync.yaml").write_text("kind: project\nformat: 1\nmouth: declared\n")
    kept = ll.resolve("english", path).compiled
    assert not resting or kept.tables.neutral.curves[..., columns].any()
    assert "solved without" not in "\n".join(kept.report.idle)


@pytest.mark.parametrize("turn", [1, -1])
def test_shapes_of_the_other_side_are_named_once(cli, tmp_path, monkeypatch, turn):
    monkeypatch.chdir(tmp_path)
    path, both = tmp_path / "head.glb", ("mouthSmileLeft", "mouthSmileRight")
    (tmp_path / "line.tsv").write_text("0\t0.2\tM\n0.2\t0.4\tAA\n")
    line = ("run", "-l", "english", "-c", path, "--schedule", "line.tsv", "-o", "line.csv")
    around = np.diag([turn, 1, turn])
    for shapes, count in (({}, 0), (dict(zip(both, both[::-1], strict=True)), 1)):
        path.write_bytes(changed(face(path, *ARKIT, turn=around).read_bytes(), (), shapes))
        told = f"on the mesh, the other side of the face moves with {', '.join(both)}: check"
        assert cli(*line).err.count(told) == count


def test_a_head_that_opens_only_by_a_misnamed_shape_is_refused(tmp_path):
    path = exchanged(tmp_path / "head.glb", "jawOpen", "mouthSmileLeft", *ARKIT)
    with pytest.raises(ll.ModelError, match=r"arkit opens the mouth: the widest .* 0\.000"):
        ll.resolve("english", path)


def test_misnamed_shapes_are_named_beside_their_character(cli, anna, tmp_path):
    anna("poseset: arkit\n")
    exchanged(tmp_path / "characters" / "head.glb", "jawOpen", "mouthFunnel", *ARKIT)
    told = "head.glb: on the mesh, jawOpen hardly opens the mouth"
    ended = cli("explain", "-l", "english", "-c", "anna", "--schedule", "line.tsv", "--at", "0.3")
    assert told in ended.err
    assert "solved without jawOpen" in ended.err


def test_no_shape_of_a_good_head_is_misnamed(data):
    shipped = Library().find("poseset", "arkit").parent.parent.glob("*/model.glb")
    models = [data / "rigs" / "head_arkit52_oculus15.glb", *shipped]
    for path in models:
        for found in Library().names("poseset"):
            shown = FaceOnModel.of(Library().poseset(found.name).model, read_model(path))
            assert not shown.misnamed, (path, found.name)


@given(st.sets(st.sampled_from([*Library().poseset("arkit").model.poses])))
def test_poses_at_rest_are_in_no_target_contact_or_style(resting):
    poseset = Library().poseset("arkit").model
    kept = without(poseset, resting)
    assert kept.poses == poseset.poses
    for name, steps in poseset.targets.items():
        for step, left in zip(steps, kept.targets[name], strict=True):
            assert left.weights == {p: w for p, w in step.weights.items() if p not in resting}
    floors = [contact.floor.keys() for contact in kept.contacts.values()]
    floors += [(one.offset | one.posture).keys() for one in kept.styles.values()]
    assert not any(own & resting for own in floors)
    assert without(poseset, ()) == poseset
