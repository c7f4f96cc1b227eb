"""Interjections: `Mmm`, `Shhh`, `Hahaha`, by a shortest spelling with its labels.

A letter may be repeated more often than in the shortest spelling; its sound lasts longer then.
A spelling that is one part twice (`haha`) may be repeated as a whole.
"""

import re
from collections.abc import Mapping
from functools import cache
from itertools import groupby
from typing import NamedTuple
from unicodedata import name

from lipsync_lang.text.phonology.g2p.drawn_out import SYLLABIC, ElongatedWord, IsVowel, lengthened
from lipsync_lang.text.phonology.g2p.g2p_engines import SpokenWord, merged
from lipsync_lang.text.phonology.g2p.spoken_forms import Interjection
from lipsync_lang.text.phonology.g2p.tokens import plain


class _Pattern(NamedTuple):
    """A shortest spelling as an expression with a group for each letter; or one for a part."""

    whole: re.Pattern[str]
    part: re.Pattern[str] | None
    runs: tuple[int, ...]
    interjection: Interjection


class Interjections:
    """A finder of interjections by their shortest spelling; `vowels` are letters."""

    def __init__(self, known: Mapping[str, Interjection], is_vowel: IsVowel, vowels: str) -> None:
        self._is_vowel, self._vowels = is_vowel, vowels
        self._known: dict[str, list[tuple[str, Interjection]]] = {}
        self._starts: set[str] = set()
        for spelling, interjection in sorted(known.items(), key=lambda item: -len(item[0])):
            folded = plain(spelling)
            self._known.setdefault(folded[0], []).append((folded, interjection))
            letters = [letter for letter, _ in groupby(folded)]
            self._starts |= {folded[0] * 2, "".join(letters[:2])}

    def possible(self, token: str) -> bool:
        """Return False for a word without hyphens that is surely no interjection."""
        return token[:2].casefold() in self._starts

    def find(self, token: str, *, shouted: bool = False) -> SpokenWord | None:
        """Return a word read as an interjection; None for any other word.

        Capitals alone are an abbreviation, unless the whole text is `shouted` in capitals.
        """
        word = plain(token)
        if "-" in word:
            parts = [self.find(part) for part in word.split("-") if part]
            said = [one for one in parts if one is not None]
            if said and len(said) == len(parts):
                return merged(token, said, " ".join(one.respelled for one in said))
        for spelling in dict.fromkeys((word, word.replace("-", ""))):
            for known in self._known.get(spelling[:1], ()):
                pattern = _pattern(*known)
                found = pattern.whole.fullmatch(spelling)
                if not found:
                    continue
                drawn = [
                    len(group) - run
                    for group, run in zip(found.groups(), pattern.runs, strict=True)
                ]
                if token.isupper() and len(token) > 1 and not (shouted or any(drawn)):
                    continue
                return self._said(token, spelling, pattern, drawn)
        return None

    def _said(self, token: str, spelling: str, pattern: _Pattern, drawn: list[int]) -> SpokenWord:
        labels, say = pattern.interjection
        said = SpokenWord(token, labels, say or re.sub(r"(.)\1{2,}", r"\1", spelling))
        if pattern.part is not None:
            return said._replace(
                labels=labels[: len(labels) // 2] * len(pattern.part.findall(spelling))
            )
        runs = tuple((place, more) for place, more in enumerate(drawn) if more)
        word = "".join(letter for letter, _ in groupby(spelling))
        return lengthened(said, ElongatedWord(word, runs), self._is_vowel, self._vowels)


@cache  # few texts need them
def _pattern(spelling: str, interjection: Interjection) -> _Pattern:
    half = spelling[: len(spelling) // 2]
    syllable = name(half[:1] or spelling, "").startswith(SYLLABIC)
    if half * 2 == spelling and (len(set(half)) > 1 or syllable):
        more = "" if syllable else "+"  # a syllable again is said again
        unit = "".join(f"{re.escape(letter)}{more}" for letter, _ in groupby(half))
        whole = re.compile(f"(?:{unit}){{2,}}(?:{re.escape(half[0])}+)?")
        return _Pattern(whole, re.compile(unit), (), interjection)
    runs = [(letter, len(list(run))) for letter, run in groupby(spelling)]
    whole = re.compile("".join(f"({re.escape(letter)}{{{n},}})" for letter, n in runs))
    return _Pattern(whole, None, tuple(n for _, n in runs), interjection)
