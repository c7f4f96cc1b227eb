"""Shades: finer common phonemes with their own drafts, and with their parents' drawn curves."""

import re
from dataclasses import replace

import numpy as np
import pytest
from lanes import full
from packs_tree import put
from shipped import LIBRARY, POSESETS

from lipsync_lang import LipsyncError, resolve
from lipsync_lang.packs.finding import built_in
from lipsync_lang.packs.library import Library
from lipsync_lang.performing.performer import Performer
from lipsync_lang.pipeline.hold import demands
from lipsync_lang.reports.quality.check_animation import check
from lipsync_lang.resolver.bank_diff import diff_banks
from lipsync_lang.resolver.bigram_sources import draft_bigrams
from lipsync_lang.schedules.schedule import Schedule

COMMON = LIBRARY.common().model
SHADES = COMMON.shades
TARGETS = """\
  ae: {open: 0.7, wide: 0.5}
  ng: {open: 0.2, tBack: 0.8}
  bw: {open: 0.2, PBM: 0.6}
"""
LANGUAGE = """\
kind: language
format: 1
name: finer
tag: qaa
notations:
  ipa: {a: aa, æ: ae, ə: ax, b: bmp, β: bw, t: d, k: kg, ŋ: ng}
"""
COARSE = re.sub(
    r"\b(ae|ax|bw|ng)\b",
    lambda shade: SHADES[shade[0]].like,
    LANGUAGE.replace("finer", "coarse"),
)
LABELS = ("k", "æ", "ŋ", "ə", "β", "a", "t")
TIMES = np.array([0.1, 0.2, 0.32, 0.4, 0.46, 0.54, 0.7, 0.8])
LINE = Schedule(LABELS, TIMES)
AS_PARENTS = Schedule(("k", "a", "k", "ə", "b", "a", "t"), TIMES)
CURVE = "[[0, 0], [0.5, 0.9], [1, 0]]"


@pytest.fixture
def packs(tmp_path):
    """A folder with two languages, one without shades, and a face with three shades."""
    put(tmp_path, "languages/finer.yaml", LANGUAGE)
    put(tmp_path, "languages/coarse.yaml", COARSE)
    face(tmp_path, TARGETS)
    return tmp_path


def face(folder, targets):
    """Write `facefx` with only the given shades."""
    text = (built_in() / "posesets/facefx/poseset.yaml").read_text("utf-8")
    text = re.sub(rf"^  (?:{'|'.join(SHADES)}): .*\n", "", text, flags=re.MULTILINE)
    text = text.replace("model: model.glb", "").replace("\ntargets:\n", f"\ntargets:\n{targets}")
    put(folder, "posesets/facefx/poseset.yaml", text)


def bank(folder, bigrams, *, style="neutral"):
    head = f"kind: bank\nformat: 1\nname: {style}\nposeset: facefx\nstyle: {style}\nbigrams:\n"
    put(folder, f"posesets/facefx/banks/{style}.yaml", head + bigrams)


def performer(folder, language="finer", **settings):
    return resolve(language, "facefx", paths=folder, cache=False, **settings)


def curves(performer, schedule=LINE, **settings):
    return performer.perform(schedule, **settings).weights


def test_a_shade_moves_by_its_own_target(packs):
    finer = performer(packs)
    assert not np.allclose(curves(finer), curves(finer, AS_PARENTS))
    assert finer.compiled.phonemes[-3:] == ("ae", "ng", "bw")


@full
def test_shades_off_are_exactly_their_parents(packs):
    coarse = curves(performer(packs, "coarse"))
    assert np.array_equal(curves(performer(packs, shades=False)), coarse)
    assert np.array_equal(curves(performer(packs), AS_PARENTS), coarse)
    paper = curves(performer(packs, "coarse", motion="paper"))
    assert np.array_equal(curves(performer(packs, motion="paper")), paper)
    assert not np.array_equal(curves(performer(packs, motion="paper", shades=True)), paper)


