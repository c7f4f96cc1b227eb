"""`build --watch`: changes that begin a build, changes that do not, and its messages."""

import os
import signal
import subprocess
import sys
import time
from enum import IntEnum
from types import SimpleNamespace

import pytest
from build_project import BANK, Game
from lanes import full

from lipsync_lang.cli import main
from lipsync_lang.commands import build


class Change(IntEnum):
    added = 1
    modified = 2
    deleted = 3


@pytest.fixture
def game(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    made = Game(tmp_path, capsys)
    stated = (tmp_path / "lipsync.yaml").read_text("utf-8")
    made.write("lipsync.yaml", stated + "reports: [build/report.html]\n")
    return made


@pytest.fixture
def watched(game, monkeypatch):
    """Watch while steps change files, and return the messages after each step.

    What changed is found by comparing the folder, and passes the filter, as in the real watcher.
    """

    def stamps():
        return {
            str(path): path.stat().st_mtime_ns for path in game.folder.rglob("*") if path.is_file()
        }

    def run(*steps):
        said = []

        def watch(*_folders, watch_filter, **_options):
            yield set()
            before = stamps()
            for step in steps:
                said.append(game.capsys.readouterr().err)
                before, last = stamps(), before
                step()
                now = stamps()
                found = {(Change.added, path) for path in now if path not in last}
                found |= {(Change.deleted, path) for path in last if path not in now}
                found |= {(Change.modified, p) for p in now if last.get(p, now[p]) != now[p]}
                before = now
                yield {one for one in found if watch_filter(*one)}
            said.append(game.capsys.readouterr().err)
            raise KeyboardInterrupt

        module = SimpleNamespace(watch=watch, Change=Change, DefaultFilter=lambda: lambda *_: True)
        monkeypatch.setitem(sys.modules, "watchfiles", module)
        assert main(["build", "--watch"]) == 130
        return said

    return run


def nothing():
    """Save no file."""


def table(game, *rows):
    game.write("script.csv", "id,text\n" + "".join(f"{row}\n" for row in rows))


def test_what_a_build_writes_begins_no_other(game, watched):
    first, *later = watched(nothing, lambda: game.say("map", "M AA P"), nothing, nothing)
    assert "4 lines built" in first
    assert "watching; end it with Ctrl-C" in first
    assert "1 line built" in later[1]
    assert [later[0], later[2], later[3]] == ["", "", ""]


def test_a_changed_bank_and_a_lost_output_are_built(game, watched):
    bank = watched(lambda: game.bank(0.5), (game.folder / "takes/map.csv").unlink)
    assert ["1 line built" in one for one in bank] == [False, True, True]
    assert sorted(game.takes()) == ["home", "low", "mail", "map"]


def test_a_fault_is_told_once_and_the_watching_goes_on(game, watched):
    said = watched(
        lambda: table(game, "low,low", "a/b,low"),
        lambda: table(game, "low,low", "a/b,low "),
        lambda: table(game, "low,low", "map,map"),
    )
    assert "script.csv:3: the id 'a/b' has a '/'" in said[1]
    assert said[2] == "", "it is the same fault"
    assert "0 lines built" in said[3]
    assert "2 up to date" in said[3]


@full
def test_faults_of_packs_and_of_the_project_are_told_too(game, watched):
    stated = (game.folder / "lipsync.yaml").read_text("utf-8")
    said = watched(
        lambda: game.write("posesets/facefx/banks/common.yaml", BANK.format(level="high")),
        lambda: game.bank(0.5),
        (game.folder / "lipsync.yaml").unlink,
        lambda: game.write("lipsync.yaml", stated),
    )
    assert "posesets/facefx/banks/common.yaml:7:" in said[1]
    assert "1 line built" in said[2]
    assert "this folder has no lipsync.yaml" in said[3]
    assert "0 lines built" in said[4]


@full
def test_remarks_of_a_script_are_said_once(game, watched):
    said = watched(
        lambda: table(game, "low,low", "more,", "map,map"),
        lambda: table(game, "low,low", "more,"),
        lambda: table(game, "low,low"),
        lambda: table(game, "low,low", "more,", "map,map"),
    )
    assert ["without text, left out" in one for one in said] == [False, True, False, False, True]


def test_the_watcher_sees_inputs_alone(game):
    made = build.MadeByBuilds()
    project = SimpleNamespace(
        folder=game.folder,
        lines=[SimpleNamespace(outputs=[("csv", "takes/l1.csv"), ("csv", "crab.zip/l1.csv")])],
    )
    made.learn(project, [game.folder / "build/report.html"])
    for path in (
        "takes/l1.csv",
        "crab.zip",
        "build/report.html",
        "build/report-lines/l1.html",
        ".lipsync_lang/build.sqlite-wal",
        "takes/.l1.csv.0bbfd16a-454-dfd32d0c.lipsync-tmp",
    ):
        assert made.has(str(game.folder / path)), path
    for path in ("script.csv", "vo/l1.wav", "takes/other.csv", "lipsync.yaml"):
        assert not made.has(str(game.folder / path)), path


@full
def test_a_real_watcher_builds_what_is_saved_and_ends_with_ctrl_c(game):
    pytest.importorskip("watchfiles", reason="the extra `watch` is not installed")
    log = game.folder.parent / "watch.log"

    def until(text, times=1):
        end = time.monotonic() + 60
        while log.read_text("utf-8").count(text) < times and time.monotonic() < end:
            time.sleep(0.1)
        assert log.read_text("utf-8").count(text) == times, log.read_text("utf-8")

    command = [sys.executable, "-m", "lipsync_lang", "build", "--watch"]
    with log.open("wb") as err, subprocess.Popen(command, stderr=err) as running:
        try:
            until("watching; end it with Ctrl-C")
            game.bank(0.5)
            until("1 line built")
            table(game, "a/b,low")
            until("the id 'a/b'")
            table(game, "low,low")
            until("0 lines built")
            time.sleep(3)  # longer than the watcher gathers changes
            until("built in", 3)
            running.send_signal(signal.SIGINT)
            assert running.wait(30) == 130
        finally:
            running.kill()
    assert "Traceback" not in log.read_text("utf-8")
    assert not list(game.folder.rglob("*.lipsync-tmp"))
    assert os.listdir(game.folder / "takes")  # noqa: PTH208 something was made
