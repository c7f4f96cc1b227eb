"""Words that the aligner leaves out: spoken ones, and those that the sound really lacks.

    python benchmarks/left_out.py TEXTS [--only LANGUAGE ...] [--first N] [--lines N]
        [--aligner NAME] [--list] [--json FILE]

TEXTS is a table with a column for each language, or a folder of texts, both named as `languages.py`
reads them. Each pack's own voice speaks the lines of its language. A line is aligned as it is, with
a word cut out of its sound at the voice's own times, with a word that the voice never said, and
with two neighbours exchanged. The table counts

left out   words of right texts that are left out, of all
doubted    right lines with a confidence below a half, of all
cut, said  words cut out of the sound, and words that were never said, that are left out, of all
exchanged  lines with two words exchanged that are in doubt, of all

`--list` writes rows in place of the table, to compare two versions: language, number of the line,
words of its own text that are left out, and the text. Lines with errors are not tried then.
"""

import argparse
import csv
import random
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import json_figures
import numpy as np

from languages import find
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.library import Library
from lipsync_lang.schedules.schedule import DOUBTFUL, Audio, Schedule
from lipsync_lang.sound.speech.hearing.alignment import align_many
from lipsync_lang.sound.speech.speaking.speaker import Speaker

MAX_WORDS = 40
"""Most words of a line; longer ones, such as paragraphs of a law, are cut."""

MIN_CUT_PHONEMES = 4
"""Fewest phonemes of a word that is taken from the sound: a shorter one is hardly heard."""

MIN_WORDS = 5
"""Fewest words of a line that is changed."""


class Trial(NamedTuple):
    """A sound with a text, by what was done to them; `word` is the one that is not spoken."""

    kind: str
    audio: Audio
    text: str
    word: str = ""


def texts(path: Path) -> Iterator[tuple[str, list[str]]]:
    """Yield the lines of each column of a table, or of each text of a folder, with its name."""
    if path.is_dir():
        for file in sorted(path.glob("*.txt")):
            yield file.stem, file.read_text("utf-8").splitlines()
        return
    with path.open(encoding="utf-8") as stream:
        rows = [*csv.DictReader(stream, delimiter="\t")]
    for name in rows[0]:
        yield name, [row[name] or "" for row in rows]


def trials(speaker: Speaker, line: str, chance: random.Random) -> Iterator[Trial]:
    """Yield a line that its voice speaks, as it is and with small errors."""
    text = " ".join(line.split()[:MAX_WORDS])
    spoken = speaker.speak(text)
    if spoken.audio is None:
        return
    yield Trial("right", spoken.audio, text)
    words = text.split()
    # a word of the voice is a word of the text only where both count alike
    if len(words) < MIN_WORDS or len(spoken.words) != len(words):
        return
    long = [n for n, one in enumerate(spoken.words) if one.stop - one.first >= MIN_CUT_PHONEMES]
    if long:
        at = chance.choice(long)
        one, rate, samples = spoken.words[at], spoken.audio.rate, spoken.audio.samples
        first, stop = round(one.start * rate), round(one.end * rate)
        rest = np.concatenate([samples[:first], samples[stop:]])
        yield Trial("cut", Audio(rest, rate), text, one.text)
        without = speaker.speak(" ".join([*words[:at], *words[at + 1 :]])).audio
        if without is not None:
            yield Trial("never said", without, text, one.text)
    at = chance.randrange(len(words) - 1)
    if words[at].casefold() != words[at + 1].casefold():
        exchanged = [*words[:at], words[at + 1], words[at], *words[at + 2 :]]
        yield Trial("exchanged", spoken.audio, " ".join(exchanged))


