"""Errors of alignment by warping at known boundaries.

    python benchmarks/warping.py [FOLDER] [--json FILE]

FOLDER holds the German recordings (NAME.wav beside NAME.phones.tsv: start, end, label in SAMPA),
whose boundaries were set by hand. One of them is of words that make no sentence, so that its
transcript is a guess at the spelling. Beside them, sentences by other voices than the one that
aligns: eSpeak's `en-us+f3` at 140 words per minute, and Festival's, where it is installed, whose
voice was cut from a person's. Each also with noise, and with a text that is not the one said.

Both sides become common phonemes and are aligned by them. A boundary counts where the sounds on
both its sides are the same on both sides: what the voice says otherwise than the speaker did, or
leaves out, has no boundary to compare.
"""

import argparse
import sys
from itertools import pairwise
from pathlib import Path
from time import perf_counter
from typing import Any

import json_figures
import numpy as np

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule
from lipsync_lang.sound.speech import ENGINES
from lipsync_lang.sound.speech.hearing.align.warping import Warp
from lipsync_lang.sound.speech.sound import read_audio
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.align import align

GERMAN = {
    "dfg91_s1em_0666": "Melanies Omi Kallim mit ihr ein Lied.",
    "dfgspp_mo1_prosody_0020": "Sie arbeitet in einer Kneipe als Kellnerin.",
    "dfgspp_mo1_prosody_0024": "Morgen muss sie weder Klausur noch Examen schreiben.",
}
PAUSES = ("<p:>", "&p:", "H#")
ENGLISH = (
    "The juice of lemons makes fine punch.",
    "Cars and busses stalled in snow drifts.",
    "The slang word for raw whiskey is booze.",
    "Add the column and put the sum here.",
    "The birch looked stark white and lonesome.",
    "The tube was blown and the tire flat and useless.",
    "Better hash is made of rare beef.",
    "The ramp led up to the wide highway.",
    "Send the stuff in a thick paper bag.",
    "The best method is to fix it in place with clips.",
    "When the frost has come it is time for turkey.",
    "A round mat will cover the dull spot.",
)

Trial = tuple[str, Schedule]
"""A text, and its true times with the recording."""


def german(folder: Path) -> list[Trial]:
    """Return the recordings of a folder; empty if it has none."""
    found = []
    for name, text in GERMAN.items():
        phones = folder / f"{name}.phones.tsv"
        if not phones.exists():
            continue
        rows = [row.split() for row in phones.read_text(encoding="utf-8").splitlines()]
        intervals = [
            (SILENCE if label in PAUSES else label, float(start), float(end))
            for start, end, label in rows
            if float(end) > float(start)
        ]
        audio = read_audio(folder / f"{name}.wav")
        found.append((text, Schedule.from_intervals(intervals, notation="sampa", audio=audio)))
    return found


def spoken(engine: str, voice: str, words_per_minute: int | None) -> list[Trial]:
    """Return the English sentences as another voice says them."""
    try:
        return [
            (text, ENGINES[engine].speak(text, voice, words_per_minute=words_per_minute))
            for text in ENGLISH
        ]
    except SpeechError as error:
        print(error)
        return []


def units(schedule: Schedule, speaker: Speaker) -> tuple[list[str], list[float]]:
    """Return the common phonemes, and when each starts; NaN within a label."""
    notation = speaker.notations[schedule.notation or "ipa"]
    names: list[str] = []
    starts: list[float] = []
    for label, start in zip(schedule.labels, schedule.times, strict=False):
        value = notation.find(label) or ()
        names += [name for name, _ in value]
        starts += [float(start), *[float("nan")] * (len(value) - 1)][: len(value)]
    return names, starts


def errors(found: Schedule, true: Schedule, speaker: Speaker) -> np.ndarray:
    """Return by how many seconds each boundary that both have comes late."""
    ours, our_starts = units(found, speaker)
    theirs, their_starts = units(true, speaker)
    at = align(theirs, ours, speaker.manner.kinds, SILENCE)
    late = [
        our_starts[n] - their_starts[at[n]]
        for m, n in pairwise(range(len(ours)))
        if at[m] >= 0
        and at[n] == at[m] + 1
        and ours[n] != SILENCE
        and (ours[m], ours[n]) == (theirs[at[m]], theirs[at[n]])
    ]
    return np.array([seconds for seconds in late if np.isfinite(seconds)])


def noisy(audio: Audio, decibels: float) -> Audio:
    """Return a recording with white noise so far below it."""
    sound = audio.samples.astype(float)
    level = np.sqrt((sound**2).mean()) * 10 ** (-decibels / 20)
    sound += np.random.default_rng(1).standard_normal(len(sound)) * level
    return Audio(np.clip(sound, -32768, 32767).astype(np.int16), audio.rate)


def report(
    name: str, trials: list[Trial], speaker: Speaker, decibels: float | None = None
) -> dict[str, Any]:
    """Print a row, and return its figures."""
    late, right, wrong = [], [], []
    seconds, began = 0.0, perf_counter()
    for number, (text, true) in enumerate(trials):
        audio = true.audio if decibels is None else noisy(true.audio, decibels)
        found = Warp().align(audio, text, speaker)
        late.append(errors(found, true, speaker))
        right.append(found.confidence)
        other = trials[(number + 1) % len(trials)][0]
        wrong.append(Warp().align(audio, other, speaker).confidence)
        seconds += 2 * audio.seconds
    speed = seconds / (perf_counter() - began)
    milliseconds = np.abs(np.concatenate(late)) * 1000
    print(
        f"{name:<32}{len(milliseconds):>6}{np.median(milliseconds):>8.1f}"
        f"{np.percentile(milliseconds, 90):>8.1f}{1000 * np.median(np.concatenate(late)):>8.1f}"
        f"{np.median(right):>8.2f}{min(right):>6.2f}{np.median(wrong):>8.2f}{max(wrong):>6.2f}"
        f"{speed:>7.0f}x"
    )
    return json_figures.boundary_errors(np.concatenate(late)) | {"name": name}


