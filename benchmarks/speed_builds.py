"""Sections of the benchmark on whole builds: from timings, from text, and on a Dask cluster."""

import re
import subprocess
import sys
import threading
import tracemalloc
from argparse import Namespace
from collections.abc import Iterator
from contextlib import ExitStack, chdir, contextmanager, redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from zlib import compress

from speed_script import EDITED, BuildError, Script, script
from speed_table import Figures, best, say

from lipsync_lang.cli import main
from lipsync_lang.production.builds.project_build import ProjectBuild
from lipsync_lang.production.builds.records import Records

WHOLE = 10_000
"""Lines of the goals."""

GOAL_SECONDS, GOAL_SPOKEN_SECONDS, GOAL_EDITED_SECONDS = 60.0, 90.0, 2.0
"""Goals on two cores: from timings to CSV and GLB, from text to CSV, after an edited bigram."""

Cold = tuple[float, float]
"""Lines a second of a build, and its seconds of processors."""

MAX_ALIGNED = 120
"""Lines to align at most: each takes some 0.2 s."""

GOAL_TWO_WORKERS = 1.8
"""Goal of two workers against one, on two idle cores."""


def _cold(
    figures: Figures, name: str, made: Script, *options: str, goal: float | None = None
) -> Cold:
    """Build everything again."""
    made.clear()
    say(f"{made.lines:,} lines, {name}")
    ended, rate = made.build(*options, expected=made.lines)
    start = max(0.0, ended.seconds - made.lines / rate)
    figures.row(
        f"{made.lines:,} lines, {name}",
        ended.seconds,
        goal=goal if made.lines == WHOLE else None,
        peak_mb=ended.peak_mb,
        more={
            "lines/s": rate,
            "s to start": start,
            "ms CPU a line": 1e3 * ended.cpu_seconds / made.lines,
        },
    )
    if made.lines != WHOLE and goal:
        figures.row(f"{WHOLE:,} lines, {name}, estimated", start + WHOLE / rate, goal=goal)
    return rate, ended.cpu_seconds


def _beside(figures: Figures, what: str, one: Cold, two: Cold) -> None:
    """Compare two workers with one, which needs idle processors; their work in all does not."""
    more = {"of the CPU time": two[1] / one[1]}
    figures.row(f"two {what} against one", two[0] / one[0], "x", goal=GOAL_TWO_WORKERS, more=more)


def _planned(made: Script) -> float:
    """Return the seconds of a build without a change, in a process that has all at hand."""
    with chdir(made.folder), redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        return best(lambda: main(["build", "--workers", "1"]), 5)


def _planned_kilobytes(made: Script) -> float:
    """Return the memory of all lines while they are planned, with the record of the last build."""
    tracemalloc.start()
    opened = ProjectBuild.open(made.folder / "lipsync.yaml")
    with Records.open(made.folder) as records:
        plan = opened.plan(records)
        kilobytes = tracemalloc.get_traced_memory()[0] / 1e3
    tracemalloc.stop()
    del plan
    return kilobytes


def _planning(figures: Figures, made: Script) -> float:
    """Measure what planning takes for each line, beside a project of few; return the seconds."""
    with script(EDITED, made.outputs) as few:
        few.build("--workers", "1", expected=few.lines)
        more = made.lines - few.lines
        seconds = max(0.0, _planned(made) - _planned(few)) / more
        kilobytes = (_planned_kilobytes(made) - _planned_kilobytes(few)) / more
    figures.row("planning, for each line", seconds)
    figures.row("memory to plan, for each line", kilobytes, "kB")
    return seconds


def _again(figures: Figures, made: Script, expected: int, workers: int, planned: float) -> None:
    """Build once more; `planned` is the time that each further line would take."""
    if expected:
        made.edit(0.4 + workers / 10)
    ended, _ = made.build("--workers", str(workers), expected=expected)
    name = f"{expected} edited" if expected else "no change"
    name, goal = f"{name}, {_named(workers)}", GOAL_EDITED_SECONDS if expected else None
    figures.row(
        f"{made.lines:,} lines, {name}",
        ended.seconds,
        goal=goal if made.lines == WHOLE else None,
        peak_mb=ended.peak_mb,
    )
    if made.lines != WHOLE and goal:
        whole = ended.seconds + planned * (WHOLE - made.lines)
        figures.row(f"{WHOLE:,} lines, {name}, estimated", whole, goal=goal)


def _named(workers: int) -> str:
    return f"{workers} worker{'s' * (workers > 1)}"


def build(figures: Figures, options: Namespace) -> None:
    """Lines with timings to CSV and GLB: all of them, those of an edited bigram (50), and none."""
    planned, colds = 0.0, []
    with script(options.lines, ("csv", "glb")) as made:
        for workers in (1, 2):
            goal = GOAL_SECONDS if workers == 2 else None
            name = f"cold, {_named(workers)}"
            colds.append(_cold(figures, name, made, "--workers", str(workers), goal=goal))
            planned = planned or _planning(figures, made)
            for expected in (EDITED, 0):
                _again(figures, made, expected, workers, planned)
        _beside(figures, "workers", *colds)
        for name in (*made.outputs, ".lipsync_lang/build.sqlite"):
            size = made.kilobytes(name, lambda path: path.stat().st_size)
            figures.row(f"{Path(name).name} for each line", size, "kB")
        packed = made.kilobytes("csv", lambda path: len(compress(path.read_bytes())))
        figures.row("csv in an archive, for each line", packed, "kB")
    with script(options.lines, ("csv",)) as made:
        names = {workers: f"CSV alone, cold, {_named(workers)}" for workers in (1, 2)}
        found = [_cold(figures, name, made, "--workers", f"{n}") for n, name in names.items()]
        _beside(figures, "workers of CSV alone", *found)


def spoken(figures: Figures, options: Namespace) -> None:
    """Lines of text, spoken by eSpeak, to CSV."""
    _untimed(figures, options, "spoken", "a voice", goal=GOAL_SPOKEN_SECONDS)


def aligned(figures: Figures, options: Namespace) -> None:
    """Lines of text with their recordings, aligned, to CSV."""
    _untimed(figures, options, "aligned", "recordings", most=MAX_ALIGNED)


def _untimed(  # noqa: PLR0913 a section and its project
    figures: Figures,
    options: Namespace,
    told: str,
    by: str,
    *,
    goal: float | None = None,
    most: int = WHOLE,
) -> None:
    """Build lines without timings by one worker and by two."""
    found = []
    with script(min(options.lines, most), ("csv",), by=by) as made:
        for workers in (1, 2):
            name, own_goal = f"{told}, {_named(workers)}", goal if workers == 2 else None
            own = "--workers", str(workers), "--force"  # no timings of the build before
            found.append(_cold(figures, name, made, *own, goal=own_goal))
    _beside(figures, "workers", *found)


# A cluster


@contextmanager
def _dask(*arguments: str, says: str) -> Iterator[str]:
    """Run a program of Dask; yield the first group of a pattern in its output."""
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
    found = []
    with script(options.lines, ("csv", "glb")) as made:
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
                name = f"cold, {_named(workers)} of Dask"
                found.append(_cold(figures, name, made, "--scheduler", scheduler))
    figures.row("two Dask workers against one", found[1][0] / found[0][0], "x", goal=1.7)