def test_without_targets_shades_are_exactly_their_parents_and_take_no_room(packs):
    face(packs, "")
    finer = performer(packs)
    assert np.array_equal(curves(finer), curves(performer(packs, "coarse")))
    assert finer.compiled.tables.pairs.shape == (22, 22)
    assert finer.report.shades == ()


def test_a_drawn_parent_comes_before_a_drafted_shade(packs):
    drafted = curves(performer(packs))
    bank(packs, f"  kg-aa: {{status: edited, curves: {{FV: {CURVE}}}}}\n")
    drawn = performer(packs).perform(LINE)
    assert not np.allclose(drawn.weights, drafted)
    assert drawn.weights[:, drawn.poses.index("FV")].max() > 0.3
    told = drawn.source.performer.explain(drawn, 0.2)
    first = next(b for b in told.bigrams if b.pair == ("kg", "ae"))
    assert (first.layer, first.status, first.drawn_as) == ("shared", "edited", ("kg", "aa"))
    assert "drawn as kg-aa" in str(told)


@full
def test_a_drawn_shade_comes_before_its_drawn_parent_and_the_finest_first(packs):
    finest = f"  ae-ng: {{curves: {{wide: {CURVE}}}}}\n"
    half = f"  aa-ng: {{curves: {{W: {CURVE}}}}}\n"
    parent = f"  aa-kg: {{curves: {{FV: {CURVE}}}}}\n"
    for drawn, pair in ((parent, "aa-kg"), (parent + half, "aa-ng"), (parent + finest, "ae-ng")):
        bank(packs, drawn)
        made = performer(packs).compiled
        row = made.tables.pairs[made.phonemes.index("ae"), made.phonemes.index("ng")]
        assert "-".join(made.origins[row].pair) == pair


def test_a_style_that_draws_the_parent_moves_its_shades(packs):
    bank(packs, f"  kg-aa: {{curves: {{FV: {CURVE}}}}}\n", style="angry")
    made = performer(packs)
    angry = curves(made, styles={"angry": 1.0})
    assert angry[:, made.poses.index("FV")].max() > 0.3
    assert made.report.styles == {"angry": {"edited": 1}}


@full
def test_what_counts_are_the_parents(packs):
    finer, coarse = performer(packs).report, performer(packs, "coarse").report
    assert replace(finer, language="", shades=()) == replace(coarse, language="", shades=())
    assert (finer.shared, finer.extra, finer.shades) == (441, 0, ("ae", "ng", "bw"))
    assert "3 shades: ae ng bw" in str(finer)
    assert diff_banks(Library([packs], project=None), "finer", "facefx").total == 483


@full
def test_a_shade_that_a_bank_draws_is_compared_as_any_bigram(packs):
    bank(packs, f"  kg-ae: {{status: edited, curves: {{FV: {CURVE}}}}}\n")
    library = Library([packs], project=None)
    found = diff_banks(library, "finer", "facefx")
    assert (found.total, [one.bigram for one in found.changes]) == (484, ["kg-ae"])
    change = found.changes[0]
    assert (str(change.before), str(change.after)) == ("draft, drafted", "shared, edited")
    assert any(pose.pose == "FV" and pose.largest > 0.3 for pose in change.poses)

    face(packs, "")
    bank(packs, f"  kg-aa: {{curves: {{FV: {CURVE}}}}}\n  kg-ae: {{curves: {{W: {CURVE}}}}}\n")
    found = diff_banks(Library([packs], project=None), "finer", "facefx")
    assert {one.bigram for one in found.changes} == {"kg-aa", "kg-ae"}


@full
def test_a_shade_that_no_bank_draws_is_compared_if_it_is_asked_for(packs):
    bank(packs, f"  kg-aa: {{curves: {{FV: {CURVE}}}}}\n")
    library = Library([packs], project=None)
    assert [one.bigram for one in diff_banks(library, "finer", "facefx").changes] == ["kg-aa"]
    (asked,) = diff_banks(library, "finer", "facefx", wanted=["kg-ae"]).named
    assert (asked.bigram, asked.changed) == ("kg-ae", True)


