"""A build without work leaves an index, and the next one answers by it if nothing changed."""

import importlib
import json
import logging
import os
import subprocess
import sys
import warnings
from argparse import Namespace
from contextlib import contextmanager
from hashlib import blake2b
from pathlib import Path
from types import SimpleNamespace

import pytest
from build_project import BANK, Game

from lipsync_lang.cli import main
from lipsync_lang.production.builds import build_run, planning, unchanged
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
    """Run a build in a process of its own; return its code, events, messages and read files."""
    command = [sys.executable, "-c", BUILD, *arguments]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=120, check=False)
    *events, read = done.stdout.splitlines()
    return done.returncode, events, done.stderr, read


@pytest.fixture(scope="module")
def own_cache(tmp_path_factory):
    """A cache that no test beside these writes into while their builds read it."""
    return str(tmp_path_factory.mktemp("cache"))


@pytest.fixture(autouse=True)
def alone(monkeypatch, own_cache):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", own_cache)


@pytest.fixture
def game(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    made = Game(tmp_path, capsys)
    made.write("posesets/facefx/banks/common.yaml", BANK.format(level=0.2))
    made.write("lipsync.yaml", (tmp_path / "lipsync.yaml").read_text() + "reports: [out.json]\n")
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
def test_a_build_that_reads_nothing_says_the_same(tmp_path_factory, monkeypatch):
    # With an empty cache, the first build takes longer than file times need to settle.
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path_factory.mktemp("cache")))
    first = build_apart("--json")
    assert first[0] == 0, first[2]
    # The first build makes the lines; the second makes none, and its report differs.
    read = [build_apart("--json") for _ in range(3)]
    assert [one[3] for one in read] == ["read packs", "read nothing", "read nothing"]
    assert read[0][:3] == read[1][:3] == read[2][:3]
    assert json.loads(read[0][1][-1])["current"] == 4


def test_a_report_in_a_folder_of_its_own_is_left_as_it_is(tmp_path, monkeypatch):
    # As above, the first build is to take longer.
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    assert main(["new", "game", "-q"]) == 0
    monkeypatch.chdir(tmp_path / "game")
    stated, report = Path("lipsync.yaml").read_text("utf-8"), Path("build/report.xml")
    wanted = "reports: [build/report.html, build/report.xml, build/report.json]"
    assert "\nreports: build/report.html\n" in stated
    Path("lipsync.yaml").write_text(stated.replace("reports: build/report.html", wanted), "utf-8")
    said = "--json", "--tts", "none"
    read = [build_apart(*said)[3] for _ in range(2)]  # the second one counts no line as built
    paths = [report.parent, *report.parent.iterdir()]
    changed = [path.stat().st_mtime_ns for path in paths]
    read += [build_apart(*said)[3] for _ in range(2)]
    assert read == [*["read packs"] * 3, "read nothing"]
    assert len(paths) == 4
    assert [path.stat().st_mtime_ns for path in paths] == changed
    content = report.read_bytes()
    report.write_bytes(content.swapcase())
    build_apart(*said)
    assert report.read_bytes() == content


def test_a_folder_of_builds_is_left_as_it_is(answered):
    game, ask = answered
    before = {path: path.stat().st_mtime_ns for path in game.folder.rglob("*")}
    assert ask()["passed"]
    assert {path: path.stat().st_mtime_ns for path in game.folder.rglob("*")} == before


@pytest.mark.skipif(not Path("/proc/self/fd").is_dir(), reason="the system has no /proc")
def test_a_look_at_the_system_is_no_input(tmp_path, monkeypatch):
    monkeypatch.setattr(unchanged, "READERS", "no.such.module")
    log = unchanged.BuildLog(tmp_path)
    list(Path("/proc/self/fd").iterdir())
    list(tmp_path.parent.iterdir())
    log.listens = False
    assert (str(tmp_path.parent), False) in log.states
    assert not any(path.startswith("/proc/") for path, _ in log.states)


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
    "a report that is gone": lambda game: (game.folder / "out.json").unlink(),
    "a record that a killed build left": lambda game: game.write(
        ".lipsync_lang/build.sqlite-wal", "x"
    ),
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
    monkeypatch.setenv("XDG_STATE_HOME", "elsewhere")  # names the folders that the user allows
    assert ask() is None
    monkeypatch.delenv("XDG_STATE_HOME")
    monkeypatch.setenv("LIPSYNC_LANG_PATH", "elsewhere")
    assert ask() is None


def test_a_log_is_written_again(answered):
    _, ask = answered
    log = logging.getLogger("lipsync_lang")
    log.setLevel(logging.DEBUG)
    try:
        assert ask() is None
    finally:
        log.setLevel(logging.NOTSET)
    assert ask() is not None


