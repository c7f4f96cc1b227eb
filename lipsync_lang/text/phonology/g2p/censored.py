"""Censored words, such as `f*ck`: the signs in them stand for a vowel."""

import re
from collections.abc import Iterator
from unicodedata import name

from lipsync_lang.text.phonology.g2p.abbreviation_keys import Replacement
from lipsync_lang.text.phonology.g2p.drawn_out import folded
from lipsync_lang.text.phonology.g2p.spoken_forms import SpokenForms

_CURSE_SIGN, _LETTER = "[#@$%&*∗]", r"[^\W\d_]"
_BETWEEN_LETTERS = (
    rf"(?:[*∗]+(?={_LETTER})|[#@$](?=[^\W\d_A-Z])|{_CURSE_SIGN}(?:[!?]*{_CURSE_SIGN})+)"
)
_MASKED = re.compile(rf"(?<![\w*]){_LETTER}+(?:{_BETWEEN_LETTERS}{_LETTER}*)+")


def uncensored(text: str, forms: SpokenForms) -> Iterator[Replacement]:
    """Yield censored words, of which a part lacks a vowel, with one in place of the signs.

    `Lehrer*innen` and `x*y` are none.
    """
    for found in _MASKED.finditer(text) if re.search(_CURSE_SIGN, text) else ():
        parts = re.split(r"\W+", found[0])
        script = name(found[0][0], "").split(" ")[0]
        vowel = next((one for one in forms.censored if name(one[0]).startswith(script)), "")
        lacking = any(part and not set(folded(part)) & set(forms.vowels) for part in parts)
        formula = found[0].isascii() and all(len(part) == 1 for part in parts)
        if vowel and lacking and not formula:
            yield Replacement(*found.span(), vowel.join(parts))


def unstressed(text: str, forms: SpokenForms) -> str:
    """Return a text in which the asterisks of censored words are no emphasis."""
    for start, stop, _ in uncensored(text, forms):
        text = text[:start] + text[start:stop].replace("*", "∗") + text[stop:]
    return text
