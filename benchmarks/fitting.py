"""Fit a pose set to recordings of real mouths, each tested on a recording that its fit did not see.

    python benchmarks/fitting.py FOLDER [-c facefx] [--json FILE]

FOLDER is that of `articulography.py`. One recording after the other is left out. The fit to the
others judges itself by cross-validation, as `bank fit` does; its items are accepted by a character,
and that character performs the recording that was left out. A fit that does not generalise changes
nothing. The shipped targets were tuned on these recordings, the one left out among them: so
"before" has seen what "after" has not.

Then a face with known targets, which differ from the shipped ones at random, says ten minutes of
random sounds, with errors of 10 ms in the timings and of 0.02 in the weights. The fit is timed, and
its curves are compared with the true ones on timings without errors.
"""

import argparse
import os
import sys
import time
from contextlib import chdir
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import articulography
import json_figures
import numpy as np

import lipsync_lang as ll
from lipsync_lang.packs.library import Library
from lipsync_lang.performing.performer import Performer
from lipsync_lang.plugins.capture.accept_fit import accept_fit
from lipsync_lang.plugins.capture.capture_reading import read_captures
from lipsync_lang.plugins.capture.fit_captures import CaptureFit, fit_captures
from lipsync_lang.plugins.capture.fit_lines import CapturedLine, lay_lines
from lipsync_lang.plugins.capture.fit_values import FitFace
from lipsync_lang.resolver.retouch import OpenPair

CHARACTER = "kind: character\nformat: 1\nname: fitted\nposeset: {}\n"
SOUNDS = (
    "M P B F V TH DH T D N S Z SH CH JH L R K G NG HH W Y "
    "IY IH EH AE AA AO UH UW AH ER EY AY OW AW OY"
)
MINUTES, FPS = 10, 60
JITTER_SECONDS, NOISE = 0.01, 0.02
LEAST_SECONDS = 0.015


def open_pair(language: str, poseset: str) -> tuple[OpenPair, Performer]:
    """Return a pair with its packs, and its performer."""
    pair = OpenPair.open(Library(project=None), language, poseset)
    return pair, Performer(pair.compiled, pair.compiled.motion)


def accepted(fit: CaptureFit, poseset: str) -> Performer:
    """Return the performer of a character that accepts a fit, whatever the confidence of items."""
    with TemporaryDirectory() as folder, chdir(folder):
        path = Path("characters/fitted.yaml")
        path.parent.mkdir()
        path.write_text(CHARACTER.format(poseset), encoding="utf-8")
        if fit.proposal.verdict.accepted:
            accept_fit(Library(), fit.proposal, "fitted", every=True, confidence=0)
        return ll.resolve(articulography.LANGUAGE, "fitted", cache=False)


def leave_one_out(folder: Path, poseset: str) -> dict[str, dict[str, list[float]]]:
    """Print and return r before and after, by measure."""
    pair, performer = open_pair(articulography.LANGUAGE, poseset)
    lines = read_captures(performer, folder, readout=articulography.READ_OUT).lines
    kept: dict[str, dict[str, list[float]]] = {}
    print(f"{poseset}, each recording by the fit to the others: r before and after")
    for left in lines:
        fit = fit_captures(pair, performer, [line for line in lines if line is not left])
        after = accepted(fit, poseset)
        print(f"  {left.name}\n    {fit.proposal.verdict.why}")
        for number, measure in enumerate(left.signals):
            signal, gains = left.values[:, number], performer.compiled.measures[measure]
            both = [
                articulography.correlate(
                    who.perform(left.schedule, articulography.FPS), gains, signal, left.times
                )
                for who in (performer, after)
            ]
            print(f"    {measure:<12}{both[0]:8.3f}{both[1]:8.3f}")
            found = kept.setdefault(measure, {"before": [], "after": []})
            found["before"].append(both[0])
            found["after"].append(both[1])
    for measure, found in kept.items():
        before, after = np.mean(found["before"]), np.mean(found["after"])
        print(f"  mean of {measure:<12}{before:8.3f}{after:8.3f}")
    print(f"  mean of all         {_mean(kept, 'before'):8.4f}{_mean(kept, 'after'):8.4f}")
    return kept


