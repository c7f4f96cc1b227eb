"""Drafts and descriptions of pose sets."""

import json
from pathlib import Path

import pytest
from face_models import ARKIT, face
from lanes import full, swept
from packs_tree import TREE, plant, put
from shipped import POSESETS
from small_models import glb

from lipsync_lang.authoring.poseset_draft import MAX_SCREEN_LINES, PoseSetWish, draft, guessed
from lipsync_lang.base.errors import LipsyncError, PackError
from lipsync_lang.faces.rigs.channel import bare
from lipsync_lang.faces.rigs.face_on_model import FaceOnModel
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.faces.rigs.shape_matching import placed
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.models import Pose, PoseSet
from lipsync_lang.packs.models.rig_models import pose_names


def new(cli, *arguments):
    """Make a pose set, and return the messages and the pack."""
    ended = cli("posesets", "new", *arguments)
    assert ended.code == 0, ended.err
    assert not ended.out
    return ended.err, Library().poseset(arguments[0]).model


def assert_it_speaks(cli, name):
    """Check that a pose set is valid and short, and that it moves."""
    text = Path(f"posesets/{name}/poseset.yaml").read_text("utf-8")
    assert text.count("\n") <= MAX_SCREEN_LINES
    ended = cli("validate", f"posesets/{name}")
    assert (ended.code, ended.out) == (0, "")
    spoken = ["HH", "AH", "L", "OW", "F", "AA", "DH", "ER", "P"]
    line = [{"label": s, "start": n / 10, "end": (n + 1) / 10} for n, s in enumerate(spoken)]
    Path("line.json").write_text(json.dumps(line), "utf-8")
    ended = cli("run", "--schedule", "line.json", "-l", "english", "-c", name, "-o", "out.csv")
    assert ended.code == 0, ended.err
    rows = Path("out.csv").read_text("utf-8").splitlines()[1:]
    assert max(float(weight) for row in rows for weight in row.split(",")[1:]) > 0.1


# What nobody knows


@full
@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 9, 20, 21, 40])
def test_poses_nobody_knows_move_at_once(count, cli):
    names = [f"zz{chr(97 + n // 26)}{chr(97 + n % 26)}" for n in range(count)]
    said, model = new(cli, "thing", *names, "--guess")
    kept = names[:21]
    assert [*model.poses] == kept
    assert f"{len(kept)} pose{'s' * (len(kept) > 1)}, with guessed targets" in said
    assert ("19 unused, in a comment" in said) == (count == 40)
    moved = {p for (t,) in model.targets.values() for p, weight in t.weights.items() if weight}
    assert moved == set(kept)
    assert_it_speaks(cli, "thing")


@pytest.mark.usefixtures("folder")
def test_poses_nobody_knows_rest_unless_a_guess_is_asked_for(cli):
    said, model = new(cli, "thing", "zza", "zzb")
    assert "2 poses, all at rest until you give them targets, or use --guess" in said
    assert not any(target.weights for (target,) in model.targets.values())
    ended = cli("validate", "posesets/thing")
    assert ended.code == 0
    assert ended.out.count("W301 warning: no target moves") == len(model.poses)


def test_each_pose_nobody_knows_is_for_a_kind_of_sounds():
    common = Library(project=None).common().model
    kinds = {p.sound for label, p in common.phonemes.items() if label in common.base}
    model = guessed(["zza", "zzb", "zzc", "zzd"], common)
    heard = {}
    for label, (target,) in model.targets.items():
        strong = max(target.weights, key=target.weights.get)
        heard.setdefault(strong, set()).add(common.phonemes[label].sound)
    assert heard["zza"] == {"vowel"}
    assert all(len(some) == 1 for some in heard.values())
    assert len(heard) == len(kinds)
    assert model.contacts["closure"].ceiling == {"zza": 0.1}
    assert model.contacts["closure"].phonemes == ("bmp",), "teeth on a lip leave a lamp lit"
    assert model.targets["bmp"][0].weights["zza"] == 0


