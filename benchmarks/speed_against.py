"""Ratios of two revisions: each is built in an environment of its own, and both run in turn.

Times are of processors, user and system, the least of some runs: other programs disturb them least.
Both revisions run this script, which calls only commands and public names that both have.
"""

import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from speed_performing import PAIR, SENTENCE, schedule
from speed_script import Script
from speed_table import command, run, say, shown

import lipsync_lang as ll

ROOT = Path(__file__).resolve().parent.parent
FACES = ("facefx", "arkit")
TURNS = 3
"""Runs of each revision, one after the other."""

RUNS = 20
"""Runs of a line in a process."""

SETTLED_SECONDS = 3
"""Time after which the times of files tell whether they change again."""

Rows = dict[str, tuple[float, str]]
"""Value and unit of each figure by its name."""


def _spent(act: Callable[[list[ll.Schedule]], object], given: Sequence[ll.Schedule]) -> float:
    """Return the least seconds of the processor for each of some schedules.

    They are new ones each time, since the labels of a known schedule are cached.
    """
    found = []
    for _ in range(RUNS):
        new = list(map(replace, given))
        start = time.process_time()
        act(new)
        found.append(time.process_time() - start)
    return min(found) / len(given)


def lines() -> Rows:
    """Lines alone and in a batch, and a long one."""
    rows: Rows = {}
    many, long = [schedule(SENTENCE, seed) for seed in range(200)], [schedule(2_560)] * 2
    for face in FACES:
        performer = ll.resolve(PAIR[0], face)
        one_by_one, at_once = partial(_alone, performer), performer.perform_many
        rows[f"{SENTENCE} phonemes alone, {face}"] = _spent(one_by_one, many), "s"
        rows[f"{SENTENCE} phonemes in a batch, {face}"] = _spent(at_once, many), "s"
        rows[f"2,560 phonemes, {face}"] = _spent(one_by_one, long), "s"
    return rows


def _alone(performer: ll.Performer, schedules: Sequence[ll.Schedule]) -> list[ll.Animation]:
    return [performer.perform(one) for one in schedules]


def starts(folder: Path) -> Rows:
    """Commands whose packs are in the cache."""
    file, out = folder / "line.json", str(folder / "line.csv")
    line = schedule(3 * SENTENCE)
    timed = zip(line.labels, line.times, line.times[1:], strict=False)
    phonemes = [{"label": label, "start": start, "end": end} for label, start, end in timed]
    file.write_text(json.dumps({"notation": "arpabet", "phonemes": phonemes}), "utf-8")
    rows: Rows = {}
    pair = ("-l", PAIR[0], "-c", PAIR[1])
    for name, arguments in (
        ("--help", ("--help",)),
        ("run", ("run", "--schedule", str(file), *pair, "-o", out)),
        ("resolve", ("resolve", *pair)),
    ):
        tries = [run(command(*arguments)) for _ in range(6)]
        rows[f"{name}, warm"] = min(one.cpu_seconds for one in tries[1:]), "s"
    return rows


def built(folder: Path, name: str, count: int, *, timed: bool) -> Rows:
    """Build all lines with one worker, and three times more without a change.

    The first of them may keep an index of files, by which the others answer.
    """
    made = Script(
        folder / name.replace(" ", "_"), count, ("csv",), by="timings" if timed else "a voice"
    )
    report = ("--report", "report.html") if not timed else ()
    run(command("build", "--dry-run"), folder=made.folder)
    first = run(command("build", "--workers", "1", *report), folder=made.folder)
    if first.code:
        raise SystemExit(f"{name}: {first.error}")
    time.sleep(SETTLED_SECONDS)
    kept, *again = (
        run(command("build", "--workers", "1", *report), folder=made.folder) for _ in range(3)
    )
    rows: Rows = {
        f"{count:,} {name}": (first.cpu_seconds, "s"),
        f"{count:,} {name}, memory": (first.peak_mb, "MB"),
        f"{count:,} {name}, first without a change": (kept.cpu_seconds, "s"),
        f"{count:,} {name}, unchanged": (min(one.cpu_seconds for one in again), "s"),
        f"{count:,} {name}, unchanged, memory": (min(one.peak_mb for one in again), "MB"),
    }
    return rows


def measured(count: int) -> Rows:
    """Measure the revision of this process; builds are left out if they have no lines."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["LIPSYNC_LANG_CACHE"] = str(Path(folder) / "cache")
        rows = {**lines(), **starts(Path(folder))}
        if count:
            rows |= built(Path(folder), "spoken lines with a report", count, timed=False)
            rows |= built(Path(folder), "timed lines", count, timed=True)
    return rows


@contextmanager
def environment(revision: str | None) -> Iterator[str]:
    """Yield the Python of a temporary environment that has another revision, or the files here.

    A start reads the names of all installed packages, so both environments have the same ones.
    """
    with tempfile.TemporaryDirectory() as folder:
        tree, venv = Path(folder) / "tree" if revision else ROOT, Path(folder) / "venv"
        python = str(venv / ("Scripts/python.exe" if os.name == "nt" else "bin/python"))
        do = partial(subprocess.run, check=True, cwd=ROOT, stdout=subprocess.DEVNULL)
        if revision:
            do(["git", "worktree", "add", "--detach", str(tree), revision])
        try:
            say(f"{revision or 'this revision'} is built in an environment of its own")
            do([sys.executable, "-m", "venv", str(venv)])
            do([python, "-m", "pip", "install", "-q", f"{tree}[speech]"])  # builds speak
            yield python
        finally:
            if revision:
                do(["git", "worktree", "remove", "--force", str(tree)])


def _rows(python: str, count: int) -> Rows:
    """Measure in an interpreter, once."""
    with tempfile.TemporaryDirectory() as empty:  # packs of a working folder would come first
        own = [python, __file__, "--lines", str(count)]
        done = subprocess.run(  # noqa: S603 our own script, no shell
            own, check=True, stdout=subprocess.PIPE, text=True, cwd=empty
        )
    return {name: (value, unit) for name, (value, unit) in json.loads(done.stdout).items()}


def compare(revision: str, count: int) -> Iterator[str]:
    """Yield a line for each figure; end with a sentence if a step of it fails."""
    try:
        yield from _compared(revision, count)
    except subprocess.CalledProcessError as error:
        step = shlex.join(map(str, error.cmd))
        raise SystemExit(f"nothing is measured: {step} failed, as told above") from None


def _compared(revision: str, count: int) -> Iterator[str]:
    """Yield a line for each figure: there, here, and their ratio."""
    with environment(revision) as other, environment(None) as own:
        runs: list[list[Rows]] = [[], []]
        for turn in range(TURNS):
            say(f"turn {turn + 1} of {TURNS}")
            for found, python in zip(runs, (other, own), strict=True):
                # builds take minutes, and are measured once
                found.append(_rows(python, 0 if turn else count))
    there, here = (
        {name: min(one[name] for one in turns if name in one) for name in turns[0]}
        for turns in runs
    )
    yield f"{'':<50}{revision[:10]:>11}{'here':>11}{'ratio':>8}"
    for name, (value, unit) in here.items():
        if name in there:
            old = there[name][0]
            yield f"{name:<50}{shown(old, unit):>11}{shown(value, unit):>11}{value / old:>8.2f}"


if __name__ == "__main__":
    parser = ArgumentParser(description="Measure this revision, and print its figures as JSON.")
    parser.add_argument("--lines", type=int, default=0, help="lines of a build [%(default)s]")
    print(json.dumps(measured(parser.parse_args().lines)))
