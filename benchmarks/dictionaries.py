"""Read the words of dictionaries, and count the phonemes that differ from theirs.

A folder holds a dictionary for each language, `LANGUAGE.tsv` by the pack's name or tag, or several,
`LANGUAGE.NAME.tsv`: a word, a tab, and its IPA, with or without spaces and slashes. Several lines
of a word, or several entries between commas or bars, are several pronunciations; the nearest
counts. Both sides become common phonemes, and a shade counts as its parent, as in the packs' tests.
A phoneme twice in a row counts once: some dictionaries write long sounds with two letters.

Printed for each language: words, phoneme error (edit distance by phonemes of the dictionary), the
shares of words whose lip closures and whose rounding of vowels differ, and with `--confusions N`
the commonest differences, with some words of each. Dictionaries also differ by how they write a
sound: `dictionaries.yaml` states such conventions, and a second line allows them.
`--json FILE` keeps the figures.
Dictionaries that a pack was tuned on say nothing: keep those for judging apart.
"""

import argparse
import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from statistics import median
from typing import Any, NamedTuple

import json_figures

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.library import Library
from lipsync_lang.packs.yaml.events import load_yaml
from lipsync_lang.resolver.language_tables import notations_of
from lipsync_lang.resolver.nearest_phonemes import among
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.phonology.g2p.ipa_text import segments
from lipsync_lang.text.phonology.labels import normalise

CLOSED = "bmp"
ROUNDED = {"w", "yu", "ao", "ow", "aw", "oy"}
NOTHING = "-"
IPA = "ipa"
SILENT = re.compile("[\\s.\u0361ˈˌ]")
"""Spaces, ties and stress in the IPA of a dictionary."""

CONVENTIONS = Path(__file__).with_suffix(".yaml")
Conventions = Mapping[str, str]
Pair = tuple[str, str]


class Score(NamedTuple):
    """Errors of a language in the words of a dictionary."""

    words: int
    phonemes: int
    errors: int
    closures: int
    rounding: int
    confusions: dict[Pair, list[str]]
    """The words of each (stated, read) pair that differs, most words first."""

    def shares(self) -> dict[str, float]:
        """Return errors by phonemes, and words whose lip closures and whose rounding differ."""
        return {
            "error": self.errors / max(self.phonemes, 1),
            "closures": self.closures / max(self.words, 1),
            "rounding": self.rounding / max(self.words, 1),
        }


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
        found: list[str] = []
        for label in segments(SILENT.sub("", ipa), self.known):
            value = self.notation.find(label) or self.near.value(label) or ()
            found += [name for name, _ in value]
        return self.coarse(found)

    def read(self, words: Iterable[str]) -> list[list[str]]:
        """Return the common phonemes of words, as the language reads them."""
        return [self.coarse(one.phonemes) for one in self.speaker.transcribe(words)]

    def score(
        self,
        dictionary: Mapping[str, list[str]],
        read: Iterable[Sequence[str]],
        allowed: Conventions,
    ) -> Score:
        """Compare readings with a dictionary, of whose IPA some conventions are allowed."""
        confusions: defaultdict[Pair, list[str]] = defaultdict(list)
        phonemes = errors = closures = rounding = 0
        for (word, stated), said in zip(dictionary.items(), read, strict=True):
            found, sounds = min(
                ((differences(one, said), one) for one in map(self.stated, meant(stated, allowed))),
                key=lambda pair: len(pair[0]),
            )
            phonemes += len(sounds)
            errors += len(found)
            closures += any(CLOSED in pair for pair in found)
            rounding += any((one in ROUNDED) != (other in ROUNDED) for one, other in found)
            for pair in found:
                confusions[pair].append(word)
        most = dict(sorted(confusions.items(), key=lambda item: -len(item[1])))
        return Score(len(dictionary), phonemes, errors, closures, rounding, most)


def meant(stated: Sequence[str], allowed: Conventions) -> list[str]:
    """Return the IPA of a dictionary, and each that some conventions make of it."""
    found = list(dict.fromkeys(SILENT.sub("", ipa) for ipa in stated))
    for pattern, instead in allowed.items():
        found += [new for one in found if (new := re.sub(pattern, instead, one)) not in found]
    return found


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
    conventions = load_yaml(CONVENTIONS.read_text("utf-8"))
    kept: dict[str, dict[str, Any]] = {}
    print(f"{'language':<20}{'words':>7}{'error':>8}{'closures':>10}{'rounding':>10}")
    for path in sorted(options.folder.glob("*.tsv")):
        name = path.stem.partition(".")[0]
        if options.only and name not in options.only:
            continue
        try:
            judge, words = Judge(library, name), words_of(path, options.most)
            read = judge.read(words)
        except LipsyncError as error:
            print(f"{path.stem:<20} {str(error).splitlines()[0]}")
            continue
        score = judge.score(words, read, {})
        kept[path.stem] = {"words": len(words), **score.shares()}
        show(path.stem, len(words), score.shares())
        if allowed := conventions.get(path.stem):
            score = judge.score(words, read, allowed)
            kept[path.stem]["allowed"] = score.shares()
            show("  conventions allowed", "", score.shares())
        for (stated, said), differ in list(score.confusions.items())[: options.confusions]:
            print(f"    {stated} read as {said}: {len(differ)}, as {', '.join(differ[:5])}")
    if kept:
        print(f"{'median':<27}{median(one['error'] for one in kept.values()):>8.3f}")
    json_figures.write_figures(options.json, {"languages": kept})


def show(name: str, words: int | str, shares: Mapping[str, float]) -> None:
    """Print a line of shares."""
    error, closures, rounding = shares.values()
    print(f"{name:<20}{words:>7}{error:>8.3f}{closures:>10.1%}{rounding:>10.1%}")


if __name__ == "__main__":
    main()
