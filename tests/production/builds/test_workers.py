"""Batches in this process and in others: all results once, with equal bytes."""

import os
import pickle
import signal
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest
import toy_work
from lanes import full
from toy_work import WORKER_ENVIRONMENT

import lipsync_lang as ll
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.production.builds import workers
from lipsync_lang.production.builds.workers import (
    Job,
    LostBatch,
    MissingValues,
    parcel_of,
    run_batches,
)

HEAVY = [{"name": name, "weight": b"x" * 100_000} for name in "abc"]


def heavy(batch):
    """The part that a batch of `named` shares with its neighbours."""
    return HEAVY[batch // 20]


WORKED = """
import pickle, sys
from io import BytesIO
from pathlib import Path
import lipsync_lang.production.builds.making
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.reports.quality.check_animation import check
performer, schedule = pickle.loads(Path(sys.argv[1]).read_bytes())
animation = performer.perform(schedule)
assert check(animation, performer=performer).figures
WRITERS["csv"].write(animation, BytesIO())
print("pydantic" in sys.modules)
"""
"""The work of a worker on a line with timings."""


def test_a_worker_makes_a_timed_line_without_the_models_of_packs(tmp_path):
    line = ll.Schedule(("M", "AA", "S"), [0, 0.1, 0.3, 0.5])
    (tmp_path / "work").write_bytes(pickle.dumps((ll.resolve("english", "facefx"), line)))
    own = [sys.executable, "-c", WORKED, str(tmp_path / "work")]
    done = subprocess.run(own, capture_output=True, text=True, check=False)
    assert (done.stdout.strip(), done.stderr) == ("False", "")


# In this process


def test_results_come_in_order_and_batches_are_read_as_they_are_needed():
    read = []

    def batches():
        for number in range(3):
            read.append(number)
            yield (number,)

    results = run_batches(toy_work.doubled, batches(), workers=1)
    assert read == []
    assert next(results) == [0]
    assert read == [0]
    assert list(results) == [[2], [4]]


def test_what_batches_share_is_given_with_them():
    found = list(run_batches(toy_work.named, range(60), shared=heavy, workers=1))
    assert found == [(n, "abc"[n // 20], 100_000) for n in range(60)]


@pytest.mark.parametrize("count", [0, -1])
def test_fewer_than_one_worker_is_refused(count):
    with pytest.raises(LipsyncError, match="give 1 or more"):
        run_batches(toy_work.doubled, [], workers=count)


def test_a_scheduler_and_a_number_of_workers_exclude_each_other():
    with pytest.raises(LipsyncError, match="either a scheduler or a number"):
        run_batches(toy_work.doubled, [], workers=2, scheduler="tcp://127.0.0.1:1")


# On the way


def test_equal_content_has_one_name_and_other_content_another():
    assert parcel_of({"a": 1}).key == parcel_of({"a": 1}).key != parcel_of({"a": 2}).key


def test_a_worker_asks_for_what_it_has_not_got_and_keeps_what_it_got(monkeypatch):
    monkeypatch.setattr(workers, "opened", type(workers.opened)())
    job = Job(parcel_of(toy_work.named), parcel_of(HEAVY[0]), 7)
    assert job.bare.run() == MissingValues(job.key)
    assert job.run() == job.bare.run() == (7, "a", 100_000)


def test_a_worker_keeps_a_few_values_only(monkeypatch):
    monkeypatch.setattr(workers, "opened", type(workers.opened)())
    for number in range(50):
        Job(parcel_of(toy_work.named), parcel_of(HEAVY[0] | {"name": number}), 0).run()
    assert len(workers.opened) == workers.MAX_OPENED


def test_what_batches_share_is_pickled_once(monkeypatch):
    pickled = []
    monkeypatch.setattr(
        workers, "parcel_of", lambda value: pickled.append(value) or parcel_of(value)
    )
    jobs = list(workers.pack_jobs(toy_work.named, range(60), heavy))
    assert len(pickled) == 1 + len(HEAVY)
    assert len({job.key for job in jobs}) == len(HEAVY)


# In processes


@full
def test_processes_find_what_this_process_finds():
    performer = ll.resolve("english", "facefx")
    known = list(
        run_batches(toy_work.written, toy_work.lines(), shared=lambda _: performer, workers=1)
    )
    found = run_batches(toy_work.written, toy_work.lines(), shared=lambda _: performer, workers=2)
    assert sorted(found) == known


@full
def test_a_process_that_dies_loses_nothing(tmp_path):
    batches = [(n, tmp_path / "died" if n == 5 else None) for n in range(20)]
    assert sorted(run_batches(toy_work.deadly_once, batches, workers=2)) == list(range(20))


@full
def test_a_batch_that_ends_every_process_is_reported_and_the_others_go_on():
    batches = ["a", "b", toy_work.FATAL, *"cdefgh"]
    found = list(run_batches(toy_work.deadly, batches, workers=2))
    lost = [one for one in found if isinstance(one, LostBatch)]
    assert [one.batch for one in lost] == [toy_work.FATAL]
    assert "--workers 1" in lost[0].message
    assert sorted(one for one in found if isinstance(one, str)) == [*"abcdefgh"]


@full
def test_an_error_of_the_work_is_raised_here():
    with pytest.raises(ValueError, match="no 0"):
        list(run_batches(toy_work.refused, [0], workers=2))


@full
def test_processes_that_end_within_an_answer_keep_nobody_waiting():
    for _ in range(3):
        with closing(run_batches(toy_work.lengthy, range(4), workers=2)) as results:
            assert len(next(results)) == toy_work.LENGTH
            # the other process has begun to send as much


def test_who_stops_early_leaves_no_process():
    with closing(run_batches(toy_work.leisurely, range(10**9), workers=2)) as results:
        process, _ = next(results)
    assert not alive(process)


def alive(process):
    """Return True for a running process, but not for one that has ended and is still listed."""
    try:
        state = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


ENDLESS = """
import toy_work
from build_project import left_behind
from lipsync_lang.production.builds.workers import run_batches
from lipsync_lang.base.files.signals import Terminated, terminating
if __name__ == "__main__":
    try:
        with terminating():
            for process, _ in run_batches(toy_work.leisurely, range(10**9), workers=2):
                print(process, flush=True)
    except KeyboardInterrupt:
        raise SystemExit(130)
    except Terminated as ended:
        raise SystemExit(ended.code)
"""


@full
@pytest.mark.parametrize(
    ("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143), (signal.SIGKILL, -9)]
)
def test_a_signal_ends_every_process_without_a_traceback(tmp_path, number, code):
    script = tmp_path / "endless.py"
    script.write_text(ENDLESS)
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    run = [sys.executable, script]
    with subprocess.Popen(run, env=WORKER_ENVIRONMENT, start_new_session=True, **pipes) as started:
        seen = {int(started.stdout.readline()) for _ in range(20)}
        if number == signal.SIGINT:
            os.killpg(started.pid, number)  # as Ctrl-C in a terminal does
        else:
            started.send_signal(number)
        _, told = started.communicate(timeout=60)
    assert started.returncode == code
    assert "Traceback" not in told
    until = time.monotonic() + 30
    while any(map(alive, seen)) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(map(alive, seen))
