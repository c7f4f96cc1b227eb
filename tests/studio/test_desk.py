"""Unsaved edits of packs: undo, journal, merging and saving."""

from pathlib import Path

import pytest
from desk_texts import BOUNDARY, STATUS, THEIRS, content, value
from hypothesis import given
from hypothesis import strategies as st
from packs_tree import BANK

from lipsync_lang.base.errors import LipsyncError, OutputError
from lipsync_lang.packs.splicing import ABSENT, SplicedText, plain
from lipsync_lang.packs.yaml.building import read_yaml
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.studio.desk import Desk
from lipsync_lang.studio.merging import EditConflict, SaveConflict, differences


def test_an_edit_stays_on_the_desk_until_it_is_saved(bank):
    desk = Desk(None)
    assert (content(desk, bank), dict(desk.contents)) == (None, {})
    desk.change("Status", [(bank, STATUS, "edited")])
    assert bank.read_text() == BANK
    assert desk.contents == {bank: BANK.replace("status: approved", "status: edited").encode()}
    assert desk.unsaved() == [(bank, ("bigrams", "p-yu"), "changed")]
    assert desk.save() == [bank]
    assert bank.read_text() == BANK.replace("status: approved", "status: edited")
    assert (dict(desk.contents), desk.unsaved()) == ({}, [])


def test_undo_and_redo_reach_back_over_saving(bank):
    desk = Desk(None)
    desk.change("One", [(bank, BOUNDARY, 0.3)])
    desk.change("Two", [(bank, BOUNDARY, 0.6), (bank, STATUS, "edited")])
    desk.save()
    assert (desk.undo_title, desk.redo_title) == ("Two", None)
    assert desk.undo() == "Two"
    assert value(desk, bank, BOUNDARY) == 0.3
    assert desk.undo() == "One"
    assert content(desk, bank) == BANK.encode()
    assert desk.undo_title is None
    with pytest.raises(LipsyncError, match="nothing to undo"):
        desk.undo()
    assert (desk.redo(), desk.redo()) == ("One", "Two")
    assert desk.contents == {}
    with pytest.raises(LipsyncError, match="nothing to redo"):
        desk.redo()


def test_a_drag_is_one_step(bank):
    desk = Desk(None)
    desk.change("Before", [(bank, STATUS, "edited")])
    for number in range(1, 9):
        desk.change("Drag", [(bank, BOUNDARY, number / 10)], merge="drag 1")
    desk.change("Drag", [(bank, BOUNDARY, 0.9)], merge="drag 2")
    revision = desk.revision
    assert [desk.undo(), value(desk, bank, BOUNDARY)] == ["Drag", 0.8]
    assert [desk.undo(), value(desk, bank, BOUNDARY)] == ["Drag", 0.4]
    assert [desk.undo(), desk.contents] == ["Before", {}]
    assert desk.revision == revision + 3


def test_a_new_edit_forgets_what_was_undone(bank):
    desk = Desk(None)
    desk.change("Drag", [(bank, BOUNDARY, 0.3)], merge="drag")
    desk.undo()
    desk.change("Drag", [(bank, BOUNDARY, 0.7)], merge="drag")
    assert (desk.undo_title, desk.redo_title) == ("Drag", None)


def test_all_edits_of_a_change_are_made_or_none(bank, home):
    desk = Desk(None)
    other = home / "posesets/face/poseset.yaml"
    with pytest.raises(PackFaults, match=r"common\.yaml:7:19: P104"):
        desk.change("Bad", [(other, ("title",), "New"), (bank, BOUNDARY, 3)])
    assert (desk.contents, desk.undo_title, desk.revision) == ({}, None, 0)
    desk.change("Nothing", [(bank, STATUS, "approved")])
    assert (desk.undo_title, desk.revision) == (None, 0)


def test_two_tabs_do_not_overwrite_each_other(bank):
    desk = Desk(None)
    desk.change("Mine", [(bank, STATUS, "edited")], seen=0, tab="a")
    desk.change("Yours", [(bank, BOUNDARY, 0.3)], seen=0, tab="b")
    with pytest.raises(EditConflict, match=r"p-yu.*common\.yaml"):
        desk.change("Yours", [(bank, ("bigrams", "p-yu"), ABSENT)], seen=0, tab="b")
    desk.change("Mine", [(bank, STATUS, "drafted")], seen=1, tab="a")
    with pytest.raises(EditConflict):
        desk.change("Mine", [(bank, BOUNDARY, 0.7)], seen=1, tab="a")
    desk.undo(tab="a")
    with pytest.raises(EditConflict):
        desk.change("Yours", [(bank, STATUS, "edited")], seen=2, tab="b")
    desk.change("Yours", [(bank, STATUS, "drafted")], seen=desk.revision, tab="b")


