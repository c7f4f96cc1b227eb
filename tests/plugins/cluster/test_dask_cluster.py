"""A Dask cluster: all results once, with equal bytes, and refusals of schedulers and workers."""

import re
import socket
import subprocess
import sys
import threading
from contextlib import contextmanager
from pathlib import Path

import pytest
import toy_work
from build_project import PROJECT, Game, left_behind
from lanes import full
from toy_work import WORKER_ENVIRONMENT, lines

import lipsync_lang as ll
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.plugins.cluster import dask_cluster
from lipsync_lang.production.builds import build_run
from lipsync_lang.production.builds.workers import run_batches

LANGUAGE = """\
kind: language
format: 1
name: toki
tag: tok
g2p: {engine: lexicon, file: words.tsv, notation: ipa}
notations:
  ipa: {m: bmp, i: iy}
"""

# A cluster's answers, without one


class Told:
    """Client of a cluster with stated versions."""

    def __init__(self, worker=(), scheduler=(), count=1, machine="x86_64"):
        self.worker, self.scheduler, self.count = dict(worker), dict(scheduler), count
        self.host = {"machine": machine}

    def wait_for_workers(self, count, timeout):
        if self.count < count:
            raise TimeoutError(timeout)

    def get_versions(self, packages):
        own = {"python": "3.11.7.final.0", "distributed": "2025.1.0", "numpy": "2.1.0"}
        own |= dict.fromkeys(packages, "0.1.0")
        return {
            "client": {"packages": own, "host": {"machine": "x86_64"}},
            "scheduler": {"packages": own | self.scheduler},
            "workers": {"tcp://far:1": {"packages": own | self.worker, "host": self.host}},
        }


@pytest.mark.parametrize(
    ("client", "words"),
    [
        (Told({"python": "3.12.1.final.0"}), "tcp://far:1 has Python 3.12, this machine 3.11"),
        (Told({"numpy": "1.26.0"}), "numpy 1.26.0, this machine 2.1.0; install the same"),
        (Told({"lipsync-lang": None}), r"lipsync-lang \(none\), this machine 0.1.0"),
        (Told(scheduler={"distributed": "2024.8.0"}), "the scheduler has distributed 2024.8.0"),
        (Told(count=0), "has no workers; start one with `dask worker tcp://s:1 --nthreads 1`"),
    ],
)
def test_a_cluster_of_other_versions_or_without_workers_is_named(client, words):
    with pytest.raises(LipsyncError, match=words):
        dask_cluster.check_versions(client, "tcp://s:1")


@pytest.mark.parametrize(
    "client",
    [
        *(Told(), Told({"python": "3.11.2.final.0"})),
        *(Told(scheduler={"numpy": None}), Told(machine="AMD64")),
    ],
)
def test_small_differences_of_a_cluster_are_none(client):
    dask_cluster.check_versions(client, "tcp://s:1")


def test_a_worker_with_a_processor_of_another_family_is_named():
    words = r"s:1: has workers with processors of another family \(aarch64, this machine x86_64\)"
    with pytest.warns(UserWarning, match=words):
        dask_cluster.check_versions(Told(machine="arm64"), "tcp://s:1")


@pytest.fixture
def spoken(tmp_path, tmp_path_factory, capsys, monkeypatch):
    """A game in a language whose pack lies elsewhere, with a lexicon."""
    game = Game(tmp_path, capsys)
    game.packs = tmp_path_factory.mktemp("packs") / "languages"
    game.packs.mkdir()
    (game.packs / "toki.yaml").write_text(LANGUAGE)
    (game.packs / "words.tsv").write_text("mi\tm i\n")
    game.write("script.csv", "id,text\na,mi\n")
    stated = PROJECT.replace("english", "toki").replace('timings: "vo/{id}.json"\n', "")
    game.write("lipsync.yaml", stated)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LIPSYNC_LANG_PATH", str(game.packs.parent))
    return game


def test_lexicons_outside_the_project_travel_to_the_workers_of_a_cluster(spoken, monkeypatch):
    lexicons = []

    def cluster(work, batches, *, shared, folder, **_):
        for batch in batches:
            (pair,) = shared(batch).values()
            lexicons.append(pair.performer.speaker.manner.settings.file)
            assert lexicons[-1].is_relative_to(folder)
            (spoken.packs / "words.tsv").rename(spoken.packs / "gone.tsv")  # as on another machine
            yield work(batch, shared(batch))
            (spoken.packs / "gone.tsv").rename(spoken.packs / "words.tsv")

    monkeypatch.setattr(build_run, "run_batches", cluster)
    assert spoken.build("--scheduler", "tcp://nobody:1", "--force").built == ["a"]
    assert not lexicons[0].exists()
    monkeypatch.undo()
    monkeypatch.chdir(spoken.folder)
    monkeypatch.setenv("LIPSYNC_LANG_PATH", str(spoken.packs.parent))
    assert spoken.build().built == [], "the record is that of a build on this machine"