def test_sounds_that_shut_are_those_of_a_shut_mouth(folder):
    plant(folder)
    shut = TREE["languages/common.yaml"].replace(
        "example: put,", "example: put, mouth: {aperture: 0, width: 0},"
    )
    put(folder, "languages/common.yaml", shut)
    made = draft(
        Library([folder], project=None), PoseSetWish("thing", ["zz"], like="face", guess=True)
    )
    text = made.outputs[made.path].decode()
    assert "closure: {phonemes: [p], ceiling: {zz: 0.1}}" in text
    assert "p:   {zz: 0}" in text
    assert not (folder / "posesets/thing").exists(), "drafting alone writes nothing"


def test_targets_may_be_solved_on_the_model(folder, cli):
    face(folder / "head.glb", *ARKIT, "tongueUp")
    said, declared = new(cli, "plain", "--model", "head.glb")
    assert "solved" not in said
    assert declared.targets["l"][0].weights["tongueUp"] == 1, "an optional pose"
    said, model = new(cli, "thing", "--model", "head.glb", "--solve")
    assert "with the targets of arkit, solved on the model" in said
    gains = FaceOnModel.of(model, read_model(folder / "head.glb")).gains[0]
    for name in ("aa", "eh", "kg"):
        (weights,) = (step.weights for step in model.targets[name])
        opens = gains @ [weights.get(pose, 0) for pose in model.poses]
        wanted = Library(project=None).common().model.phonemes[name].mouth[0].aperture
        assert opens == pytest.approx(wanted, abs=0.03), name
    assert model.contacts == declared.contacts
    assert cli("validate", "posesets/thing").code == 0


@pytest.mark.parametrize(
    ("more", "why"),
    [
        (["jawOpen"], "targets are solved on a model; name it with --model"),
        (["--model", "flat.glb"], "flat.glb: its mouth cannot be measured"),
    ],
)
def test_targets_that_cannot_be_solved_are_told(folder, cli, more, why):
    glb(folder / "flat.glb", "jawOpen")
    ended = cli("posesets", "new", "thing", *more, "--solve")
    assert ended.code == 2
    assert why in ended.err
    assert not (folder / "posesets").exists()


def looked(folder):
    """Write a pose set of a project whose targets are to be solved."""
    drawn = Library(project=None).poseset("arkit").model.looks
    looks = {name: [step.weights for step in steps] for name, steps in drawn.items()}
    poses = {pose: {} for steps in looks.values() for step in steps for pose in step}
    put(
        folder,
        "posesets/own/poseset.yaml",
        f"kind: poseset\nformat: 1\nname: own\nposes: {json.dumps(poses)}\n"
        f"looks: {json.dumps(looks)}\n",
    )
    return folder / "posesets/own/poseset.yaml"


def test_looks_are_solved_on_a_head_and_the_second_run_gives_the_same(folder, cli):
    face(folder / "head.glb", *ARKIT)
    path = looked(folder)
    ended = cli("posesets", "solve", "own", "--model", "head.glb")
    assert (ended.code, "targets, solved on the model" in ended.err) == (0, True), ended.err
    first = path.with_name("targets.yaml").read_text("utf-8")
    assert first.startswith("# Targets of own, solved on head.glb")
    path.write_text(path.read_text("utf-8") + "extends: targets.yaml\n", "utf-8")
    assert cli("posesets", "solve", "own", "--model", "head.glb").code == 0
    assert path.with_name("targets.yaml").read_text("utf-8") == first
    assert cli("validate", "posesets/own").code == 0
    made = Library().poseset("own").model
    (aa,), (look,) = made.targets["aa"], made.looks["aa"]
    gains = FaceOnModel.of(made, read_model(folder / "head.glb")).gains[0]
    opens, drawn = (gains @ [one.weights.get(pose, 0) for pose in made.poses] for one in (aa, look))
    wanted = Library(project=None).common().model.phonemes["aa"].mouth[0].aperture
    assert abs(opens - wanted) < abs(drawn - wanted) / 2


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("own", "targets.yaml: was written by hand, so it stays"),
        ("vrm", "states no looks; call the targets"),
        ("arkit", "lies outside this folder; copy the pose set to posesets/"),
        (None, "name the pose set: posesets solve NAME --model FILE"),
    ],
)
def test_looks_that_cannot_be_solved_are_told_and_nothing_is_lost(folder, cli, name, why):
    face(folder / "head.glb", *ARKIT)
    hand = looked(folder).with_name("targets.yaml")
    hand.write_text("# mine\n", "utf-8")
    ended = cli("posesets", "solve", *([name] if name else []), "--model", "head.glb")
    assert (ended.code, why in ended.err) == (2, True), ended.err
    assert hand.read_text("utf-8") == "# mine\n"


