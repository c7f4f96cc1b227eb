"""Tells labels that are one sound of a language from words and nonsense in letters of the IPA.

Most words and many codes can be read as IPA, letter by letter. A label is one sound only if its
letters go together in one: a vowel or vowels in a row, a stop with its release, a glide at an edge.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby

from lipsync_lang.phonology.ipa import LetterSound

_KINDS = (
    ("G", {"glide"}),
    ("S", {"stop", "click"}),
    ("N", {"nasal"}),
    ("F", {"fricative"}),
    ("R", {"rhotic"}),
    ("C", {"trill", "tap", "approximant"}),
)
"""Codes of letters by the words that describe them; any other letter is a vowel, V."""

_ONE_SOUND = re.compile(
    r"G?V{1,3}[GR]?"  # a vowel, or several in a row: ɛ, aɪ, jaʊ, ɔɹ
    r"|N?S{1,2}F?G?"  # a stop with nose, another stop, friction or a glide: t, ⁿd, k͡p, tʃ, kw
    r"|[NFRC]?G"
    r"|[NFRC]"
)


def is_one_sound(letters: Sequence[LetterSound]) -> bool:
    """Return True if letters are one sound; those that are doubled count once."""
    return _ONE_SOUND.fullmatch("".join(_kinds(letters))) is not None


def _kinds(letters: Iterable[LetterSound]) -> Iterator[str]:
    for _, alike in groupby(letters, key=lambda sound: sound.letter):
        words = next(alike).words
        yield next((code for code, some in _KINDS if words & some), "V")
