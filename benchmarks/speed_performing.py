"""Sections of the benchmark in one thread: utterances, batches, streams, and commands."""

import json
import tempfile
import time
from argparse import Namespace
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path

import numpy as np
from speed_table import Figures, best, both, command, no_kernel, own_peak, run

import lipsync_lang as ll
from lipsync_lang.pipeline import kernel

PAIR = ("english", "facefx")
LABELS = "HH AH L OW W ER L D P L IY Z B AY F AY V M AO R".split()  # noqa: SIM905 readable

LENGTH_SECONDS = 0.083
"""Length of a phoneme, as in running speech."""

SENTENCE = 40
"""Phonemes of a sentence, its pause among them."""

GOAL_AT_ONCE, GOAL_ALONE = 20e-6, 30e-6
"""Seconds of one of 1,000 utterances, in a batch and alone."""

GOALS = {10: 70e-6, 40: 100e-6, 2_560: 3e-3, 100_000: 100e-3}
"""Seconds of one utterance by its phonemes."""

FPS = 60


def schedule(count: int, seed: int = 0) -> ll.Schedule:
    """Make phonemes of uneven length, with a pause at the end of each sentence."""
    labels = [
        "_" if i % SENTENCE == SENTENCE - 1 else LABELS[(i + seed) % len(LABELS)]
        for i in range(count)
    ]
    lengths = LENGTH_SECONDS * (0.6 + 0.8 * np.random.default_rng((count, seed)).random(count))
    times = np.concatenate(([0.0], np.cumsum(lengths)))
    return ll.Schedule(tuple(labels), times, notation="arpabet")


def utterance(figures: Figures, _options: Namespace) -> None:
    """Measure one utterance of 10 to 100,000 phonemes at 60 frames per second."""
    performer = ll.resolve(*PAIR)
    found: dict[int, tuple[float, float | None]] = {}
    for count in (10, 40, 100, 1_000, 2_560, 10_000, 100_000):
        line = schedule(count)
        # a new one each time, since the labels of a known schedule are cached
        found[count] = both(partial(performer.perform, fps=FPS), given=partial(replace, line))
        seconds, plain = found[count]
        figures.row(f"{count:,} phonemes", seconds, plain=plain, goal=GOALS.get(count))
    long = [count for count in found if count >= 1_000]
    spent = [[found[count][way] for count in long] for way in (0, 1)]
    fitted = [None if None in one else exponent(long, one) for one in spent]  # type: ignore[arg-type]
    figures.row("growth exponent from 1,000", fitted[0] or inf, "", plain=fitted[1], goal=1.02)
    figures.row("peak memory", own_peak(), "MB")


def exponent(counts: list[int], seconds: list[float]) -> float:
    """Return k of seconds ~ counts**k, fitted to the logarithms."""
    return float(np.polyfit(np.log(counts), np.log(seconds), 1)[0])


def batch(figures: Figures, _options: Namespace) -> None:
    """1,000 new utterances of 40 phonemes at once, and one by one."""
    performer = ll.resolve(*PAIR)
    lines = [schedule(SENTENCE, seed) for seed in range(1_000)]
    for name, act, runs, goal in (
        ("perform_many", lambda new: performer.perform_many(new, FPS), 5, GOAL_AT_ONCE),
        ("perform", lambda new: [performer.perform(line, FPS) for line in new], 3, GOAL_ALONE),
    ):
        spent, plain = both(act, runs, given=lambda: list(map(replace, lines)))
        figures.row(f"each of 1,000, {name}", spent / 1e3, plain=plain and plain / 1e3, goal=goal)
    figures.row("peak memory", own_peak(), "MB")


# Streams


def played(performer: ll.Performer, line: ll.Schedule, ahead: float) -> tuple[np.ndarray, float]:
    """Play a stream frame by frame; return the (T, 2) seconds of each, and the longest wait.

    Seconds are those of the clock and of the processor: other programs cost the first alone.

    The wait of a frame is the time from its own until it is final.

    Parameters
    ----------
    ahead : seconds before its start from which a phoneme is known
    """
    stream = performer.stream(FPS, notation="arpabet")
    rows = list(zip(line.labels, line.times.tolist(), line.times[1:].tolist(), strict=False))
    spent, wait, at = [], 0.0, 0
    for frame in range(int(line.times[-1] * FPS)):
        now = frame / FPS
        start, begun = time.perf_counter(), time.thread_time()
        while at < len(rows) and rows[at][1] <= now + ahead:
            stream.feed(*rows[at])
            at += 1
        if at == len(rows) and not stream.finished:
            stream.finish()
        stream.frames()
        spent.append((time.perf_counter() - start, time.thread_time() - begun))
        wait = max(wait, now - (stream.final_until or 0.0))
    return np.array(spent), wait


