"""Compare our faces with films of people who say the same texts: both are tracked from the front.

    python benchmarks/face_on.py FOLDER --tracker PYTHON -c HEAD [-c HEAD] [-l english]
                                 [--scores MODEL.task] [--films FOLDER] [--json FILE]

FOLDER holds films (.mp4, .mov, .mkv, .webm), each with its text as NAME.txt. PYTHON is an
environment of its own with mediapipe 0.10.14 (1.2 GB). Each text is aligned with the sound of its
film; each HEAD, a model or a character with one, performs it; and the rendered film is tracked by
the same tracker, `track_lips.py`. The first head also performs it by the paper's motion, by
keyframes at the centres of phonemes and by held shapes.

aperture r   Pearson's r of the distance between the lips, over speech
width r      the same, of the distance between the corners of the mouth
ranges       our standard deviation divided by the real one
lag          ms by which our aperture comes late: the shift of the largest r
shut         lip contacts that are seen shut, ours and theirs, of those in the text

With --scores, ARKit weights of the first head are compared with the scores that the tracker gives
the real face. Small scores are unreliable.
"""

import argparse
import subprocess
import sys
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory, mkdtemp
from typing import NamedTuple

import json_figures
import numpy as np

import lipsync_lang as ll
from lipsync_lang.render.video import film, find_ffmpeg
from lipsync_lang.reports.quality.baselines import held, keyframes

KINDS = {".mp4", ".mov", ".mkv", ".webm"}
PIXELS = 480
"""Side of a rendered frame: as large as the face in a common film."""

LAGS = np.arange(-0.15, 0.151, 0.005)
"""Shifts that are tried, in seconds."""

SHUT = 0.1
"""Share of a film's widest aperture (its 95th percentile) below which lips are shut."""

SHUTS = "bmp"
"""The common phoneme that shuts the lips."""

Perform = Callable[[ll.Schedule, float], ll.Animation]


class Lips(NamedTuple):
    """A tracked film: (T,) seconds from the start of the sound, and (T, 2) aperture and width."""

    times: np.ndarray
    shape: np.ndarray
    scores: Mapping[str, np.ndarray] = {}
    fps: float = 0.0


def track(python: str, path: Path, start: float = 0.0, model: Path | None = None) -> Lips:
    """Track the lips of a film whose sound starts `-start` seconds after its first frame."""
    with TemporaryDirectory() as folder:
        out = Path(folder) / "lips.npz"
        script = Path(__file__).with_name("track_lips.py")
        command = [python, script, path, out, *([model] if model else [])]
        ended = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603 no shell
        if ended.returncode:
            sys.exit(f"{path}: the tracker failed: {ended.stderr.strip().splitlines()[-1]}")
        with np.load(out) as found:
            fps, shape = float(found["fps"]), found["lips"]
            scores = dict(zip(found["names"].tolist(), found["scores"].T, strict=True))
    return Lips(start + np.arange(len(shape)) / fps, shape, scores, fps)


def spoken(path: Path, language: str) -> ll.Schedule:
    """Align the text beside a film with its sound."""
    with TemporaryDirectory() as folder:
        sound = Path(folder) / "sound.wav"
        quiet = [find_ffmpeg(), "-loglevel", "error", "-nostdin", "-y"]
        command = [*quiet, "-i", path, "-ac", "1", "-ar", "16000", sound]
        subprocess.run(command, check=True)  # noqa: S603 no shell
        return ll.align(sound, path.with_suffix(".txt").read_text("utf-8").strip(), language)


def correlate(real: np.ndarray, ours: np.ndarray) -> float:
    """Return Pearson's r over the frames where both faces were found."""
    both = np.isfinite(real) & np.isfinite(ours)
    if both.sum() < 3 or not np.ptp(real[both]) or not np.ptp(ours[both]):
        return float("nan")
    return float(np.corrcoef(real[both], ours[both])[0, 1])


def shut(lips: Lips, spans: np.ndarray) -> np.ndarray:
    """Return of each span, in seconds, whether the lips are seen shut in it: (n,)."""
    aperture = lips.shape[:, 0]
    limit = SHUT * np.nanquantile(aperture, 0.95)
    near = 0.5 / lips.fps
    seen = [(lips.times >= a - near) & (lips.times <= b + near) for a, b in spans]
    return np.array([np.nanmin(aperture[one], initial=np.inf) <= limit for one in seen], bool)


def judge(real: Lips, ours: Lips, speech: tuple[float, float], spans: np.ndarray) -> dict:
    """Compare two tracked films of one line."""
    inside = (real.times >= speech[0]) & (real.times <= speech[1])
    times, theirs = real.times[inside], real.shape[inside]

    def shifted(lag: float) -> np.ndarray:
        columns = [np.interp(times + lag, ours.times, one) for one in ours.shape.T]
        return np.column_stack(columns)

    mine = shifted(0.0)
    by_lag = [correlate(theirs[:, 0], shifted(lag)[:, 0]) for lag in LAGS]
    ranges = np.nanstd(mine, axis=0) / np.nanstd(theirs, axis=0)
    return {
        "aperture r": correlate(theirs[:, 0], mine[:, 0]),
        "width r": correlate(theirs[:, 1], mine[:, 1]),
        "aperture range": ranges[0],
        "width range": ranges[1],
        "lag ms": 1000 * LAGS[int(np.nanargmax(by_lag))] if np.isfinite(by_lag).any() else np.nan,
        "shut %": 100 * shut(ours, spans).mean() if len(spans) else np.nan,
        "really shut %": 100 * shut(real, spans).mean() if len(spans) else np.nan,
    }