@pytest.mark.parametrize("path", ["vo/low.json", "takes/low.csv"])
def test_a_file_that_went_during_the_build_is_missed(answered, monkeypatch, path):
    game, ask = answered
    plan = ProjectBuild.plan

    def lost(*given, **named):
        found = plan(*given, **named)
        (game.folder / path).unlink()
        return found

    monkeypatch.setattr(ProjectBuild, "plan", lost)
    game.write(".lipsync_lang/unchanged.txt", "")
    game.build()
    assert ask() is None


def test_a_file_that_changed_during_the_build_is_noticed_whatever_the_clock(answered, monkeypatch):
    game, ask = answered
    plan = ProjectBuild.plan

    def changed(*given, **named):
        found = plan(*given, **named)
        game.script(["low"])
        return found

    with monkeypatch.context() as slow:
        # The clock of a server may be late, and then the file looks old.
        slow.setattr(unchanged, "TICK_NANOSECONDS", -(10**12))
        slow.setattr(ProjectBuild, "plan", changed)
        game.write(".lipsync_lang/unchanged.txt", "")
        game.build()
    assert ask() is None


def test_a_code_of_a_plug_in_that_changed_is_noticed(game, monkeypatch, request):
    game.write("code/my_plug_in.py", "low = 1")
    monkeypatch.syspath_prepend(str(game.folder / "code"))
    importlib.import_module("my_plug_in")
    monkeypatch.setitem(sys.modules, "my_plug_in", sys.modules["my_plug_in"])
    _, ask = request.getfixturevalue("answered")
    game.write("code/my_plug_in.py", "map = 1")
    assert ask() is None


def test_the_index_is_kept_while_other_builds_wait(game, monkeypatch):
    done = []

    @contextmanager
    def locked(*_given):
        yield
        done.append("released")

    monkeypatch.setattr(build_run, "locked", locked)
    monkeypatch.setattr(unchanged.BuildLog, "keep", lambda *_, **__: done.append("kept"))
    game.build()
    game.build()
    assert done == ["released", "kept", "released"]


def test_folders_where_names_are_tried_are_listed(tmp_path, monkeypatch):
    monkeypatch.setattr(unchanged, "READERS", "no.such.module")
    below, packs = tmp_path / "below", tmp_path / "packs.lipsync_lang"
    below.mkdir()
    packs.mkdir()
    monkeypatch.chdir(below)
    monkeypatch.setenv("LIPSYNC_LANG_PATH", str(tmp_path / "later"))
    log = unchanged.BuildLog(tmp_path)
    assert list(packs.iterdir()) == []
    log.listens = False
    assert {tmp_path, below, packs, tmp_path / "later"} <= {Path(path) for path, _ in log.states}


def test_files_of_one_size_and_time_differ_by_their_numbers(monkeypatch):
    stated = {"st_size": 1, "st_mtime_ns": 2, "st_ctime_ns": 3}
    with monkeypatch.context() as patched:
        patched.setattr(os, "stat", lambda path: SimpleNamespace(**stated, st_ino=len(path)))
        states = {unchanged._file_state(path) for path in ("vo", "old")}  # noqa: SLF001
    assert len(states) == 2


def test_an_output_that_is_gone_is_not_trusted(tmp_path):
    gone = str(tmp_path / "low.csv")
    assert unchanged._file_state(gone, 0, lost=b"") == b""  # noqa: SLF001
    assert unchanged._file_state(gone, 0) != b""  # noqa: SLF001


def test_a_folder_whose_inner_folder_changed_late_is_not_trusted(tmp_path):
    (tmp_path / "inner").mkdir()
    assert unchanged._folder_state(str(tmp_path), settled=0) == b""  # noqa: SLF001
    assert unchanged._folder_state(str(tmp_path), settled=2**63) != b""  # noqa: SLF001


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


def forged(old):
    """Return an index of wrong types whose digest is right."""
    first, *lines, _ = old.splitlines(keepends=True)
    head = json.loads(first)
    head["said"]["remarks"] = 5
    lines = [json.dumps(head).encode() + b"\n", *lines]
    return b"".join([*lines, b"end\t", blake2b(b"".join(lines)).hexdigest().encode(), b"\n"])


DAMAGES = {
    "wrong types": forged,
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


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no named pipes")
def test_a_pipe_in_place_of_the_index_answers_nothing(answered):
    game, ask = answered
    path = game.folder / ".lipsync_lang/unchanged.txt"
    path.unlink()
    os.mkfifo(path)
    assert ask() is None
    game.build()
    assert ask() is not None


def test_a_link_in_place_of_the_index_is_replaced(answered):
    game, ask = answered
    path = game.folder / ".lipsync_lang/unchanged.txt"
    path.unlink()
    game.write("mine.txt", "mine")
    path.symlink_to(game.folder / "mine.txt")
    game.build()
    assert ask() is not None
    assert (game.folder / "mine.txt").read_text() == "mine"