def _mean(kept: dict[str, dict[str, list[float]]], side: str) -> float:
    return float(np.mean([found[side] for found in kept.values()]))


def random_lines(random: np.random.Generator, count: int, sounds: int = 38) -> list[ll.Schedule]:
    """Return lines of some four seconds."""
    return [
        ll.Schedule(
            ["_", *random.choice(SOUNDS.split(), sounds), "_"],
            np.concatenate(([0, 0.3], 0.3 + np.cumsum(lengths), [0.6 + lengths.sum()])),
            notation="arpabet",
        )
        for lengths in random.uniform(0.05, 0.14, (count, sounds))
    ]


def capture(who: Performer, said: list[ll.Schedule], random: np.random.Generator) -> list:
    """Return lines as a capture has them, with errors."""
    out = []
    for number, schedule in enumerate(said):
        shown, times = who.perform(schedule, FPS), np.array(schedule.times)
        times[1:-1] += random.normal(0, JITTER_SECONDS, len(times) - 2)
        for at in range(1, len(times)):
            times[at] = max(times[at], times[at - 1] + LEAST_SECONDS)
        values = shown.weights + random.normal(0, NOISE, shown.weights.shape)
        told = replace(schedule, times=times)
        gains = np.eye(len(shown.poses))
        out.append(CapturedLine(f"{number}", told, shown.times, shown.poses, values, gains))
    return out


def exact(who: Performer, said: list[ll.Schedule]) -> list[CapturedLine]:
    """Return lines without errors."""
    made = [(schedule, who.perform(schedule, FPS)) for schedule in said]
    gains = np.eye(len(who.poses))
    return [
        CapturedLine(f"{n}", schedule, shown.times, shown.poses, shown.weights, gains)
        for n, (schedule, shown) in enumerate(made)
    ]


def known_face(poseset: str, minutes: float) -> dict[str, float]:
    """Print and return how well, and how fast, a known face is found again."""
    random = np.random.default_rng(0)
    pair, performer = open_pair("english", poseset)
    said = random_lines(random, round(minutes * 60 / 4.2))
    face = FitFace.of(pair, lay_lines(performer, exact(performer, said), FPS))
    start = face.start
    weights, dominance, free = start.weights.copy(), start.dominance.copy(), face.free(start)
    count, named = int(free.sum()), free.any(axis=1)
    moved = weights[free] * random.uniform(0.6, 1.4, count) + random.normal(0, 0.05, count)
    weights[free] = np.where(weights[free] > 0, np.clip(moved, 0.02, 1), 0)
    dominance[named] += random.normal(0, 0.4, int(named.sum()))
    truth = replace(start, weights=weights, dominance=dominance)
    tables = replace(pair.compiled, tables=face.tables_with(truth))
    captured = capture(Performer(tables, performer.motion), said, random)
    began = time.perf_counter()
    fit = fit_captures(pair, performer, captured, workers=os.cpu_count() or 1)
    seconds = time.perf_counter() - began
    clean = lay_lines(performer, exact(Performer(tables, performer.motion), said), FPS)
    errors = [fit.face.errors(values, clean) for values in (fit.face.start, fit.values)]
    before, after = (float(np.sqrt(np.mean(error**2))) for error in errors)
    print(f"{poseset}, {minutes:g} minutes of a known face: {seconds:.1f} s")
    print(f"  error of the curves {before:.4f} before, {after:.4f} after")
    return {"minutes": minutes, "seconds": seconds, "before": before, "after": after}


def main(folder: Path, posesets: list[str], file: Path | None) -> int:
    """Print both tables."""
    if not any(folder.glob("*.ema.csv")):
        print(f"{folder} holds no recordings (NAME.ema.csv beside NAME.phones.tsv)")
        return 1
    found = {poseset: leave_one_out(folder, poseset) for poseset in posesets}
    known = {poseset: known_face(poseset, MINUTES) for poseset in posesets}
    json_figures.write_figures(file, {"posesets": found, "known": known})
    return 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="articulography", type=Path)
    parser.add_argument("-c", "--poseset", nargs="+", default=["facefx"], help="those to fit")
    json_figures.add_option(parser)
    arguments = parser.parse_args()
    sys.exit(main(arguments.folder, arguments.poseset, arguments.json))