def methods(heads: list[ll.Performer]) -> dict[str, tuple[ll.Performer, Perform]]:
    """Return the ways to perform a line, by the name of their row."""
    first = heads[0]
    rows = {f"default, {one.character}": (one, one.perform) for one in heads}
    paper = first.with_motion("paper")
    # plain methods read targets from packs, and a model has none of its own
    plain = ll.resolve(first.language, first.compiled.poseset)
    return rows | {
        "paper's motion": (paper, paper.perform),
        "keyframes at centres": (first, partial(keyframes, plain)),
        "held shapes": (first, partial(held, plain)),
    }


def lip_contacts(performer: ll.Performer, schedule: ll.Schedule) -> np.ndarray:
    """Return the spans of phonemes that shut the lips: (n, 2) seconds."""
    ids, bounds, _ = performer.common_phonemes(schedule)
    shuts = [performer.compiled.phonemes[one] == SHUTS for one in ids]
    return np.column_stack([bounds[:-1], bounds[1:]])[np.array(shuts, bool)]


def compare_scores(real: Lips, animation: ll.Animation) -> dict[str, tuple[float, float, float]]:
    """Compare ARKit weights with scores of a real face: r, our deviation and theirs, by shape."""
    found = {}
    for name in set(real.scores) & set(animation.poses):
        ours = np.interp(real.times, animation.times, animation[name])
        found[name] = (
            correlate(real.scores[name], ours),
            float(ours.std()),
            float(np.nanstd(real.scores[name])),
        )
    return found


def films_of(folder: Path) -> list[Path]:
    """Return the films of a folder that have a text; exit with a reason if there are none."""
    films = sorted(one for one in folder.glob("*") if one.suffix.lower() in KINDS)
    found = [one for one in films if one.with_suffix(".txt").exists()]
    if not found:
        told = f"{folder} holds no films with a text (NAME.mp4 beside NAME.txt)"
        if any(folder.glob("*_texts.tsv")):
            told += "; its lips are tracked already, so compare them by benchmarks/mouths.py"
        sys.exit(told)
    return found


def head_of(language: str, name: str) -> ll.Performer:
    """Return a performer with a model; exit with a reason if there is none."""
    found = ll.resolve(language, name)
    if found.model is None:
        sys.exit(f"{name} has no model to film; name a model with -c, as HEAD.glb")
    return found


def main(arguments: argparse.Namespace) -> int:
    """Print the table."""
    films = films_of(arguments.folder)
    heads = [head_of(arguments.language, one) for one in arguments.head]
    kept: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    scores: dict[str, list[tuple[float, float, float]]] = defaultdict(list)
    folder = arguments.films or Path(mkdtemp(prefix="lipsync-lang-"))
    folder.mkdir(parents=True, exist_ok=True)
    for path in films:
        real = track(arguments.tracker, path, model=arguments.scores)
        lost = np.isnan(real.shape[:, 0]).mean()
        print(f"{path.name}: {len(real.times)} frames, {lost:.0%} without a face", file=sys.stderr)
        schedule = spoken(path, arguments.language)
        said = [i for i, one in enumerate(schedule.labels) if one != ll.schedules.SILENCE]
        speech = float(schedule.times[said[0]]), float(schedule.times[said[-1] + 1])
        spans = lip_contacts(heads[0], schedule)
        for number, (name, (performer, perform)) in enumerate(methods(heads).items()):
            animation = perform(schedule, real.fps)
            if not number:
                for shape, row in compare_scores(real, animation).items():
                    scores[shape].append(row)
            out = folder / f"{path.stem}-{number}.mp4"
            with out.open("wb") as stream:
                shown = replace(performer.rigged(animation), model=performer.model)
                film(shown, stream, "mp4", size=PIXELS)
            ours = track(arguments.tracker, out, float(animation.times[0]))
            for figure, value in judge(real, ours, speech, spans).items():
                kept[name][figure].append(value)
    table = {
        name: {figure: float(np.nanmean(values)) for figure, values in row.items()}
        for name, row in kept.items()
    }
    print(f"{len(films)} films, mean of the films")
    print(f"{'':24}" + "".join(f"{figure:>16}" for figure in next(iter(table.values()))))
    for name, row in table.items():
        print(f"{name:24}" + "".join(f"{value:16.2f}" for value in row.values()))
    means = {shape: np.nanmean(rows, axis=0).tolist() for shape, rows in sorted(scores.items())}
    if means:
        print(f"\n{'ARKit shape':24}{'r':>8}{'ours':>8}{'real':>8}   standard deviations")
    for shape, row in means.items():
        print(f"{shape:24}" + "".join(f"{value:8.3f}" for value in row))
    json_figures.write_figures(arguments.json, {"films": len(films), "rows": table, "arkit": means})
    return 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--tracker", required=True, metavar="PYTHON", help="has mediapipe 0.10.14")
    parser.add_argument(
        "-c", "--head", action="append", required=True, help="a model, or a character that has one"
    )
    parser.add_argument("-l", "--language", default="english")
    parser.add_argument("--scores", type=Path, metavar="MODEL", help="face_landmarker.task")
    parser.add_argument("--films", type=Path, metavar="FOLDER", help="keep our films here")
    json_figures.add_option(parser)
    sys.exit(main(parser.parse_args()))
