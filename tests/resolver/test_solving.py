"""Targets solved on a model: each sound has its mouth, and what an artist declared stays."""

import face_models
import numpy as np
import pytest
from face_models import ARKIT, OCULUS, face
from hypothesis import given
from hypothesis import strategies as st
from shipped import LIBRARY
from small_models import glb

import lipsync_lang as ll
from lipsync_lang.faces.rigs import read_outs
from lipsync_lang.faces.rigs.face_on_model import FaceOnModel
from lipsync_lang.faces.rigs.model import read_model
from lipsync_lang.packs import models
from lipsync_lang.packs.library import Library
from lipsync_lang.resolver.layers import PairPacks
from lipsync_lang.resolver.solving import (
    _FaceToSolve,
    asked_measures,
    farther,
    solved_face,
)

SOLVED = [
    name.name
    for name in LIBRARY.names("poseset")
    if LIBRARY.poseset(name.name).model.mouth == "solved"
]
ARKIT_SET = LIBRARY.poseset("arkit").model
COMMON = LIBRARY.common().model
SOUNDS = {**COMMON.phonemes, **COMMON.shades}
READABLE = {
    name: [one.jaw is not None for one in mouth]
    for name, mouth in COMMON.mouths().items()
    if any(one.jaw is not None for one in mouth)
}
"""Sounds of a small hole or of near teeth, with the steps that are."""


def solved_on(path, poseset=ARKIT_SET):
    """Solve a pose set on a model."""
    return solved_face(FaceOnModel.of(poseset, read_model(path)), COMMON.mouths())


def targets(poseset, gains, reach=1.0):
    """Solve every target of a pose set for shapes with these effects."""
    solver = _FaceToSolve.of(poseset, gains)
    return {
        name: solver.target(name, steps, asked_measures(SOUNDS[name].mouth, len(steps), reach))
        for name, steps in poseset.targets.items()
        if SOUNDS[name].mouth
    }


def error(solver, name, steps):
    """Return the distance of a target's first step from its mouth, in the measures stated."""
    mouth = SOUNDS[name].mouth[0]
    missed = solver.gains @ solver.weights(steps[0]) - [
        getattr(mouth, m) or 0.0 for m in models.MOUTH_MEASURES
    ]
    stated = [getattr(mouth, m) is not None for m in models.MOUTH_MEASURES]
    return np.linalg.norm(missed[stated])


@pytest.mark.parametrize("name", SOLVED)
@given(data=st.data())
def test_a_solved_target_keeps_bounds_pairs_contacts_and_ceilings(name, data):
    poseset = LIBRARY.poseset(name).model
    count = len(poseset.poses)
    draws = st.lists(st.floats(-0.6, 0.6), min_size=4 * count, max_size=4 * count)
    solver = _FaceToSolve.of(poseset, np.array(data.draw(draws)).reshape(4, count))
    touching = {pose for contact in poseset.contacts.values() for pose in contact.floor}
    for phoneme, steps in targets(poseset, solver.gains).items():
        for declared, step in zip(poseset.targets[phoneme], steps, strict=True):
            weights = solver.weights(step)
            assert ((weights >= 0) & (weights <= 1)).all()
            for group in solver.groups:
                free = solver.most[group].min() > 0
                assert not free or np.ptp(weights[group]) == 0
            for pose in touching:
                assert step.weights.get(pose, 0) == declared.weights.get(pose, 0)
            for contact in poseset.contacts.values():
                if phoneme in contact.phonemes:
                    for pose, most in contact.ceiling.items():
                        assert step.weights.get(pose, 0) <= max(most, declared.weights.get(pose, 0))
            assert step.dominance == declared.dominance
            assert step.overall == declared.overall


@pytest.mark.parametrize("name", SOLVED)
def test_no_threshold_lowers_a_shape_of_the_lips_beside_one_at_rest(name):
    poseset = LIBRARY.poseset(name).model
    solver = _FaceToSolve.of(poseset, np.ones((4, len(poseset.poses))))
    most = dict(zip(poseset.poses, solver.most, strict=True))
    pairs = [pair for pair in poseset.constraints.pairs if isinstance(pair, models.Threshold)]
    assert pairs
    for pair in pairs:
        if "jawOpen" not in pair.between:
            assert max(most[pose] for pose in pair.between) <= pair.threshold, pair


