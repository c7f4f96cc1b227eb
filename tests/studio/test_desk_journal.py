"""Unsaved edits of packs that are found again after a crash."""

import json
import os
import signal
import subprocess
import sys

import pytest
from desk_texts import BOUNDARY, STATUS, THEIRS, value
from packs_tree import BANK, plant

from lipsync_lang.base.errors import OutputError
from lipsync_lang.packs.splicing import ABSENT
from lipsync_lang.studio import desk as desk_module
from lipsync_lang.studio.desk import Desk


def test_a_killed_desk_is_found_again(bank, home, journal):
    other = home / "posesets/face/poseset.yaml"
    made = home / "posesets/face/banks/new.yaml"
    desk = Desk(journal)
    assert (desk.restored, desk.notes) == (0, [])
    desk.change("One", [(bank, BOUNDARY, 0.3)])
    desk.change("Two", [(bank, ("bigrams", "p-yu"), ABSENT), (other, ("title",), "New")])
    desk.change("Three", [(made, (), BANK.replace("name: common", "name: new"))])
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


def test_a_journal_of_an_earlier_version_is_read(bank, home, journal):
    other = home / "posesets/face/poseset.yaml"
    made = home / "posesets/face/banks/new.yaml"
    file, title = (
        {"file": str(bank), "at": ["bigrams", "p-yu"]},
        {"file": str(other), "at": ["title"]},
    )
    lines = [
        {"journal": "lipsync-lang studio", "format": 1},
        {"base": str(bank), "text": BANK},
        {"put": str(bank), "text": BANK.replace("0.4", "0.35")},
        {"base": str(made), "text": None},
        {"base": str(other), "text": other.read_text()},
        {"change": "New", "merge": "", "tab": "", "edits": [{**file, "file": str(made)}],
         "create": {str(made): BANK.replace("name: common", "name: new")}},
        *({"change": "Drag", "merge": "k", "tab": "a", "edits": [{**title, "value": name}],
           "create": {}} for name in "ab"),
        {"change": "Last", "merge": "", "tab": "a", "edits": [file], "create": {}},
        {"undo": "Last"},
    ]  # fmt: skip
    journal.parent.mkdir()
    rows = [json.dumps(line) for line in lines]
    journal.write_text("\n".join([*rows, '{"change": "To']))
    for desk in (Desk(journal), Desk(journal)):
        assert (desk.notes, desk.restored, desk.undo_title) == ([], 3, "Drag")
        assert (value(desk, bank, BOUNDARY), value(desk, other, ("title",))) == (0.35, "b")
        assert desk.text(made).at(("bigrams", "p-yu")) is ABSENT
        assert desk.redo() == "Last"
        assert desk.text(bank).at(("bigrams", "p-yu")) is ABSENT
        titles = [desk.undo() for _ in range(4)]
        assert (titles[1:3], desk.contents, desk.undo_title) == (["Drag", "New"], {}, None)
        journal.write_text("\n".join([*rows, ""]))


def test_a_save_that_an_earlier_version_began_is_completed(bank, journal):
    mine = BANK.replace("0.4", "0.35")
    lines = [
        desk_module.JOURNAL_HEADER, {"base": str(bank), "text": BANK},
        {"put": str(bank), "text": mine}, {"save": {str(bank): "a digest"}},
    ]  # fmt: skip
    journal.parent.mkdir()
    journal.write_text("".join(f"{json.dumps(line)}\n" for line in lines))
    desk = Desk(journal)
    assert bank.read_text() == mine
    assert (desk.contents, desk.restored) == ({}, 0)
    assert "is complete" in desk.notes[0]


