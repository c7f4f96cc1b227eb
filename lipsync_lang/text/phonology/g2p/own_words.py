"""Words that a pack reads its own way, with the endings of its language.

An entry serves the word and its inflected forms: `Shepardowi` is `Shepard` and `owi`, and a
language may have prefixes, too. A hyphen or an apostrophe may part the two. An ending that replaces
another, as `ę` does the `a` of `Anna`, replaces as many sounds as it has letters. An entry with a
capital serves words with a capital alone: names are short, and other words begin like them. It is
found behind a hyphen and a prefix in small letters, too: `noMacron` is `no` and `Macron`.
"""

import re
from collections.abc import Collection, Iterable, Mapping
from itertools import chain
from typing import NamedTuple

from lipsync_lang.text.phonology.g2p.abbreviation_keys import is_spaced
from lipsync_lang.text.phonology.g2p.g2p_engines import SpokenWord
from lipsync_lang.text.phonology.g2p.ipa_text import segments
from lipsync_lang.text.phonology.g2p.spoken_forms import OwnWord, SpokenForms
from lipsync_lang.text.phonology.g2p.tokens import Replacement, TextPiece, pieces, plain, respelled
from lipsync_lang.text.phonology.labels import STRESS, normalise

MIN_PREFIXED_CHARS = 3
"""Minimum number of letters of a word that takes a prefix; shorter ones begin other words."""

_WORD_PARTS = re.compile("^(?:[a-z]+(?=[A-Z])|[A-Z](?=[A-Z][a-z]))|[^-]+")


class FoundWords(NamedTuple):
    """Own words in a text: respelled ones, and those with labels by where they start."""

    respelled: list[Replacement]
    said: dict[int, SpokenWord]


def stands_alone(word: str) -> bool:
    """Return True for one word of a script that puts spaces between words."""
    return all(map(is_spaced, re.sub("['’-]", "", word)))


def by_spelling(labels: Iterable[str]) -> dict[str, str]:
    """Map the canonical spelling of each label to the label."""
    return {normalise(label): label for label in labels}


def ipa_labels(ipa: str, known: Mapping[str, str]) -> tuple[str, ...]:
    """Cut IPA into the labels known by their spelling, at its spaces and within them.

    Marks of stress are left out.
    """
    unstressed = "".join(letter for letter in ipa if letter not in STRESS)
    found = (label for part in unstressed.split() for label in segments(part, known))
    return tuple(known.get(label, label) for label in found)


class OwnWords:
    """A finder of the words of a pack and of their inflected forms."""

    def __init__(self, forms: SpokenForms) -> None:
        own = {plain(word): one for word, one in forms.words.items()}
        prefixed = {
            first + word: OwnWord((), said + one.say)
            for first, said in forms.beginnings.items()
            for word, one in own.items()
            if one.say and len(word) >= MIN_PREFIXED_CHARS
        }
        self._words = prefixed | own
        self._names = {plain(word) for word in forms.words if word[0].isupper()}
        self._small = {*prefixed, *(plain(word) for word in forms.words if not word[0].isupper())}
        self._endings = forms.endings
        lost = max(map(len, forms.endings), default=0)
        # Most words begin like none of these; an ending may replace the last letters.
        self._starts = {word[: min(max(len(word) - lost, 1), 3)] for word in self._words}
        # an apostrophe or a hyphen may stand before an ending
        self._longest = 1 + max(map(len, chain.from_iterable(forms.endings.values())), default=0)

    def found_in(self, text: str, tokens: Iterable[TextPiece]) -> FoundWords:
        """Find the words that the pack reads itself; `tokens` are the pieces of the text."""
        found = FoundWords([], {})
        for piece in tokens:
            word = plain(piece.text)
            apart = "-" in word or word[1:] != piece.text[1:]
            if not apart and self._starts.isdisjoint((word[:3], word[:2], word[:1])):
                continue
            at, whole = piece.start, self._find(piece.text)
            for part in (piece.text,) if whole else _WORD_PARTS.findall(piece.text):
                at = text.index(part, at)
                one = self._find(part)
                if one is not None and one.labels:
                    found.said[at] = SpokenWord(part, *one)
                elif one is not None:
                    found.respelled.append(Replacement(at, at + len(part), one.say))
                at += len(part)
        return found

    def respelled(self, text: str) -> str:
        """Return a text with the spellings of its own words."""
        return respelled(text, self.found_in(text, pieces(text)).respelled)

    def _find(self, written: str) -> OwnWord | None:
        word = plain(written)
        if word in self._words and (written[0].isupper() or word in self._small):
            return self._words[word]
        for cut in range(len(word) - 1, max(len(word) - self._longest, 1) - 1, -1):
            stem, rest = word[:cut], word[cut:].lstrip("'-")
            for last, others in self._endings.items():
                own = self._words.get(stem + last) if rest in others else None
                if own and (written[0].isupper() or stem + last not in self._names):
                    return _inflected(own, last, rest, others)
        return None


def _inflected(
    own: OwnWord, last: str, ending: str, others: Mapping[str, Collection[str]]
) -> OwnWord | None:
    """Return a word with another ending; None if its spelling does not end with the first."""
    if own.say and not own.say.endswith(last):
        return None
    stem = own.labels[: len(own.labels) - len(last)]
    say = own.say.removesuffix(last) + ending if own.say else ""
    return OwnWord((*stem, *others[ending]) if own.labels else (), say)
