"""Lips from sound alone beside those of the text: correlation, closures, rest, speed.

    python benchmarks/listening.py DATA [--delay 0.08] [--only SECTION ...] [--json FILE]
    python benchmarks/listening.py FOLDER -l german [--whole]

DATA is a folder as for `hearing.py`. A FOLDER holds recordings in one language, each beside its
text (`NAME.wav`, `NAME.txt`). The reference is this project's own curves of the aligned text.

With `--whole`, `lips` compares what the recogniser `sound` hears in whole recordings.

Sections: `lips` compares aperture and width (protrusion, turned round) by Pearson r over speech.
A closure of the text is found if the lips reach their floor within 50 ms of it; one of the
listener is invented if none of the text is as near. `real` compares with coils on real lips.
`rest` states the largest weight in sounds that nobody speaks. `speed` states the share of a core,
the time of a push at the 99th percentile, and how many times faster than real time twenty voices
are heard that are pushed together; time is that of the processor, at the best of five runs. `hour`
states the growth of memory and the drift in an hour.
"""

import argparse
import resource
import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import articulography
import hearing
import json_figures
import numpy as np
from curve_sums import read_out

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation
from lipsync_lang.sound.speech.sound import read_audio, resampled

POSESET, MEASURES = "facefx", {"aperture": 1.0, "protrusion": -1.0}
RATE = 16_000
NEAR_SECONDS = 0.05
PUSH_SAMPLES = 267
TUNED = {"english", "spanish", "catalan", "czech", "telugu"}
"""Languages whose recordings set the constants of `listening`; the others test them."""


class Compared(NamedTuple):
    """Figures of one recording."""

    r: dict[str, float]
    closures: int
    found: int
    shown: int
    invented: int


def of_folder(folder: Path, language: str) -> Iterator[hearing.Recording]:
    """Yield the recordings of a folder with their texts."""
    for text in sorted(p for p in folder.iterdir() if p.suffix in (".txt", ".lab")):
        for path in folder.glob(f"{text.stem}.*"):
            if path.suffix in (".wav", ".flac", ".opus", ".mp3", ".ogg"):
                yield hearing.Recording(language, read_audio(path), text.read_text("utf-8").strip())


def sound_of(audio: ll.Audio) -> np.ndarray:
    """Return samples at the rate of the ear."""
    return resampled(audio, RATE).samples


def listened(performer: ll.Performer, samples: np.ndarray, delay: float, fps: float = 60) -> Any:
    """Listen to a sound; return times (k,) and weights (k, P)."""
    listener = performer.listen(RATE, delay, fps)
    parts = [listener.push(samples[at : at + 1600]) for at in range(0, len(samples), 1600)]
    parts.append(listener.finish())
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


def spans(
    performer: ll.Performer, schedule: ll.Schedule, demanded: np.ndarray
) -> list[list[float]]:
    """Return start and end of the sounds that demand a contact, joined where they touch."""
    ids, bounds, _ = performer.common_phonemes(schedule)
    return stretches(bounds, np.append(demanded[ids], False), 0)


def closed(times: np.ndarray, weights: np.ndarray, floor: np.ndarray) -> list[list[float]]:
    """Return start and end of each time in which the poses of a contact are at their floor."""
    return stretches(times, (weights >= floor - 0.02).all(axis=1))


