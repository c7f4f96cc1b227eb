"""Changes by a layer: figures with known values, and their picture."""

import json
import re
from importlib.util import find_spec
from io import BytesIO

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import costly, full

from lipsync_lang import resolve
from lipsync_lang.base.errors import LipsyncError, OutputError
from lipsync_lang.packs.library import Library
from lipsync_lang.resolver.bank_diff import TIMES, diff_banks, told

PAIR = ("-l", "english", "-c", "facefx")
ANNA = """\
kind: character
format: 1
name: anna
poseset: facefx
bigrams:
  l-ow:
    word: low
    interpolation: linear
    boundary: 0.4
    curves: {open: [[0, 0], [0.5, 1], [1, 0]]}
  f-ah: {status: approved, contact: free, curves: {FV: [[0, 0], [1, 0]]}}
"""
BANK = """\
kind: bank
format: 1
name: mine
poseset: facefx
interpolation: linear
bigrams:
  l-ow: {curves: {open: [[0, 0], [0.5, 0.75], [1, 0]], W: [[0, 0.5], [1, 0.5]]}}
  s-ow: {curves: {W: [[0, 0], [0.5, 1], [1, 0]]}}
"""
drawn = pytest.mark.skipif(
    find_spec("matplotlib") is None, reason='needs matplotlib: pip install "lipsync-lang[plot]"'
)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Change to a folder with a character and a bank of its pose set."""
    monkeypatch.chdir(tmp_path)
    banks = tmp_path / "posesets" / "facefx" / "banks"
    banks.mkdir(parents=True)
    (banks / "mine.yaml").write_text(BANK)
    (tmp_path / "characters").mkdir()
    (tmp_path / "characters" / "anna.yaml").write_text(ANNA)
    return tmp_path


def diff(*rest, **more):
    return diff_banks(Library(), "english", *rest, **more)


def named(found, key):
    return next(change for change in found.named if change.bigram == key)


# Figures


@full
def test_a_character_is_compared_with_its_bare_pose_set():
    found = diff("anna")
    assert (found.against, found.total) == ("facefx", 483)
    assert {change.bigram for change in found.changes} == {"l-ow", "f-ah"}
    assert found.changes == found.named
    low = named(found, "l-ow")
    assert (low.word, str(low.before), str(low.after)) == (
        "low", "shared, edited", "character, edited",
    )  # fmt: skip
    assert (low.before.boundary, low.after.boundary) == (0.5, 0.4)
    assert [pose.pose for pose in low.poses] == ["W", "open"]
    rounded, jaw = low.poses
    assert (rounded.largest, rounded.rms, rounded.area) == pytest.approx((-0.5, 0.5, 0.5))
    # a triangle of height 1/4: its mean square is h^2/3, its area h/2
    assert (jaw.largest, jaw.at) == pytest.approx((0.25, 0.5))
    assert (jaw.rms, jaw.area) == pytest.approx((0.25 / 3**0.5, 0.125), rel=1e-3)


@full
def test_a_bare_pose_set_is_compared_with_its_drafts():
    found = diff("facefx")
    assert found.against == "its drafts"
    assert {change.bigram for change in found.changes} == {"l-ow", "s-ow"}
    assert {str(change.before) for change in found.changes} == {"draft, drafted"}


@full
def test_two_characters_and_the_other_way_round():
    one, other = diff("anna", "facefx"), diff("facefx", "anna")
    assert [c.bigram for c in one.changes] == [c.bigram for c in other.changes]
    for mine, theirs in zip(one.changes, other.changes, strict=True):
        for a, b in zip(mine.poses, theirs.poses, strict=True):
            assert (a.largest, a.rms, a.area) == pytest.approx((-b.largest, b.rms, b.area))
    assert diff("anna", "anna").named == ()


@full
def test_the_curves_are_those_that_are_performed():
    found = diff("anna", wanted=["l-ow", "s-ow", "l-ah"])
    for character, side in (("facefx", "before"), ("anna", "after")):
        compiled = resolve("english", character, cache=False).compiled
        names = compiled.phonemes
        for change in found.named:
            row = compiled.tables.pairs[tuple(map(names.index, change.bigram.split("-")))]
            curves = getattr(change, side).curves
            assert np.allclose(curves, compiled.tables.curves[row], atol=1e-6)


@full
def test_the_largest_comes_first_and_only_what_differs():
    sizes = [change.largest for change in diff("facefx").named]
    assert sizes == sorted(sizes, reverse=True)
    assert sizes[-1] > 0


def test_bigrams_asked_for_are_there_though_they_are_the_same():
    found = diff("anna", wanted=["l-ah", "l-ow", "l-ah"])
    assert (found.total, len(found.changes)) == (2, 1)
    assert [change.bigram for change in found.named] == ["l-ow", "l-ah"]
    assert told(found).endswith("l-ah: the same")
    with pytest.raises(
        LipsyncError, match="unknown bigram 'l-oow' in english; did you mean 'l-ow'"
    ):
        diff("anna", wanted=["l-oow"])


@full
def test_a_boundary_or_a_contact_alone_is_a_change(folder):
    (folder / "characters" / "anna.yaml").write_text(
        ANNA.partition("bigrams")[0] + "bigrams:\n  s-ow: {boundary: 0.3, contact: free, "
        "interpolation: linear, curves: {W: [[0, 0], [0.5, 1], [1, 0]]}}\n"
    )
    (change,) = diff("anna").changes
    assert change.poses == ()
    assert change.largest == 0
    assert "boundary 0.5 -> 0.3; contacts waived" in told(diff("anna"))


TRIGRAM = "trigrams:\n  s-l-ow: {%s curves: {open: [[0, 0], [0.5, 1], [1, 0]]}}\n"


def test_a_trigram_is_compared_with_the_larger_of_its_bigrams(folder):
    sad = BANK.replace("s-ow", "s-l").replace("W: [[0, 0.5], [1, 0.5]]", "FV: [[0, 1], [1, 1]]")
    (folder / "posesets/facefx/banks/mine.yaml").write_text(sad)
    linear = "interpolation: linear, word: slow, boundaries: [0.25, 0.5],"
    (folder / "characters/anna.yaml").write_text(ANNA + TRIGRAM % linear)
    found = diff("anna", wanted=["s-l-ow"])
    (change,) = found.named
    assert (change.bigram, change.word, found.total) == ("s-l-ow", "slow", 1)
    before, after = change.before, change.after
    assert (before.origin.source, after.origin.source) == ("bigrams", "character, edited")
    assert before.boundary == after.boundary == (0.25, 0.5)
    gained = {pose.pose: (pose.largest, pose.at) for pose in change.poses}
    # of "s-l" W peaks where "s" ends; of "l-ow" open does where "l" ends, and FV lasts throughout
    assert gained["W"] == (pytest.approx(-1), 0.25)
    assert gained["FV"] == (pytest.approx(-1), 0.25)
    assert (before.curves[64, 0], after.curves[64, 0]) == (0.75, 1)
    assert "1 of 1 bigrams and trigrams differ" in told(found)
    assert "s-l-ow, as in slow: bigrams -> character, edited\n" in told(found)
    assert json.loads(json.dumps(found.to_dict()))["changes"][0]["after"]["boundary"] == [0.25, 0.5]


def test_trigrams_of_both_sides_are_compared_with_each_other(folder):
    (folder / "posesets/facefx/banks/mine.yaml").write_text(BANK + TRIGRAM % "")
    anna = folder / "characters/anna.yaml"
    for fields, notes in (
        ("boundaries: [0.3, 0.5],", "boundary 0.333333, 0.666667 -> 0.3, 0.5"),
        ("contact: free,", "contacts waived"),
    ):
        anna.write_text(ANNA + TRIGRAM % ("interpolation: linear, " + fields))
        found = diff("anna")
        assert found.total == 484
        change = named(found, "s-l-ow")
        assert change.poses == ()
        assert f"s-l-ow: shared, edited -> character, edited; {notes}" in told(found)
    assert named(diff("facefx"), "s-l-ow").after.origin.layer == "shared"


def test_characters_of_two_pose_sets_have_nothing_to_compare(folder):
    (folder / "posesets" / "small").mkdir()
    (folder / "posesets" / "small" / "poseset.yaml").write_text(
        "kind: poseset\nformat: 1\nname: small\nposes: {jaw: {}}\n"
    )
    with pytest.raises(LipsyncError, match="'anna' moves the poses of facefx, 'small' those of sm"):
        diff("anna", "small")


POINTS = st.lists(
    st.tuples(st.floats(0, 1), st.floats(0, 1)).map(lambda p: [round(n, 3) for n in p]),
    min_size=2,
    max_size=6,
).map(sorted)


@full
@costly()
@given(points=POINTS, kind=st.sampled_from(["bspline", "linear"]))
def test_the_figures_bound_each_other(points, kind, folder):
    (folder / "characters" / "anna.yaml").write_text(
        ANNA.partition("bigrams")[0]
        + f"bigrams:\n  l-ow: {{interpolation: {kind}, curves: {{wide: {points}}}}}\n"
    )
    (change,) = diff("anna", wanted=["l-ow"]).named
    for pose in change.poses:
        assert pose.area <= pose.rms + 1e-12
        assert pose.rms <= abs(pose.largest) + 1e-12
        assert pose.at in TIMES
    assert {"open", "W"} <= {pose.pose for pose in change.poses}


# The command


def test_the_command_lists_what_differs(cli):
    ended = cli("bank", "diff", "-l", "english", "-c", "anna")
    assert (ended.code, ended.err) == (0, "")
    assert ended.out.startswith("english on anna against facefx: 2 of 483 bigrams differ\n")
    assert (
        "l-ow, as in low: shared, edited -> character, edited; boundary 0.5 -> 0.4\n"
        "  W     -0.50 at 0.00  rms 0.50  area 0.50\n"
        "  open  +0.25 at 0.50  rms 0.14  area 0.12\n"
    ) in ended.out


@full
def test_many_are_cut_short_unless_all_are_wanted(cli, folder):
    keys = [f"{sound}-ah" for sound in Library().common().model.base]
    assert cli("bank", "draft", *PAIR, "--to", "drafts.yaml", *keys).code == 0
    text = (folder / "drafts.yaml").read_text().replace("status: drafted", "boundary: 0.45")
    text = text.replace("name: drafts", "name: more")
    (folder / "posesets/facefx/banks/more.yaml").write_text(text)
    ended = cli("bank", "diff", *PAIR)
    assert ended.out.startswith("english on facefx against its drafts: 23 of 483 bigrams differ")
    assert ended.out.rstrip().endswith("... and 15 that differ less (--all)")
    assert cli("bank", "diff", *PAIR, "--all").out.count("boundary 0.5 -> 0.45") == 21


@full
def test_json_holds_the_figures(cli):
    data = json.loads(cli("bank", "diff", "-l", "english", "-c", "anna", "--json").out)
    assert (data["against"], data["bigrams"], data["changed"]) == ("facefx", 483, 2)
    low = next(change for change in data["changes"] if change["bigram"] == "l-ow")
    assert low["before"]["layer"] == "shared"
    assert low["after"]["places"] == ["characters/anna.yaml:6:3"]
    assert set(low["poses"][0]) == {"pose", "largest", "at", "rms", "area"}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--against", "nobody"], "nobody"),
        (["l-oow"], "unknown bigram 'l-oow' in english"),
        pytest.param(["--plot", "a.gif"], "no picture format 'gif'", marks=full),
        pytest.param(["--plot", "no/a.png"], "the folder no does not exist", marks=full),
    ],
)
def test_what_cannot_be_done_is_told(arguments, message, cli, folder):
    before = sorted(folder.rglob("*"))
    ended = cli("bank", "diff", "-l", "english", "-c", "anna", *arguments)
    assert (ended.code, ended.out) == (2, "")
    assert message in ended.err
    assert sorted(folder.rglob("*")) == before


# The picture


def texts(found):
    from lipsync_lang.render.bigram_plot import plot_diff

    out = BytesIO()
    plot_diff(found, out, "svg")
    return re.findall(r"<text[^>]*>([^<]*)</text>", out.getvalue().decode())


@full
@drawn
def test_the_picture_names_bigrams_words_and_poses(cli, folder):
    shown = texts(diff("anna"))
    assert {"l-ow  low", "f-ah", "open", "W", "FV", "before", "after"} <= set(shown)
    assert "anna against facefx" in shown
    assert any("2 of 483 bigrams differ" in text for text in shown)
    assert "tBack" not in shown, "it moves in none of them"
    ended = cli("bank", "diff", "-l", "english", "-c", "anna", "--plot", "a.png")
    assert ended.code == 0
    assert (folder / "a.png").read_bytes().startswith(b"\x89PNG")


@full
@drawn
def test_the_same_picture_each_time_and_what_is_the_same_says_so():
    found = diff("anna", wanted=["l-ah", "_-h"])
    assert texts(found) == texts(found)
    assert texts(found).count("unchanged") == 2


@full
@drawn
def test_only_as_many_as_there_is_room_for():
    from lipsync_lang.render.bigram_plot import MOST

    keys = [f"l-{sound}" for sound in Library().common().model.base]
    shown = texts(diff("anna", wanted=keys))
    assert sum(text.split(maxsplit=1)[0] in keys for text in shown if text) == MOST
    assert any(f"the {MOST} with the largest differences" in text for text in shown)


@full
def test_nothing_to_draw():
    from lipsync_lang.render.bigram_plot import plot_diff

    with pytest.raises(OutputError, match="no bigram differs from those of anna"):
        plot_diff(diff("anna", "anna"), BytesIO())