def stream(figures: Figures, _options: Namespace) -> None:
    """A minute of speech, one frame at a time, at 60 frames per second."""
    performer = ll.resolve(*PAIR)
    line = schedule(16 * SENTENCE)
    made = performer.stream(FPS)
    figures.row("delay, sum of the stages", made.delay, more=dict(made.delays))
    for name, ahead in (("known at its start", 0.0), ("known a second ahead", 1.0)):
        found = []
        for switch in (nullcontext, no_kernel):
            with switch():
                tries = [played(performer, line, ahead) for _ in range(3)]
            parts = [np.percentile(one, (50, 99, 100), axis=0) for one, _ in tries]
            found.append(np.min(parts, axis=0).tolist())
        for at, (part, goal) in enumerate((("median", None), ("p99", 300e-6), ("worst", None))):
            seconds, processor = found[0][at]
            plain = found[1][at][0] if kernel.compiled is not None else None
            figures.row(
                f"phoneme {name}: {part}",
                seconds,
                plain=plain,
                goal=goal,
                more={"us CPU": processor * 1e6},
            )
        figures.row(f"phoneme {name}: added delay", tries[0][1], goal=0.0 if ahead else None)
    figures.row("peak memory", own_peak(), "MB")


# Processes


RESOLVE = """
import time; start = time.perf_counter()
import lipsync_lang as ll; there = time.perf_counter()
ll.resolve(*{pair!r}); once = time.perf_counter()
print(there - start, once - there)
"""


def resolve(figures: Figures, _options: Namespace) -> None:
    """Resolve a language on a character: in a new process, and again."""
    with tempfile.TemporaryDirectory() as folder:
        for name, cache, goal in (
            ("new process, no cache", "off", 3.0),
            ("new process, warm cache", folder, None),
        ):
            seconds, peak = [], 0.0
            for _ in range(4 if cache == folder else 2):
                told: list[str] = []
                code = ["-c", RESOLVE.format(pair=PAIR)]
                peak = run(code, told=told.append, LIPSYNC_LANG_CACHE=cache).peak_mb
                seconds.append([float(one) for one in told[0].split()])
            there, once = (min(one) for one in zip(*seconds, strict=True))
            figures.row(name, once, goal=goal, peak_mb=peak, more={"s to import": there})
    again = best(lambda: ll.resolve(*PAIR), 30)
    figures.row("same process, warm cache", again, goal=20e-3)


def start(figures: Figures, _options: Namespace) -> None:
    """Whole commands, from the shell's view."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "line.json"
        line = schedule(3 * SENTENCE)
        rows = zip(line.labels, line.times, line.times[1:], strict=False)
        phonemes = [{"label": label, "start": start, "end": end} for label, start, end in rows]
        file.write_text(json.dumps({"notation": "arpabet", "phonemes": phonemes}), "utf-8")
        out = str(Path(folder) / "line.csv")
        timed = ("run", "--schedule", str(file), "-l", PAIR[0], "-c", PAIR[1], "-o", out)
        for name, arguments, goal in (
            ("--version", ("--version",), None),
            ("--help", ("--help",), 0.3),
            (f"run, {3 * SENTENCE} timed phonemes to CSV", timed, 0.8),
        ):
            tries = [run(command(*arguments), LIPSYNC_LANG_CACHE=folder) for _ in range(5)]
            least = min(tries, key=lambda one: one.seconds)
            figures.row(name, least.seconds, goal=goal, peak_mb=least.peak_mb)


def hour(figures: Figures, _options: Namespace) -> None:
    """An hour of speech as one utterance."""
    performer, line = ll.resolve(*PAIR), schedule(int(3600 / LENGTH_SECONDS))
    seconds = best(lambda: performer.perform(line, FPS), 3)
    figures.row(f"{len(line.labels):,} phonemes", seconds, peak_mb=own_peak())
    figures.row("peak memory", own_peak(), "MB", goal=300)
