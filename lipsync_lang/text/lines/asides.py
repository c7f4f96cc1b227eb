"""Asides: notes on actions or sounds, between the spoken words.

``(laughs)`` and ``*sighs*`` are notes to an actor, ``(my brother)`` and ``*never*`` are words of
the line. A language pack lists the words of its asides. In scripts with capitals an aside is also
told by its form: a few words that begin in a small letter where a sentence would begin.
"""

import re
from collections.abc import Sequence
from functools import lru_cache

from lipsync_lang.text.phonology.g2p.tokens import PAUSES, plain

MAX_ASIDE_WORDS = 5
"""Maximum number of words of an aside that is recognised by its form."""

MAX_CHARS, MAX_UNCASED_CHARS = 40, 12
"""Maximum length of an aside known by its words, in scripts with and without capitals."""

OPEN_END = "..."
"""Mark at the end of a listed word, for all words with this start."""

SENTENCE_ENDS = frozenset(".!?…。！？")

QUOTE_SIGNS = frozenset("\"'»«“”„‘’—–-[](){}")


def is_aside(
    said: str, before: str, after: str, listed: Sequence[str], *, starred: bool = False
) -> bool:
    """Return True if a passage in brackets or asterisks is an aside.

    `before` and `after` are the text around it; `listed` are the language's words of asides;
    `starred` is True if the passage is in asterisks, which emphasise other words.

    >>> is_aside("sighs deeply", "", " I know.", ["sigh..."])
    True
    >>> is_aside("never", "I ", " said so.", [], starred=True)
    False
    """
    last, first = before.rstrip()[-1:], after.lstrip()[:1]
    begins = not last or last in PAUSES or last in QUOTE_SIGNS
    ends = not first or not first.islower()
    if starred and not (begins and ends):
        return False
    longest = MAX_CHARS if _has_case(said) else MAX_UNCASED_CHARS
    if listed and len(said) <= longest and _pattern(tuple(listed)).search(plain(said)):
        return True
    if not (begins and ends and 0 < len(said.split()) <= MAX_ASIDE_WORDS and _has_case(said)):
        return False
    if starred:
        apart = (not last or last in SENTENCE_ENDS) and (not first or first.isupper())
        return said[0].islower() and apart and bool(last + first)
    closed = said.rstrip()[-1] in PAUSES
    return not closed and (said[0].islower() or (said.isupper() and not after.strip()))


def _has_case(text: str) -> bool:
    return text.lower() != text.upper()


@lru_cache(256)
def _pattern(listed: tuple[str, ...]) -> re.Pattern[str]:
    """Return the pattern of listed words; without capitals, words may have no edges."""
    ways = []
    for one in listed:
        word = re.escape(plain(one.removesuffix(OPEN_END)))
        if _has_case(word):
            word = rf"(?<!\w){word}" + ("" if one.endswith(OPEN_END) else r"(?!\w)")
        ways.append(word)
    return re.compile("|".join(ways))
