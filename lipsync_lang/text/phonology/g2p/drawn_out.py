"""Words drawn out (`Nooo`, `Shhh`) or stuttered (`W-w-what`, `B... but`), by their letters.

A word drawn out has an ordinary spelling and lengthened labels. A stutter repeats the start of the
word after it, up to its first vowel: `b ʌ b ʌ t`. A stop without a vowel would be neither heard nor
seen. The labels come from the reading of that word.

`vowels` are always the letters of vowels, in small letters without accents.
"""

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from itertools import groupby
from typing import NamedTuple
from unicodedata import combining, name, normalize

from lipsync_lang.text.phonology.g2p.g2p_engines import SpokenWord
from lipsync_lang.text.phonology.g2p.tokens import plain

MAX_COPIES = 3
"""Maximum number of copies of a lengthened label."""

DRAWN_LETTERS = 3
"""Minimum number of equal letters in a drawn-out word."""

MAX_RUNS = 100
"""Maximum number of different letters in a row; no language has longer words."""

SYLLABIC = ("CJK", "HIRAGANA", "KATAKANA", "HANGUL SYLLABLE", "BOPOMOFO", "YI ")
"""Starts of names of characters that are read as syllables, not as names of letters."""

MAX_STUTTER_CHARS = 4
"""Maximum number of letters of a repeated start of a word."""

MAX_STARTS = 20
"""Maximum number of repeated starts of a word; a longer row of hyphens is no stutter."""

_HYPHENS = re.compile("[-\u2010\u2011]")
_LONG_RUN = re.compile(r"(\w)\1\1", re.IGNORECASE)
_HYPHENATED_RUN = re.compile("(\\w)[-\u2010\u2011](?=\\1)", re.IGNORECASE)
_LONG_MARK = "PROLONGED SOUND MARK"

IsVowel = Callable[[str], bool]
"""Test a label for a vowel."""


class ElongatedWord(NamedTuple):
    """A word drawn out: its ordinary spelling, and its long runs of letters."""

    word: str
    runs: tuple[tuple[int, int], ...]
    """For each long run, the place of its letter in the word, and the number of letters beyond."""


def folded(text: str) -> str:
    """Return lower-case letters, decomposed from their marks."""
    return normalize("NFKD", text.casefold())


def bare(text: str) -> str:
    """Return lower-case letters without their marks."""
    return "".join(c for c in folded(text) if not combining(c))


def lead_letters(word: str, vowels: str) -> int:
    """Return the number of letters before the first vowel; of a script without vowels, all."""
    letters = bare(word)
    for place, letter in enumerate(letters):
        # The y of "yes" is a consonant.
        glide = not place and letter == "y" and letters[1:2] in vowels and len(letters) > 1
        if letter in vowels and not glide:
            return place
    return len(letters)


def ordinary_spellings(doubled: Collection[str]) -> dict[str, str]:
    """Map words without their double letters to the words; input of `drawn_out`."""
    return {_squeezed(word): word for word in map(plain, doubled)}


def drawn_out(token: str, ordinary: Mapping[str, str]) -> ElongatedWord | None:
    """Return the ordinary spelling of a word drawn out; None for any other word.

    >>> drawn_out("Nooooo", {})
    ElongatedWord(word='No', runs=((1, 4),))
    >>> drawn_out("Goood", ordinary_spellings(["good"])).word
    'Good'
    >>> drawn_out("Ye-e-es", {}).word
    'Yes'
    """
    token = _HYPHENATED_RUN.sub(r"\1", token)
    if not _LONG_RUN.search(token):
        return None
    runs = [(letter, len(list(same))) for letter, same in groupby(token, key=str.casefold)]
    if len(runs) > MAX_RUNS:
        return None
    long = []
    for letter, count in runs:
        called = name(letter[0], "")
        syllable = called.startswith(SYLLABIC) and not called.endswith(_LONG_MARK)
        long.append(count >= DRAWN_LETTERS and letter.isalpha() and not syllable)
    # `AAA` may be an abbreviation, and `000` is a number.
    if not any(long) or (len(runs) == 1 and (token.isupper() or not token[0].isalpha())):
        return None
    known = groupby(ordinary.get(_squeezed(plain(token)), ""))
    single = (1 if drawn else count for (_, count), drawn in zip(runs, long, strict=True))
    counts = [len(list(same)) for _, same in known] or single
    word, places, at = "", [], 0
    for (_, count), drawn, keep in zip(runs, long, counts, strict=True):
        places += [(len(word), count - keep)] if drawn else []
        word += token[at : at + keep]
        at += count
    return ElongatedWord(word, tuple(places))


def _squeezed(word: str) -> str:
    return "".join(letter for letter, _ in groupby(word))


def lengthened(
    said: SpokenWord, drawn: ElongatedWord, is_vowel: IsVowel, vowels: str
) -> SpokenWord:
    """Return a word with repeated labels for its long letters."""
    more = [0] * len(said.labels)
    for place, letters in drawn.runs:
        if said.labels:
            at = _label_at(said.labels, drawn.word, place, is_vowel, vowels)
            more[at] += min((letters + 1) // 2, MAX_COPIES)
    stress = said.stress or (None,) * len(said.labels)
    rows = list(zip(said.labels, stress, more, strict=True))
    return said._replace(
        labels=tuple(label for label, _, n in rows for _ in range(1 + n)),
        stress=tuple(m for _, mark, n in rows for m in (mark, *(None,) * n)) if said.stress else (),
    )


def _label_at(labels: Sequence[str], word: str, place: int, is_vowel: IsVowel, vowels: str) -> int:
    """Return the estimated place of the label of a letter."""
    letters = bare(word)
    guess = place * (len(labels) - 1) / max(len(word) - 1, 1)
    wanted = letters[place : place + 1] in vowels
    glide = bool(lead_letters(word, vowels))  # the w of "what" may count as a vowel
    is_vocal = [is_vowel(label) and not (glide and not at) for at, label in enumerate(labels)]
    alike = [at for at, vocal in enumerate(is_vocal) if vocal == wanted]
    if not alike or not set(letters) & set(vowels):
        return round(guess)
    if not wanted:
        return min(alike, key=lambda at: abs(at - guess))
    if not set(letters[place + 1 :]) & set(vowels):
        return alike[-1]
    groups = [key for key, _ in groupby(letters[: place + 1], key=lambda c: c in vowels)]
    return alike[min(sum(groups), len(alike)) - 1]


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
    begun = short and len(start) <= MAX_STUTTER_CHARS and long.startswith(short)
    return bool(begun) and (len(long) > len(short) or len(start) == 1)


def spelled_out(start: str, vowels: str) -> bool:
    """Return True for letters that an engine would read by their names, not as a syllable."""
    letters = start.isalpha() and not name(start[0], "").startswith(SYLLABIC)
    return letters and (len(start) == 1 or not set(folded(start)) & set(vowels))


def start_labels(
    start: str, word: str, labels: Sequence[str], is_vowel: IsVowel, vowels: str
) -> tuple[str, ...]:
    """Return the labels of a repeated start of a word, up to the first vowel of its labels."""
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