@pytest.mark.parametrize("jaw", [0.3, 0.5, 0.8])
def test_vowels_open_as_far_on_every_head(tmp_path, monkeypatch, jaw):
    monkeypatch.setitem(face_models.OPENINGS, "jawOpen", jaw)
    found = solved_on(face(tmp_path / "head.glb", *ARKIT))
    for name in ("aa", "eh", "ih", "kg"):
        reached, wanted = found.reached[name][0, 0], SOUNDS[name].mouth[0].aperture
        assert reached == pytest.approx(wanted, abs=0.03), name


def test_consonants_do_not_flap_on_a_head_whose_consonants_open(tmp_path, monkeypatch):
    for shape in ("viseme_DD", "viseme_kk", "viseme_nn", "viseme_CH"):
        monkeypatch.setitem(face_models.OPENINGS, shape, 0.3)
    poseset = LIBRARY.poseset("oculus").model
    path = face(tmp_path / "head.glb", *OCULUS)
    found = solved_on(path, poseset)
    solver = _FaceToSolve.of(poseset, FaceOnModel.of(poseset, read_model(path)).gains)
    for name in ("d", "n", "kg", "ch"):
        assert error(solver, name, found.targets[name]) < 2 / 3 * error(
            solver, name, poseset.targets[name]
        )
        assert found.reached[name][0, 0] < found.reached["aa"][0, 0]


FACEFX = LIBRARY.poseset("facefx").model


def facefx_gains(**apertures):
    """Effects of poses of which `open` opens, `W` rounds and some open besides."""
    gains = np.zeros((4, len(FACEFX.poses)))
    for pose, aperture in ({"open": 0.5} | apertures).items():
        gains[0, [*FACEFX.poses].index(pose)] = aperture
    gains[1:3, [*FACEFX.poses].index("W")] = -0.5, 0.25
    return gains


def test_every_solved_target_names_each_pose_that_opens_the_mouth():
    gains = facefx_gains(ShCh=0.3)
    for name, steps in targets(FACEFX, gains).items():
        assert all({"open", "ShCh"} <= step.weights.keys() for step in steps), name


def test_a_solution_holds_to_the_look_as_firmly_as_the_set_says():
    lips = []
    for look in (0.0, 0.3, 3.0):
        solved = targets(FACEFX.model_copy(update={"look": look}), facefx_gains())
        lips.append(solved["w"][0].weights["W"])
    declared = FACEFX.targets["w"][0].weights["W"]
    assert lips[0] < lips[1] < lips[2] <= declared
    assert declared - lips[2] < 0.1


def test_what_a_kept_pose_does_is_left_out_of_what_is_solved():
    opened = [
        targets(FACEFX, facefx_gains(**kept))["f"][0].weights["open"] for kept in ({}, {"FV": 0.05})
    ]
    assert opened[1] < opened[0] - 0.03


def test_reach_moves_every_mouth_farther(tmp_path):
    poseset = LIBRARY.poseset("arkit").model
    path = face(tmp_path / "head.glb", *ARKIT)
    near, far = (
        solved_on(path, poseset.model_copy(update={"reach": reach})) for reach in (1.0, 1.6)
    )
    for name in ("aa", "eh", "l", "d"):
        ratio = far.reached[name][0, 0] / near.reached[name][0, 0]
        assert 1.4 < ratio < 1.8, name


def test_a_head_whose_mouth_the_pose_set_cannot_open_is_refused(tmp_path):
    path = face(tmp_path / "head.glb", *ARKIT, "viseme_aa", dead={"jawOpen"})
    with pytest.raises(ll.ModelError, match=r"head\.glb: no shape of it that is a pose of arkit"):
        FaceOnModel.of(LIBRARY.poseset("arkit").model, read_model(path)).refuse_shut()


def test_a_head_on_which_nothing_opens_a_mouth_is_refused_by_the_names_that_are_dead(tmp_path):
    path = face(tmp_path / "head.glb", *ARKIT, dead={"jawOpen"})
    with pytest.raises(ll.ModelError, match=r"head\.glb: no shape opens the mouth: .*jawOpen"):
        ll.resolve("english", path)