def measured(
    speaker: Speaker, lines: Sequence[str], aligner: str | None
) -> tuple[Counter[str], Counter[str], list[str]]:
    """Count what was found and what was tried, by kind, and list what went wrong."""
    chance = random.Random(1)
    found: Counter[str] = Counter()
    tried: Counter[str] = Counter()
    told: list[str] = []
    known: list[Trial] = []
    for line in lines:
        try:
            known += trials(speaker, line, chance)
        except LipsyncError as error:
            told.append(str(error).splitlines()[0])
    results = align_many(speaker, [(one.audio, one.text) for one in known], aligner=aligner)
    for one, result in zip(known, results, strict=True):
        lost = [*result.left_out] if isinstance(result, Schedule) else []
        sure = (result.confidence or 0.0) if isinstance(result, Schedule) else 0.0
        if one.kind == "right":
            words = len(result.words) if isinstance(result, Schedule) else 0
            found["words"] += len(lost)
            tried["words"] += words + len(lost)
            told += [f"{', '.join(lost)} in '{one.text}'"] if lost else []
        if one.kind in ("right", "exchanged"):
            found[one.kind] += sure < DOUBTFUL
            tried[one.kind] += 1
            if one.kind == "right" and sure < DOUBTFUL:
                what = result.remarks if isinstance(result, Schedule) else [str(result)]
                told.append(f"doubted: '{one.text}' {'; '.join(what)}")
        else:
            found[one.kind] += one.word in lost
            tried[one.kind] += 1
    return found, tried, told


def listed(speaker: Speaker, lines: Sequence[str], first: int, aligner: str | None) -> None:
    """Print a row for each line whose own text loses words."""
    for number, line in enumerate(lines, first):
        try:
            known = [*islice(trials(speaker, line, random.Random(1)), 1)] if line.strip() else []
        except LipsyncError:
            continue
        pairs = [(one.audio, one.text) for one in known]
        for one, found in zip(known, align_many(speaker, pairs, aligner=aligner), strict=True):
            lost = found.left_out if isinstance(found, Schedule) else ("the whole line",)
            if lost:
                print(
                    speaker.manner.language, number, ", ".join(lost), one.text, sep="\t", flush=True
                )


def main() -> int:
    """Print the table, or a list."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("texts", type=Path)
    parser.add_argument("--only", nargs="+", metavar="LANGUAGE")
    parser.add_argument("--first", type=int, default=1, help="first line that is taken [1]")
    parser.add_argument("--lines", type=int, default=12, help="lines of each language [12]")
    parser.add_argument("--aligner")
    parser.add_argument("--list", action="store_true", help="print the lines that lose words")
    json_figures.add_option(parser)
    options = parser.parse_args()
    library, kinds = Library(), ("words", "right", "cut", "never said", "exchanged")
    names = ("left out", "doubted", "cut", "never said", "exchanged")
    if not options.list:
        print(f"{'':16}" + "".join(f"{name:>12}" for name in names))
    counted: dict[str, dict[str, float]] = {}
    all_found: Counter[str] = Counter()
    all_tried: Counter[str] = Counter()
    for name, lines in texts(options.texts):
        if options.only and name not in options.only:
            continue
        language = find(library, name)
        speaker = Speaker.of(language) if language and ":" not in language else None
        if speaker is None or not speaker.manner.voice:
            continue
        some = lines[options.first - 1 :][: options.lines]
        if options.list:
            listed(speaker, some, options.first, options.aligner)
            continue
        found, tried, told = measured(
            speaker, [one for one in some if one.strip()], options.aligner
        )
        cells = "".join(f"{f'{found[kind]}/{tried[kind]}':>12}" for kind in kinds)
        print(f"{speaker.manner.language:16}{cells}", flush=True)
        for one in told:
            print(f"    {one}", file=sys.stderr, flush=True)
        counted[speaker.manner.language] = {f"{kind}_found": found[kind] for kind in kinds} | {
            f"{kind}_tried": tried[kind] for kind in kinds
        }
        all_found += found
        all_tried += tried
    if options.list:
        return 0
    print(f"{'all':16}" + "".join(f"{f'{all_found[k]}/{all_tried[k]}':>12}" for k in kinds))
    json_figures.write_figures(options.json, counted)
    return 0


if __name__ == "__main__":
    sys.exit(main())