@pytest.mark.usefixtures("folder")
def test_what_is_in_a_draft_explains_itself(cli):
    new(cli, "thing", "zz top", "true", "zz: zy", "--guess", "--title", "It's a:\n thing")
    text = Path("posesets/thing/poseset.yaml").read_text("utf-8")
    assert '# constraints: {pairs: [{between: [zz top, "true"], threshold: 1}]}' in text
    assert "# No pose set knows these poses" in text
    assert 'lipsync-lang run "Hello" -l LANGUAGE -c thing' in text
    model = Library().poseset("thing").model
    assert [*model.poses] == ["zz top", "true", "zz: zy"]
    assert model.title == "It's a: thing"
    uncommented = "\n".join(line.removeprefix("# ") for line in text.split("\n")
                            if not line.startswith("# ") or ": [" in line)  # fmt: skip
    Path("posesets/thing/poseset.yaml").write_text(uncommented, "utf-8")
    assert cli("validate", "posesets").out == "", "the example in the comments is sound"


# What a pose set knows


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("name", swept(POSESETS, quick=2))
def test_every_pose_set_can_be_started_from(name, cli):
    _, model = new(cli, "mine", "--like", name)
    known = Library().poseset(name).model
    assert {*model.poses} <= {*known.poses}
    assert {*model.contacts} == {*known.contacts}
    for label, steps in known.targets.items():
        ours = [(s.weights, s.dominance, s.overall) for s in model.targets[label]]
        poses = model.poses
        assert ours == [
            (
                {p: w for p, w in step.weights.items() if p in poses},
                {p: d for p, d in step.dominance.items() if p in poses},
                step.overall,
            )
            for step in steps
        ]
    assert_it_speaks(cli, "mine")


def test_known_poses_move_as_they_do_elsewhere_under_their_new_names(folder, cli):
    plant(folder, "languages/common.yaml", "characters/anna.yaml", "characters/anna-bank.yaml")
    face = TREE["posesets/face/poseset.yaml"].replace("p:", "bmp:").replace("[p]", "[bmp]")
    face = face.replace("  a: [", "  aa: [").replace(
        "wide:\n", "wide: {names: ['grin{Left,Right}']}\n"
    )
    put(folder, "posesets/face/poseset.yaml", face)
    names = ["Robo_OPEN", "Robo_pbm", "Robo_GrinLeft", "Robo_GrinRight", "Robo_antenna"]
    said, model = new(cli, "robo", *names, "--like", "face")
    assert "4 poses, with the targets of face; 1 unused, in a comment" in said
    assert [*model.poses] == names[:4]
    assert model.poses["Robo_OPEN"] == Pose(title="jaw open", region="jaw")
    first, second = model.targets["aa"]
    assert first.weights == {"Robo_OPEN": 0.45, "Robo_GrinLeft": 0.1, "Robo_GrinRight": 0.1}
    assert second.weights == {"Robo_OPEN": 0.25}
    assert model.targets["bmp"][0].dominance == {"Robo_pbm": 6, "Robo_OPEN": 6}
    assert [p.model_dump(exclude_none=True) for p in model.constraints.pairs] == [
        {"between": ("Robo_OPEN", "Robo_pbm"), "threshold": 0.5},
        {"pose": "Robo_GrinLeft", "at_most": "Robo_OPEN"},
        {"pose": "Robo_GrinRight", "at_most": "Robo_OPEN"},
    ]
    assert model.priority == ("Robo_OPEN", "Robo_pbm")
    assert [*model.contacts] == ["lips"], "nothing is left of the other"
    assert model.measures == {"aperture": {"Robo_OPEN": 1, "Robo_pbm": -1}}
    assert (model.motion.speed_limit, model.motion.window) == (15, None), "what is usual goes"
    assert {*Library().common().model.base} <= {*model.targets}
    text = Path("posesets/robo/poseset.yaml").read_text("utf-8")
    assert "region: jaw}   # as open" in text
    assert "#   Robo_antenna" in text
    assert_it_speaks(cli, "robo")


