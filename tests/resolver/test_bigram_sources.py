"""Sources of the curves of a bigram: their pack, the layers below, and the targets."""

import json
import re
from dataclasses import replace
from importlib.util import find_spec
from io import BytesIO

import numpy as np
import pytest
from packs_tree import plant

from lipsync_lang.base.errors import LipsyncError, OutputError
from lipsync_lang.packs.library import Library
from lipsync_lang.resolver.bigram_sources import beneath, show_bigrams, stated, target_curves
from lipsync_lang.resolver.layers import PairPacks


@pytest.fixture
def shelf(tmp_path):
    plant(tmp_path)
    return PairPacks.open(Library([tmp_path], project=None), "parent", "anna")


def places(row):
    return row.origin.layer, row.place and row.place.file.name


def test_a_row_leads_to_its_key(shelf):
    own, bank = shelf.row(("f", "a")), shelf.row(("p", "yu"))
    assert places(own) == ("character", "anna.yaml")
    assert (stated(shelf, own), stated(shelf, bank)) == ("f-a", "p-yu")
    assert stated(shelf, shelf.row(("a", "p"))) is None, "a draft is stated nowhere"


def test_a_row_of_a_like_pair_leads_to_that_pair(shelf):
    row = shelf.row(("f", "yu"))
    assert row.origin.layer == "like"
    assert stated(shelf, row) == "f-a"


def test_a_row_leads_to_its_own_pair_where_lines_are_those_of_before(shelf):
    bank = next(file for file in shelf.drawn if file.path.name == "common.yaml")
    place = bank.rows["f", "a"].place
    stale = {("a", "a"): replace(bank.rows["p", "yu"], place=place)}
    moved = bank._replace(rows=stale | bank.rows)
    other = shelf.redrawn(tuple(moved if file is bank else file for file in shelf.drawn))
    assert stated(other, bank.rows["f", "a"]) == "f-a"


def test_beneath_a_row_lies_that_of_the_next_pack(shelf):
    own = shelf.row(("f", "a"))
    bank = beneath(shelf, own)
    assert places(bank) == ("shared", "common.yaml")
    assert bank.boundary == 0.4
    assert places(beneath(shelf, shelf.row(("a", "f")))) == ("draft", None)
    assert beneath(shelf, shelf.row(("a", "p"))) is None


def test_targets_stand_in_the_middle_of_their_phonemes(shelf):
    curves = {
        shelf.poses[pose]: points for pose, points in target_curves(shelf, ("a", "p"), 0.4).items()
    }
    assert set(curves) == {"open", "wide", "PBM"}
    np.testing.assert_allclose(curves["open"], [[0, 0], [0.1, 0.45], [0.3, 0.25], [0.7, 0], [1, 0]])
    np.testing.assert_allclose(curves["PBM"][:, 1], [0, 0, 0, 1, 0])


def test_without_targets_there_are_no_curves(shelf):
    poseset = shelf.poseset.model.model_copy(update={"targets": {}})
    object.__setattr__(shelf.poseset, "model", poseset)
    assert target_curves(shelf, ("a", "p"), 0.5) == {}


def shown(tmp_path, *wanted):
    plant(tmp_path)
    return show_bigrams(Library([tmp_path], project=None), "parent", "anna", wanted)


def test_a_shown_bigram_is_what_is_performed_whoever_drew_it(shelf, tmp_path):
    drawn, draft = shown(tmp_path, "a-f", "a-p")
    assert (drawn.origin.source, draft.origin.source) == ("character, edited", "draft, drafted")
    assert {pose: points.tolist() for pose, points in drawn.curves.items()} == {
        "FV": [[0, 0], [1, 1]]
    }
    row = shelf.row(("a", "p"))
    assert [*draft.curves] == [shelf.poses[pose] for pose in row.curves]
    assert all(map(np.array_equal, draft.curves.values(), row.curves.values()))


def test_a_shown_bigram_is_told_as_a_bank_has_it(tmp_path):
    drawn, waived = shown(tmp_path, "a-f", "p-yu")
    head, *rest = drawn.told().splitlines()
    assert head.startswith("# a-f: character, edited, ")
    assert "\n".join(rest) == ("a-f:\n  status: edited\n  curves:\n    FV: [[0, 0], [1, 1]]")
    assert "contact: free" in waived.told()
    assert json.loads(json.dumps(waived.to_dict()))["contact"] == "free"


def test_an_unknown_bigram_to_show_is_named(tmp_path):
    with pytest.raises(LipsyncError, match=r"unknown bigram 'a-x' in parent; did you mean 'a-"):
        shown(tmp_path, "a-x")


@pytest.mark.skipif(
    find_spec("matplotlib") is None, reason='needs matplotlib: pip install "lipsync-lang[plot]"'
)
def test_a_picture_has_each_moving_pose_of_a_bigram(tmp_path):
    from lipsync_lang.render.bigram_plot import MOST, plot_bigrams

    found, out = shown(tmp_path, "f-a", "a-p"), BytesIO()
    plot_bigrams(found, out, "svg")
    texts = re.findall(r"<text[^>]*>([^<]*)</text>", out.getvalue().decode())
    assert {"f-a", "a-p", "f", "a", "p", *found[0].curves, *found[1].curves} <= {*texts}
    with pytest.raises(OutputError, match=f"room for {MOST} bigrams, not {MOST + 1}"):
        plot_bigrams(found[:1] * (MOST + 1), BytesIO())
