"""Figures of a benchmark: measured, printed as they are found, and kept as JSON.

Values are seconds, MB and kB. Every row has the time of an empty loop, taken beside it: where that
differs, so did the speed of the machine.
"""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

LOOP = 3_000_000
"""Numbers that the empty loop adds up."""

MB = 1024 if sys.platform != "darwin" else 1024**2
"""Units of `ru_maxrss` in a MB."""

SECONDS = 0.4
"""Time for which a call is repeated."""

HEAD = f"{'':<46}{'figure':>11}{'no kernel':>12}{'goal':>11}{'peak':>9}{'loop':>8}"


@dataclass(frozen=True)
class Row:
    """A measured figure."""

    section: str
    name: str
    value: float
    unit: str = "s"
    plain: float | None = None
    """The figure without the compiled kernel."""
    goal: float | None = None
    peak_mb: float | None = None
    """Memory of the largest process."""
    loop_s: float = 0.0
    """Time of the empty loop."""
    more: Mapping[str, float] = field(default_factory=dict)
    """Further figures, by their unit."""

    def __str__(self) -> str:
        peak = "" if self.peak_mb is None else f"{self.peak_mb:.0f} MB"
        more = "; ".join(f"{value:,.4g} {unit}" for unit, value in self.more.items())
        figures = [shown(one, self.unit) for one in (self.value, self.plain, self.goal)]
        cells = "{:>11}{:>12}{:>11}".format(*figures)
        return f"{self.name:<46}{cells}{peak:>9}{self.loop_s:>6.2f} s  {more}".rstrip()


def shown(value: float | None, unit: str) -> str:
    """Format a figure; seconds as us, ms or s."""
    if value is None:
        return ""
    scale = 1.0
    if unit == "s":
        unit, scale = ("us", 1e6) if value < 1e-3 else ("ms", 1e3) if value < 1 else ("s", 1)
    return f"{value * scale:,.4g} {unit}".strip()


class Figures:
    """The rows of a section; each is printed, and appended to a file, as it comes."""

    def __init__(self, section: str, file: Path) -> None:
        self.section, self.file = section, file

    def row(  # noqa: PLR0913 the columns
        self,
        name: str,
        value: float,
        unit: str = "s",
        *,
        plain: float | None = None,
        goal: float | None = None,
        peak_mb: float | None = None,
        more: Mapping[str, float] | None = None,
    ) -> None:
        """Add a row."""
        made = Row(self.section, name, value, unit, plain, goal, peak_mb, loop(), more or {})
        print(made, flush=True)
        with self.file.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(asdict(made)) + "\n")


def read_rows(file: Path) -> list[Row]:
    """Return the rows that processes have appended to a file."""
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    return [Row(**json.loads(line)) for line in lines]


def say(text: str) -> None:
    """Print the name of a measurement on stderr while it runs."""
    print(f"  ... {text}", file=sys.stderr, flush=True)


# Measuring


def loop() -> float:
    """Return the seconds of the empty loop."""
    start = time.perf_counter()
    sum(range(LOOP))
    return time.perf_counter() - start


def best(
    act: Callable[..., object], runs: int = 300, given: Callable[[], object] | None = None
) -> float:
    """Return the least seconds of some runs, after one that is not counted.

    Parameters
    ----------
    given : makes the argument of each run, outside its time; None for no argument
    """
    act(*(() if given is None else (given(),)))
    least, begun, number = float("inf"), time.perf_counter(), 0
    while number < 3 or (number < runs and time.perf_counter() - begun < SECONDS):
        arguments = () if given is None else (given(),)
        start = time.perf_counter()
        act(*arguments)
        least = min(least, time.perf_counter() - start)
        number += 1
    return least


@contextmanager
def no_kernel() -> "Iterator[None]":
    """Run the stages in numpy, as LIPSYNC_LANG_KERNEL=off does."""
    from lipsync_lang.pipeline import kernel

    compiled, kernel.compiled = kernel.compiled, None
    try:
        yield
    finally:
        kernel.compiled = compiled


def both(
    act: Callable[..., object], runs: int = 300, given: Callable[[], object] | None = None
) -> tuple[float, float | None]:
    """Time a call with the compiled kernel, where there is one, and without it; see `best`."""
    from lipsync_lang.pipeline import kernel

    with no_kernel():
        plain = best(act, runs, given)
    return (plain, None) if kernel.compiled is None else (best(act, runs, given), plain)


def own_peak() -> float:
    """Return the most memory of this process so far, in MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MB


@dataclass(frozen=True)
class Ended:
    """A process that has ended, with those that it started."""

    seconds: float
    cpu_seconds: float
    """Time of processors, those of the processes that it started included."""
    peak_mb: float
    code: int
    error: str


LAUNCHER = """
import os, sys, time
start = time.perf_counter()
process = os.posix_spawn(sys.executable, [sys.executable, *sys.argv[2:]], os.environ)
_, status, used = os.wait4(process, 0)
seconds = time.perf_counter() - start
code = os.waitstatus_to_exitcode(status)
with open(sys.argv[1], "w") as out:
    print(code, seconds, used.ru_utime + used.ru_stime, used.ru_maxrss, file=out)
"""
"""A small process that starts a command: its peak would count as that of the command."""


def run(
    command: Sequence[str],
    *,
    folder: Path | None = None,
    told: Callable[[str], None] = lambda _line: None,
    **environment: str,
) -> Ended:
    """Run a Python command to its end; `told` gets each line of its stdout."""
    with tempfile.TemporaryDirectory() as beside:
        used, errors = Path(beside) / "used", Path(beside) / "errors"
        with (
            errors.open("w", encoding="utf-8") as stream,
            subprocess.Popen(  # noqa: S603 our own commands
                [sys.executable, "-I", "-S", "-c", LAUNCHER, str(used), *command],
                cwd=folder,
                env={**os.environ, **environment},
                stdout=subprocess.PIPE,
                stderr=stream,
                text=True,
            ) as process,
        ):
            for line in process.stdout or ():
                told(line)
        code, seconds, spent, peak = used.read_text("utf-8").split()
        error = errors.read_text("utf-8")
        return Ended(float(seconds), float(spent), int(peak) / MB, int(code), error)


def command(*arguments: str) -> list[str]:
    """Return a call of our command."""
    return ["-m", "lipsync_lang", *arguments]
