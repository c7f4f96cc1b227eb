"""Censored words, such as `f*ck`: the signs in them stand for letters."""

import re
from collections.abc import Iterable, Iterator
from itertools import pairwise
from unicodedata import name

from lipsync_lang.text.phonology.g2p.abbreviation_keys import is_spaced
from lipsync_lang.text.phonology.g2p.drawn_out import folded
from lipsync_lang.text.phonology.g2p.spoken_forms import SpokenForms
from lipsync_lang.text.phonology.g2p.tokens import Replacement

_CURSE_SIGN, _SMALL = "[#@$%&*∗]", r"(?=[^\W\d_A-Z])"
_CASED = r"[^\W\d_\u0590-\u1dff\u2c00-\uffff]"
"""A letter of an alphabet with capitals; beside others, `!` ends a sentence."""
_HIDING = (
    rf"[*∗]+(?=[^\W\d_])|(?:[#@$]|(?<={_CASED})!(?={_CASED}))(?:{_SMALL}|(?<=[A-Z].)(?=[A-Z]))"
    rf"|(?<=[㐀-鿿])×+(?! ?\d)|[!?]*{_CURSE_SIGN}(?:[!?]*{_CURSE_SIGN}|[!?]+{_SMALL})+"
)
_MASKED = re.compile(rf"(?<![\w*])[^\W\d_]+(?:(?:{_HIDING})[^\W\d_]*)+(?![\w*∗])")
_POSSIBLE = re.compile(rf"{_CURSE_SIGN}|\w!\w|×")


def uncensored(text: str, forms: SpokenForms) -> Iterator[Replacement]:
    """Yield censored words with letters in place of the signs.

    They hold a curse of the pack. In others a vowel is missing, or several signs stand for letters:
    `Lehrer*innen` and `x*y` are none.
    """
    for found in _MASKED.finditer(text) if _POSSIBLE.search(text) else ():
        if cursed := _cursed(found[0], forms.curses):
            yield Replacement(*found.span(), cursed)
            continue
        if "×" in found[0]:
            yield Replacement(*found.span(), found[0].replace("×", " "))
        if re.search("×|(?<=[A-Z])[#@$!](?=[A-Z])", found[0]):
            continue
        words, signs = re.split(r"\W+", found[0]), re.findall(r"\W+", found[0])
        script = name(found[0][0], "").split(" ")[0]
        letters = {
            sign: next((one for one in some if name(one[0]).startswith(script)), "")
            for sign, some in forms.censored.items()
        }
        usual, vowels = letters.pop("*", ""), set(forms.vowels)
        # two consonants beside a sign: `verd*mmter`; before `!`, a space may be missing
        sides = [a[-1] + b[0] for a, b in pairwise(words) if b and "!" not in signs]
        lacking = not all(vowels & set(folded(one)) for one in [*filter(None, words), *sides])
        formula = found[0].isascii() and re.fullmatch(r"(?:\w\W)+\w?", found[0])
        many = len(signs) == 1 < len(signs[0]) and words[1]
        if usual and (lacking or many) and not formula:
            said = [
                "".join(letters[one] for one in s) if {*s} <= {*letters} else usual for s in signs
            ]
            yield Replacement(*found.span(), "".join(map(str.__add__, words, [*said, ""])))


def _cursed(masked: str, curses: Iterable[str]) -> str:
    """Return a word with the letters of a curse in place of its signs; empty if none fits.

    A sign is a letter. A row of asterisks may be a letter more or less of a whole word, and within
    the word any number of them if nothing else fits.
    """
    row = re.sub(r"(?<=\w)[*∗]{2,}(?=\w)|[*∗]{3,}$", r"\\w{2,}", masked)
    loose = re.sub(r"[^\w{},\\]", r"\\w", row)
    fitting = [one for one in curses if re.fullmatch(loose, one, re.IGNORECASE)]
    whole = min(fitting, key=lambda one: abs(len(one) - len(masked)), default="")
    if abs(len(whole) - len(masked)) > 1:
        whole = _in_word(masked, curses) or (whole if masked[-1].isalpha() else "")
    return whole.upper() if masked.isupper() else whole


def _in_word(masked: str, curses: Iterable[str]) -> str:
    """Return a word that holds a curse as its part."""
    for curse in curses:
        first, *others = map(re.escape, curse)
        signs = "".join(rf"[{letter}\W]" for letter in others)
        fit = re.fullmatch(rf"(\w{{,30}}?)({first}{signs})(\w{{,30}})", masked, re.IGNORECASE)
        # one letter in sight is too little within a word: `murd***r`
        if fit and (not is_spaced(fit[1][-1:]) or len(re.findall(r"\w", fit[2])) > 1):
            return f"{masked[: fit.end(1)]}{curse}{masked[fit.end(2) :]}"
    return ""


def unstressed(text: str, forms: SpokenForms) -> str:
    """Return a text in which the asterisks of censored words are no emphasis."""
    for start, stop, _ in uncensored(text, forms):
        text = text[:start] + text[start:stop].replace("*", "∗") + text[stop:]
    return text
