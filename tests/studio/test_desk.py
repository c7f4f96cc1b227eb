"""Unsaved edits of packs: undo, journal, merging and saving."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from packs_tree import BANK, plant

from lipsync_lang.errors import LipsyncError, OutputError
from lipsync_lang.packs.splicing import ABSENT, SplicedText, plain
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.packs.yaml.source import read_yaml
from lipsync_lang.studio import edit_journal
from lipsync_lang.studio.desk import Desk
from lipsync_lang.studio.merging import EditConflict, SaveConflict, differences

STATUS = ("bigrams", "p-yu", "status")
BOUNDARY = ("bigrams", "f-a", "boundary")


@pytest.fixture
def home(tmp_path):
    return plant(tmp_path / "project")


@pytest.fixture
def bank(home):
    return home / "posesets/face/banks/common.yaml"


@pytest.fixture
def journal(tmp_path):
    return tmp_path / "state/journal"


def value(desk, path, loc):
    data = read_yaml(path, desk.content(path)).data
    for step in loc:
        data = data[step]
    return data


def test_an_edit_stays_on_the_desk_until_it_is_saved(bank):
    desk = Desk(None)
    assert (desk.content(bank), dict(desk.contents)) == (None, {})
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
    assert desk.content(bank) == BANK.encode()
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
        desk.change("Add", [], create={new: text.replace("poseset: face\n", "")})
    desk.change("Add", [(new, ("style",), "sad")], create={new: text})
    assert desk.unsaved()[-1] == (new, ("style",), "added")
    desk.undo()
    assert (desk.content(new), desk.contents, desk.save()) == (None, {}, [])
    desk.redo()
    assert desk.save() == [new]
    assert new.read_text() == text + "style: sad\n"


# The journal


def test_a_killed_desk_is_found_again(bank, home, journal):
    other = home / "posesets/face/poseset.yaml"
    made = home / "posesets/face/banks/new.yaml"
    desk = Desk(journal)
    assert (desk.restored, desk.notes) == (0, [])
    desk.change("One", [(bank, BOUNDARY, 0.3)])
    desk.change("Two", [(bank, ("bigrams", "p-yu"), ABSENT), (other, ("title",), "New")])
    desk.change("Three", [], create={made: BANK.replace("name: common", "name: new")})
    desk.change("Four", [(bank, BOUNDARY, 0.7)])
    desk.undo()
    again = Desk(journal)
    assert (again.restored, again.notes) == (3, [])
    assert again.contents == desk.contents
    assert again.redo() == "Four"
    third = Desk(journal)
    assert value(third, bank, BOUNDARY) == 0.7
    assert [third.undo() for _ in range(4)] == ["Four", "Three", "Two", "One"]
    assert third.contents == {}
    third.redo()
    third.save()
    assert (Desk(journal).restored, len(journal.read_text().splitlines())) == (0, 1)


def test_a_torn_line_is_the_only_loss(bank, journal):
    desk = Desk(journal)
    desk.change("One", [(bank, BOUNDARY, 0.3)])
    desk.change("Two", [(bank, BOUNDARY, 0.7)])
    journal.write_bytes(journal.read_bytes()[:-9])
    again = Desk(journal)
    assert (again.restored, again.notes) == (1, [])
    assert value(again, bank, BOUNDARY) == 0.3
    again.change("Two", [(bank, BOUNDARY, 0.8)])
    assert value(Desk(journal), bank, BOUNDARY) == 0.8


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"a diary\n", "is damaged"),
        (b'{"some": "json"}\n', "is not a journal"),
        (b"\xff\xfe\n", "is damaged"),
        (b"[" * 100_000 + b"\n", "is damaged"),
        ("edited", "is damaged"),
        ("unknown", "newer version"),
        ("unopened", "precedes the text of its file"),
        ("faulty", "P104"),
    ],
)
def test_a_damaged_journal_is_put_aside(content, why, bank, journal):
    desk = Desk(journal)
    desk.change("One", [(bank, BOUNDARY, 0.3)])
    lines = journal.read_text().splitlines()
    broken = {
        "edited": [*lines[:-1], lines[-1][:-3], lines[-1]],
        "unknown": [*lines, '{"run": "rm"}'],
        "unopened": [lines[0], *lines[2:]],
        "faulty": [*lines[:-1], lines[-1].replace("0.3", "3")],
    }
    if isinstance(content, str):
        content = "".join(f"{line}\n" for line in broken[content]).encode()
    journal.write_bytes(content)
    again = Desk(journal)
    assert (again.restored, again.contents, again.undo_title) == (0, {}, None)
    assert why in again.notes[0]
    aside = journal.with_name("journal.damaged")
    assert str(aside) in again.notes[0]
    assert aside.read_bytes() == content
    again.change("One", [(bank, BOUNDARY, 0.6)])
    assert Desk(journal).restored == 1


def test_a_long_journal_is_written_anew(bank, journal, monkeypatch):
    monkeypatch.setattr(edit_journal, "MAX_JOURNAL_LINES", 5)
    desk = Desk(journal)
    for number in range(1, 20):
        desk.change(f"Step {number}", [(bank, BOUNDARY, number / 20)])
        assert value(Desk(journal), bank, BOUNDARY) == number / 20
    assert len(journal.read_text().splitlines()) < 8
    for number in range(18, 0, -1):
        desk.undo()
        assert value(Desk(journal), bank, BOUNDARY) == number / 20
    desk.redo()
    assert value(Desk(journal), bank, BOUNDARY) == 2 / 20


def test_a_drag_is_one_line_of_the_journal(bank, journal):
    desk = Desk(journal)
    desk.change("Status", [(bank, STATUS, "edited")], merge="drag")
    for number in range(1, 9):
        desk.change("Drag", [(bank, BOUNDARY, number / 10)], merge="drag")
        assert value(Desk(journal), bank, BOUNDARY) == number / 10
    desk.change("Drag", [(bank, BOUNDARY, 0.3), (bank, STATUS, "drafted")], merge="drag")
    assert len(journal.read_text().splitlines()) == 5
    again = Desk(journal)
    assert again.contents == desk.contents
    assert (again.undo_title, again.undo(), again.contents) == ("Status", "Status", {})


def test_a_drag_goes_on_in_a_journal_written_anew(bank, journal, monkeypatch):
    monkeypatch.setattr(edit_journal, "MAX_JOURNAL_LINES", 2)
    desk = Desk(journal)
    for number in range(1, 9):
        loc = BOUNDARY if number % 2 else ("bigrams", "p-yu", "boundary")
        desk.change("Drag", [(bank, loc, number / 10)], merge="drag")
        assert Desk(journal).contents == desk.contents
    while desk.undo_title:
        desk.undo()
        assert Desk(journal).contents == desk.contents


HOLD = """
import fcntl, sys
held = open(sys.argv[1], "ab")
fcntl.lockf(held, fcntl.LOCK_EX)
print("held", flush=True)
sys.stdin.read()
"""


def test_two_studios_do_not_share_a_journal(bank, journal):
    pytest.importorskip("fcntl", reason="Windows has no such locks")
    Desk(journal).change("Mine", [(bank, BOUNDARY, 0.6)])
    kept = journal.read_bytes()
    lock = journal.with_name("journal.lock")
    other = subprocess.Popen(
        [sys.executable, "-c", HOLD, lock], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    with other:
        assert other.stdout.readline() == b"held\n"
        desk = Desk(journal)
        assert desk.restored == 0
        assert "another studio of this project is running" in desk.notes[0]
        desk.change("Yours", [(bank, BOUNDARY, 0.7)])
        assert journal.read_bytes() == kept
        other.kill()
    assert Desk(journal).restored == 1


def test_a_journal_is_json(bank, journal):
    Desk(journal).change("One", [(bank, BOUNDARY, 0.3)], tab="a")
    lines = [json.loads(line) for line in journal.read_text().splitlines()]
    assert lines[1] == {"base": str(bank), "text": BANK}
    assert lines[2]["edits"] == [{"file": str(bank), "at": list(BOUNDARY), "value": 0.3}]


# A studio that is killed while it saves

STEPS = {"open", "os.rename", "os.remove", "os.mkdir"}


def save_until(journal, edits, step):
    """Edit and save in a child, which kills itself before its nth step; return True if it did."""
    child = os.fork()
    if not child:
        count = 0

        def stop(event, _arguments):
            nonlocal count
            count += saving and event in STEPS
            if event in STEPS and count > step:
                os.kill(os.getpid(), signal.SIGKILL)

        saving = False
        sys.addaudithook(stop)
        desk = Desk(journal)
        desk.change("Both", edits)
        saving, count = True, 0
        desk.save()
        os._exit(0)
    return os.waitpid(child, 0)[1] == signal.SIGKILL


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes to kill")
def test_a_save_that_is_killed_at_any_step_is_whole_after_the_next_start(tmp_path):
    left = {"old": 0, "new": 0}
    for step in range(1000):
        home = plant(tmp_path / f"{step}/project")
        bank, other = home / "posesets/face/banks/common.yaml", home / "posesets/face/poseset.yaml"
        journal = tmp_path / f"{step}/state/journal"
        before = bank.read_bytes(), other.read_bytes()
        edits = [(bank, BOUNDARY, 0.6), (other, ("title",), "New")]
        killed = save_until(journal, edits, step)
        desk = Desk(journal)
        after = bank.read_bytes(), other.read_bytes()
        saved = [now != was for now, was in zip(after, before, strict=True)]
        assert saved in ([True, True], [False, False]), f"half a save after {step} steps"
        assert bool(desk.contents) == (not all(saved)), "neither lost nor unsaved twice"
        assert bool(desk.restored) == bool(desk.contents)
        left["new" if all(saved) else "old"] += 1
        desk.change("On", [(bank, BOUNDARY, 0.2), (other, ("title",), "Newer")])
        desk.save()  # no conflict with what the killed studio saved
        assert b"boundary: 0.2" in bank.read_bytes()
        assert b"Newer" in other.read_bytes()
        hidden = [path.name for path in (tmp_path / str(step)).rglob(".*")]
        assert hidden == [], f"left after {step} steps"
        if not killed:
            break
    assert min(left.values()) > 1


@pytest.mark.parametrize("changed", ["disk", "unwritable"])
def test_a_save_that_was_cut_off_overwrites_no_later_change(bank, home, journal, changed):
    other = home / "posesets/face/poseset.yaml"
    desk = Desk(journal)
    desk.change("Both", [(bank, BOUNDARY, 0.6), (other, ("title",), "New")])

    def killed(source, target):
        source.replace(target) if target == journal else 1 / 0

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr("lipsync_lang.files.writing.replace_file", killed)
        with pytest.raises(ZeroDivisionError):
            desk.save()
    del desk
    if changed == "disk":
        bank.write_text(THEIRS)
    else:
        bank.chmod(0o444)
    again = Desk(journal)
    if changed == "disk":
        assert bank.read_text() == THEIRS
        assert b"New" in other.read_bytes()
        assert list(again.contents) == [bank]
    else:
        assert "cannot be completed" in again.notes[0]
        bank.chmod(0o644)
        assert {*again.save()} == {bank, other}


def test_a_save_that_fails_stays_unsaved(bank, home, journal, monkeypatch):
    other = home / "posesets/face/poseset.yaml"
    desk = Desk(journal)
    desk.change("Both", [(bank, BOUNDARY, 0.6), (other, ("title",), "New")])

    def refused(source, target):
        if target == other:
            raise PermissionError(13, "held open")
        source.replace(target)

    monkeypatch.setattr("lipsync_lang.files.writing.replace_file", refused)
    with pytest.raises(OutputError, match="held open"):
        desk.save()
    assert list(desk.contents) == [other], "what reached the disk is saved"
    monkeypatch.undo()
    del desk
    again = Desk(journal)
    assert list(again.contents) == [other]
    assert again.save() == [other]


# Saving over what changed meanwhile

THEIRS = BANK.replace("boundary: 0.4", "boundary: 0.45") + "  a-a: {curves: {}}  # new\n"


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
    assert desk.content(bank).decode() == THEIRS
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
    states = conflict.base, conflict.mine, conflict.theirs
    assert [state["boundary"] for state in states] == [0.4, 0.6, 0.45]
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
    assert desk.content(bank).decode() == THEIRS


def test_the_same_change_on_both_sides_is_no_conflict(bank):
    desk = Desk(None)
    desk.change("One", [(bank, BOUNDARY, 0.45)])
    bank.write_text(THEIRS)
    desk.save()
    assert bank.read_text() == THEIRS


def test_a_deleted_file_is_asked_about(bank):
    desk = Desk(None)
    desk.change("One", [(bank, BOUNDARY, 0.6)])
    text = desk.content(bank)
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
    text = desk.content(bank)
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
    assert desk.content(bank).decode() == THEIRS


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
    assert desk.save([other]) == [other]
    assert list(desk.contents) == [bank]


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
        states.append(desk.content(bank) or BANK.encode())
    if kill and "save" not in edits:
        desk = Desk(journal)
        assert (desk.content(bank) or BANK.encode()) == states[-1]
    while desk.redo_title is not None:
        desk.redo()
    last = desk.content(bank) or BANK.encode()
    while desk.undo_title is not None:
        desk.undo()
    assert (desk.content(bank) or BANK.encode()) == BANK.encode()
    while desk.redo_title is not None:
        desk.redo()
    assert (desk.content(bank) or BANK.encode()) == last


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
        assert read_yaml(bank, desk.content(bank)).data["bigrams"] == kept
