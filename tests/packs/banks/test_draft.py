"""Drafts: complete, as high as their targets, and below curves of a person."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import real

from lipsync_lang import resolve
from lipsync_lang.packs.banks.draft import DECIMALS, PASSIVE, TIMES, Target, draft
from lipsync_lang.packs.banks.write import bigrams_yaml, write_drafts
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml import building
from lipsync_lang.pipeline.curve import bspline
from lipsync_lang.pipeline.tables import RESOLUTION
from lipsync_lang.resolver.bigram_sources import draft_bigrams
from lipsync_lang.resolver.layers import PairPacks

AT = np.linspace(0, 1, RESOLUTION + 1)
HALF, FIRST, SECOND = RESOLUTION // 2, RESOLUTION // 4, 3 * RESOLUTION // 4
"""Boundary of a bigram's phonemes, and the middles of the two."""


def target(weight, dominance=1.0):
    return Target(np.array([np.atleast_1d(weight)]).T.astype(float), np.array([float(dominance)]))


def curve(first, second):
    """The smooth curve of a bigram of one pose."""
    values = draft([first], [second])[0, 0]
    return bspline(np.column_stack((TIMES, values))[None], AT)[0]


REST, PASSING = target(0), target(0, PASSIVE)


@pytest.fixture(scope="module")
def library():
    return Library([], project=None)


def shelf(library):
    return PairPacks.open(library, "english", "facefx")


def test_every_bigram_and_every_passage_from_and_to_silence_is_drafted(library):
    performer = real()
    phonemes = performer.compiled.counted
    assert len(phonemes) == 22
    wanted = {pair for pair in product(phonemes, repeat=2) if pair != ("_", "_")}
    found = shelf(library).drafts(sorted(wanted))
    assert set(found) == wanted
    assert len(wanted) == 21 * 21 + 42
    assert performer.report.gaps == ()
    pairs = performer.compiled.tables.pairs
    assert (pairs > 0).sum() == len(performer.compiled.phonemes) ** 2 - 1


def test_drafted_points_are_round_and_between_0_and_1(library):
    rows = shelf(library).drafts(shelf(library).pairs())
    assert rows
    for row in rows.values():
        assert row.origin.status == "drafted"
        for points in row.curves.values():
            assert points[:, 0].tolist() == TIMES.tolist()
            values = points[:, 1]
            assert values.min() >= 0
            assert values.max() <= 1
            assert values.any(), "a pose at rest has no curve"
            assert np.array_equal(values.round(min(DECIMALS, 3)), values)


def test_drafting_twice_gives_the_same(library):
    one, two = (shelf(library).drafts(shelf(library).pairs()) for _ in range(2))
    assert list(one) == list(two)
    for pair, row in one.items():
        assert list(row.curves) == list(two[pair].curves)
        for pose, points in row.curves.items():
            assert np.array_equal(points, two[pair].curves[pose])
    assert np.array_equal(resolve("english", "facefx", cache=False).compiled.tables.curves,
                          real().compiled.tables.curves)  # fmt: skip


@given(st.floats(0.2, 1), st.floats(4, 10))
def test_the_smooth_curve_reaches_a_strong_lone_target_at_the_phonemes_middle(weight, dominance):
    for made in (
        curve(REST, target(weight, dominance)),
        curve(target(weight, dominance), REST)[::-1],
    ):
        assert made[SECOND] >= 0.85 * weight
        assert made[HALF:].max() == pytest.approx(weight, rel=0.07)
        assert made[:FIRST].max() <= 0.15 * weight, "its neighbour is at rest"


@given(st.floats(0.1, 1))
def test_equal_targets_stay_level_from_middle_to_middle(weight):
    level = curve(target(weight), target(weight))[FIRST : SECOND + 1]
    assert level == pytest.approx(weight, rel=0.15)


def passage(made):
    """Return the time at which a rising curve is half way up."""
    return AT[np.argmax(made >= 0.5 * made.max())]


def test_the_more_a_target_insists_the_earlier_it_begins():
    strengths = [0.1, 0.3, 1, 2, 4, 6, 10]
    times = [passage(curve(REST, target(1, strength))) for strength in strengths]
    assert times == sorted(times, reverse=True)
    assert times[0] > times[2] > times[-1]
    assert times[2] == pytest.approx(0.5, abs=0.03)
    # and the mirror image: it lasts the longer
    ends = [1 - passage(curve(target(1, strength), REST)[::-1]) for strength in strengths]
    assert ends == sorted(ends)


