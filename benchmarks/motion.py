"""Print how curves move, beside what captures of real faces show.

    python benchmarks/motion.py [FOLDER] [-c POSESET ...] [--set NAME=VALUE ...] [--contacts]
        [--json FILE]

Eight English lines are spoken by eSpeak NG and performed. FOLDER may hold articulograph
recordings, as `articulography.py` reads them. All that a row says is of the poses of one region
or of a read-out (`measures`) of the pose set, so that pose sets compare:

jaw           the sum of the poses that loudness opens (`intensity`), at 30 frames per second (the
              captures' rate), divided by its 99th percentile over all lines
speed, jerk   95th percentiles of its first and third derivative, in 1/s and 1/s^3
> 8 Hz        share of the power of its spectrum above 8 Hz, each line by itself
still         share of the frames with the jaw above 0.1 to and from which it moves by less than
              0.015: a peak is no stillness, a shelf is
extrema       turns of the jaw, larger than 0.02, in a second
shut          share of the frames of vowels beside p b m f v in which the jaw, at 60 frames per
              second, is below 0.1
lead          milliseconds by which the read-out `protrusion` comes before an "oo" or "oh" after s,
              k, t or rest: to a tenth and to a half of its peak within the vowel (medians)
missed        phonemes that demand a contact and do not come to 90 % of all its floors, and to 0.02
              above its ceilings, in a frame within half a frame of the phoneme
peak          99th percentile of the jaw
"""

import argparse
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import articulography
import json_figures
import numpy as np
from curve_sums import read_out

import lipsync_lang as ll
from lipsync_lang.pipeline.hold import demands
from lipsync_lang.reports.quality import curve_statistics as statistics
from lipsync_lang.reports.quality.face_columns import face_of
from lipsync_lang.reports.quality.likeness import CAPTURE_FPS

LINES = (
    "Please buy five more maps before Bob's baby puppy bumps.",
    "School. Two. Boot. The cool tooth grew too soon.",
    "Fire! Get down! Everybody out, now!",
    "I never said that she could borrow my father's old boat.",
    "We were away a year ago, watching the whales by the harbour.",
    "He thought a cup of strong coffee would make him happy.",
    "Don't ask me to carry an oily rag like that.",
    "My mother found the blue shoes on the floor of the kitchen.",
)
RATES = (12, 15, 24, 25, 30, 50, 60, 100, 120)
VOWELS = {"aa", "ah", "ao", "eh", "er", "ih", "w", "yu", "ow", "aw", "oy", "ay"}
LIPS = {"bmp", "f"}
BEFORE = {"s", "kg", "d", "_"}
ROUNDED = ("u", "o", "ʊ")
"""How the labels of the vowels begin; the common phoneme w is also the consonant of "we"."""


@cache
def lines() -> tuple[ll.Schedule, ...]:
    """Speak the lines."""
    return tuple(ll.speak(text, "english") for text in LINES)


def jaw(performer: ll.Performer, animation: ll.Animation) -> np.ndarray:
    """Return the sum of the poses that open the mouth: (T,)."""
    return animation.weights[:, face_of(animation, performer).roles.opening].sum(axis=1)


def at_rate(performer: ll.Performer, fps: float) -> tuple[list[np.ndarray], float]:
    """Return each line's jaw, and its 99th percentile over all."""
    curves = [jaw(performer, performer.perform(line, fps=fps)) for line in lines()]
    return curves, max(statistics.peak(np.concatenate(curves)), 1e-9)


def movement(performer: ll.Performer) -> dict[str, float]:
    """Measure the jaw at the captures' rate."""
    fps = CAPTURE_FPS
    raw, full = at_rate(performer, fps)
    curves = [curve / full for curve in raw]
    speed, jerk = (
        np.percentile(np.concatenate([statistics.derivative(c, fps, order) for c in curves]), 95)
        for order in (1, 3)
    )
    frames = [statistics.open_frames(curve) for curve in curves]
    opened, still = (sum(int(part.sum()) for part in parts) for parts in zip(*frames, strict=True))
    seconds = sum(len(c) for c in curves) / fps
    return {
        "> 8 Hz %": 100 * float(np.mean([statistics.high_share(c, fps) for c in curves])),
        "still %": 100 * still / max(opened, 1),
        "speed": float(speed),
        "jerk e4": float(jerk) / 1e4,
        "extrema": sum(statistics.turns(c) for c in curves) / seconds,
        "peak": full,
    }


def common(performer: ll.Performer, line: ll.Schedule) -> tuple[list[str], np.ndarray, np.ndarray]:
    """Return a line's common phonemes, their boundaries, and the label of each."""
    ids, times, source = performer.common_phonemes(line)
    return [performer.compiled.phonemes[i] for i in ids], times, source


