"""Print how long coverage of a large corpus takes, and how much memory, beside their goals.

python benchmarks/coverage.py FILE [--lines N] [--language NAME] [--character NAME]

The lines of the file, such as the Harvard sentences, are repeated until there are enough.
"""

import argparse
import os
import resource
import sys
import time
from collections.abc import Iterator
from itertools import cycle, islice
from pathlib import Path

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

from lipsync_lang.reports.coverage import coverage
from lipsync_lang.text.lines import Line, read_lines

GOAL_SECONDS, GOAL_MEMORY = 60, 500
"""For 10,000 lines; the memory for any number."""


def repeated(path: Path, number: int) -> Iterator[Line]:
    """Yield so many lines, the file's over and over."""
    yield from islice(cycle(list(read_lines([path]))), number)


def memory() -> float:
    """Return the most memory used so far, in MB: this process and the largest it started."""
    kinds = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    return sum(resource.getrusage(kind).ru_maxrss for kind in kinds) / 1024


def main() -> int:
    """Count, and say how long it took."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("file", type=Path)
    parser.add_argument("--lines", type=int, default=10_000)
    parser.add_argument("--language", default="english")
    parser.add_argument("--character", default="facefx")
    options = parser.parse_args()
    start = time.perf_counter()
    found = coverage(repeated(options.file, options.lines), options.language, options.character)
    seconds = time.perf_counter() - start
    report, goal = found.reports[0], GOAL_SECONDS * options.lines / 10_000
    print(f"{report.lines:,} lines, {report.occurrences:,} bigrams of {len(report.bigrams)} kinds")
    print(f"{seconds:.1f} s (goal {goal:g}), {memory():.0f} MB (goal {GOAL_MEMORY})")
    return int(seconds > goal or memory() > GOAL_MEMORY)


if __name__ == "__main__":
    sys.exit(main())
