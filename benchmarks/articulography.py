"""Compare curves with real mouths: Pearson r of read-outs on articulograph recordings.

    python benchmarks/articulography.py FOLDER [-c facefx] [--json FILE]

FOLDER holds, for each recording, NAME.ema.csv (time_s and coil positions in mm, axis 1 front to
back, axis 2 upwards) and NAME.phones.tsv (start, end, label in German SAMPA), and NAME.wav for the
method that follows its loudness. The read-outs are the pose set's `measures`, the same for every
method and never fitted. Only speech is compared: not
the pauses, not the frames where a coil was lost, and of a last phone that runs on into silence
as long as phones are elsewhere.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import json_figures
import numpy as np
from curve_sums import read_out

import lipsync_lang as ll
from lipsync_lang.packs.finding import MODEL_SUFFIXES
from lipsync_lang.plugins.capture.capture_reading import read_captures
from lipsync_lang.reports.quality.baselines import dominance, keyframes
from lipsync_lang.sound.speech.sound import read_audio

LANGUAGE = "german"
"""The pack that knows the labels, which are its SAMPA."""

FPS = 200.0
READ_OUT = Path(__file__).with_suffix(".yaml")
"""Measures as sums of coil positions, and the labels of pauses."""


def recordings(
    folder: Path, performer: ll.Performer | None = None
) -> list[tuple[str, ll.Schedule, dict[str, np.ndarray], np.ndarray]]:
    """Read every recording: name, schedule, (T,) signals by measure, (T,) times; lost as NaN."""
    if not any(folder.glob("*.ema.csv")):
        return []
    found = read_captures(performer or ll.resolve(LANGUAGE, "facefx"), folder, readout=READ_OUT)
    for one in found.set_aside:
        print(f"{one.line} is set aside: {one.why}", file=sys.stderr)
    return [
        (line.name, line.schedule, dict(zip(line.signals, line.values.T, strict=True)), line.times)
        for line in found.lines
    ]


def correlate(
    animation: ll.Animation, gains: dict[str, float], signal: np.ndarray, times: np.ndarray
) -> float:
    """Return Pearson r over speech."""
    schedule = animation.schedule
    spoken = [i for i, label in enumerate(schedule.labels) if label != ll.schedules.SILENCE]
    inside = (times >= schedule.times[spoken[0]]) & (times <= schedule.times[spoken[-1] + 1])
    inside &= np.isfinite(signal)
    ours = np.interp(times[inside], animation.times, read_out(animation, gains))
    return float(np.corrcoef(ours, signal[inside])[0, 1]) if np.ptp(ours) else 0.0


def main(folder: Path, poseset: str = "facefx", file: Path | None = None) -> int:
    """Print the table."""
    if poseset.lower().endswith(MODEL_SUFFIXES):
        make = "make one of the model (`lipsync-lang characters new`), and name it"
        print(f"{poseset}: is a model, and the plain methods need a character; {make}")
        return 1
    performer = ll.resolve(LANGUAGE, poseset)
    lines = recordings(folder, performer)
    if not lines:
        print(f"{folder} holds no recordings (NAME.ema.csv beside NAME.phones.tsv)")
        return 1
    methods = {
        "drafted bank": performer.perform,
        "linear warp": performer.with_motion({"warp": "linear"}).perform,
        "cross-fade": performer.with_motion({"stitch": "crossfade"}).perform,
        "paper's motion": performer.with_motion("paper").perform,
        "keyframes at centres": lambda schedule, fps: keyframes(performer, schedule, fps),
        "dominance, utterance": lambda schedule, fps: dominance(performer, schedule, fps),
    }
    heard = {
        schedule: replace(schedule, audio=read_audio(folder / f"{name}.wav"))
        for name, schedule, *_ in lines
        if (folder / f"{name}.wav").is_file()
    }
    if len(heard) == len(lines):
        methods["with its sound"] = lambda schedule, fps: performer.perform(heard[schedule], fps)
    kept: dict[str, dict[str, list[float]]] = {}
    print(f"Pearson r, {performer.character} speaking {performer.language}, at {FPS:g} fps")
    for measure, gains in performer.compiled.measures.items():
        if not all(measure in signals for _, _, signals, _ in lines):
            continue  # no sensor shows it
        print(
            f"\n{measure:<24}" + "".join(f"{name[-14:]:>16}" for name, *_ in lines) + f"{'mean':>8}"
        )
        for method, perform in methods.items():
            values = [
                correlate(perform(schedule, fps=FPS), gains, signals[measure], times)
                for _, schedule, signals, times in lines
            ]
            kept.setdefault(measure, {})[method] = values
            row = "".join(f"{value:>16.3f}" for value in values)
            print(f"  {method:<22}{row}{np.mean(values):>8.3f}")
    names = [name for name, *_ in lines]
    json_figures.write_figures(file, {"poseset": poseset, "recordings": names, "r": kept})
    return 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="articulography", type=Path)
    parser.add_argument("-c", "--poseset", default="facefx", help="whose targets, measures")
    json_figures.add_option(parser)
    arguments = parser.parse_args()
    sys.exit(main(arguments.folder, arguments.poseset, arguments.json))