@pytest.mark.parametrize(
    ("content", "why"),
    [
        (b"a diary\n", "is damaged"),
        (b'{"some": "json"}\n', "is not a journal"),
        (b"\xff\xfe\n", "is damaged"),
        (b"[" * 100_000 + b"\n", "is damaged"),
        ("edited", "is damaged"),
        ("unknown", "newer version"),
        ("unopened", "is damaged"),
        ("faulty", "P104"),
        ("text", "is damaged"),
        ("list", "is damaged"),
        ("create", "is damaged"),
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
        "text": [lines[0], '{"base": "b.yaml", "text": 5}'],
        "list": [*lines, '["undo"]'],
        "create": [*lines[:-1], lines[-1].replace('"edits"', '"create":[1],"edits"')],
        "faulty": [*lines[:-1], lines[-1].replace("0.3", "3")],
    }
    if isinstance(content, str):
        content = "".join(f"{line}\n" for line in broken[content]).encode()
    journal.write_bytes(content)
    again = Desk(journal)
    assert (again.restored, again.contents, again.undo_title) == (0, {}, None)
    assert why in again.notes[0]
    (aside,) = journal.parent.glob("journal.damaged-*")
    assert str(aside) in again.notes[0]
    assert aside.read_bytes() == content
    again.change("One", [(bank, BOUNDARY, 0.6)])
    assert Desk(journal).restored == 1


def test_a_long_journal_is_written_anew(bank, journal, monkeypatch):
    monkeypatch.setattr(desk_module, "MAX_JOURNALED", 5)
    desk = Desk(journal)
    for number in range(1, 20):
        desk.change(f"Step {number}", [(bank, BOUNDARY, number / 20)])
        assert value(Desk(journal), bank, BOUNDARY) == number / 20
    assert len(journal.read_text().splitlines()) == 1 + 2 + 5
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
    assert (again.undo(), again.contents, again.undo_title) == ("Drag", {}, None)


def test_a_drag_goes_on_in_a_journal_written_anew(bank, journal, monkeypatch):
    monkeypatch.setattr(desk_module, "MAX_JOURNALED", 2)
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


def test_an_edit_that_the_journal_could_not_take_is_written_with_the_next(
    bank, journal, monkeypatch
):
    def refused(*_):
        raise PermissionError(13, "held open")

    desk = Desk(journal)
    with monkeypatch.context() as patched:
        patched.setattr("lipsync_lang.base.files.writing.replace_file", refused)
        with pytest.raises(OutputError, match="held open"):
            desk.change("One", [(bank, STATUS, "edited")])
    desk.change("Two", [(bank, BOUNDARY, 0.7)])
    again = Desk(journal)
    assert again.contents == desk.contents
    assert (again.undo(), again.undo(), again.contents) == ("Two", "One", {})


def test_what_is_undone_after_saving_is_found_again(bank, journal):
    desk = Desk(journal)
    desk.change("One", [(bank, BOUNDARY, 0.3)])
    desk.change("Two", [(bank, BOUNDARY, 0.7)])
    desk.save()
    assert (desk.undo(), desk.undo()) == ("Two", "One")
    again = Desk(journal)
    assert again.contents == desk.contents == {bank: BANK.encode()}
    assert again.save() == [bank]


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


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no processes to kill")
@pytest.mark.parametrize("changed", ["disk", "unwritable"])
def test_a_save_that_was_cut_off_overwrites_no_later_change(bank, home, journal, changed):
    other = home / "posesets/face/poseset.yaml"
    edits = [(bank, BOUNDARY, 0.6), (other, ("title",), "New")]
    before = other.read_bytes()
    for step in range(1000):
        save_until(journal, edits, step)
        if b'"save"' in journal.read_bytes():
            break
    assert (bank.read_text(), other.read_bytes()) == (BANK, before)
    if changed == "disk":
        bank.write_text(THEIRS)
    else:
        bank.chmod(0o444)
    again = Desk(journal)
    assert "cannot be completed" in again.notes[0]
    assert bank.read_text() == (THEIRS if changed == "disk" else BANK)
    assert other.read_bytes() == before
    assert {*again.contents} == {*Desk(journal).contents} == {bank, other}
    bank.chmod(0o644)
    assert {*again.save({(bank, ("bigrams", "f-a")): "mine"})} == {bank, other}
    assert b"boundary: 0.6" in bank.read_bytes()


def test_a_save_that_fails_stays_unsaved(bank, home, journal, monkeypatch):
    other = home / "posesets/face/poseset.yaml"
    desk = Desk(journal)
    desk.change("Both", [(bank, BOUNDARY, 0.6), (other, ("title",), "New")])

    def refused(source, target):
        if target == other:
            raise PermissionError(13, "held open")
        source.replace(target)

    monkeypatch.setattr("lipsync_lang.base.files.writing.replace_file", refused)
    with pytest.raises(OutputError, match="held open"):
        desk.save()
    assert list(desk.contents) == [other], "what reached the disk is saved"
    monkeypatch.undo()
    del desk
    again = Desk(journal)
    assert list(again.contents) == [other]
    assert again.save() == [other]