def test_a_wish_spreads_into_a_phoneme_that_says_nothing_of_the_pose():
    silent, against = curve(PASSING, target(0.8)), curve(REST, target(0.8))
    assert passage(silent) < passage(against)


def test_a_phoneme_without_a_say_takes_its_neighbours_shape():
    breath = target(0.3, 1e-6)
    for weight in (0.0, 0.5, 0.8):
        made = curve(breath, target(weight))[FIRST : SECOND + 1]
        assert made == pytest.approx(
            curve(target(weight), target(weight))[FIRST : SECOND + 1], abs=0.02
        )


def written(folder, old, new):
    """Return the built-in pose set with one changed line, without its model."""
    source = Library([], project=None).poseset("facefx").path
    text = "\n".join(
        line for line in source.read_text("utf-8").splitlines() if not line.startswith("model:")
    )
    lines = [new if line.strip().startswith(old) else line for line in text.splitlines()]
    assert lines != text.splitlines()
    path = folder / "posesets" / "facefx" / "poseset.yaml"
    path.parent.mkdir(parents=True)
    path.write_text("\n".join(lines) + "\n", "utf-8")


def test_a_compiled_h_without_a_say_takes_its_neighbours_shape(tmp_path):
    written(tmp_path, "h:", "  h:   {open: 0.3, dominance: {open: 0.0}}")
    made = resolve("english", "facefx", paths=[tmp_path], cache=False).compiled
    numbers = {name: index for index, name in enumerate(made.phonemes)}
    jaw = made.poses.index("open")

    def at_the_middle_of_h(neighbour):
        row = made.tables.pairs[numbers["h"], numbers[neighbour]]
        return made.tables.curves[row, FIRST, jaw]

    wide, close = at_the_middle_of_h("aa"), at_the_middle_of_h("w")
    targets = Library(project=None).poseset("facefx").model.targets
    assert wide == pytest.approx(targets["aa"][0].weights["open"], abs=0.09)
    assert close == pytest.approx(targets["w"][0].weights["open"], abs=0.06)


def test_every_drafted_contact_reaches_its_floor_by_itself():
    compiled = real().compiled
    made = compiled.tables
    checked = 0
    for contact in made.contacts:
        for phoneme in np.flatnonzero(contact.phonemes):
            for other in range(len(compiled.phonemes)):
                first = made.curves[made.pairs[phoneme, other], : HALF + 1]
                second = made.curves[made.pairs[other, phoneme], HALF:]
                for pose in contact.raised:
                    floor = contact.floor[pose]
                    names = compiled.phonemes[phoneme], compiled.phonemes[other]
                    assert first[:, pose].max() >= floor, names
                    assert second[:, pose].max() >= floor, names
                    checked += 1
    assert checked == 2 * len(compiled.phonemes)
    assert real().report.warnings == ()


BANK = """\
kind: bank
format: 1
name: common
poseset: facefx
bigrams:
  # by hand, and meant so
  l-ow: {word: low, status: edited, curves: {open: [[0, 0], [0.5, 0.123], [1, 0]]}}
  aa-h: {status: approved, curves: {}}
"""


def test_what_a_bank_file_says_is_never_drafted_over(tmp_path):
    banks = tmp_path / "posesets" / "facefx" / "banks"
    banks.mkdir(parents=True)
    path = banks / "common.yaml"
    path.write_text(BANK, "utf-8")
    found = Library([tmp_path], project=None)
    compiled = resolve("english", "facefx", paths=[tmp_path], cache=False).compiled
    origins = {origin.pair: origin for origin in compiled.origins}
    assert (origins["l", "ow"].layer, origins["l", "ow"].status) == ("shared", "edited")
    assert (origins["aa", "h"].layer, origins["aa", "h"].status) == ("shared", "approved")
    assert origins["l", "aa"].layer == "draft"
    pairs, names = compiled.tables.pairs, compiled.phonemes
    still = compiled.tables.curves[pairs[names.index("aa"), names.index("h")]]
    assert not still.any()

    without = draft_bigrams(found, "english", "facefx")
    assert {"l-ow", "aa-h"}.isdisjoint(without.bigrams)
    assert len(without.bigrams) == 483 - 2

    some = draft_bigrams(found, "english", "facefx", ["l-ow", "l-aa", "aa-h"])
    said = write_drafts(found, some, path)
    assert said.startswith("1 drafted bigram put into")
    text = path.read_text("utf-8")
    assert text.startswith(BANK.rstrip("\n")), "every line that was there is as it was"
    assert "l-aa:" in text[len(BANK) - 1 :]
    again = write_drafts(found, draft_bigrams(found, "english", "facefx", ["l-ow", "l-aa"]), path)
    assert again.startswith("0 drafted bigrams put into")
    assert path.read_text("utf-8") == text


