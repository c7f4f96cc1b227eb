"""Read the words of dictionaries, and count the phonemes that differ from theirs.

A folder holds a dictionary for each language, `LANGUAGE.tsv` by the pack's name or tag, or several,
`LANGUAGE.NAME.tsv`: a word, a tab, and its IPA, with or without spaces and slashes. Several lines
of a word, or several entries between commas or bars, are several pronunciations; the nearest
counts. Both sides become common phonemes, and a shade counts as its parent, as in the packs' tests.
A phoneme twice in a row counts once: some dictionaries write long sounds with two letters.

Printed for each language: words, phoneme error (edit distance by phonemes of the dictionary), the
shares of words whose lip closures and whose rounding of vowels differ, and with `--confusions N`
the commonest differences.
`--json FILE` keeps the figures.
Dictionaries that a pack was tuned on say nothing: keep those for judging apart.
"""

import argparse
from collections import Counter
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from statistics import median
from typing import NamedTuple

import json_figures

from lipsync_lang.errors import LipsyncError
from lipsync_lang.packs.library import Library
from lipsync_lang.phonology.g2p.epitran import segments
from lipsync_lang.phonology.labels import normalise
from lipsync_lang.resolver.language_tables import notations_of
from lipsync_lang.resolver.nearest_phonemes import among
from lipsync_lang.speech.speaking.speaker import Speaker

CLOSED = "bmp"
ROUNDED = {"w", "yu", "ao", "ow", "aw", "oy"}
NOTHING = "-"
IPA = "ipa"

Pair = tuple[str, str]


class Score(NamedTuple):
    """Errors of a language in the words of a dictionary."""

    words: int
    phonemes: int
    errors: int
    closures: int
    rounding: int
    confusions: Counter[Pair]

    @property
    def error(self) -> float:
        """Errors by phonemes of the dictionary."""
        return self.errors / max(self.phonemes, 1)


def differences(stated: Sequence[str], read: Sequence[str]) -> list[Pair]:
    """Return the least (stated, read) pairs that differ; `-` for a missing side."""
    above: list[list[Pair]] = [[(NOTHING, one) for one in read[:n]] for n in range(len(read) + 1)]
    for row, one in enumerate(stated, start=1):
        here = [[(name, NOTHING) for name in stated[:row]]]
        for column, other in enumerate(read, start=1):
            changed = [] if one == other else [(one, other)]
            here.append(
                min(
                    above[column - 1] + changed,
                    above[column] + [(one, NOTHING)],
                    here[-1] + [(NOTHING, other)],
                    key=len,
                )
            )
        above = here
    return above[-1]


class Judge:
    """A language, and the common phonemes of its dictionary's IPA."""

    def __init__(self, library: Library, name: str) -> None:
        pack = library.language(name)
        common = library.common().model
        self.shades, self.silence = common.shades, common.silence
        self.speaker = Speaker.of(name)
        self.notation = notations_of(library, pack)[IPA]
        self.near = among(library, pack)
        self.known = frozenset(map(normalise, pack.model.notations[IPA]))

    def coarse(self, phonemes: Sequence[str]) -> list[str]:
        """Return phonemes without silence and repeats, shades as their parents."""
        parents = (
            self.shades[name].like if name in self.shades else name
            for name in phonemes
            if name != self.silence
        )
        return [name for name, _ in groupby(parents)]

    def stated(self, ipa: str) -> list[str]:
        """Return the common phonemes of IPA."""
        plain = "".join(ipa.split()).replace("\u0361", "").replace(".", "")
        found: list[str] = []
        for label in segments(plain, self.known):
            value = self.notation.find(label) or self.near.value(label) or ()
            found += [name for name, _ in value]
        return self.coarse(found)

    def score(self, dictionary: dict[str, list[str]]) -> Score:
        """Read the words, and compare."""
        read = self.speaker.transcribe(dictionary)
        confusions: Counter[Pair] = Counter()
        phonemes = errors = closures = rounding = 0
        for (_, stated), transcript in zip(dictionary.items(), read, strict=True):
            said = self.coarse(transcript.phonemes)
            found, sounds = min(
                ((differences(one, said), one) for one in map(self.stated, stated)),
                key=lambda pair: len(pair[0]),
            )
            phonemes += len(sounds)
            errors += len(found)
            closures += any(CLOSED in pair for pair in found)
            rounding += any((one in ROUNDED) != (other in ROUNDED) for one, other in found)
            confusions.update(found)
        return Score(len(dictionary), phonemes, errors, closures, rounding, confusions)


def words_of(path: Path, most: int) -> dict[str, list[str]]:
    """Read a dictionary, thinned evenly to at most `most` words."""
    found: dict[str, list[str]] = {}
    for line in path.read_text("utf-8").splitlines():
        word, _, ipa = line.partition("\t")
        if word.strip() and ipa.strip():
            stated = (one.strip().strip("/") for one in ipa.replace("|", ",").split(","))
            found.setdefault(word.strip(), []).extend(one for one in stated if one)
    step = max(1, -(-len(found) // most))
    return dict(list(found.items())[::step])


def main() -> None:
    """Judge the dictionaries of a folder."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--most", type=int, default=1000, help="words of a dictionary")
    parser.add_argument("--confusions", type=int, default=0)
    json_figures.add_option(parser)
    options = parser.parse_args()
    library = Library()
    kept: dict[str, dict[str, float]] = {}
    errors: list[float] = []
    print(f"{'language':<16}{'words':>7}{'error':>8}{'closures':>10}{'rounding':>10}")
    for path in sorted(options.folder.glob("*.tsv")):
        if options.only and path.stem.partition(".")[0] not in options.only:
            continue
        try:
            score = Judge(library, path.stem.partition(".")[0]).score(words_of(path, options.most))
        except LipsyncError as error:
            print(f"{path.stem:<16} {str(error).splitlines()[0]}")
            continue
        errors.append(score.error)
        closures, rounding = (n / max(score.words, 1) for n in (score.closures, score.rounding))
        kept[path.stem] = {"words": score.words, "error": score.error, "closures": closures,
                           "rounding": rounding}  # fmt: skip
        print(
            f"{path.stem:<16}{score.words:>7}{score.error:>8.3f}{closures:>10.1%}{rounding:>10.1%}"
        )
        for (stated, read), count in score.confusions.most_common(options.confusions):
            print(f"    {stated} read as {read}: {count}")
    if errors:
        print(f"{'median':<16}{'':>7}{median(errors):>8.3f}")
    json_figures.write_figures(options.json, {"languages": kept})


if __name__ == "__main__":
    main()
