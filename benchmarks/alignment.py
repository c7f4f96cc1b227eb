"""Compare alignments with known boundaries: how far off they are, and how fast they come.

    python benchmarks/alignment.py SENTENCES [--lab WAV LAB TEXT] [--aligner NAME] [-l english]
        [--json FILE]

SENTENCES is a file of English sentences; the first twenty are spoken by the language's own voice,
which says when each phoneme starts, and aligned again from sound and text alone. Of a recording,
LAB is its HTK label file.

How boundaries are paired: both sequences of labels become common phonemes, silence left out, and
the longest runs that agree are matched (difflib). A boundary counts where the phonemes on both
sides of it are matched and neighbours in both. The error is aligned less known, in milliseconds;
speed is seconds of sound for each second of processor time, G2P and its process aside.
"""

import argparse
import re
import sys
import time
from collections.abc import Iterator
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any

import json_figures
import numpy as np
from closures import by_place, closures, print_places

import lipsync_lang as ll
from lipsync_lang.schedules import SILENCE, Schedule
from lipsync_lang.sound.speech.hearing.alignment import aligned
from lipsync_lang.sound.speech.sound import read_audio, resampled
from lipsync_lang.sound.speech.speaking.speaker import Speaker

SPOKEN = 20
RATE = 16_000
PAUSE = 0.3
LONG = 300.0
SNR = 10.0
"""Decibels between the voice and the noise that is added to it."""


def starts(schedule: Schedule, speaker: Speaker) -> tuple[list[str], list[float | None]]:
    """Return common phonemes without silence, and when each starts; within a label nobody knows."""
    notation = speaker.notations[schedule.notation or "ipa"]
    names: list[str] = []
    times: list[float | None] = []
    for label, start in zip(schedule.labels, schedule.times, strict=False):
        for number, (name, _) in enumerate(notation.find(label) or ()):
            if name != SILENCE:
                names.append(name)
                times.append(None if number else float(start))
    return names, times


def errors(found: Schedule, known: Schedule, speaker: Speaker) -> Iterator[float]:
    """Yield, for each boundary that is paired, aligned less known, in seconds."""
    (here, mine), (there, theirs) = starts(found, speaker), starts(known, speaker)
    for a, b, size in SequenceMatcher(None, here, there, autojunk=False).get_matching_blocks():
        for n in range(1, size):
            one, other = mine[a + n], theirs[b + n]
            if one is not None and other is not None:
                yield one - other


def noisy(audio: ll.Audio, noise: np.ndarray) -> ll.Audio:
    """Add noise to a sound."""
    voice = audio.samples.astype(np.float64)
    there = np.resize(noise, len(voice))
    gain = np.sqrt(np.square(voice).mean() / np.square(there).mean()) / 10 ** (SNR / 20)
    return ll.Audio(np.clip(voice + gain * there, -32768, 32767).astype(np.int16), audio.rate)


def joined(schedules: list[Schedule], seconds: float) -> Schedule:
    """Return schedules one after the other, again and again, with pauses between them."""
    rows: list[tuple[str, float, float]] = []
    sounds: list[np.ndarray] = []
    rate, at = schedules[0].audio.rate, 0.0
    while at < seconds:
        for one in schedules:
            times = one.times + at
            rows += zip(one.labels, times[:-1], times[1:], strict=True)
            sounds += [one.audio.samples, np.zeros(int(PAUSE * rate), np.int16)]
            at = sum(map(len, sounds[-2:])) / rate + at
            rows.append((SILENCE, rows[-1][2], at))
    audio = ll.Audio(np.concatenate(sounds), rate)
    return Schedule.from_intervals(rows, notation=schedules[0].notation, audio=audio)


