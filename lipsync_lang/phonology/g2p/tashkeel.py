"""Text with the vowel marks that its script leaves out, as a model of whole sentences guesses them.

Words that have marks keep them. Without the extra the text stays as it is.
"""

import re
from collections.abc import Callable, Iterator
from functools import cache
from itertools import pairwise
from unicodedata import category

from lipsync_lang.phonology.g2p.g2p_engines import RESPELLERS
from lipsync_lang.phonology.g2p.tokens import unmarked

_CHUNK = re.compile(r".{1,1000}(?!\S)|.{1,1000}", re.DOTALL)
"""The model takes 12,000 characters at most."""

_WORDS = re.compile(r"(\s+)")


@RESPELLERS.register("tashkeel")
def respell(text: str) -> list[tuple[str, str]]:
    """Cut a text into its letters, each with its marks, and into words that have marks."""
    mark = _marker()
    if mark is None:
        return [(text, text)]
    return [pair for part in _CHUNK.findall(text) for pair in _marked(part, mark(part))]


def _marked(text: str, marked: str) -> Iterator[tuple[str, str]]:
    """Yield the letters of a text with their marks; without any if the letters are not the same."""
    words, guesses = _WORDS.split(text), _WORDS.split(marked)
    if [unmarked(word) for word in words] != [unmarked(word) for word in guesses]:
        yield text, text
        return
    for word, guess in zip(words, guesses, strict=True):
        if unmarked(word) != word:
            yield word, word
            continue
        starts = [at for at, sign in enumerate(guess) if category(sign) != "Mn"]
        yield from zip(word, (guess[a:b] for a, b in pairwise([*starts, len(guess)])), strict=True)


@cache
def _marker() -> Callable[[str], str] | None:
    try:
        from dengjen_tashkeel_py import tashkeel
    except (ImportError, RuntimeError):  # the second for a broken onnxruntime
        return None
    # half of a surrogate pair has no UTF-8; its text is then read without guesses
    return lambda text: str(tashkeel(text.encode("utf-8", "replace").decode()))
