"""Shares of wrong and of right texts that the aligner warns of.

    python benchmarks/doubts.py FOLDER [--only LANGUAGE ...] [--aligner NAME] [--json FILE]

FOLDER has a folder for each language, named as its pack, with a folder for each speaker: recordings
`NAME.wav` (or .flac, .ogg, .mp3, .opus), and the text of each in `NAME.txt`. Each text of at least
five words is tried as it is, with a word left out, with two neighbours exchanged, with a word moved
by three places or more, and with its halves exchanged; and as it is, with 5 s of music or another
speaker before or after the line. A second from within the recording is tried with its own words
and with as many words of the next text.

A line is warned of if its confidence is below a half or a remark names a place in it. Sound without
text is no warning where there is sound beside the line.
"""

import argparse
import random
import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import json_figures
import numpy as np
from hearing import music

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.schedules.schedule import DOUBTFUL, Audio, Schedule
from lipsync_lang.sound.speech.hearing.alignment import align_many, aligned
from lipsync_lang.sound.speech.sound import AUDIO_SUFFIXES, read_audio, resampled
from lipsync_lang.sound.speech.speaking.speaker import Speaker

RATE = 16_000
BESIDE_SECONDS = 5.0
MIN_WORDS = 5
MIN_LETTERS = 3
"""Fewest letters of a word that is left out or moved."""

BESIDE = ("music beside", "a voice beside")


class Line(NamedTuple):
    """A recording with its spoken words."""

    audio: Audio
    text: str
    speaker: Path


class Trial(NamedTuple):
    """A recording with a right or a wrong text, by kind of error."""

    kind: str
    audio: Audio
    text: str


def lines(folder: Path) -> list[Line]:
    """Return the recordings of a folder that have a text of some words beside them."""
    sounds = sorted(p for p in folder.rglob("*") if p.suffix.lower() in AUDIO_SUFFIXES)
    pairs = [(sound, sound.with_suffix(".txt")) for sound in sounds]
    read = [(sound, text.read_text("utf-8")) for sound, text in pairs if text.exists()]
    long = [(sound, text) for sound, text in read if len(text.split()) >= MIN_WORDS]
    return [
        Line(resampled(read_audio(sound), RATE), " ".join(text.split()), sound.parent)
        for sound, text in long
    ]


def wrong_texts(text: str, chance: random.Random) -> Iterator[tuple[str, str]]:
    """Yield texts that differ a little from one, by kind."""
    words = text.split()
    told = [n for n, word in enumerate(words) if sum(map(str.isalpha, word)) >= MIN_LETTERS]
    if not told:
        return
    at = chance.choice(told)
    rest = [*words[:at], *words[at + 1 :]]
    yield "a word left out", " ".join(rest)
    to = chance.choice([n for n in range(len(words)) if abs(n - at) >= min(3, len(words) // 2)])
    yield "a word moved", " ".join([*rest[:to], words[at], *rest[to:]])
    at = chance.randrange(len(words) - 1)
    exchanged = [*words[:at], words[at + 1], words[at], *words[at + 2 :]]
    yield "neighbours exchanged", " ".join(exchanged)
    half = len(words) // 2
    yield "halves exchanged", " ".join(words[half:] + words[:half])


def beside(line: Line, voice: Line, chance: random.Random) -> Iterator[Trial]:
    """Yield a line with music, and with another voice, before or after it."""
    said = line.audio.samples.astype(float)
    for kind, sound in zip(BESIDE, (music(BESIDE_SECONDS), voice.audio.samples), strict=True):
        more = np.resize(sound.astype(float), round(BESIDE_SECONDS * RATE))
        more *= said.std() / max(more.std(), 1e-9)
        parts = [more, said] if chance.random() < 1 / 2 else [said, more]
        whole = np.clip(np.concatenate(parts), -32768, 32767)
        yield Trial(kind, Audio(whole.astype(np.int16), RATE), line.text)


def second(found: Schedule, line: Line, other: Line, chance: random.Random) -> Iterator[Trial]:
    """Yield some words that take a second, with their own text and with another one."""
    ends = [(found.times[word.first], found.times[word.stop], word.text) for word in found.words]
    first = chance.randrange(len(ends))
    inside = [one for one in ends[first:] if one[1] <= ends[first][0] + 1.0]
    if not inside:
        return
    start = max(0, round((ends[first][0] - 0.05) * RATE))
    clip = Audio(line.audio.samples[start : round((inside[-1][1] + 0.05) * RATE)], RATE)
    wrong = other.text.split()[: len(inside)]
    yield Trial("a second, right", clip, " ".join(text for *_, text in inside))
    yield Trial("a second, wrong", clip, " ".join(wrong))


def trials(
    speaker: Speaker, known: Sequence[Line], voices: Sequence[Line], aligner: str | None
) -> Iterator[Trial]:
    """Yield the trials of a language, with voices of any."""
    chance = random.Random(1)
    for number, line in enumerate(known):
        other = known[(number + 1) % len(known)]
        yield Trial("right", line.audio, line.text)
        for kind, text in wrong_texts(line.text, chance):
            if text != line.text:
                yield Trial(kind, line.audio, text)
        others = [one for one in voices if one.speaker != line.speaker]
        if others:
            yield from beside(line, chance.choice(others), chance)
        try:
            found = aligned(speaker, line.audio, line.text, aligner=aligner)
        except SpeechError as error:
            print(error, file=sys.stderr)
        else:
            yield from second(found, line, other, chance)


def warned(kind: str, found: Schedule | SpeechError) -> bool:
    """Return True if a remark of the result doubts the text."""
    if isinstance(found, SpeechError) or (found.confidence or 0.0) < DOUBTFUL:
        return True
    told = [one for one in found.remarks if not one.startswith("aligned by")]
    return any(kind not in BESIDE or "sound without text" not in one for one in told)


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="+", metavar="LANGUAGE")
    parser.add_argument("--aligner")
    json_figures.add_option(parser)
    options = parser.parse_args()
    names = sorted(path.name for path in options.folder.iterdir() if path.is_dir())
    counted: dict[str, dict[str, list[bool]]] = {}
    known = {name: lines(options.folder / name) for name in names}
    voices = [line for of in known.values() for line in of]
    for language in options.only or names:
        speaker, counts = Speaker.of(language), defaultdict(list)
        tried = list(trials(speaker, known[language], voices, options.aligner))
        pairs = [(one.audio, one.text) for one in tried]
        found = align_many(speaker, pairs, aligner=options.aligner)
        for one, result in zip(tried, found, strict=True):
            counts[one.kind].append(warned(one.kind, result))
        counted[language] = counts
        print(f"{language} is done", file=sys.stderr, flush=True)
    kinds = list(dict.fromkeys(kind for counts in counted.values() for kind in counts))
    print(f"{'warned of':22}" + "".join(f"{language:>12}" for language in counted))
    for kind in kinds:
        cells = [counts[kind] for counts in counted.values()]
        shown = [f"{sum(one)}/{len(one)}" if one else "-" for one in cells]
        print(f"{kind:22}" + "".join(f"{one:>12}" for one in shown))
    json_figures.write_figures(
        options.json,
        {
            language: {
                kind: {"texts": len(of), "warned_of": np.mean(of)} for kind, of in counts.items()
            }
            for language, counts in counted.items()
        },
    )
    return 0


if __name__ == "__main__":
    sys.exit(main())