def test_a_frame_names_the_shade(packs):
    animation = performer(packs).perform(LINE)
    told = animation.source.performer.explain(animation, 0.25)
    assert (told.phoneme, told.common, told.shade_of) == ("æ", "ae", "aa")
    assert "æ as ae (a shade of aa)" in str(told)
    off = performer(packs, shades=False).perform(LINE)
    assert off.source.performer.explain(off, 0.25).shade_of is None


@full
def test_contacts_are_the_parents_unless_a_shade_is_free(packs):
    face(packs, TARGETS.replace("  bw", "  ch: {ShCh: 0.5}\n  bw"))
    made = performer(packs)
    track = made.performance(LINE, 60).track
    lips = made.compiled.tables.contacts[1]
    assert not demands(lips, track).any()
    assert demands(lips, performer(packs, shades=False).performance(LINE, 60).track).sum() == 1
    face(packs, "")
    assert demands(lips, performer(packs).performance(LINE, 60).track).sum() == 1


def test_rules_about_a_parent_hold_for_its_shades(packs):
    opens = "opens: {phonemes: [aa], measure: opening, at_least: 2}"
    path = packs / "posesets/facefx/poseset.yaml"
    path.write_text(re.sub(r"opens: {[^}]*}", opens, path.read_text("utf-8")), "utf-8")
    animation = performer(packs).perform(Schedule(("æ", "t"), [0, 0.2, 0.3]))
    found = check(animation).figures
    assert [one.parts for one in found if one.name == "rules opens"] == [{"kept": 0, "missed": 1}]


def test_a_shade_can_be_drafted_for_a_close_up(packs):
    library = Library([packs], project=None)
    made = draft_bigrams(library, "finer", "facefx", ["kg-ae"])
    assert list(made.bigrams) == ["kg-ae"]
    assert not {p for key in draft_bigrams(library, "finer", "facefx").bigrams
                for p in key.split("-")} & {*SHADES}  # fmt: skip
    with pytest.raises(LipsyncError, match="unknown bigram 'kg-zz'"):
        draft_bigrams(library, "finer", "facefx", ["kg-zz"])


def test_a_performer_with_shades_survives_the_cache(packs, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(packs / "cache"))
    first = resolve("finer", "facefx", paths=packs)
    again = resolve("finer", "facefx", paths=packs)
    assert again.compiled.shades == first.compiled.shades
    assert np.array_equal(curves(again), curves(first))
    face(packs, "")
    assert resolve("finer", "facefx", paths=packs).report.shades == ()


def test_a_project_and_a_command_turn_shades_off(packs, cli, monkeypatch):
    monkeypatch.chdir(packs)
    rows = "".join(f"{a},{b},{label}\n" for a, b, label in zip(TIMES, TIMES[1:], LABELS,
                                                                strict=False))  # fmt: skip
    put(packs, "line.csv", f"start,end,label\n{rows}")

    def run(*options):
        assert cli("run", "--schedule", "line.csv", "-o", "out.csv", "-q", *options).code == 0
        return (packs / "out.csv").read_text("utf-8")

    pair = ("--path", ".", "-l", "finer", "-c", "facefx")
    shaded, plain = run(*pair), run(*pair, "--no-shades")
    assert shaded != plain
    project = "kind: project\nformat: 1\nlanguage: finer\ncharacter: facefx\npaths: ['.']\n"
    put(packs, "lipsync.yaml", f"{project}shades: false\n")
    assert (run(), run("--shades")) == (plain, shaded)


def test_every_shade_is_told_and_looks_like_a_phoneme():
    assert SHADES
    for name, shade in SHADES.items():
        assert shade.like in COMMON.phonemes, name
        assert shade.title, name
        assert shade.ipa, name
        assert shade.reason, name


@pytest.mark.parametrize("pack", POSESETS)
def test_every_shade_of_a_pose_set_differs_from_its_parent(pack):
    targets = LIBRARY.poseset(pack).model.targets
    for name in targets.keys() & SHADES.keys():
        assert targets[name] != targets[SHADES[name].like], name


def test_a_performer_says_how_many_phonemes_count(packs):
    made = performer(packs)
    assert isinstance(made, Performer)
    assert "21 common phonemes" in repr(made)
