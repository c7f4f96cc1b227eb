"""The edited pair of the studio equals the files compiled again, after any edit."""

import os

import numpy as np
import pytest
from packs_tree import plant, put

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.splicing import ABSENT
from lipsync_lang.resolver.compile import compile_pair
from lipsync_lang.resolver.retouch import OpenPair
from lipsync_lang.studio.workshop import Workshop

BANK = "posesets/face/banks/common.yaml"
POSESET = "posesets/face/poseset.yaml"
OPEN = [[0, 0], [0.5, 0.9], [1, 0]]


@pytest.fixture
def workshop(tmp_path):
    made = Workshop(plant(tmp_path / "project"), engine="none")
    made.open("parent", "anna")
    made.pair()
    return made


def edit(workshop, file, at, value=ABSENT, **more):
    workshop.edit("Draw", [(workshop.project / file, tuple(at), value)], **more)


def compiled_anew(workshop):
    library = Library([], workshop.project, unsaved=workshop.desk.contents)
    return compile_pair(library, "parent", "anna")


def assert_current(workshop):
    """Compare the performed curves with those of the same packs compiled again."""
    mine, fresh = workshop.performer.compiled, compiled_anew(workshop)
    np.testing.assert_array_equal(mine.tables.curves, fresh.tables.curves)
    np.testing.assert_array_equal(mine.tables.pairs, fresh.tables.pairs)
    np.testing.assert_array_equal(mine.tables.boundary, fresh.tables.boundary)
    assert mine.measures == fresh.measures
    assert [one[:3] for one in mine.origins] == [one[:3] for one in fresh.origins]


@pytest.fixture
def opened(monkeypatch):
    """Count how often a pair is compiled as a whole."""
    times, real = [], OpenPair.open

    def counted(*args):
        times.append(args)
        return real(*args)

    monkeypatch.setattr(OpenPair, "open", counted)
    return times


def test_edits_of_bigrams_compile_nothing_anew(workshop, opened):
    before = workshop.performer.compiled.tables.curves
    for value in (0.2, 0.4):
        edit(workshop, BANK, ["bigrams", "a-p"], {"curves": {"open": [[0, value], [1, 1]]}})
        assert_current(workshop)
    edit(workshop, "characters/anna.yaml", ["bigrams", "f-a", "curves", "open"], OPEN)
    assert_current(workshop)
    for _ in range(3):
        workshop.desk.undo()
        assert_current(workshop)
    np.testing.assert_array_equal(workshop.performer.compiled.tables.curves, before)
    workshop.desk.redo()
    assert_current(workshop)
    workshop.desk.save()
    edit(workshop, BANK, ["bigrams", "a-p", "boundary"], 0.3)
    assert_current(workshop)
    assert opened == []


def test_other_edits_compile_the_pair_anew(workshop, opened):
    edit(workshop, POSESET, ["measures", "aperture", "open"], 2)
    assert workshop.performer.compiled.measures == {"aperture": {"open": 2, "PBM": -1}}
    assert len(opened) == 1
    edit(workshop, BANK, ["bigrams", "a-p"], {"curves": {"open": OPEN}})
    assert_current(workshop)
    assert len(opened) == 1
    workshop.desk.undo()
    workshop.desk.undo()
    assert_current(workshop)
    assert len(opened) == 2


def test_a_bank_that_comes_and_goes_is_compiled(workshop, opened):
    new = workshop.project / "posesets/face/banks/new.yaml"
    text = "kind: bank\nformat: 1\nname: new\nposeset: face\nbigrams: {}\n"
    edits = [(new, (), text), (new, ("bigrams", "a-p"), {"curves": {"open": OPEN}})]
    workshop.edit("Draw", edits)
    assert_current(workshop)
    assert workshop.performer.compiled.report.layers["shared"] == {"edited": 1, "approved": 1}
    workshop.desk.undo()
    assert_current(workshop)
    assert len(opened) == 2


def test_a_bank_that_was_saved_and_is_undone_is_not_performed(workshop):
    new = workshop.project / "posesets/face/banks/new.yaml"
    text = "kind: bank\nformat: 1\nname: new\nposeset: face\nbigrams: {}\n"
    before = workshop.performer.compiled.tables.curves
    workshop.edit("Draw", [(new, (), text), (new, ("bigrams", "a-p"), {"curves": {"open": OPEN}})])
    workshop.save()
    assert not np.array_equal(workshop.performer.compiled.tables.curves, before)
    workshop.desk.undo()
    np.testing.assert_array_equal(workshop.performer.compiled.tables.curves, before)
    assert_current(workshop)
    assert workshop.save() == [new]
    np.testing.assert_array_equal(compiled_anew(workshop).tables.curves, before)


def test_a_file_that_changes_on_the_disk_is_read_with_the_next_edit(workshop):
    path = workshop.project / POSESET
    put(
        workshop.project,
        POSESET,
        path.read_text().replace("aperture: {open: 1", "aperture: {open: 3"),
    )
    os.utime(path, ns=(1, 1))
    edit(workshop, BANK, ["bigrams", "a-p"], {"curves": {"open": OPEN}})
    assert workshop.performer.compiled.measures["aperture"]["open"] == 3
    assert_current(workshop)


@pytest.mark.parametrize("pose", ["nothing", "open"])
def test_an_edit_that_cannot_be_performed_changes_nothing(workshop, pose):
    before = workshop.performer.compiled
    with pytest.raises(LipsyncError, match=r"unknown (pose|phoneme)"):
        edit(
            workshop,
            BANK,
            ["bigrams", "a-p" if pose == "nothing" else "x-p"],
            {"curves": {pose: OPEN}},
        )
    assert workshop.performer.compiled is before
    assert workshop.desk.contents == {}