def music(seconds: float, rate: int) -> np.ndarray:
    """Return chords with harmonics, and drums, at any level."""
    random = np.random.default_rng(5)
    time = np.arange(rate // 2) / rate
    out = []
    for beat in range(int(seconds * 2)):
        root = 220 * 2 ** (random.choice([0, 2, 4, 5, 7, 9]) / 12)
        tones = [root * third * order for third in (1, 1.26, 1.5) for order in range(1, 8)]
        chord = sum(np.sin(2 * np.pi * tone * time) * root / tone for tone in tones)
        drum = random.standard_normal(len(time)) * np.exp(-time * (40 if beat % 2 else 15)) * 3
        out.append(chord * np.exp(-2 * time) + drum)
    return np.concatenate(out)


def beside(audio: Audio, sound: np.ndarray) -> tuple[Audio, float]:
    """Return a recording with other sound of its level before and after it, and its start."""
    line = audio.samples.astype(float)
    other = sound * np.sqrt((line**2).mean() / (sound.astype(float) ** 2).mean())
    samples = np.concatenate([other, line, other])
    whole = Audio(np.clip(samples, -32768, 32767).astype(np.int16), audio.rate)
    return whole, len(other) / audio.rate


def moved(name: str, trials: list[Trial], speaker: Speaker) -> None:
    """Print rows: how far 5 s of other sound on both sides move the boundaries."""
    for kind in ("music", "noise", "another line"):
        apart = []
        for number, (text, true) in enumerate(trials):
            rate = true.audio.rate
            if kind == "music":
                sound = music(5, rate)
            elif kind == "noise":
                sound = np.random.default_rng(6).standard_normal(5 * rate)
            else:
                sound = trials[(number + 1) % len(trials)][1].audio.samples.astype(float)
            audio, start = beside(true.audio, sound)
            clean, found = (Warp().align(one, text, speaker) for one in (true.audio, audio))
            times = [
                np.array([t for x, t in zip(one.labels, one.times, strict=False) if x != SILENCE])
                for one in (clean, found)
            ]
            apart.append(np.abs(times[1] - start - times[0]) * 1000)
        late = np.concatenate(apart)
        print(
            f"{name + ', ' + kind:<40}{len(late):>6}{np.median(late):>8.1f}"
            f"{np.percentile(late, 90):>8.1f}{100 * np.mean(late > 20):>7.0f} %"
        )


def joined(name: str, trials: list[Trial], speaker: Speaker, repeats: int = 4) -> None:
    """Print a row: sentence ends of a long take that are more than 300 ms off."""
    random = np.random.default_rng(3)
    rate = trials[0][1].audio.rate
    order = [trials[n] for _ in range(repeats) for n in random.permutation(len(trials))]
    sounds, ends, at = [], [], 0.0
    for _, true in order:
        pause = random.normal(0, 10, int(random.uniform(0.15, 1.2) * rate)).astype(np.int16)
        ends += [at + true.times[true.words[0].first], at + true.times[true.words[-1].stop]]
        sounds += [true.audio.samples, pause]
        at += (len(true.audio.samples) + len(pause)) / rate
    audio = Audio(np.concatenate(sounds), rate)
    began = perf_counter()
    found = Warp().align(audio, " ".join(text for text, _ in order), speaker)
    speed = audio.seconds / (perf_counter() - began)
    words, spans = 0, []
    for _, true in order:
        last = found.words[words + len(true.words) - 1]
        spans += [found.times[found.words[words].first], found.times[last.stop]]
        words += len(true.words)
    late = np.abs(np.array(spans) - ends) * 1000
    print(
        f"{f'{name}, {audio.seconds:.0f} s at once':<40}{len(late):>6}{np.median(late):>8.1f}"
        f"{100 * np.mean(late > 300):>7.1f} % {speed:>6.0f}x"
    )


def main(folder: Path, file: Path | None = None) -> int:
    """Print the table."""
    speakers = {name: Speaker.of(name) for name in ("german", "english")}
    trials = [
        ("German, by hand", german(folder), speakers["german"]),
        ("English, eSpeak en-us+f3", spoken("espeak", "en-us+f3", 140), speakers["english"]),
        ("English, Festival kal", spoken("festival", "kal_diphone", None), speakers["english"]),
    ]
    print("Boundaries found by warping: error in ms, confidence of right and wrong texts")
    print(
        f"{'':<32}{'number':>6}{'median':>8}{'90 %':>8}{'late':>8}{'right':>8}{'least':>6}"
        f"{'wrong':>8}{'most':>6}{'speed':>8}"
    )
    rows = []
    for name, some, speaker in trials:
        if some:
            rows.append(report(name, some, speaker))
            rows.append(report(f"{name}, noise at 20 dB", some, speaker, 20))
            rows.append(report(f"{name}, noise at 10 dB", some, speaker, 10))
    print("How far other sound on both sides moves them, in ms; share of more than 20 ms")
    for name, some, speaker in trials:
        if len(some) > 1:
            moved(name, some, speaker)
    print("Sentence ends in a long take, in ms; share of more than 300 ms")
    for name, some, speaker in trials:
        if some and all(true.words for _, true in some):
            joined(name, some, speaker)
    json_figures.write_figures(file, {"rows": rows})
    return 0


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", nargs="?", default="articulography", type=Path)
    json_figures.add_option(parser)
    arguments = parser.parse_args()
    sys.exit(main(arguments.folder, arguments.json))
