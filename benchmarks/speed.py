"""Print how fast things are: medians on one core, beside their goals.

python benchmarks/speed.py [--quick]
"""

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1")
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})

import numpy as np

import lipsync_lang as ll

LABELS = [
    "HH",
    "AH",
    "L",
    "OW",
    "W",
    "ER",
    "L",
    "D",
    "P",
    "L",
    "IY",
    "Z",
    "B",
    "AY",
    "F",
    "AY",
    "V",
    "M",
    "AO",
    "R",
]
LENGTH = 0.083
"""Seconds of a phoneme, as in running speech."""


def schedule(count: int) -> ll.Schedule:
    """Make a schedule of some phonemes of uneven length, with a pause now and then."""
    labels = [("_" if i % 40 == 39 else LABELS[i % len(LABELS)]) for i in range(count)]
    lengths = LENGTH * (0.6 + 0.8 * np.random.default_rng(count).random(count))
    times = np.concatenate(([0.0], np.cumsum(lengths)))
    return ll.Schedule(tuple(labels), times, notation="arpabet")


def median(act: Callable[[], object], runs: int) -> float:
    """Return the median seconds of some runs, after one that is not counted."""
    act()
    spent = []
    for _ in range(runs):
        start = time.perf_counter()
        act()
        spent.append(time.perf_counter() - start)
    return float(np.median(spent))


def show(what: str, seconds: float, goal: float | None = None) -> None:
    """Print one row."""
    unit, scale = ("us", 1e6) if seconds < 1e-3 else ("ms", 1e3) if seconds < 1 else ("s", 1)
    wanted = f"{goal * scale:>10.5g} {unit}" if goal else ""
    print(f"{what:<44}{seconds * scale:>10.1f} {unit:<3}{wanted}", flush=True)


def performing(performer: ll.Performer, *, quick: bool) -> None:
    """Time performances of growing length, 60 frames per second."""
    goals = {40: 300e-6, 2_560: 15e-3}
    spent = {}
    for count in (40, 160, 640, 2_560, 10_240, 40_960, 100_000):
        if quick and count > 10_240:
            break
        line = schedule(count)
        runs = max(3, min(300, 400_000 // count // 10))
        spent[count] = median(lambda line=line: performer.perform(line), runs)
        show(f"perform {count:,} phonemes", spent[count], goals.get(count))
    long = [n for n in spent if n >= 2_560]
    slope = np.polyfit(np.log(long), np.log([spent[n] for n in long]), 1)[0]
    print(f"{'exponent of growth from 2,560 phonemes':<44}{slope:>10.2f}    {1.05:>10}")


def command(*arguments: str, **environment: str) -> Callable[[], object]:
    """Return a whole process to time."""
    whole = [sys.executable, "-m", "lipsync_lang.cli", *arguments]
    kept = {**os.environ, **environment}
    return lambda: subprocess.run(whole, check=True, capture_output=True, env=kept)  # noqa: S603


def processes() -> None:
    """Time whole commands."""
    with tempfile.TemporaryDirectory() as folder:
        line = Path(folder) / "line.json"
        rows = schedule(120)
        phonemes = [
            f'{{"label": "{label}", "start": {start:.4f}, "end": {end:.4f}}}'
            for label, start, end in zip(rows.labels, rows.times, rows.times[1:], strict=False)
        ]
        line.write_text('{"phonemes": [' + ", ".join(phonemes) + "]}", encoding="utf-8")
        pair = ("-l", "english", "-c", "facefx")
        to_csv = ("run", "--schedule", str(line), *pair, "-o", str(Path(folder) / "line.csv"))
        show("lipsync-lang --help, whole process", median(command("--help"), 7), 0.3)
        warm = command(*to_csv, LIPSYNC_LANG_CACHE=folder)
        show("run --schedule to CSV, whole process, warm", median(warm, 7), 0.8)
        cold = command(*to_csv, LIPSYNC_LANG_CACHE="off")
        show("run --schedule to CSV, whole process, cold", median(cold, 3))


def hour() -> None:
    """Perform an hour of speech in a process of its own, and print its peak memory."""
    count = int(3600 / LENGTH)
    code = (
        "import resource, runpy, sys, lipsync_lang as ll; speed = runpy.run_path(sys.argv[1]);"
        f"ll.resolve('english', 'facefx').perform(speed['schedule']({count}));"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)"
    )
    done = subprocess.run(  # noqa: S603
        [sys.executable, "-c", code, __file__], check=True, capture_output=True, text=True
    )
    peak = int(done.stdout) / (1024 if sys.platform != "darwin" else 1024**2)
    print(f"{'an hour of speech, peak memory':<44}{peak:>10.0f} MB {300:>10} MB")


def main() -> None:
    """Print the table."""
    print(f"{'':<44}{'median':>10}    {'goal':>10}")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["LIPSYNC_LANG_CACHE"] = folder
        start = time.perf_counter()
        performer = ll.resolve("english", "facefx")
        show("resolve, cold", time.perf_counter() - start, 3.0)
        show("resolve, warm", median(lambda: ll.resolve("english", "facefx"), 30), 20e-3)
    performing(performer, quick="--quick" in sys.argv)
    processes()
    hour()
    used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    print(f"{'this process, peak memory':<44}{used:>10} MB")


if __name__ == "__main__":
    main()