def test_the_pose_set_that_knows_most_is_asked(folder):
    plant(folder)
    put(folder, "posesets/other/poseset.yaml", "kind: poseset\n")
    library = Library([folder], project=None)
    made = draft(library, PoseSetWish("mine", ["open", "PBM", "FV", "x"]))
    assert "'face'" in made.outputs[made.path].decode()


# Models


@pytest.mark.usefixtures("folder")
def test_a_models_shapes_are_the_poses_and_it_comes_along(cli, tmp_path_factory):
    far = glb(tmp_path_factory.mktemp("far") / "robo face.glb", "zza", "zzb")
    said, model = new(cli, "robo", "--model", far, "--guess")
    assert "2 poses, with guessed targets" in said
    assert "wrote posesets/robo/robo face.glb, a copy" in said
    assert Path("posesets/robo/robo face.glb").read_bytes() == far.read_bytes()
    assert ([*model.poses], model.model) == (["zza", "zzb"], "robo face.glb")
    assert_it_speaks(cli, "robo")


def test_a_model_among_the_packs_stays_where_it_is(folder, cli):
    glb(folder / "posesets/shared/robo.glb", "zza", "zzb")
    said, model = new(cli, "robo", "zza", "zzc", "--model", "posesets/shared/robo.glb")
    assert "a copy" not in said
    assert "the model has no shape called zzc" in said
    assert model.model == "../shared/robo.glb"
    glb(folder / "posesets/two/robo.glb", "zza")
    assert new(cli, "two", "--model", "posesets/two/robo.glb")[1].model == "robo.glb"
    assert cli("validate", "posesets").code == 0


# What cannot be done


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "name the new pose set"),
        (["../evil", "zz"], "cannot be a pack's name"),
        (["thing"], "needs a source"),
        (["taken", "zz"], "already exists"),
        (["facefx", "zz"], "there is a pose set 'facefx' already"),
        (["thing", " zz"], "cannot be the name of a pose"),
        (["thing", "zz", ""], "cannot be the name of a pose"),
        (["thing", "dominance"], "cannot be the name of a pose"),
        (["thing", "z" * 121], "cannot be the name of a pose"),
        (["thing", "--like", "fce"], "did you mean 'face'"),
        (["thing", "--model", "none.glb"], "none.glb"),
        (["thing", "--model", "text.glb"], "text.glb"),
    ],
)
def test_what_cannot_be_drafted_is_a_message_and_writes_nothing(folder, cli, arguments, message):
    plant(folder, "languages/common.yaml")
    put(folder, "posesets/taken/poseset.yaml", "kept")
    put(folder, "text.glb", "kept")
    ended = cli("posesets", "new", *arguments)
    assert ended.code == 2
    assert message in ended.err
    assert sorted(p.name for p in (folder / "posesets").iterdir()) == ["face", "taken"]
    assert (folder / "posesets/taken/poseset.yaml").read_text() == "kept"


def test_files_that_are_there_are_never_written_over(folder, tmp_path_factory):
    far = glb(tmp_path_factory.mktemp("far") / "robo.glb", "zza")
    put(folder, "posesets/robo/robo.glb", "kept")
    with pytest.raises(PackError, match="already exists"):
        draft(Library(), PoseSetWish("robo", model=far))
    loose = far.with_suffix(".gltf")
    far.rename(loose)
    with pytest.raises(LipsyncError, match="GLB"):
        draft(Library(), PoseSetWish("robo", model=loose))


@pytest.mark.parametrize("arguments", [["show", "facefx", "zz"], ["list", "zz", "zy"]])
def test_only_a_new_pose_set_takes_poses(arguments, cli):
    ended = cli("posesets", *arguments)
    assert ended.code == 2
    assert "takes no" in ended.err