def told(
    name: str, off: list[float], sound: float, took: float, sure: list[float]
) -> dict[str, Any]:
    """Print one row of figures, and return them."""
    far = np.abs(off) * 1000
    print(
        f"{name:24} {len(far):6} {np.median(far):7.1f} {np.median(off) * 1000:+7.1f} "
        f"{np.quantile(far, 0.9):7.1f} {np.mean(far <= 20):7.0%} {np.mean(sure):6.2f} "
        f"{sound / took:7.1f}"
    )
    return json_figures.boundary_errors(off) | {"name": name, "speed": sound / took}


def measured(
    name: str, pairs: list[tuple[str, Schedule]], speaker: Speaker, aligner: str | None
) -> dict[str, Any]:
    """Align sounds with their texts, and print how far off they are."""
    off, sure, lips, took, sound = [], [], [], 0.0, 0.0
    for text, known in pairs:
        started = time.process_time()
        found = aligned(speaker, known.audio, text, aligner=aligner)
        took += time.process_time() - started
        sound += known.audio.seconds
        sure.append(found.confidence or 0.0)
        off += errors(found, known, speaker)
        lips += closures(found, known, speaker)
    row = told(name, off, sound, took, sure) | {"places": by_place(lips)}
    print_places(row["places"])
    return row


def labelled(wav: Path, lab: Path) -> Schedule:
    """Read a recording and its HTK labels: starts and ends in 100 ns, full context or not."""
    rows = []
    for line in lab.read_text(encoding="utf-8").splitlines():
        start, end, label = line.split()[:3]
        inner = re.search(r"-(.+?)\+", label)
        rows.append((inner[1] if inner else label, int(start) / 1e7, int(end) / 1e7))
    rows = [(SILENCE if label in ("sil", "pau") else label.upper(), a, b) for label, a, b in rows]
    return Schedule.from_intervals(rows, notation="arpabet", audio=read_audio(wav))


def main() -> int:
    """Print the figures."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("sentences", type=Path)
    parser.add_argument("--lab", nargs=3, metavar=("WAV", "LAB", "TEXT"))
    parser.add_argument("--aligner")
    parser.add_argument("-l", "--language", default="english")
    json_figures.add_option(parser)
    options = parser.parse_args()
    speaker = Speaker.of(options.language)
    texts = options.sentences.read_text(encoding="utf-8").split("\n")[:SPOKEN]
    spoken = [(text, speaker.speak(text)) for text in texts]
    aligned(speaker, spoken[0][1].audio, texts[0], aligner=options.aligner)  # reads the model
    titles = ("pairs", "median", "bias", "90 %", "<=20ms", "sure", "speed")
    print(f"{'':24} {titles[0]:>6} " + " ".join(f"{t:>7}" for t in titles[1:5]), end="")
    print(f" {titles[5]:>6} {titles[6]:>7}")
    rows = [measured("spoken", spoken, speaker, options.aligner)]
    random = np.random.default_rng(0)
    babble = sum(
        np.resize(resampled(one.audio, RATE).samples.astype(float), 30 * RATE)
        for _, one in spoken[:6]
    )
    for name, noise in (("white noise", random.normal(size=30 * RATE)), ("babble", babble)):
        loud = [
            (text, Schedule(known.labels, known.times, audio=noisy(known.audio, noise)))
            for text, known in spoken
        ]
        rows.append(measured(f"{name}, {SNR:g} dB", loud, speaker, options.aligner))
    long = joined([known for _, known in spoken], LONG)
    times = round(long.audio.seconds / joined([k for _, k in spoken], 1).audio.seconds)
    pair = (" ".join(texts * times), long)
    rows.append(measured(f"{long.audio.seconds:.0f} s", [pair], speaker, options.aligner))
    if options.lab:
        wav, lab, text = options.lab
        known = labelled(Path(wav), Path(lab))
        rows.append(measured(Path(wav).name, [(text, known)], speaker, options.aligner))
    json_figures.write_figures(options.json, {"rows": rows})
    return 0


if __name__ == "__main__":
    sys.exit(main())