def test_a_file_is_made_from_its_text(home):
    desk = Desk(None)
    new = home / "posesets/other/banks/mine.yaml"
    text = "# Mine.\nkind: bank\nformat: 1\nname: mine\nposeset: face\nbigrams: {}\n"
    with pytest.raises(LipsyncError, match="no such file"):
        desk.change("Add", [(new, ("style",), "sad")])
    with pytest.raises(PackFaults, match="P102"):
        desk.change("Add", [(new, (), text.replace("poseset: face\n", ""))])
    desk.change("Add", [(new, (), text), (new, ("style",), "sad")])
    assert desk.unsaved()[-1] == (new, ("style",), "added")
    desk.undo()
    assert (content(desk, new), desk.contents, desk.save()) == (None, {}, [])
    desk.redo()
    assert desk.save() == [new]
    assert new.read_text() == text + "style: sad\n"
    desk.undo()
    assert (desk.unsaved()[0], desk.save()) == ((new, ("kind",), "deleted"), [new])
    assert not new.exists()
    desk.redo()
    assert desk.save() == [new]
    desk.undo()
    new.write_text(f"{text}style: angry\n")
    with pytest.raises(SaveConflict, match="the whole file"):
        desk.save()
    assert desk.save({(new, ()): "theirs"}) == []
    assert new.read_text() == f"{text}style: angry\n"


# Saving over what changed meanwhile


def test_other_bigrams_of_the_disk_are_kept(bank):
    desk = Desk(None)
    desk.change("One", [(bank, STATUS, "edited")])
    desk.change("Two", [(bank, ("bigrams", "p-p"), {"curves": {"PBM": [[0, 1], [1, 1]]}})])
    bank.write_text(THEIRS)
    assert desk.save() == [bank]
    saved = bank.read_text()
    assert "status: edited" in saved
    assert set(THEIRS.splitlines()) - set(saved.splitlines()) == {"    status: approved"}
    assert read_yaml(bank).data["bigrams"]["p-p"] == {"curves": {"PBM": ((0, 1), (1, 1))}}
    desk.undo()
    desk.undo()
    assert content(desk, bank).decode() == THEIRS
    desk.redo()
    desk.redo()
    assert (desk.contents, bank.read_text()) == ({}, saved)


def test_a_bigram_that_both_changed_is_asked_about(bank):
    desk = Desk(None)
    desk.change("One", [(bank, STATUS, "edited"), (bank, BOUNDARY, 0.6)])
    bank.write_text(THEIRS)
    with pytest.raises(SaveConflict, match=r"common\.yaml: f-a\n") as raised:
        desk.save()
    assert bank.read_text() == THEIRS
    (conflict,) = raised.value.conflicts
    assert (conflict.path, conflict.loc) == (bank, ("bigrams", "f-a"))
    assert [state["boundary"] for state in (conflict.mine, conflict.theirs)] == [0.6, 0.45]
    desk.save(keep={(bank, conflict.loc): "mine"})
    assert "boundary: 0.6" in bank.read_text()
    assert "a-a" in bank.read_text()
    assert "status: edited" in bank.read_text()


def test_theirs_is_kept_where_it_is_chosen(bank):
    desk = Desk(None)
    desk.change("One", [(bank, STATUS, "edited"), (bank, BOUNDARY, 0.6)])
    bank.write_text(THEIRS)
    desk.save(keep={(bank, ("bigrams", "f-a")): "theirs"})
    assert bank.read_text() == THEIRS.replace("approved", "edited")
    desk.undo()
    assert content(desk, bank).decode() == THEIRS


def test_the_same_change_on_both_sides_is_no_conflict(bank):
    desk = Desk(None)
    desk.change("One", [(bank, BOUNDARY, 0.45)])
    bank.write_text(THEIRS)
    desk.save()
    assert bank.read_text() == THEIRS


