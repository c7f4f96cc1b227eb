"""Text with the vowel marks that its script leaves out, as a model of whole sentences guesses them.

Words that have marks keep them. Without the extra the text stays as it is.
"""

import re
from collections.abc import Callable, Iterator
from functools import cache
from itertools import pairwise
from unicodedata import category

from lipsync_lang.text.phonology.g2p.g2p_engines import RESPELLERS
from lipsync_lang.text.phonology.g2p.tokens import unmarked

_CHUNK = re.compile(r".{1,1000}(?!\S)|.{1,1000}", re.DOTALL)
"""The model takes 12,000 characters at most."""

_WORDS = re.compile(r"(\s+)")

_EVERYDAY_MARKS = re.compile("(?<!^)[\u064b-\u064d\u0651]")
"""Marks of everyday spelling; a word that has no others is guessed."""

_CASE_VOWEL = re.compile(
    "(?:(?<=\u0629)\u064b|[\u064c-\u0650])(\u0651?)(?=[»\"')\\]]*\\s*(?:[.!?…,;:،؛؟]|$))"
)
"""A short vowel at the end of a word, which is silent before a pause."""


@RESPELLERS.register("tashkeel")
def respell(text: str) -> list[tuple[str, str]]:
    """Cut a text into its letters, each with its marks, and into words that have marks."""
    mark = _marker()
    if mark is None:
        return [(text, text)]
    return [
        pair
        for part in _CHUNK.findall(text)
        for pair in _marked(part, mark(_EVERYDAY_MARKS.sub("", part)))
    ]


def _marked(text: str, marked: str) -> Iterator[tuple[str, str]]:
    """Yield the letters of a text with their marks; without any if the letters are not the same."""
    words, guesses = _WORDS.split(text), _WORDS.split(_CASE_VOWEL.sub(r"\1", marked))
    if [unmarked(word) for word in words] != [unmarked(word) for word in guesses]:
        yield text, text
        return
    for word, guess in zip(words, guesses, strict=True):
        if unmarked(word) != _EVERYDAY_MARKS.sub("", word):
            yield word, word
        else:
            yield from zip(_letters(word), _letters(guess), strict=True)


def _letters(word: str) -> Iterator[str]:
    """Yield the letters of a word, each with its marks."""
    starts = (at for at, sign in enumerate(word) if category(sign) != "Mn")
    return (word[a:b] for a, b in pairwise([*starts, len(word)]))


@cache
def _marker() -> Callable[[str], str] | None:
    try:
        from dengjen_tashkeel_py import tashkeel
    except (ImportError, RuntimeError):  # the second for a broken onnxruntime
        return None
    # half of a surrogate pair has no UTF-8; its text is then read without guesses
    return lambda text: str(tashkeel(text.encode("utf-8", "replace").decode()))
