"""Sections of the benchmark on whole builds: from timings, from text, and on a Dask cluster."""

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import tracemalloc
from argparse import Namespace
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, chdir, contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from zlib import compress

import numpy as np
from speed_table import Ended, Figures, best, command, run, say

from lipsync_lang.build.project_build import ProjectBuild
from lipsync_lang.build.records import Records
from lipsync_lang.cli import main

LABELS = "AA AE AH AO EH IH IY UW B D F G HH K L M N P R S T V W Z TH SH".split()  # noqa: SIM905 readable
"""Sounds of the lines; the edited bigram is of none of them."""

WORDS = (  # noqa: SIM905 readable
    "the a old young dark bright river garden window captain morning people money bread carries "
    "opens follows under over before after slowly never always seven twenty big small please buy "
    "more maps away moves Bob Anna home tomorrow"
).split()

PHONEMES = 40
"""Phonemes of a timed line."""

EDITED = 50
"""Lines that contain the edited bigram."""

WHOLE = 10_000
"""Lines of the goals."""

GOAL_SECONDS, GOAL_SPOKEN_SECONDS, GOAL_EDITED_SECONDS = 60.0, 90.0, 2.0
"""Goals on two cores: from timings to CSV and GLB, from text to CSV, after an edited bigram."""

TELL_SECONDS = 10.0
"""Pause between two messages of progress."""

PROJECT = """\
kind: project
format: 1
language: english
character: facefx
lines: script.csv
timings: "vo/{{id}}.txt"
outputs: [{outputs}]
"""

BANK = """\
kind: bank
format: 1
name: common
poseset: facefx
bigrams:
  l-oy:
    curves: {{open: [[0, 0], [0.5, {level}], [1, 0]]}}
"""


class BuildError(Exception):
    """A build did not make the lines it should."""


