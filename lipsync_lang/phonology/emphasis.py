r"""Emphasis in a text: ``I *never* said so`` stresses a word, and its asterisks are not spoken.

One to three asterisks enclose one or more words of a longer text. Asterisks that enclose a whole
text, stand between digits or letters (``2*3*4``), or have no partner, are signs like any other.
``\*`` is an asterisk that marks nothing.
"""

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

MARKED = re.compile(
    r"\\\*|(?<!\*)(?P<mark>\*{1,3})(?=[^\s*])(?P<said>(?:[^*\\]|\\.)*?)(?<=\S)(?P=mark)(?!\*)",
    re.DOTALL,
)
ESCAPED = r"\*"
MAX_MARKED_CHARS = 1000
"""Longest emphasised passage; it also bounds the search for the partner of an asterisk."""


class EmphasisedText(NamedTuple):
    """A text without marks of emphasis, and the passages that had them."""

    text: str
    spans: tuple[tuple[int, int], ...] = ()
    """Offsets in the text, in order."""


def emphasised(text: str) -> EmphasisedText:
    r"""Take the marks of emphasis out of a text.

    >>> emphasised("I *never* said 2*3*4")
    EmphasisedText(text='I never said 2*3*4', spans=((2, 7),))
    """
    if "*" not in text:
        return EmphasisedText(text)
    parts: list[str] = []
    spans: list[tuple[int, int]] = []
    done = length = 0
    for start, stop, said, marked in _marked(text):
        parts += text[done:start], said
        length += start - done + len(said)
        spans += [(length - len(said), length)] if marked else []
        done = stop
    return EmphasisedText("".join([*parts, text[done:]]), tuple(spans))


def _marked(text: str) -> Iterator[tuple[int, int, str, bool]]:
    """Yield each mark of a text: start, end, replacement, and True for emphasis."""
    spoken = _spoken(text)
    at = 0
    while at < len(text):
        start = text.find("*", at)
        if start < 0:
            return
        if text[max(start - 1, at) : start + 1] == ESCAPED:
            yield start - 1, start + 1, "*", False
            at = start + 1
            continue
        found = MARKED.match(text, start, start + MAX_MARKED_CHARS)
        if found and _emphasises(text, found, spoken):
            yield start, found.end(), found["said"].replace(ESCAPED, "*"), True
            at = found.end()
        else:
            at = start + len(text[start:]) - len(text[start:].lstrip("*"))


def _emphasises(text: str, found: re.Match[str], spoken: range) -> bool:
    """Return True if a pair of asterisks encloses words, and not all of them."""
    start, stop = found.span()
    before = text[max(start - 1, 0) : start]
    joined = before.isdigit() or before.lower() != before.upper()
    whole = start <= spoken.start and spoken.stop <= stop
    return not joined and not whole and len(_spoken(found["said"])) > 0


def _spoken(text: str) -> range:
    """Return the offsets from the first letter or digit of a text to its last."""
    first = next((at for at, one in enumerate(text) if one.isalnum()), len(text))
    stop = next((at + 1 for at in range(len(text) - 1, -1, -1) if text[at].isalnum()), first)
    return range(first, stop)


def touched(words: Iterable[str], text: EmphasisedText) -> list[bool]:
    """Return True for each word, in the order of the text, that an emphasised passage touches."""
    found: list[bool] = []
    at = 0
    for word in words:
        first = next(iter(word.split()), word)
        start = text.text.find(first, at)
        if start < 0:
            found.append(False)
            continue
        at = start + len(first)
        found.append(any(low < at and start < high for low, high in text.spans))
    return found
