"""Builds on a Dask cluster: the same bytes, and nothing left behind."""

import json
import signal
import subprocess

from lanes import full
from test_build_runs import LINES, command, contents, game, unbuilt  # noqa: F401 a fixture
from test_dask_cluster import cluster

pytestmark = full


def test_a_cluster_that_loses_a_worker_writes_the_same_bytes(game):  # noqa: F811 the fixture
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


def test_an_interrupted_build_of_a_cluster_resumes_there_and_leaves_nothing_behind(game):  # noqa: F811 the fixture
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
            built = json.loads(told.stdout.splitlines()[-1])["built"]
            assert built < LINES, "at least the line that was reported is taken up"
            assert contents(game.folder) == one, "the workers outlive the build, not its files"
    made = {game.folder / name for name in (".lipsync_lang", "takes", "glb")}
    assert {*game.folder.iterdir()} == before | made