def test_a_head_that_cannot_be_measured_keeps_the_declared_targets(tmp_path):
    path = glb(tmp_path / "head.glb", *ARKIT)
    assert solved_on(path) is None
    plain, same = (ll.resolve("english", who) for who in ("arkit", path))
    assert np.array_equal(plain.compiled.tables.neutral.curves, same.compiled.tables.neutral.curves)
    (told,) = same.compiled.report.idle
    assert told.endswith("head.glb: no shape opens a mouth, so its targets stay as declared")


def test_a_head_of_too_many_points_says_so(tmp_path, monkeypatch):
    monkeypatch.setattr(read_outs, "MAX_MEASURED_POINTS", 9)
    head = ll.resolve("english", face(tmp_path / "head.glb", *ARKIT))
    (told,) = head.compiled.report.idle
    assert "points are too many to find a mouth in, so its targets stay" in told


@pytest.fixture
def project(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "characters").mkdir()
    face(tmp_path / "characters" / "head.glb", *ARKIT)

    def character(more=""):
        path = tmp_path / "characters" / "anna.yaml"
        path.write_text(
            "kind: character\nformat: 1\nname: anna\nposeset: arkit\nmodel: head.glb\n" + more
        )
        return PairPacks.open(Library(), "english", "anna")

    return character


def test_a_character_with_a_model_is_solved_and_says_so(project):
    packs = project()
    _, place = packs.targets["aa"]
    assert place.endswith(", solved on head.glb")
    assert "common.yaml:" in place
    told = str(
        ll.resolve("english", "anna").perform(ll.Schedule(("AA", "D"), [0, 0.2, 0.4])).explain(0.2)
    )
    assert "solved on head.glb" in told


def test_a_character_whose_mouth_stays_shut_is_refused_until_it_says_declared(project, tmp_path):
    path = tmp_path / "characters" / "head.glb"
    face(path, *ARKIT, "viseme_aa", dead={"jawOpen"})
    with pytest.raises(ll.ModelError, match="opens the mouth"):
        project()
    assert project("mouth: declared\n").solved is None
    path.write_bytes(b"damaged")
    assert project().solved is None


def test_one_line_keeps_the_declared_targets(project):
    declared = project("mouth: declared\n")
    assert declared.solved is None
    assert declared.face.targets == declared.poseset.model.targets


def test_a_character_states_mouths_of_its_own(project):
    usual = project()
    own = project("mouths: {aa: {aperture: 0.4, width: 0.02}}\n")
    before, now = (one.solved.reached for one in (usual, own))
    assert now["aa"][0, 0] == pytest.approx(0.4, abs=0.04)
    assert now["aa"][0, 0] > before["aa"][0, 0] + 0.1
    assert np.array_equal(now["eh"], before["eh"])
    assert "anna.yaml:6:" in own.targets["aa"][1]
    assert own.targets["aa"][1].endswith(", solved on head.glb")
    assert "common.yaml:" in own.targets["eh"][1]


def test_a_mouth_of_an_unknown_sound_is_a_fault(project):
    with pytest.raises(ll.LipsyncError, match=r"anna\.yaml:6:10: P\d+ .*'aaa'"):
        project("mouths: {aaa: {aperture: 0.4, width: 0}}\n")
    with pytest.raises(ll.LipsyncError, match=r"anna\.yaml:6:.*aperture"):
        project("mouths: {aa: {aperture: 4, width: 0}}\n")
    with pytest.raises(ll.LipsyncError, match=r"anna\.yaml:6:.* P108 `aa` must have at least 1"):
        project("mouths: {aa: []}\n")


IDLE = {
    "": ("arkit", "the character has no model"),
    "mouth: solved\n": ("facefx", "facefx keeps the targets that were made for its own model"),
    "model: head.glb\nmouth: declared\n": ("arkit", "the character keeps declared targets"),
    "model: flat.glb\n": ("arkit", "the mouth of its model cannot be measured"),
}