# Names


POSES = {
    "jawOpen": Pose(names=("Mouth_Gape", "*_agape")),
    "smileLeft": Pose(names=("grin{Left,Right}",)),
    "smileRight": Pose(),
    "tongue2": Pose(),
}


@pytest.mark.parametrize(
    ("name", "pose"),
    [
        ("jawOpen", "jawOpen"),
        ("Jaw_Open", "jawOpen"),
        ("JAW OPEN", "jawOpen"),
        ("head.jawOpen", "jawOpen"),
        ("rig:face|jaw-open", "jawOpen"),
        ("mouthGape", "jawOpen"),
        ("face_agape", "jawOpen"),
        ("smile_L", "smileLeft"),
        ("SmileR", "smileRight"),
        ("smile", "smileLeft"),
        ("grinRight", "smileLeft"),
        ("tongue_2", "tongue2"),
        ("tongue_3", None),
        ("doorOpen", None),
        ("", None),
        ("...", None),
        ("__", None),
    ],
)
def test_a_name_is_known_however_it_is_spelled(name, pose):
    known = PoseSet(kind="poseset", format=1, name="known", poses=POSES)
    found = placed(bare([*POSES], pose_names(known.poses)), [name]).shapes
    assert next((list(POSES)[number] for number in sorted(found)), None) == pose


# Showing


def told(ended):
    """Content of a pack; losses of its rigs come after it."""
    pack, _, losses = ended.out.partition("\n\n")
    assert losses.startswith("not shown by model\n")
    return pack.splitlines()


def test_a_pose_set_is_shown_whole(folder, cli):
    plant(folder, "languages/common.yaml")
    text = TREE["posesets/face/poseset.yaml"].replace("title: Face", "title: Face\nneutral: calm")
    put(folder, "posesets/face/poseset.yaml", text + "model: face.glb\n")
    assert told(cli("posesets", "show", "face")) == [
        "Face, posesets/face/poseset.yaml",
        "poses",
        "  open        jaw     jaw open",
        "  PBM                 lips pressed",
        "  FV",
        "  wide",
        "at rest: calm",
        "priority, lowest first: open < FV < PBM",
        "open + PBM at most 0.5",
        "wide at most open",
        "contact lips for p: PBM at 0.9 or more; open at 0.1 or less",
        "contact teeth for f: FV at 0.8 or more",
        "targets for 3 phonemes: p f a",
        "  without: ah aa ao eh er ih w ow aw oy ay h r l s sh th d kg bmp",
        "measure aperture: open - PBM",
        "bank common: posesets/face/banks/common.yaml",
        "rig model: posesets/face/rigs/model.yaml",
        "model: face.glb (missing)",
    ]
    assert json.loads(cli("posesets", "show", "face", "--json").out)["neutral"] == "calm"


def test_a_character_is_shown_whole(folder, cli):
    plant(folder, "languages/common.yaml")
    put(folder, "characters/bob.yaml", TREE["characters/anna.yaml"].replace("anna", "bob") +
        "dials: {jaw: [[0, 1], [2.5, 0.5]]}\nstyles: {angry: 0.5}\n")  # fmt: skip
    assert told(cli("characters", "show", "bob")) == [
        "bob, characters/bob.yaml",
        "pose set: face",
        "bigrams of its own: f-a",
        "banks: bob-bank.yaml",
        "words: moi",
        "lines: intro_042",
        "motion: speed_limit 12",
        "styles: angry 0.5",
        "dials: jaw 1 at word 0, 0.5 at word 2.5",
        "rig: model",
    ]
    bare = cli("characters", "show", "face").out.splitlines()
    assert bare[-1] == "rigs to choose from: model"
    assert json.loads(cli("characters", "show", "bob", "--json").out)["rig"] == "model"


def test_drafts_of_all_that_is_built_in_have_no_warning(folder):
    for name in POSESETS:
        draft(Library(), PoseSetWish(f"my-{name}", like=name)).write()
    assert validate(Library(), [folder / "posesets"]) == []
