"""Letters of foreign names that an engine lacks, such as the ễ of Nguyễn.

eSpeak NG says "letter one E C five" for such a letter, and other engines leave it out. The letter
becomes the nearest one that the engine has: without some of its marks, or the letter in its Unicode
name, as the b of ɓ. To find what an engine has, it reads each letter once in a made-up word.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from unicodedata import name, normalize

from lipsync_lang.text.phonology.g2p.tokens import Replacement

COMMON_END = "\u024f"
"""Last letter of Latin Extended-B; engines have nearly all letters up to here."""

_RARE = re.compile(r"[^\W\d_][\u0300-\u036f]+|[\u0250-\u02af\u1e00-\u1eff]")
_LETTER_NAME = re.compile(r"LATIN .*LETTER (?:SMALL CAPITAL |SCRIPT )?([A-Z])(?: WITH .+)?")
_WHOLE_WORD = re.compile(r"[^\W\d_](?:[^\W\d_]|[\u0300-\u036f'’])*")

SPELLED_LABELS = 4
"""Least number of labels by which a letter that is spelled as a number is longer than another."""

LettersRead = Callable[[Sequence[str]], Sequence[int | None]]
"""Count the labels of words; None for a word with letters that are not read."""


def plainer(letter: str) -> str:
    """Return the nearest common letter: with one of its marks, or none; itself if there is none.

    >>> plainer("ễ"), plainer("ộ"), plainer("ɓ"), plainer("ш")
    ('ê', 'ô', 'b', 'ш')
    """
    base, *marks = [*normalize("NFD", letter)]
    for mark in marks:
        marked = normalize("NFC", base + mark)
        if len(marked) == 1 and marked <= COMMON_END:
            return marked
    if base <= "z":
        return base
    found = _LETTER_NAME.fullmatch(name(base, ""))
    return found[1].upper() if found and base.isupper() else found[1].lower() if found else letter


class RareLetters:
    """Finds words with letters that an engine lacks."""

    def __init__(self, read: LettersRead) -> None:
        self._read = read
        self._known: dict[str, str] = {}

    def instead(self, text: str) -> dict[str, str]:
        """Return the letters of a text that the engine lacks, with those to read instead."""
        rare = dict.fromkeys(normalize("NFC", found) for found in _RARE.findall(text))
        self._learn([one for one in rare if one not in self._known])
        return {one: self._known[one] for one in rare if self._known[one] != one}

    def found_in(self, text: str) -> Iterator[Replacement]:
        """Yield the words with such letters, spelled with others."""
        others = self.instead(text)
        for word in _WHOLE_WORD.finditer(text) if others else ():
            read = normalize("NFC", word[0])
            for letter, other in others.items():
                read = read.replace(letter, other)
            if read != normalize("NFC", word[0]):
                yield Replacement(word.start(), word.end(), read)

    def _learn(self, letters: Sequence[str]) -> None:
        """Compare what the engine says for letters and for plainer ones."""
        pairs = [(one, plainer(one)) for one in letters]
        self._known |= {one: one for one, _ in pairs}
        tried = [(one, other) for one, other in pairs if one != other]
        # Within a word, because a letter alone is read by its name.
        words = list(dict.fromkeys(f"ta{one}a".lower() for pair in tried for one in pair))
        counts = dict(zip(words, self._read(words), strict=True)) if words else {}
        for letter, other in tried:
            mine, its = (counts[f"ta{one}a".lower()] for one in (letter, other))
            if its is not None and (mine is None or mine >= its + SPELLED_LABELS):
                self._known[letter] = other