@pytest.mark.parametrize("head", IDLE)
def test_mouths_of_a_head_that_is_not_solved_have_no_effect_and_a_warning(
    cli, tmp_path, monkeypatch, head
):
    field = "mouths: {aa: {aperture: 0.4, width: 0}}"
    monkeypatch.chdir(tmp_path)
    (tmp_path / "characters").mkdir()
    face(tmp_path / "characters" / "head.glb", *ARKIT)
    glb(tmp_path / "characters" / "flat.glb", *ARKIT)
    poseset, cause = IDLE[head]
    text = f"kind: character\nformat: 1\nname: anna\nposeset: {poseset}\n{field}\n{head}"
    (tmp_path / "characters" / "anna.yaml").write_text(text)
    told = f"anna.yaml:5:1: W322 warning: no effect, because {cause}"
    (tmp_path / "line.tsv").write_text("0\t0.2\tM\n0.2\t0.4\tAA\n")
    for command in ("run", "check"):
        ended = cli(command, "-l", "english", "-c", "anna", "--schedule", "line.tsv")
        assert ended.err.count(told) == 1, (command, ended)
        assert "targets" in ended.err.split(told)[1]
    # no pack is checked by reading a model
    assert (told in cli("validate").out) == ("flat.glb" not in head)
    (tmp_path / "characters" / "anna.yaml").write_text(text.replace(f"{field}\n", ""))
    for command in (
        ("run", "-l", "english", "-c", "anna", "--schedule", "line.tsv"),
        ("validate",),
    ):
        ended = cli(*command)
        assert ("W322" in ended.err + ended.out) == (head == "mouth: solved\n"), command


def test_a_mouth_beside_a_target_of_the_same_sound_has_a_warning(project):
    own = "mouths: {aa: {aperture: 0.4, width: 0}, eh: {aperture: 0.3, width: 0}}\n"
    project(own + "targets: {aa: {jawOpen: 0.9}}\n")
    (told,) = ll.resolve("english", "anna").compiled.report.idle
    assert "anna.yaml:6:10: W322 warning: no effect on the motion" in told
    assert "`targets` states the weights of 'aa'" in told


def test_a_line_of_the_project_keeps_the_declared_targets_of_all_faces(
    project, tmp_path, monkeypatch
):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / "cache"))
    project()
    head = tmp_path / "characters" / "head.glb"
    solved, bare = (ll.resolve("english", who) for who in ("anna", head))
    (tmp_path / "lipsync.yaml").write_text("kind: project\nformat: 1\nmouth: declared\n")
    for before, who in ((solved, "anna"), (bare, head)):
        kept = ll.resolve("english", who)
        assert kept.compiled.tables.neutral.curves.max() != pytest.approx(
            before.compiled.tables.neutral.curves.max()
        )
    assert project("mouth: solved\n").solved is not None
    (tmp_path / "lipsync.yaml").write_text("kind: project\nformat: 1\nmouth: wide\n")
    assert project().solved is not None


def test_a_target_of_the_character_itself_stays(project):
    packs = project("targets: {aa: {jawOpen: 0.9}}\n")
    assert packs.face.targets["aa"][0].weights == {"jawOpen": 0.9}
    assert packs.targets["aa"][1].endswith("anna.yaml:6:15")
    assert packs.face.targets["eh"] == packs.solved.targets["eh"]


def test_a_reach_of_the_character_replaces_that_of_the_set(project):
    near, far = project(), project("reach: 1.5\n")
    opened = [one.face.targets["aa"][0].weights["jawOpen"] for one in (near, far)]
    assert opened[1] > 1.3 * opened[0]


@given(reach=st.floats(0.5, 2))
def test_a_reach_scales_declared_targets_but_no_contact(reach):
    for poseset in (LIBRARY.poseset(name).model for name in SOLVED):
        touching = {pose for contact in poseset.contacts.values() for pose in contact.floor}
        for name, steps in farther(poseset, reach, COMMON.mouths()).items():
            if reach < 1 and name in READABLE:
                continue
            for before, now in zip(poseset.targets[name], steps, strict=True):
                assert now.model_copy(update={"weights": before.weights}) == before
                for pose, weight in before.weights.items():
                    factor = 1 if pose in touching else reach
                    assert now.weights[pose] == pytest.approx(min(1, factor * weight), abs=1e-4)


