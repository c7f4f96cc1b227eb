"""Builds as processes: killed, resumed, two at once, over several workers."""

import json
import os
import signal
import subprocess
import sys
from hashlib import blake2b
from pathlib import Path
from shutil import rmtree

import pytest
from build_project import PROJECT, Game
from lanes import full
from test_workers import cluster

pytestmark = full

LINES = 150


def command(*options):
    return [sys.executable, "-m", "lipsync_lang", "build", "--json", *options]


@pytest.fixture
def game(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    made = Game(tmp_path, capsys)
    names = [f"line{number}" for number in range(LINES)]
    for number, name in enumerate(names):
        made.say(name, ["L OW", "M AE P", "M EY L", "HH OW M"][number % 4] + " AH" * (number % 7))
    made.script(names)
    made.write(
        "lipsync.yaml", PROJECT.replace('"takes/{id}.csv"]', '"takes/{id}.csv", "glb/{id}.glb"]')
    )
    return made


def contents(folder):
    """Return the digest of each output; pytest compares long bytes for minutes."""
    return {
        str(path.relative_to(folder)): blake2b(path.read_bytes()).hexdigest()
        for part in ("takes", "glb")
        for path in (folder / part).rglob("*")
    }


def unbuilt(folder):
    """Take away what builds made."""
    for part in ("takes", "glb", ".lipsync_lang"):
        rmtree(folder / part)


def test_workers_write_the_same_bytes(game):
    assert len(game.build("--workers", "1").built) == LINES
    one = contents(game.folder)
    assert len(one) == 2 * LINES
    assert len(game.build("--workers", "2", "--force").built) == LINES
    assert contents(game.folder) == one


def test_a_killed_build_resumes_and_leaves_nothing_behind(game):
    whole = subprocess.run(command("--workers", "2"), capture_output=True, text=True, check=True)
    expected = contents(game.folder)
    unbuilt(game.folder)
    assert json.loads(whole.stdout.splitlines()[-1])["built"] == LINES
    for kills in range(3):
        running = subprocess.Popen(
            command("--workers", "2"), stdout=subprocess.PIPE, text=True, start_new_session=True
        )
        for _ in range(2 + kills):
            assert running.stdout is not None
            running.stdout.readline()
        os.killpg(running.pid, 9)
        running.communicate()
        for path in game.folder.glob("glb/*.glb"):
            name = f"glb/{path.name}"
            assert contents(game.folder)[name] == expected[name], "what stands is whole"
    told = game.build("--workers", "2")
    assert told.code == 0
    assert 0 < len(told.built) < LINES, "something was made before"
    assert told.end["kept"] == []
    assert contents(game.folder) == expected, "and nothing else lies there"


def test_two_builds_at_once_share_the_work(game):
    both = [
        subprocess.Popen(command("--workers", "1"), stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    ends = [json.loads(one.communicate()[0].splitlines()[-1]) for one in both]
    assert [one.returncode for one in both] == [0, 0]
    assert sorted(end["built"] for end in ends) == [0, LINES]
    assert len(contents(game.folder)) == 2 * LINES


def test_a_cluster_that_loses_a_worker_writes_the_same_bytes(game):
    assert len(game.build("--workers", "1").built) == LINES
    one = contents(game.folder)
    unbuilt(game.folder)
    with cluster(2) as (address, workers):
        running = subprocess.Popen(
            command("--scheduler", address), stdout=subprocess.PIPE, text=True
        )
        assert running.stdout is not None
        running.stdout.readline()
        workers[0].kill()
        last = running.communicate()[0].splitlines()[-1]
    assert (running.returncode, json.loads(last)["built"]) == (0, LINES)
    assert contents(game.folder) == one


def test_an_interrupted_build_of_a_cluster_resumes_there_and_leaves_nothing_behind(game):
    before = {*game.folder.iterdir()}
    assert len(game.build("--workers", "1").built) == LINES
    one = contents(game.folder)
    with cluster(2) as (address, _):
        for number in (signal.SIGINT, signal.SIGKILL):
            unbuilt(game.folder)
            running = subprocess.Popen(
                command("--scheduler", address), stdout=subprocess.PIPE, text=True
            )
            assert running.stdout is not None
            running.stdout.readline()
            running.send_signal(number)
            running.communicate()
            told = subprocess.run(
                command("--scheduler", address), capture_output=True, text=True, check=True
            )
            assert 0 < json.loads(told.stdout.splitlines()[-1])["built"] < LINES
            assert contents(game.folder) == one, "the workers outlive the build, not its files"
    made = {game.folder / name for name in (".lipsync_lang", "takes", "glb")}
    assert {*game.folder.iterdir()} == before | made


@pytest.mark.usefixtures("game")
def test_ctrl_c_ends_a_build_quietly():
    running = subprocess.Popen(
        command("--workers", "2"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert running.stdout is not None
    running.stdout.readline()
    running.send_signal(2)
    _, err = running.communicate()
    assert running.returncode == 130
    assert "Traceback" not in err


@pytest.mark.skipif(os.name != "posix" or os.geteuid() == 0, reason="root may write everywhere")
def test_a_read_only_folder_is_named(game):
    Path(game.folder).chmod(0o500)
    told = game.build()
    Path(game.folder).chmod(0o700)
    assert told.code == 2
    assert "writable" in told.err