def shut(performer: ll.Performer) -> float:
    """Return the share of the frames of vowels beside labials that keep the jaw shut."""
    fps = 60.0
    curves, full = at_rate(performer, fps)
    frames = closed = 0
    for line, curve in zip(lines(), curves, strict=True):
        names, times, _ = common(performer, line)
        begin = performer.performance(line, fps).frames.times()
        for i, name in enumerate(names):
            around = {*names[max(0, i - 1) : i], *names[i + 1 : i + 2]}
            if name in VOWELS - {"w", "yu"} and around & LIPS:
                inside = np.flatnonzero((begin >= times[i]) & (begin <= times[i + 1]))
                frames += len(inside)
                closed += int((curve[inside] < statistics.SHUT_SHARE * full).sum())
    return 100 * closed / max(frames, 1)


def leads(performer: ll.Performer, gains: dict[str, float]) -> dict[str, float]:
    """Return by how much rounding leads its vowel, to a tenth and to a half of its peak, in ms."""
    fps = 240.0
    found: dict[float, list[float]] = {0.1: [], 0.5: []}
    for line in lines():
        names, times, source = common(performer, line)
        animation = performer.perform(line, fps=fps)
        curve = np.maximum(read_out(animation, gains), 0)
        at = animation.times
        for i, name in enumerate(names):
            before = names[i - 1] if i else "_"
            vowel = line.labels[source[i]].startswith(ROUNDED)
            if not (name != "_" and vowel and before in BEFORE):
                continue
            start = int(np.searchsorted(at, times[i]))
            stop = int(np.searchsorted(at, times[i + 1]))
            for share, kept in found.items():
                begun = statistics.rise(curve, start, stop, share)
                if begun is not None:
                    kept.append(1000 * (times[i] - at[begun]))
    return {f"lead {share:g}": float(np.median(kept)) for share, kept in found.items() if kept}


def missed(
    performer: ll.Performer, fps: float, spoken: Sequence[ll.Schedule] = ()
) -> tuple[int, int]:
    """Count the phonemes that do not get their contact, and those that demand one."""
    lost = wanted = 0
    for line in spoken or lines():
        performance = performer.performance(line, fps)
        weights, times = performance.weights(), performance.frames.times()
        track = performance.track
        for contact in performance.tables.contacts:
            up = (weights >= 0.9 * contact.floor - 1e-9).all(axis=1)
            down = (weights <= contact.ceiling + 0.02 + 1e-9).all(axis=1)
            for i in np.flatnonzero(demands(contact, track)):
                near = times >= track.bounds[i] - 0.5 / fps - 1e-6
                near &= times <= track.bounds[i + 1] + 0.5 / fps + 1e-6
                wanted += 1
                lost += not (near & up & down).any()
    return lost, wanted


def correlations(performer: ll.Performer, folder: Path) -> dict[str, float]:
    """Return Pearson r of each read-out, the mean of the recordings."""
    found: dict[str, float] = {}
    recordings = articulography.recordings(folder)
    for measure, gains in performer.compiled.measures.items():
        if recordings and all(measure in signals for _, _, signals, _ in recordings):
            values = [
                articulography.correlate(
                    performer.perform(schedule, fps=articulography.FPS),
                    gains, signals[measure], times,
                )
                for _, schedule, signals, times in recordings
            ]  # fmt: skip
            found[f"r {measure[:9]}"] = float(np.mean(values))
    return found


def main(
    folder: Path,
    posesets: list[str],
    settings: dict[str, str],
    *,
    contacts: bool,
    file: Path | None = None,
) -> int:
    """Print the figures of each pose set."""
    kept: dict[str, dict[str, object]] = {}
    for name in posesets:
        performer = ll.resolve("english", name).with_motion(settings)
        row = movement(performer) | {"shut %": shut(performer)}
        gains = performer.compiled.measures.get("protrusion")
        row |= leads(performer, gains) if gains else {}
        if folder.is_dir():
            german = ll.resolve(articulography.LANGUAGE, name).with_motion(settings)
            row |= correlations(german, folder)
        print(name + "".join(f"   {what} {value:.3g}" for what, value in row.items()))
        kept[name] = {**row}
        if contacts:
            counts = [(fps, *missed(performer, fps)) for fps in RATES]
            told = ", ".join(f"{lost} of {wanted} at {fps}" for fps, lost, wanted in counts)
            print(f"  contacts missed: {told}", flush=True)
            kept[name]["missed"] = {fps: lost for fps, lost, _ in counts}
            kept[name]["contacts"] = counts[0][2]
    json_figures.write_figures(file, {"lines": len(lines()), "posesets": kept})
    return 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="articulography", type=Path)
    parser.add_argument("-c", "--poseset", action="append", help="facefx unless stated")
    parser.add_argument("--set", action="append", default=[], help="a motion setting, NAME=VALUE")
    parser.add_argument("--contacts", action="store_true", help="count contacts missed as well")
    json_figures.add_option(parser)
    arguments = parser.parse_args()
    chosen = dict(setting.split("=", 1) for setting in arguments.set)
    named = arguments.poseset or ["facefx"]
    sys.exit(
        main(arguments.folder, named, chosen, contacts=arguments.contacts, file=arguments.json)
    )