def test_a_deleted_file_is_asked_about(bank):
    desk = Desk(None)
    desk.change("One", [(bank, BOUNDARY, 0.6)])
    text = content(desk, bank)
    bank.unlink()
    with pytest.raises(SaveConflict, match="the whole file") as raised:
        desk.save()
    assert raised.value.conflicts[0].theirs is ABSENT
    assert not bank.exists()
    desk.save(keep={(bank, ()): "mine"})
    assert bank.read_bytes() == text
    desk.change("Two", [(bank, BOUNDARY, 0.7)])
    bank.unlink()
    assert desk.save(keep={(bank, ()): "theirs"}) == []
    assert (desk.contents, bank.exists()) == ({}, False)


def test_a_file_that_became_faulty_is_named_with_its_place(bank):
    desk = Desk(None)
    desk.change("One", [(bank, BOUNDARY, 0.6)])
    text = content(desk, bank)
    bank.write_text(BANK + "\tbad: [")
    with pytest.raises(PackFaults, match=r"common\.yaml:12:1: P007"):
        desk.save()
    bank.write_text(BANK.replace("curves: {}", "curves: {} \n    curvs: {}"))
    with pytest.raises(PackFaults, match=r"common\.yaml:12:5: P101.*curvs"):
        desk.save()
    desk.save(keep={(bank, ()): "mine"})
    assert bank.read_bytes() == text


def test_a_file_changed_on_the_disk_is_read_again_once_nothing_is_unsaved(bank):
    desk = Desk(None)
    desk.change("One", [(bank, STATUS, "edited")])
    desk.save()
    bank.write_text(THEIRS.replace("approved", "edited"))
    desk.change("Two", [(bank, ("bigrams", "a-a", "boundary"), 0.3)])
    assert desk.undo() == "Two"
    assert desk.contents == {}
    assert desk.undo() == "One"
    assert content(desk, bank).decode() == THEIRS


def test_no_file_is_written_unless_all_are(bank, home):
    other = home / "posesets/face/poseset.yaml"
    desk = Desk(None)
    desk.change("One", [(bank, BOUNDARY, 0.6), (other, ("title",), "New")])
    before = other.read_bytes()
    bank.chmod(0o444)
    with pytest.raises(OutputError, match="read-only"):
        desk.save()
    assert other.read_bytes() == before
    bank.chmod(0o644)
    assert {*desk.save()} == {bank, other}


def test_files_that_are_not_the_projects_are_refused(bank, home, tmp_path):
    desk = Desk(None, shipped=[home / "posesets"])
    with pytest.raises(OutputError, match=r"installed.* face/banks/common\.yaml"):
        desk.change("One", [(bank, BOUNDARY, 0.6)])
    desk = Desk(None)
    with pytest.raises(OutputError, match="file of a pack"):
        desk.change("One", [(tmp_path / "passwd", BOUNDARY, 0.6)])
    with pytest.raises(OutputError, match="file of a pack"):
        desk.change("One", [(Path("common.yaml"), BOUNDARY, 0.6)])
    bank.chmod(0o444)
    with pytest.raises(OutputError, match="read-only"):
        desk.change("One", [(bank, BOUNDARY, 0.6)])


def test_a_link_is_edited_by_one_name_and_stays_a_link(bank):
    link = bank.with_name("link.yaml")
    real = bank.rename(bank.with_name("real"))
    bank.symlink_to(real)
    link.symlink_to(bank)
    desk = Desk(None)
    desk.change("One", [(bank, BOUNDARY, 0.6)])
    with pytest.raises(OutputError, match=r"link\.yaml.* same file.*common\.yaml"):
        desk.change("Two", [(link, STATUS, "edited")])
    desk.save()
    assert bank.is_symlink()
    assert "boundary: 0.6" in real.read_text()
    circle = bank.with_name("circle.yaml")
    circle.symlink_to(circle)
    with pytest.raises(LipsyncError, match="circle"):
        desk.change("Three", [(circle, STATUS, "edited")])


def test_differences_are_those_of_entries():
    base = {"a": 1, "b": {"x": 1, "y": {"z": 1}}, "c": None}
    assert differences(base, base) == []
    after = {"b": {"x": 1, "y": {"z": 2}, "w": 0}, "c": {"k": 1}, "d": ()}
    assert differences(base, after) == [
        (("a",), ABSENT), (("b", "y"), {"z": 2}), (("b", "w"), 0), (("c", "k"), 1), (("d",), ()),
    ]  # fmt: skip