@given(reach=st.floats(0.1, 3))
def test_small_holes_and_near_teeth_stay_readable_at_any_reach_and_other_sounds_follow_it(reach):
    assert READABLE.keys() >= {"ao", "w", "yu", "uh", "ow", "sh", "r", "s", "th", "f"}
    assert not READABLE.keys() & {"aa", "iy", "l", "d", "bmp"}
    for name, mouth in COMMON.mouths().items():
        steps = len(mouth)
        kept = READABLE.get(name, [False] * steps)
        factors = np.where(kept, max(reach, 0.9), reach)[:, None]
        usual = asked_measures(mouth, steps, 1)
        assert np.allclose(asked_measures(mouth, steps, reach), factors * usual, equal_nan=True)
    near = farther(FACEFX, reach, COMMON.mouths())
    weights = [one[0].weights for one in (near["w"], near["th"], near["aa"])]
    declared = [FACEFX.targets[name][0].weights for name in ("w", "th", "aa")]
    assert weights[0]["W"] >= min(1, 0.9 * declared[0]["W"]) - 1e-4
    assert weights[1]["tTeeth"] >= min(1, 0.9 * declared[1]["tTeeth"]) - 1e-4
    assert weights[2]["open"] == pytest.approx(min(1, reach * declared[2]["open"]), abs=1e-4)


def test_the_shipped_head_is_a_cartoon_by_the_reach_of_its_character(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "characters").mkdir()
    stated = "kind: character\nformat: 1\nname: anna\nposeset: facefx\nreach: 1.25\n"
    stated += "targets: {eh: {open: 0.3}}\n"
    (tmp_path / "characters" / "anna.yaml").write_text(stated)
    packs, usual = (PairPacks.open(Library(), "english", who) for who in ("anna", "facefx"))
    assert packs.face.targets["aa"][0].weights["open"] == pytest.approx(0.9375)
    assert packs.face.targets["eh"][0].weights == {"open": 0.3}
    assert usual.face.targets == FACEFX.targets
    checks = [ll.resolve("english", who).compiled.checks for who in ("anna", "facefx")]
    assert [one["reach"] for one in checks] == [1.25, 1]
    far, near = (one["apertures"]["aa"] for one in checks)
    assert far == pytest.approx(1.25 * near)


ADDED = """\
kind: language
format: 1
name: mine
tag: en
adds:
  ka: {like: kg, mouth: {aperture: 0.5, width: 0.1}}
  pe: {like: bmp, mouth: {aperture: 0, width: 0}}
notations: {ipa: {k: ka, g: kg, p: pe, a: aa}}
"""


def test_a_sound_that_a_language_adds_has_its_own_mouth(project, tmp_path):
    project()
    (tmp_path / "languages").mkdir()
    (tmp_path / "languages" / "mine.yaml").write_text(ADDED)
    packs = PairPacks.open(Library(), "mine", "anna")
    assert packs.solved.reached["ka"][0, 0] == pytest.approx(0.5, abs=0.05)
    assert packs.solved.reached["kg"][0, 0] < 0.3
    lips = packs.poseset.model.contacts["lips"]
    for pose, most in lips.ceiling.items():
        declared = packs.poseset.model.targets["bmp"][0].weights.get(pose, 0)
        assert packs.face.targets["pe"][0].weights.get(pose, 0) <= max(most, declared)
    assert "mine.yaml:6:25, solved on head.glb" in packs.targets["ka"][1]
    assert ll.resolve("mine", "anna").compiled.checks["apertures"]["ka"] == 0.5


def test_a_common_sound_that_a_language_adds_keeps_its_mouth(project):
    project()
    packs = PairPacks.open(Library(), "german", "anna")
    assert packs.language.model.adds["yu"] is None
    assert np.array_equal(packs.solved.asked["yu"], asked_measures(SOUNDS["yu"].mouth, 1, 1))


def test_an_explanation_says_what_the_mesh_misses_of_a_mouth(project):
    project("mouths: {aa: {aperture: 0.3, width: 0.3}}\n")
    line = ll.resolve("english", "anna").perform(ll.Schedule(("AA", "AH"), [0, 0.2, 0.4]))
    wide, near = line.explain(0.2).bigrams[0].places
    assert ", solved on head.glb, with width 0.0" in wide
    assert wide.endswith(" for 0.300")
    assert near.endswith(", solved on head.glb")