class Script:
    """A project of lines in a folder, and the command that builds it."""

    def __init__(self, folder: Path, lines: int, outputs: Sequence[str], *, timed: bool) -> None:
        self.folder, self.lines, self.outputs = folder, lines, tuple(outputs)
        (folder / "vo").mkdir(parents=True)
        paths = ", ".join(f'"{one}/{{id}}.{one}"' for one in outputs)
        (folder / "lipsync.yaml").write_text(PROJECT.format(outputs=paths), "utf-8")
        chance = np.random.default_rng(1)
        rows = ["id,text"]
        for number in range(lines):
            rows.append(f"l{number:05},{_text(chance, number)}")
            if timed:
                part, rest = divmod(number, max(1, lines // EDITED))
                edited = rest == 0 and part < EDITED
                timings = _timings(chance, edited=edited)
                (folder / f"vo/l{number:05}.txt").write_text(timings, "utf-8")
        (folder / "script.csv").write_text("\n".join(rows) + "\n", "utf-8")

    def clear(self) -> None:
        """Delete what builds have made."""
        for name in (*self.outputs, ".lipsync_lang"):
            shutil.rmtree(self.folder / name, ignore_errors=True)

    def edit(self, level: float) -> None:
        """Draw the edited bigram in a bank of the project."""
        bank = self.folder / "posesets/facefx/banks/common.yaml"
        bank.parent.mkdir(parents=True, exist_ok=True)
        bank.write_text(BANK.format(level=level), "utf-8")

    def build(self, *options: str, expected: int) -> Ended:
        """Build, tell the progress, and see that as many lines as expected were made."""
        made, since, failed = 0, time.monotonic(), list[str]()

        def told(line: str) -> None:
            nonlocal made, since
            event = json.loads(line)
            made += event.get("outcome") == "built"
            if event.get("outcome") == "failed":
                failed.append(event["message"])
            if event["event"] == "progress" and time.monotonic() - since > TELL_SECONDS:
                since = time.monotonic()
                say(f"{event['done']:,} of {event['of']:,} lines in {event['seconds']:.0f} s")

        ended = run(command("build", "--json", *options), folder=self.folder, told=told)
        if ended.code or made != expected:
            raise BuildError(f"{made} lines of {expected} were made: {failed[:1]} {ended.error}")
        return ended

    def kilobytes(self, name: str, size: Callable[[Path], int]) -> float:
        """Return the size of a file or of the files of a folder, in kB for each line."""
        found = self.folder / name
        return sum(map(size, found.iterdir() if found.is_dir() else [found])) / self.lines / 1e3


def _text(chance: np.random.Generator, number: int) -> str:
    """Return a sentence that no other line has."""
    return f"{' '.join(chance.choice(WORDS, 8))} {number}"


def _timings(chance: np.random.Generator, *, edited: bool) -> str:
    """Return timed phonemes as tab-separated labels."""
    times = np.concatenate(([0.0], np.cumsum(chance.uniform(0.04, 0.12, PHONEMES))))
    labels = chance.choice(LABELS, PHONEMES).tolist()
    if edited:
        labels[10:12] = ["L", "OY"]
    rows = zip(times, times[1:], labels, strict=False)
    return "".join(f"{start:.4f}\t{end:.4f}\t{label}\n" for start, end, label in rows)


@contextmanager
def scripts(lines: int, outputs: Sequence[str], *, timed: bool = True) -> Iterator[list[Script]]:
    """Make a small script and one of so many lines; two sizes tell the start from the rate."""
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        os.environ["LIPSYNC_LANG_CACHE"] = str(Path(folder) / "cache")
        stack.callback(os.environ.pop, "LIPSYNC_LANG_CACHE")
        sizes = (max(EDITED, lines // 5), lines)
        made = [
            Script(Path(folder) / f"{size}", size, outputs, timed=timed)
            for size in dict.fromkeys(sizes)
        ]
        run(command("build", "--dry-run"), folder=made[0].folder)  # packs and bytecode are read
        yield made


def _cold(
    figures: Figures, name: str, made: Sequence[Script], *options: str, goal: float | None = None
) -> float:
    """Build everything anew, at both sizes; return the seconds of a line."""
    ended: list[Ended] = []
    for script in made:
        script.clear()
        say(f"{script.lines:,} lines, {name}")
        ended.append(script.build(*options, expected=script.lines))
    each, fixed = _fit(made, [one.seconds for one in ended])
    processor, _ = _fit(made, [one.cpu_seconds for one in ended])
    lines = made[-1].lines
    figures.row(
        f"{lines:,} lines, {name}",
        ended[-1].seconds,
        goal=goal if lines == WHOLE else None,
        peak_mb=ended[-1].peak_mb,
        more={"lines/s": 1 / each, "s to start": fixed, "ms CPU a line": processor * 1e3},
    )
    if lines != WHOLE and goal:
        figures.row(f"{WHOLE:,} lines, {name}, estimated", fixed + WHOLE * each, goal=goal)
    return each


def _planned(made: Sequence[Script]) -> float:
    """Return the seconds that an unchanged line takes, in a process that has all at hand."""
    seconds = []
    for script in made:
        with chdir(script.folder), redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            seconds.append(best(lambda: main(["build", "--workers", "1"]), 5))
    return _fit(made, seconds)[0]


def _planned_kilobytes(made: Sequence[Script]) -> float:
    """Return the memory of a line while it is planned, with the record of its last build."""
    held = []
    for script in made:
        tracemalloc.start()
        opened = ProjectBuild.open(script.folder / "lipsync.yaml")
        with Records.open(script.folder) as records:
            plan = opened.plan(records)
            held.append(tracemalloc.get_traced_memory()[0] / 1e3)
        tracemalloc.stop()
        del opened, plan
    return _fit(made, held)[0]


def _again(figures: Figures, script: Script, expected: int, workers: int, planned: float) -> None:
    """Build once more; `planned` is the time that each further line would take."""
    if expected:
        script.edit(0.4 + workers / 10)
    ended = script.build("--workers", str(workers), expected=expected)
    name = f"{expected} edited" if expected else "no change"
    name, goal = f"{name}, {_named(workers)}", GOAL_EDITED_SECONDS if expected else None
    figures.row(
        f"{script.lines:,} lines, {name}",
        ended.seconds,
        goal=goal if script.lines == WHOLE else None,
        peak_mb=ended.peak_mb,
    )
    if script.lines != WHOLE and goal:
        whole = ended.seconds + planned * (WHOLE - script.lines)
        figures.row(f"{WHOLE:,} lines, {name}, estimated", whole, goal=goal)


def _fit(made: Sequence[Script], seconds: Sequence[float]) -> tuple[float, float]:
    """Return the seconds of a line, and those that do not depend on the number of lines."""
    if len(made) == 1:
        return seconds[0] / made[0].lines, 0.0
    each = (seconds[1] - seconds[0]) / (made[1].lines - made[0].lines)
    if each <= 0:  # another program had the processor
        return seconds[1] / made[1].lines, 0.0
    return each, max(0.0, seconds[0] - each * made[0].lines)


def _named(workers: int) -> str:
    return f"{workers} worker{'s' * (workers > 1)}"


def build(figures: Figures, options: Namespace) -> None:
    """Lines with timings to CSV and GLB: all of them, those of an edited bigram (50), and none."""
    with scripts(options.lines, ("csv", "glb")) as made:
        for workers in (1, 2):
            goal = GOAL_SECONDS if workers == 2 else None
            _cold(figures, f"cold, {_named(workers)}", made, "--workers", str(workers), goal=goal)
            if workers == 1:
                planned = _planned(made)
                figures.row("planning, for each line", planned)
                figures.row("memory to plan, for each line", _planned_kilobytes(made), "kB")
            for expected in (EDITED, 0):
                _again(figures, made[-1], expected, workers, planned)
        for name in (*made[-1].outputs, ".lipsync_lang/build.sqlite"):
            size = made[-1].kilobytes(name, lambda path: path.stat().st_size)
            figures.row(f"{Path(name).name} for each line", size, "kB")
        packed = made[-1].kilobytes("csv", lambda path: len(compress(path.read_bytes())))
        figures.row("csv in an archive, for each line", packed, "kB")
    with scripts(options.lines, ("csv",)) as made:
        _cold(figures, "CSV alone, cold, 2 workers", made, "--workers", "2")


def spoken(figures: Figures, options: Namespace) -> None:
    """Lines of text, spoken by eSpeak, to CSV."""
    with scripts(options.lines, ("csv",), timed=False) as made:
        for workers in (1, 2):
            goal = GOAL_SPOKEN_SECONDS if workers == 2 else None
            _cold(figures, f"spoken, {_named(workers)}", made, "--workers", str(workers), goal=goal)


# A cluster


@contextmanager
def _dask(*arguments: str, says: str) -> Iterator[str]:
    """Run a program of Dask; yield the first group of what it says."""
    with subprocess.Popen(  # noqa: S603 our own commands
        [sys.executable, "-m", "dask", *arguments], stderr=subprocess.PIPE, text=True
    ) as started:
        errors = started.stderr
        try:
            found = next((m for line in errors or () if (m := re.search(says, line))), None)
            if found is None:
                raise BuildError(
                    "Dask does not start; it needs pip install 'lipsync-lang[cluster]'"
                )
            if errors is not None:
                threading.Thread(target=errors.read, daemon=True).start()
            yield found[1]
        finally:
            started.kill()


def dask(figures: Figures, options: Namespace) -> None:
    """Lines with timings to CSV and GLB by the workers of a Dask cluster on this machine."""
    rates = []
    with scripts(options.lines, ("csv", "glb")) as made:
        for workers in (1, 2):
            with ExitStack() as stack:
                say(f"a Dask scheduler and {_named(workers)} start")
                host = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
                scheduler = stack.enter_context(
                    _dask("scheduler", *host, says=r"Scheduler at:\s+(tcp://\S+)")
                )
                single = ("--nthreads", "1", "--no-nanny", "--no-dashboard")
                for _ in range(workers):
                    stack.enter_context(_dask("worker", scheduler, *single, says="(Registered to)"))
                made[0].clear()
                made[0].build("--scheduler", scheduler, expected=made[0].lines)  # workers import
                name = f"cold, {_named(workers)} of Dask"
                rates.append(1 / _cold(figures, name, made, "--scheduler", scheduler))
    figures.row("two Dask workers against one", rates[1] / rates[0], "x", goal=1.7)