# Any sequence

ENTRY = {"status": "drafted", "curves": {"FV": [[0, 0], [1, 1]]}}
EDITS = st.lists(
    st.one_of(
        st.tuples(st.just(BOUNDARY), st.sampled_from([0.2, 0.5, 0.8])),
        st.tuples(st.just(STATUS), st.sampled_from(["edited", "drafted"])),
        st.tuples(
            st.tuples(st.just("bigrams"), st.sampled_from(["f-a", "p-yu", "a-a"])),
            st.sampled_from([ABSENT, ENTRY]),
        ),
        st.sampled_from(["undo", "redo", "save"]),
    ),
    max_size=12,
)


@given(EDITS, st.booleans())
def test_undo_of_everything_gives_the_bytes_and_redo_gives_them_back(tmp_path, edits, kill):
    bank, journal = tmp_path / "common.yaml", tmp_path / "journal"
    bank.write_text(BANK)
    journal.unlink(missing_ok=True)
    desk = Desk(journal)
    states = [BANK.encode()]
    for edit in edits:
        if edit == "save":
            desk.save()
        elif isinstance(edit, str):
            if getattr(desk, f"{edit}_title") is not None:
                getattr(desk, edit)()
        else:
            try:
                desk.change("Any", [(bank, *edit)])
            except PackFaults:
                continue  # a field of a bigram that was deleted
        states.append(content(desk, bank) or BANK.encode())
    if kill and "save" not in edits:
        desk = Desk(journal)
        assert (content(desk, bank) or BANK.encode()) == states[-1]
    while desk.redo_title is not None:
        desk.redo()
    last = content(desk, bank) or BANK.encode()
    while desk.undo_title is not None:
        desk.undo()
    assert (content(desk, bank) or BANK.encode()) == BANK.encode()
    while desk.redo_title is not None:
        desk.redo()
    assert (content(desk, bank) or BANK.encode()) == last


KEYS = ["f-a", "p-yu", "a-a", "p-p", "f-f"]
STATES = st.dictionaries(
    st.sampled_from(KEYS), st.sampled_from([ABSENT, ENTRY, {**ENTRY, "boundary": 0.3}])
)


@given(STATES, STATES, st.sampled_from(["mine", "theirs"]))
def test_saving_merges_entry_by_entry(tmp_path, mine, theirs, side):
    bank = tmp_path / "common.yaml"
    bank.write_text(BANK)
    base = read_yaml(bank).data["bigrams"]
    desk = Desk(None)
    for key, entry in mine.items():
        desk.change("Mine", [(bank, ("bigrams", key), entry)])
    edited = desk.undo_title is not None
    other = SplicedText.read(bank, BANK.encode())
    other = other.changed([(("bigrams", key), entry) for key, entry in theirs.items()])
    bank.write_bytes(other.content + b"# theirs\n")
    keep = {}
    try:
        desk.save()
    except SaveConflict as error:
        keep = {(one.path, one.loc): side for one in error.conflicts}
        assert bank.read_bytes() == other.content + b"# theirs\n"
        desk.save(keep=keep)
    states = {key: {**dict.fromkeys(KEYS, ABSENT), **base} for key in ("mine", "theirs")}
    states["mine"] |= {key: plain(entry) for key, entry in mine.items()}
    states["theirs"] |= {key: plain(entry) for key, entry in theirs.items()}
    expected = {}
    for key in KEYS:
        old, one, two = base.get(key, ABSENT), states["mine"][key], states["theirs"][key]
        assert ((bank, ("bigrams", key)) in keep) == (old not in (one, two) and one != two)
        chosen = two if one == old or (side == "theirs" and two != old) else one
        if chosen is not ABSENT:
            expected[key] = chosen
    assert (read_yaml(bank).data["bigrams"] or {}) == expected
    assert bank.read_text().endswith("# theirs\n") or not mine
    assert (desk.contents, desk.unsaved()) == ({}, [])
    while desk.undo_title is not None:
        desk.undo()
    kept = {key: states["theirs"][key] for key in KEYS if states["theirs"][key] is not ABSENT}
    if edited and not keep:
        assert read_yaml(bank, content(desk, bank)).data["bigrams"] == kept