def test_the_model_of_a_pose_set_is_what_its_targets_were_made_for():
    packs = PairPacks.open(LIBRARY, "english", "facefx")
    assert packs.poseset.model.mouth == "solved"
    assert packs.solved is None


def test_a_changed_model_is_solved_again(project, tmp_path, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / "cache"))
    project()
    first, again = (ll.resolve("english", "anna").compiled for _ in range(2))
    assert np.array_equal(first.tables.neutral.curves, again.tables.neutral.curves)
    monkeypatch.setitem(face_models.OPENINGS, "jawOpen", 0.3)
    face(tmp_path / "characters" / "head.glb", *ARKIT)
    changed = ll.resolve("english", "anna").compiled
    assert changed.tables.neutral.curves.max() > first.tables.neutral.curves.max()


def test_every_sound_that_a_solved_set_targets_has_a_mouth_or_takes_its_neighbours():
    without = {
        name
        for poseset in SOLVED
        for name in LIBRARY.poseset(poseset).model.targets
        if not SOUNDS[name].mouth
    }
    idle = {COMMON.silence, *(n for n, one in SOUNDS.items() if "neighbours" in one.title)}
    assert without <= idle


MADE_HEAD = {
    "jawOpen": (0.502, -0.03, -0.152, 0.428), "jawForward": (0.018, 0.022, 0.074, 0.023),
    "mouthClose": (-0.57, 0, 0.139, -0.069), "mouthFunnel": (0.29, -0.049, 0.131, 0.066),
    "mouthPucker": (0.135, -0.083, 0.277, -0.024), "mouthRollLower": (-0.119, 0, -0.073, -0.003),
    "mouthRollUpper": (-0.052, 0.002, -0.08, 0), "mouthPress": (-0.028, 0, 0.002, -0.031),
    "mouthLowerDown": (0.051, 0.005, -0.006, 0.026), "mouthUpperUp": (0.058, -0.003, -0.003, 0),
    "mouthShrugUpper": (0.094, 0, 0.008, 0), "mouthStretch": (-0.008, 0.025, -0.014, -0.008),
    "tongueOut": (0, 0, 0, 0),
}  # fmt: skip
"""Measures of the shapes of a head by `heads ict`, without their sides."""


def test_teeth_meet_in_a_sibilant():
    """From a chin that falls by 0.06 widths of the mouth on, both rows of teeth stand apart."""
    poseset = LIBRARY.poseset("arkit").model
    gains = np.transpose(
        [MADE_HEAD[pose.removesuffix("Left").removesuffix("Right")] for pose in poseset.poses]
    )
    solver = _FaceToSolve.of(poseset, gains)
    found = targets(poseset, gains)
    for name, most in (("s", 0.055), ("sh", 0.035)):
        assert (gains @ solver.weights(found[name][0]))[-1] < most


@pytest.mark.parametrize("touching", ["M", "F", "TH"])
def test_lips_that_touch_do_not_stretch_beside_a_wide_vowel(touching):
    line = ll.Schedule(
        ("_", "IY", touching, "IY", "_"), [0, 0.3, 0.5, 0.6, 0.8, 1.1], notation="arpabet"
    )
    found = ll.resolve("english", "arkit").perform(line, fps=100)
    vowel, middle = (np.interp(at, found.times, found["mouthStretchLeft"]) for at in (0.4, 0.55))
    assert vowel > 0.1 > 2.5 * middle


def test_a_firm_aperture_becomes_the_dominance_of_poses_that_open_and_declared_ones_stay(project):
    packs = project(
        "mouths: {l: {aperture: 0.15, width: 0, firm: 3}, r: {aperture: 0.05, width: 0}}\n"
    )
    declared, solved = packs.poseset.model.targets, packs.solved.targets
    assert solved["l"][0].dominance["jawOpen"] == 3
    assert solved["r"][0].dominance == declared["r"][0].dominance != {}
    assert solved["bmp"][0].dominance["jawOpen"] == declared["bmp"][0].dominance["jawOpen"]
    assert "mouthStretchLeft" not in solved["l"][0].dominance
