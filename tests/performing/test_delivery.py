"""Delivery of lines: styles blended over neutral, scaled regions, and poses one at a time."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full
from strategies import RATES, any_lines, motions, undisturbed

import lipsync_lang as ll
from lipsync_lang import Schedule
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.pipeline.levels import Blend, Dial, Level, scale, shares
from lipsync_lang.pipeline.prepare import GIVEN
from lipsync_lang.pipeline.switch import FREE, NONE, switch
from lipsync_lang.schedules.schedule import Word

GRIM = """\
kind: bank
format: 1
name: grim
poseset: facefx
style: grim
bigrams:
  l-ow: {status: approved, boundary: 0.3, curves: {W: [[0, 0], [0.2, 1], [0.8, 1], [1, 0]]}}
  ow-_: {curves: {open: [[0, 0.5], [0.5, 0.5], [1, 0]]}}
"""
CHARACTER = """\
kind: character
format: 1
name: anna
poseset: facefx
styles: {grim: 0.5}
lines:
  shout: {styles: {grim: 1}, dials: {jaw: [[0, 0.5], [1, 0.5], [2, 1]]}}
  calm: {styles: {grim: 0}}
  far: {dials: {jaw: [[0, 1], [7, 1]]}}
"""
LINE = Schedule.from_intervals(
    [
        ("HH", 0.1, 0.2), ("EH", 0.2, 0.35), ("L", 0.35, 0.45), ("OW", 0.45, 0.8),
        ("P", 0.8, 0.9), ("AA", 0.9, 1.2), ("P", 1.2, 1.3),
    ],
    words=(Word("hello", 0, 4), Word("pop", 4, 7)),
    notation="arpabet",
)  # fmt: skip


@pytest.fixture(scope="module")
def project(tmp_path_factory):
    folder = tmp_path_factory.mktemp("project")
    (folder / "posesets/facefx/banks").mkdir(parents=True)
    (folder / "posesets/facefx/banks/grim.yaml").write_text(GRIM, "utf-8")
    (folder / "characters").mkdir()
    (folder / "characters/anna.yaml").write_text(CHARACTER, "utf-8")
    return folder


@pytest.fixture(scope="module")
def bare(project):
    return ll.resolve("english", "facefx", paths=[project], cache=False)


@pytest.fixture(scope="module")
def anna(project):
    return ll.resolve("english", "anna", paths=[project], cache=False)


def stitched(performer, **how):
    performance = performer.performance(LINE, 60, **how)
    return performance.frames.times(), performance.stages(0, performance.frames.count)[0].curves


@full
def test_a_share_of_nothing_is_neutral_to_the_bit(bare):
    plain = ll.resolve("english", "facefx", cache=False).perform(LINE)
    assert np.array_equal(bare.perform(LINE).weights, plain.weights)
    assert np.array_equal(bare.perform(LINE, styles={"grim": 0}).weights, plain.weights)


def test_a_style_changes_its_own_bigrams_and_no_others(bare):
    times, neutral = stitched(bare)
    _, grim = stitched(bare, styles={"grim": 1})
    changed = np.abs(grim - neutral).max(axis=0) > 1e-9
    assert changed.any()
    assert (times[changed] > 0.35).all()
    assert (times[changed] < 0.8).all()  # the line never comes to `ow-_`


def test_the_styles_of_a_character_shape_a_line_without_words(bare, anna):
    plain = replace(LINE, words=())
    asked = bare.perform(plain, styles={"grim": 0.5}).weights
    assert np.array_equal(anna.perform(plain).weights, asked)
    assert not np.array_equal(bare.perform(plain).weights, asked)


def test_half_a_style_is_half_way_before_all_else(bare):
    bare = bare.with_motion({"stitch": "crossfade"})  # which is linear, as a maximum is not
    _, neutral = stitched(bare)
    _, grim = stitched(bare, styles={"grim": 1})
    _, half = stitched(bare, styles={"grim": 0.5})
    assert np.abs(half - (neutral + grim) / 2).max() < 1e-6


def test_each_bank_is_warped_by_its_own_boundary(bare):
    """The first sound ends at 0.3 of the grim curve, where W is high already."""
    times, grim = stitched(bare, styles={"grim": 1})
    w = grim[bare.poses.index("W")]
    at = np.abs(times - 0.45).argmin()
    curve = bare.compiled.tables.styles[0].curves
    row = next(n for n, o in enumerate(bare.compiled.origins) if o.pair == ("l", "ow"))
    assert w[at] == pytest.approx(float(curve[row, round(0.3 * 128), 1]), abs=0.02)


def test_of_a_layer_the_style_comes_first_and_of_styles_each_has_its_own(tmp_path):
    banks = tmp_path / "posesets/facefx/banks"
    banks.mkdir(parents=True)
    for style, weight in (("neutral", 0.2), ("grim", 0.6), ("calm", 0.1)):
        (banks / f"{style}.yaml").write_text(
            f"kind: bank\nformat: 1\nname: {style}\nposeset: facefx\nstyle: {style}\n"
            "interpolation: linear\nbigrams:\n"
            f"  l-ow: {{curves: {{wide: [[0, {weight}], [1, {weight}]]}}}}\n", "utf-8",
        )  # fmt: skip
    for _ in range(2):  # the second time from the cache
        performer = ll.resolve("english", "facefx", paths=[tmp_path])
        wide = performer.poses.index("wide")
        row = next(n for n, o in enumerate(performer.compiled.origins) if o.pair == ("l", "ow"))
        tables = performer.compiled.tables
        assert tuple(performer.compiled.style_origins) == ("calm", "grim")
        found = [bank.curves[row, 64, wide] for bank in (tables.neutral, *tables.styles)]
        assert found == pytest.approx([0.2, 0.1, 0.6])


def test_a_contact_is_waived_only_if_all_that_is_heard_waives_it(tmp_path):
    banks = tmp_path / "posesets/facefx/banks"
    banks.mkdir(parents=True)
    free = "".join(
        f"  {pair}: {{contact: free, curves: {{}}}}\n" for pair in ("ow-bmp", "bmp-aa", "aa-bmp")
    )
    (banks / "loose.yaml").write_text(
        "kind: bank\nformat: 1\nname: loose\nposeset: facefx\nstyle: loose\nbigrams:\n" + free,
        "utf-8",
    )
    performer = ll.resolve("english", "facefx", paths=[tmp_path], cache=False)

    def held(share):
        performance = performer.performance(LINE, 60, styles={"loose": share})
        names = performer.compiled.contact_names
        return performance.held[names.index("lips")][0].sum()

    assert (held(0), held(0.5), held(1)) == (2, 2, 0)
    assert held([(0, 1), (1, 0.9)]) == 2, "neutral is heard at the end"


def test_shares_over_time_pass_from_one_to_the_other(bare):
    bare = bare.with_motion({"stitch": "crossfade"})
    times, neutral = stitched(bare)
    _, grim = stitched(bare, styles={"grim": 1})
    _, moving = stitched(bare, styles={"grim": [(0.4, 0), (0.8, 1)]})
    share = np.interp(times, [0.4, 0.8], [0, 1])
    assert np.abs(moving - (neutral * (1 - share) + grim * share)).max() < 1e-6


@given(st.lists(st.lists(st.floats(0, 1), min_size=1, max_size=4), min_size=1, max_size=3))
def test_shares_add_up_to_one(wanted):
    blends = [
        Blend(n, Level(np.arange(len(v), dtype=float), np.array(v))) for n, v in enumerate(wanted)
    ]
    parts = shares(blends, np.linspace(-1, 5, 31))
    assert parts.shape == (len(wanted) + 1, 31)
    assert parts.min() >= 0
    assert np.abs(parts.sum(axis=0) - 1).max() < 1e-9


def test_lines_say_how_they_are_spoken_and_calls_have_the_last_word(bare, anna):
    def same(one, other):
        return np.array_equal(one.weights, other.weights)

    assert same(anna.perform(LINE), bare.perform(LINE, styles={"grim": 0.5}))
    assert same(anna.perform(LINE, line="calm"), bare.perform(LINE))
    shout = bare.perform(
        LINE, styles={"grim": 1}, dials={"jaw": [(0.1, 0.5), (0.8, 0.5), (1.3, 1)]}
    )
    assert same(anna.perform(LINE, line="shout"), shout)
    assert same(anna.perform(LINE, line="shout", styles={"grim": 0}, dials={"jaw": 1}),
                bare.perform(LINE))  # fmt: skip


def test_words_survive_a_new_recording(anna):
    slow = Schedule(LINE.labels, LINE.times * 2, words=LINE.words, notation="arpabet")
    before = anna.performance(LINE, 60, line="shout").dials[0].level
    after = anna.performance(slow, 60, line="shout").dials[0].level
    assert after.times.tolist() == (before.times * 2).tolist()


def test_a_word_beyond_the_line_is_told(anna):
    with pytest.raises(LipsyncError, match=r"jaw has a point at word 7, but .* has 2 words"):
        anna.perform(LINE, line="far")


@pytest.mark.parametrize("level", [0, 0.3, 1.5, 2])
def test_a_dial_scales_its_region_alone_and_contacts_hold(bare, level):
    usual, dialled = bare.perform(LINE), bare.perform(LINE, dials={"lips": level})
    poses = bare.poses
    lips = bare.compiled.regions["lips"]
    tongue = [n for n, pose in enumerate(poses) if n not in (*lips, poses.index("open"))]
    assert np.abs(dialled.weights[:, tongue] - usual.weights[:, tongue]).max() < 1e-9
    performance = bare.performance(LINE, 60, dials={"lips": level})
    for contact, frames in undisturbed(performance):
        held = dialled.weights[frames]
        assert (held >= contact.floor - GIVEN).all()
    w = poses.index("W")
    free = ~performance.held[0][1]
    change = dialled.weights[free, w].max() / usual.weights[free, w].max()
    assert change <= 1e-9 if level == 0 else (change > 1) == (level > 1)


@full
@given(any_lines(), RATES, motions())
def test_a_dial_at_its_usual_level_changes_nothing(line, fps, motion):
    performance = line.perform(motion, fps)
    curves = performance.stages(0, performance.frames.count)[0].curves
    every = Dial(np.ones(len(curves), bool), Level(np.zeros(1), np.ones(1)))
    assert np.array_equal(scale(curves, [every], performance.frames.times()), curves)


@pytest.mark.parametrize(
    ("how", "told"),
    [
        ({"styles": {"grimm": 1}}, "unknown style 'grimm'; did you mean 'grim'"),
        ({"styles": {"grim": 1.5}}, "style grim: 1.5 is not a level; give a number from 0 to 1"),
        ({"styles": {"grim": float("nan")}}, "style grim: nan is not a level"),
        ({"dials": {"jawz": 1}}, "unknown region 'jawz'; did you mean 'jaw'"),
        ({"dials": {"jaw": -1}}, "dial jaw: -1 is not a level; give a number from 0 to 2"),
        ({"dials": {"jaw": [(1, 1), (0, 1)]}}, "dial jaw: its points are not in order of time"),
        ({"dials": {"jaw": []}}, "dial jaw"),
        ({"dials": {"jaw": [(1, 1, 1)]}}, "dial jaw"),
    ],
)
def test_what_cannot_be_delivered_is_told(bare, how, told):
    with pytest.raises(LipsyncError) as error:
        bare.perform(LINE, **how)
    assert told in str(error.value)


def test_the_command_line_delivers(project, cli, tmp_path):
    (tmp_path / "line.json").write_text(
        json.dumps({"phonemes": [
            {"label": label, "start": a, "end": b}
            for label, a, b in zip(LINE.labels, LINE.times, LINE.times[1:], strict=False)
        ]}), "utf-8",
    )  # fmt: skip
    asked = ("run", "-l", "english", "-c", "facefx", "--path", project, "--notation", "arpabet",
             "--schedule", tmp_path / "line.json")  # fmt: skip
    out = tmp_path / "line.csv"
    assert cli(*asked, "-o", out).code == 0
    usual = out.read_text("utf-8")
    ended = cli(*asked, "-o", out, "--style", "grim:0@0,1@0.5", "--dial", "jaw:0.5")
    assert ended.code == 0
    assert out.read_text("utf-8") != usual
    ended = cli(*asked, "--style", "grim")
    assert ended.code == 2
    assert "--style grim: write NAME:NUMBER (--style grim:0.5)" in ended.err
    ended = cli("explain", *asked[1:], "--at", "0.5", "--dial", "jaw:0.5", "--style", "grim:1")
    assert "dial      " in ended.out
    assert "style grim" in ended.out
    assert "grim.yaml:7:3" in ended.out


def test_resolving_counts_what_a_style_has(bare, anna, project):
    assert bare.report.styles == anna.report.styles == {"grim": {"approved": 1, "edited": 1}}
    assert "style grim: 1 approved, 1 edited; the rest is neutral" in str(bare.report)
    kept = [ll.resolve("english", "anna", paths=[project]) for _ in range(2)]
    assert [str(k.report) for k in kept] == [str(anna.report)] * 2
    assert kept[1].compiled.style_origins == anna.compiled.style_origins
    assert np.array_equal(kept[1].perform(LINE).weights, anna.perform(LINE).weights)


def test_a_style_or_region_that_is_not_there_is_found(project, tmp_path):
    (tmp_path / "characters").mkdir()
    file = tmp_path / "characters/bob.yaml"
    file.write_text(
        "kind: character\nformat: 1\nname: bob\nposeset: facefx\nstyles: {grimm: 1}\n"
        "lines: {one: {dials: {jawz: 1}}}\n", "utf-8",
    )  # fmt: skip
    found = validate(Library([tmp_path, project], project=None), [file])
    assert [(f.code, f.line, f.hint) for f in found] == [
        ("W320", 5, "did you mean 'grim'?"),
        ("P230", 6, "did you mean 'jaw'?"),
    ]


# One pose at a time


@st.composite
def shown(draw):
    poses, frames = draw(st.integers(1, 4)), draw(st.integers(1, 80))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    steps = rng.random((poses, frames // 3 + 1)).repeat(3, axis=1)[:, :frames]
    forced = np.full(frames, FREE)
    for start in rng.integers(0, frames, draw(st.integers(0, 3))):
        forced[start : start + 3] = rng.integers(NONE, poses)
    barred = (rng.random((poses, 1)) < 0.3) & (forced != FREE)
    return steps, barred, forced, draw(st.integers(1, 12))


@given(shown())
def test_one_pose_is_shown_at_a_time_and_lasts(made):
    curves, barred, forced, least = made
    out = switch(curves, barred, forced, least)
    assert set(np.unique(out)) <= {0.0, 1.0}
    assert (out.sum(axis=0) <= 1).all()
    at = np.flatnonzero(forced > NONE)
    assert (out[forced[at], at] == 1).all(), "a contact is shown"
    names = np.where(out.any(axis=0), out.argmax(axis=0), NONE)
    bounds = [0, *(np.flatnonzero(np.diff(names)) + 1), len(names)]
    inner = list(pairwise(bounds))[1:-1]
    near = forced != FREE
    for start, stop in inner:
        contact = near[max(0, start - 2 * least) : stop + 2 * least].any()
        assert stop - start >= least or contact, (start, stop)


def test_a_contact_lasts_as_long_as_the_rest():
    curves = np.zeros((2, 40))
    curves[1] = 1
    forced = np.full(40, FREE)
    forced[20:22] = 0
    out = switch(curves, np.zeros(curves.shape, bool), forced, 6)
    assert np.flatnonzero(out[0]).tolist() == list(range(18, 24))


def test_a_vowel_between_two_contacts_alike_stays_however_short():
    curves = np.zeros((2, 30))
    curves[1, 12:15] = 1
    forced = np.full(30, FREE)
    forced[8:12] = forced[15:19] = 0
    curves[0, forced == 0] = 1
    out = switch(curves, np.zeros(curves.shape, bool), forced, 8)
    assert np.flatnonzero(out[1]).tolist() == [12, 13, 14]


def test_a_flicker_makes_room_where_its_neighbours_meet():
    curves = np.zeros((3, 30))
    curves[0, :14], curves[1, 14:16], curves[2, 16:] = 1, 1, 1
    out = switch(curves, np.zeros(curves.shape, bool), np.full(30, FREE), 5)
    assert out[0, :14].all()
    assert not out[1].any()
    assert out[2, 16:].all()
