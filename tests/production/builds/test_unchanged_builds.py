"""A build without work leaves an index, and the next one answers by it if nothing changed."""

import json
import os
import subprocess
import sys
import warnings
from argparse import Namespace

import pytest
from build_project import BANK, Game

from lipsync_lang.production.builds import planning, unchanged
from lipsync_lang.production.builds.project_build import ProjectBuild

BUILD = """
import sys
from lipsync_lang.cli import main
from lipsync_lang.production.builds import unchanged
unchanged.TICK_NANOSECONDS = 0
code = main(["build", *sys.argv[1:]])
print("read packs" if "lipsync_lang.packs.library" in sys.modules else "read nothing")
sys.exit(code)
"""


def build_apart(*arguments):
    """Build in a process of its own; return its exit code, events, words and what it read."""
    command = [sys.executable, "-c", BUILD, *arguments]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=120, check=False)
    *events, read = done.stdout.splitlines()
    return done.returncode, events, done.stderr, read


@pytest.fixture
def game(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    made = Game(tmp_path, capsys)
    made.write("posesets/facefx/banks/common.yaml", BANK.format(level=0.2))
    made.write("lipsync.yaml", (tmp_path / "lipsync.yaml").read_text() + "reports: [out.html]\n")
    return made


@pytest.fixture
def answered(game, monkeypatch):
    """A game whose last build left an index, and the function that asks the index."""
    monkeypatch.setattr(unchanged, "READERS", "no.such.module")
    monkeypatch.setattr(unchanged, "TICK_NANOSECONDS", 0)
    monkeypatch.setattr(planning, "TICK_NANOSECONDS", 0)
    stated = []
    keep = unchanged.BuildLog.keep

    def kept(self, own, options, **rest):
        stated.append(options)
        keep(self, own, options, **rest)

    monkeypatch.setattr(unchanged.BuildLog, "keep", kept)
    for _ in range(2):  # the first one makes the lines and the report, and lists their folders
        game.build()
    game.build()

    def ask(**changed):
        return unchanged.answer(game.folder, "", Namespace(**vars(stated[-1]) | changed))

    assert ask() is not None, "a change is noticed only where an index stands"
    return game, ask


@pytest.mark.usefixtures("game")
def test_a_build_that_reads_nothing_says_the_same():
    first = build_apart("--json")
    assert first[0] == 0, first[2]
    # The first build makes the lines; the second makes none, and its report differs.
    read = [build_apart("--json") for _ in range(3)]
    assert [one[3] for one in read] == ["read packs", "read nothing", "read nothing"]
    assert read[0][:3] == read[1][:3] == read[2][:3]
    assert json.loads(read[0][1][-1])["current"] == 4


def test_a_folder_of_builds_is_left_as_it_is(answered):
    game, ask = answered
    before = {path: path.stat().st_mtime_ns for path in game.folder.rglob("*")}
    assert ask()["passed"]
    assert {path: path.stat().st_mtime_ns for path in game.folder.rglob("*")} == before


def edit_of_equal_length(game):
    path = game.folder / "vo/low.json"
    stat = path.stat()
    path.write_text(path.read_text().replace("OW", "IY"))
    os.utime(path, ns=(stat.st_atime_ns, stat.st_mtime_ns))


def new_pose_set(game):
    # The folder of the project's bank was never listed.
    game.write("posesets/facefx/poseset.yaml", "kind: poseset\n")


CHANGES = {
    "timings of equal length and time": edit_of_equal_length,
    "a file of timings that is gone": lambda game: (game.folder / "vo/low.json").unlink(),
    "a new file of timings": lambda game: game.write("vo/new.json", "[]"),
    "a line more": lambda game: game.script(["low", "map"]),
    "the project": lambda game: game.write("lipsync.yaml", "kind: project\n"),
    "a bank": lambda game: game.write("posesets/facefx/banks/common.yaml", BANK.format(level=0.4)),
    "a language": lambda game: game.write("languages/english.yaml", "kind: language\n"),
    "a character": lambda game: game.write("characters/facefx.yaml", "kind: character\n"),
    "a pose set": new_pose_set,
    "an output that is gone": lambda game: (game.folder / "takes/low.csv").unlink(),
    "an output that was edited": lambda game: game.write("takes/low.csv", "mine"),
    "a report that is gone": lambda game: (game.folder / "out.html").unlink(),
    "a record that is gone": lambda game: (game.folder / ".lipsync_lang/build.sqlite").unlink(),
}


@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_change_of_any_input_or_output_is_noticed(answered, change):
    game, ask = answered
    change(game)
    assert ask() is None


def test_a_change_of_options_or_variables_is_noticed(answered, monkeypatch):
    _, ask = answered
    assert ask(force=True) is None
    assert ask(only=["low"]) is None
    monkeypatch.setenv("LIPSYNC_LANG_PATH", "elsewhere")
    assert ask() is None


def test_a_file_that_changed_shortly_before_the_build_is_not_trusted(game, monkeypatch):
    monkeypatch.setattr(unchanged, "READERS", "no.such.module")
    monkeypatch.setattr(unchanged, "TICK_NANOSECONDS", 10**15)
    for _ in range(3):
        game.build()
    assert not (game.folder / ".lipsync_lang/unchanged.txt").exists()


def test_a_build_that_warned_warns_again(game, monkeypatch):
    monkeypatch.setattr(unchanged, "READERS", "no.such.module")
    monkeypatch.setattr(unchanged, "TICK_NANOSECONDS", 0)
    told = []
    monkeypatch.setattr(warnings, "showwarning", lambda *given: told.append(given))
    plan = ProjectBuild.plan

    def warned(*given, **named):
        warnings.showwarning("the plug-in is damaged", UserWarning, "x.py", 1)
        return plan(*given, **named)

    monkeypatch.setattr(ProjectBuild, "plan", warned)
    for _ in range(3):
        game.build()
    assert len(told) == 3
    assert not (game.folder / ".lipsync_lang/unchanged.txt").exists()


DAMAGES = {
    "cut": lambda old: old[:-5],
    "empty": lambda old: old[:0],
    "deep": lambda old: b"[" * len(old),
    "no text": lambda old: b"\xff" + old,
    "another answer": lambda old: old.replace(b"passed", b"failed"),
    "other files": lambda old: old.replace(b"map", b"w\xff\xff"),
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_a_damaged_index_answers_nothing(answered, damage):
    game, ask = answered
    path = game.folder / ".lipsync_lang/unchanged.txt"
    path.write_bytes(damage(path.read_bytes()))
    assert ask() is None