def stretches(times: np.ndarray, held: np.ndarray, last: int = 1) -> list[list[float]]:
    """Return first and last time of each stretch that is held; `last` 0 has the one after it."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], held.astype(int), [0]])))
    return [[float(times[a]), float(times[z - last])] for a, z in edges.reshape(-1, 2)]


def near(one: list[float], others: list[list[float]], seconds: float = NEAR_SECONDS) -> bool:
    """Return True if a time is within some seconds of any of the others."""
    return any(a <= one[1] + seconds and one[0] <= z + seconds for a, z in others)


def compared(
    performer: ll.Performer, spoken: Animation, times: np.ndarray, weights: np.ndarray
) -> Compared:
    """Compare heard lips with those of a text."""
    schedule = spoken.schedule
    sounds = [n for n, label in enumerate(schedule.labels) if label != ll.schedules.SILENCE]
    at = spoken.times
    inside = (at >= schedule.times[sounds[0]]) & (at <= schedule.times[sounds[-1] + 1])
    r = {}
    for measure in MEASURES:
        gains = performer.compiled.measures[measure]
        ours = weights @ [gains.get(pose, 0.0) for pose in performer.poses]
        both = np.interp(at[inside], times, ours), read_out(spoken, gains)[inside]
        r[measure] = float(np.corrcoef(*both)[0, 1]) if min(map(np.ptp, both)) > 0 else 0.0
    # the contact with the highest floor is that of the lips
    lips = max(performer.compiled.tables.contacts, key=lambda one: one.floor.max())
    true = spans(performer, schedule, lips.phonemes)
    shown = closed(times, weights, lips.floor)
    return Compared(
        r, len(true), sum(near(one, shown) for one in true),
        len(shown), sum(not near(one, true) for one in shown),
    )  # fmt: skip


def row(name: str, ones: list[Compared]) -> dict[str, float]:
    """Print and return the figures of some recordings."""
    figures = {m: float(np.mean([one.r[m] for one in ones])) for m in MEASURES}
    figures["found"] = sum(one.found for one in ones) / max(sum(one.closures for one in ones), 1)
    figures["invented"] = sum(one.invented for one in ones) / max(sum(o.shown for o in ones), 1)
    values = [figures[m] for m in MEASURES]
    print(
        f"{name:24}{len(ones):4}" + "".join(f"{value:10.2f}" for value in values)
        + f"{figures['found']:10.0%}{figures['invented']:10.0%}", flush=True,
    )  # fmt: skip
    return figures


def lips(recordings: list[hearing.Recording], delay: float, *, whole: bool) -> dict[str, Any]:
    """Print figures by language."""
    print(f"{'lips':24}{'':4}{'aperture':>10}{'width':>10}{'found':>10}{'invented':>10}")
    by_language: dict[str, list[Compared]] = defaultdict(list)
    for one in recordings:
        performer = _performer(one.language)
        schedule = ll.align(one.audio, one.text, one.language)
        if whole:
            heard = ll.recognise(one.audio, one.language, recogniser="sound")
            found = performer.perform(heard, fps=100)
            times, weights = found.times, found.weights
        else:
            times, weights = listened(performer, sound_of(one.audio), delay)
        spoken = performer.perform(schedule, fps=100)
        by_language[one.language].append(compared(performer, spoken, times, weights))
    figures: dict[str, Any] = {}
    for name, ones in by_language.items():
        figures[name] = row(name + " (tuned)" * (name in TUNED), ones)
    for name, chosen in (("tuned", True), ("others", False)):
        some = [f for language, f in figures.items() if (language in TUNED) == chosen]
        if some and len(figures) > 1:
            mean = {key: float(np.mean([f[key] for f in some])) for key in some[0]}
            figures[f"mean, {name}"] = mean
            print(f"{'mean, ' + name:28}" + "".join(f"{v:10.2f}" for v in mean.values()))
    return figures


_PERFORMERS: dict[str, ll.Performer] = {}


def _performer(language: str) -> ll.Performer:
    return _PERFORMERS.setdefault(language, ll.resolve(language, POSESET))


def real(data: Path, delay: float) -> dict[str, Any]:
    """Print r to coils on real lips, beside that of the text."""
    folder, performer = data / "articulography", _performer(articulography.LANGUAGE)
    figures: dict[str, Any] = defaultdict(list)
    for name, schedule, signals, at in articulography.recordings(folder, performer):
        samples = sound_of(read_audio(folder / f"{name}.wav"))
        times, weights = listened(performer, samples, delay, 100)
        spoken = performer.perform(schedule, fps=100)
        heard = Animation(times, performer.poses, weights, 100.0, schedule)
        for measure in set(MEASURES) & set(signals):
            gains = performer.compiled.measures[measure]
            for method, animation in (("sound", heard), ("text", spoken)):
                r = articulography.correlate(animation, gains, signals[measure], at)
                figures[f"{measure}, {method}"].append(r)
    for name, values in sorted(figures.items()):
        print(f"{'real lips, ' + name:32}{np.mean(values):8.2f}   {np.round(values, 2)}")
    return dict(figures)


def unspoken() -> dict[str, np.ndarray]:
    """Make sounds that nobody speaks, int16."""
    chance = np.random.default_rng(5)
    seconds = np.arange(20 * RATE) / RATE
    cough = sum(
        np.where(seconds >= at, np.exp(-np.maximum(seconds - at, 0) / 0.08), 0.0) for at in (2, 2.4)
    ) * chance.normal(size=len(seconds))
    cough = np.convolve(cough, np.hanning(9))[: len(seconds)]
    music = np.resize(hearing.music(5.0), len(seconds))
    sounds = {
        "silence": np.zeros(len(seconds)),
        "quiet hiss": chance.normal(size=len(seconds)) * 0.01,
        "loud hiss": chance.normal(size=len(seconds)) * 0.1,
        "music": music / np.abs(music).max() * 0.5,
        "a tone": 0.3 * np.sin(2 * np.pi * 440 * seconds),
        "hum": 0.1 * sum(np.sin(2 * np.pi * 50 * n * seconds) / n for n in (1, 2, 3, 5)),
        "a cough, twice": cough / np.abs(cough).max() * 0.7,
    }
    return {name: (sound * 32767).astype(np.int16) for name, sound in sounds.items()}


def rest(delay: float) -> dict[str, Any]:
    """Print the largest weight in sounds that nobody speaks, and its mean over time."""
    figures = {}
    print(f"{'rest, largest weight':24}{'first s':>10}{'later':>10}{'mean':>10}")
    for name, sound in unspoken().items():
        times, weights = listened(_performer("english"), sound, delay)
        most = weights.max(axis=1)
        parts = [float(most[times < 1].max()), float(most[times >= 1].max()), float(most.mean())]
        figures[name] = parts
        print(f"{name:24}" + "".join(f"{value:10.2f}" for value in parts), flush=True)
    return figures


def speed(samples: np.ndarray, delay: float) -> dict[str, float]:
    """Print the cost of one voice, and of twenty in a process, each push at its best of five."""
    performer = _performer("english")
    performer.listen()
    found = {}
    for count in (1, 20):
        parts = samples[: 5 * RATE // PUSH_SAMPLES * PUSH_SAMPLES].reshape(-1, PUSH_SAMPLES)
        runs = []
        for _ in range(5):
            voices, took = [performer.listen(RATE, delay) for _ in range(count)], []
            for part in parts:
                before = time.thread_time()
                voices[0].push_together(voices, [part] * count)
                took.append(time.thread_time() - before)
            runs.append(took)
        best = np.min(runs, axis=0)
        found[count] = best.sum() / (parts.size / RATE), float(np.quantile(best, 0.99))
    (share, late), (twenty, _) = found[1], found[20]
    print(f"one voice {share:.1%} of a core, push p99 {late * 1000:.1f} ms")
    print(f"twenty voices in one process at {1 / twenty:.2f} times their pace")
    return {"share": share, "push_p99_seconds": late, "twenty": 1 / twenty}


def hour(samples: np.ndarray, delay: float) -> dict[str, float]:
    """Print how memory grows in an hour, and how far the last frame is from its time."""
    listener, known = _performer("english").listen(RATE, delay), []
    pushes = round(3600 * RATE / len(samples))
    frames = 0
    for number in range(pushes):
        times, _ = listener.push(samples)
        frames += len(times)
        if number in (pushes // 10, pushes - 1):
            known.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
    drift = float(times[-1]) - (pushes * len(samples) / RATE - delay)
    print(f"an hour: {known[1] - known[0]:.1f} MB more after the first tenth, {frames} frames,")
    print(f"  the last {drift * 1000:+.1f} ms from the delay behind the sound")
    return {"megabytes": known[1] - known[0], "drift_seconds": drift}


def main() -> int:
    """Print the sections."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("-l", "--language", help="of a folder of recordings with texts")
    parser.add_argument("--delay", type=float, default=0.08)
    parser.add_argument("--whole", action="store_true", help="whole recordings instead of live")
    names = ["lips", "real", "rest", "speed", "hour"]
    parser.add_argument("--only", nargs="+", choices=names, default=names[:-1])
    json_figures.add_option(parser)
    asked = parser.parse_args()
    if asked.language:
        recordings = list(of_folder(asked.folder, asked.language))
    else:
        recordings = [*hearing.natural(asked.folder), *hearing.spoken()]
    if not recordings:
        print(f"{asked.folder} holds no recordings with texts")
        return 1
    longest = max((sound_of(one.audio) for one in recordings[:12]), key=len)
    sections = {
        "lips": lambda: lips(recordings, asked.delay, whole=asked.whole),
        "real": lambda: real(asked.folder, asked.delay),
        "rest": lambda: rest(asked.delay),
        "speed": lambda: speed(longest, asked.delay),
        "hour": lambda: hour(longest, asked.delay),
    }
    figures = {name: sections[name]() for name in asked.only}
    json_figures.write_figures(asked.json, figures)
    return 0


if __name__ == "__main__":
    sys.exit(main())