def test_a_bank_is_scanned_once_before_and_once_after_a_draft_is_written_into_it(
    tmp_path, monkeypatch
):
    path = tmp_path / "posesets" / "facefx" / "banks" / "common.yaml"
    path.parent.mkdir(parents=True)
    path.write_text(BANK, "utf-8")
    scanned = []

    def counted(path, content, decoded=building._text):  # noqa: SLF001 once in each scan
        scanned.append(path)
        return decoded(path, content)

    monkeypatch.setattr(building, "_text", counted)
    found = Library([tmp_path], project=None)
    write_drafts(found, draft_bigrams(found, "english", "facefx", ["l-aa"]), path)
    assert scanned.count(path) == 2


def test_a_draft_that_is_written_down_performs_as_the_draft_did(tmp_path):
    path = tmp_path / "posesets" / "facefx" / "banks" / "common.yaml"
    found = Library([], project=None)
    drafts = draft_bigrams(found, "english", "facefx", ["bmp-aa", "w-ih", "_-f"])
    write_drafts(found, drafts, path)
    compiled, drafted = (
        one.compiled
        for one in (resolve("english", "facefx", paths=[tmp_path], cache=False), real())
    )
    written = [origin.layer == "shared" for origin in compiled.origins]
    assert sum(written) == 3
    for name in ("bmp-aa", "w-ih", "_-f"):
        rows = [
            one.tables.pairs[tuple(map(one.phonemes.index, name.split("-")))]
            for one in (compiled, drafted)
        ]
        gap = compiled.tables.curves[rows[0]] - drafted.tables.curves[rows[1]]
        assert np.abs(gap).max() < 1e-6
    assert "bmp-aa:" in bigrams_yaml(drafts)


POSES = "poses: {jaw: {}, shut: {}, round: {}}\n"


def drafted(tmp_path, targets, *, constrained=True):
    """Draft over a small pose set, and return the smooth curves by bigram and pose."""
    pairs = "[{between: [jaw, shut], threshold: 0.5}]" if constrained else "[]"
    folder = tmp_path / str(constrained) / "posesets" / "small"
    folder.mkdir(parents=True)
    (folder / "poseset.yaml").write_text(
        f"kind: poseset\nformat: 1\nname: small\n{POSES}"
        f"constraints: {{pairs: {pairs}}}\npriority: [jaw, shut]\n"
        "targets:\n" + "".join(f"  {label}: {target}\n" for label, target in targets.items())
    )
    shelf = PairPacks.open(Library([folder.parents[1]], project=None), "english", "small")
    values = {}
    for pair, row in shelf.drafts([(a, b) for a in targets for b in targets]).items():
        for pose, points in row.curves.items():
            values[pair, shelf.poses[pose]] = bspline(points[None], AT)[0]
    return lambda a, b, pose: values.get(((a, b), pose), np.zeros(len(AT)))


def test_one_low_dominance_for_all_takes_the_neighbours_shape_but_not_its_closure(tmp_path):
    curve = drafted(
        tmp_path,
        {
            "h": "{jaw: 0.3, dominance: 0.001}",
            "w": "{jaw: 0.1, round: 0.8}",
            "bmp": "{shut: 1, dominance: 6}",
        },
    )
    assert curve("h", "w", "round")[FIRST] > 0.6
    assert curve("h", "w", "jaw")[FIRST] < 0.15
    assert curve("bmp", "h", "shut")[SECOND] < 0.15


def test_a_pose_against_a_named_one_does_not_spread_into_its_phoneme(tmp_path):
    targets = {"aa": "{jaw: 0.5}", "bmp": "{shut: 1}"}
    apart = drafted(tmp_path, targets)("aa", "bmp", "shut")
    freely = drafted(tmp_path, targets, constrained=False)("aa", "bmp", "shut")
    before = slice(FIRST, HALF)
    assert (apart[before] <= freely[before] + 1e-9).all()
    assert apart[HALF - 10] < freely[HALF - 10] - 0.2


def test_a_draft_starts_and_ends_at_rest():
    drafts = draft([target(1.0), target(0.2, 5.0)], [target(0.3), target(1.0, 0.01)])
    assert not drafts[..., 0].any()
    assert not drafts[..., -1].any()
    shelf = PairPacks.open(Library(project=None), "english", "facefx")
    for row in shelf.drafts(shelf.pairs()).values():
        for points in row.curves.values():
            assert points[0, 1] == points[-1, 1] == 0
