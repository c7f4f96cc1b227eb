"""Stutters (`W-w-what`, `B... but`), by the letters of a text.

A stutter repeats the start of the word after it, up to its first vowel: `b ʌ b ʌ t`. A stop without
a vowel would be neither heard nor seen. The labels come from the reading of that word.

`vowels` are always the letters of vowels, in small letters without accents.
"""

import re
from collections.abc import Collection, Sequence
from unicodedata import name

from lipsync_lang.phonology.g2p.drawn_out import SYLLABIC, IsVowel, bare, folded, lead_letters
from lipsync_lang.phonology.g2p.tokens import plain

MAX_STUTTER_CHARS = 4
"""Maximum number of letters of a repeated start of a word."""


MAX_STARTS = 20
"""Maximum number of repeated starts of a word; a longer row of hyphens is no stutter."""

_HYPHENS = re.compile("[-\u2010\u2011]")


def starts_of(token: str, vowels: str, hyphenated: Collection[str] = ()) -> tuple[str, ...]:
    """Return the repeated starts of a word with hyphens, in order; none if it is not a stutter.

    `hyphenated` are words that only look like stutters, in small letters.

    >>> starts_of("Th-th-that's", "aeiou")
    ('Th', 'th')
    >>> starts_of("T-shirt", "aeiou")
    ()
    """
    parts = _HYPHENS.split(token)
    if not 1 < len(parts) <= MAX_STARTS + 1 or plain(token) in hyphenated:
        return ()
    for number in range(len(parts) - 1, 0, -1):
        starts, word = parts[:number], parts[number]
        repeated = all(begins(start, word) for start in starts)
        if repeated and any(spelled_out(start, vowels) for start in starts):
            return tuple(starts)
    return ()


def begins(start: str, word: str) -> bool:
    """Return True if a word begins with these letters and goes on, or is that one letter."""
    short, long = folded(start), folded(word)
    if not short or len(start) > MAX_STUTTER_CHARS or not long.startswith(short):
        return False
    return len(long) > len(short) or len(start) == 1


def spelled_out(start: str, vowels: str) -> bool:
    """Return True for letters that an engine would read by their names, not as a syllable."""
    if not start.isalpha() or name(start[0], "").startswith(SYLLABIC):
        return False
    return len(start) == 1 or not set(folded(start)) & set(vowels)


def start_labels(
    start: str, word: str, labels: Sequence[str], is_vowel: IsVowel, vowels: str
) -> tuple[str, ...]:
    """Return the labels of a repeated start of a word, up to the first vowel.

    Parameters
    ----------
    start : the letters that are repeated
    word, labels : the word after them, and its labels
    """
    lead = next((place for place, label in enumerate(labels) if is_vowel(label)), len(labels))
    letters = lead_letters(word, vowels)
    if not letters:
        return tuple(labels[: lead + 1])
    if not lead:  # a glide that counts as a vowel, as in German "ja"
        return tuple(labels[: 2 if any(map(is_vowel, labels[1:2])) else 1])
    count = max(min(len(start), letters) * lead // letters, 1)
    return (*labels[:count], *labels[lead : lead + 1])


def respelled_start(start: str, word: str, vowels: str) -> str:
    """Return the spelling of a repeated start for a voice, up to the word's first vowel."""
    place = lead_letters(word, vowels)
    if place == len(word) or len(bare(word)) != len(word):
        return word
    return start + word[place] if len(start) <= place else start