def test_a_changed_lexicon_makes_its_lines_again_and_a_moved_one_does_not(spoken, monkeypatch):
    assert spoken.build().built == ["a"]
    spoken.packs.rename(spoken.folder / "languages")
    monkeypatch.delenv("LIPSYNC_LANG_PATH")
    assert spoken.build().built == []
    spoken.write("languages/words.tsv", "mi\tm i m\n")
    assert spoken.build().built == ["a"]


def test_a_worker_that_does_not_see_the_folder_is_named(tmp_path):
    class Blind:
        def run(self, function, *arguments):
            return {"tcp://far:1": False, "tcp://near:1": function(*arguments)}

    words = "tcp://far:1 does not see this folder; share it"
    with dask_cluster.sight_mark(tmp_path) as mark, pytest.raises(LipsyncError, match=words):
        dask_cluster.check_sight(Blind(), tmp_path, mark)
    assert list(tmp_path.iterdir()) == []
    left_behind(tmp_path, "seen")
    with dask_cluster.sight_mark(tmp_path) as mark:
        assert list(tmp_path.iterdir()) == [Path(mark)], "a killed build left its mark"
    with pytest.raises(LipsyncError, match="does not see this folder"):
        dask_cluster.run_there(mark, b"")


# On a cluster


@contextmanager
def dask(*arguments, says):
    """Run a program of Dask; yield it and the first group of a pattern in its output."""
    run = [sys.executable, "-m", "dask", *arguments]
    with subprocess.Popen(
        run, env=WORKER_ENVIRONMENT, stderr=subprocess.PIPE, text=True
    ) as started:
        try:
            found = next(m for line in started.stderr if (m := re.search(says, line)))
            threading.Thread(target=started.stderr.read, daemon=True).start()
            yield started, found[1]
        finally:
            started.kill()


@contextmanager
def cluster(count):
    """Run a scheduler and workers; yield its address and the workers' processes."""
    from contextlib import ExitStack

    with ExitStack() as stack:
        host = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        _, address = stack.enter_context(
            dask("scheduler", *host, says=r"Scheduler at:\s+(tcp://\S+)")
        )
        single = ("--nthreads", "1", "--no-nanny", "--no-dashboard")
        started = [
            stack.enter_context(dask("worker", address, *single, says="(Registered to)"))[0]
            for _ in range(count)
        ]
        yield address, started


@full
def test_a_cluster_that_loses_a_worker_finds_the_same_bytes(tmp_path):
    performer = ll.resolve("english", "facefx")
    known = list(run_batches(toy_work.written, lines(), shared=lambda _: performer, workers=1))
    with cluster(2) as (address, started):
        found = run_batches(
            toy_work.written, lines(), shared=lambda _: performer, scheduler=address,
            folder=tmp_path,
        )  # fmt: skip
        assert sorted(found) == known
        results = run_batches(toy_work.leisurely, range(60), scheduler=address)
        seen = [next(results) for _ in range(20)]
        assert len({process for process, _ in seen}) == 2
        started[0].kill()
        seen += results
        assert sorted(number for _, number in seen) == list(range(60))


@full
@pytest.mark.parametrize(
    ("address", "words"),
    [
        ("nowhere", "'nowhere' is not the address of a Dask scheduler .missing port"),
        ("http://127.0.0.1:80", "unknown address scheme"),
        ("tcp://127.0.0.1:1", "tcp://127.0.0.1:1: no Dask scheduler answers within 1 s"),
    ],
)
def test_a_scheduler_that_is_absent_is_named(monkeypatch, address, words):
    monkeypatch.setattr(dask_cluster, "LIMIT_SECONDS", 1)
    with pytest.raises(LipsyncError, match=words):
        list(run_batches(toy_work.doubled, [(1,)], scheduler=address))


@full
def test_a_server_that_is_no_scheduler_is_named(monkeypatch):
    monkeypatch.setattr(dask_cluster, "LIMIT_SECONDS", 1)
    with socket.create_server(("127.0.0.1", 0)) as mute:
        address = f"tcp://127.0.0.1:{mute.getsockname()[1]}"
        with pytest.raises(LipsyncError, match=f"{address}: no Dask scheduler answers within 1 s"):
            list(run_batches(toy_work.doubled, [(1,)], scheduler=address))


@full
def test_a_scheduler_that_ends_is_named():
    with cluster(1) as (address, _):
        results = run_batches(toy_work.leisurely, range(10**6), scheduler=address)
        next(results)
    with pytest.raises(LipsyncError, match="the scheduler is gone; finished lines are kept"):
        list(results)
