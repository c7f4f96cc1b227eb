"""Sources of the curves of a bigram: their pack, the layers below, and the targets."""

from dataclasses import replace

import numpy as np
import pytest
from packs_tree import plant

from lipsync_lang.packs.library import Library
from lipsync_lang.resolver.bigram_sources import beneath, stated, target_curves
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
