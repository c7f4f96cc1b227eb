r"""Emphasis in a text: ``I *never* said so`` stresses a word, and no asterisk is spoken.

One to three asterisks enclose one or more words, or the whole text. Asterisks that begin within a
word or number (``2*3*4``), enclose no word, have no partner or stand after a backslash (``\*``)
emphasise nothing, and are left out; between two letters or digits a space is left.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

EMPHASIS_MARK = re.compile(
    r"\\\*|(?<!\*)(?P<mark>\*{1,3})(?=[^\s*])(?P<said>(?:[^*\\]|\\.)*?)(?<=\S)(?P=mark)(?!\*)",
    re.DOTALL,
)
ESCAPED_STAR = r"\*"
RUN, ESCAPES = re.compile(r"\*+"), re.compile(r"(?:\\\*)+")
MAX_MARKED_CHARS = 1000
"""Maximum length of an emphasised passage, which also limits the search for a closing asterisk."""


class EmphasisedText(NamedTuple):
    """A text without asterisks, and the passages that they emphasise."""

    text: str
    spans: tuple[tuple[int, int], ...] = ()
    """Offsets in the text, in order."""


def emphasised(text: str) -> EmphasisedText:
    """Remove the asterisks from a text.

    >>> emphasised("I *never* said 2*3*4")
    EmphasisedText(text='I never said 2 3 4', spans=((2, 7),))
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
    at = 0
    while at < len(text):
        start = text.find("*", at)
        if start < 0:
            return
        if text[max(start - 1, at) : start + 1] == ESCAPED_STAR:
            at = ESCAPES.match(text, start - 1).end()  # type: ignore[union-attr]  # at least one
            yield start - 1, at, _between(text, start - 1, at), False
            continue
        found = EMPHASIS_MARK.match(text, start, start + MAX_MARKED_CHARS)
        if found and _emphasises(text, found):
            at = found.end()
            yield start, at, found["said"].replace(ESCAPED_STAR, ""), True
        else:
            at = start + len(RUN.match(text, start)[0])  # type: ignore[index]  # at least one
            yield start, at, _between(text, start, at), False


def _emphasises(text: str, found: re.Match[str]) -> bool:
    """Return True if a pair of asterisks encloses words, and does not start within a word."""
    before = text[max(found.start() - 1, 0) : found.start()]
    joined = before.isdigit() or before.lower() != before.upper()
    return not joined and any(map(str.isalnum, found["said"]))


def _between(text: str, start: int, stop: int) -> str:
    """Return the replacement of asterisks: a space if words would run together."""
    before, after = text[max(start - 1, 0) : start], text[stop : stop + 1]
    return " " if before.isalnum() and after.isalnum() else ""


def touched(words: Iterable[str], text: str, spans: Sequence[tuple[int, int]]) -> list[bool]:
    """Return, for each word of a text in order, True if an emphasised span touches it."""
    found: list[bool] = []
    at = 0
    for word in words:
        first = next(iter(word.split()), word)
        start = text.find(first, at)
        if start < 0:
            found.append(False)
            continue
        at = start + len(first)
        found.append(any(low < at and start < high for low, high in spans))
    return found
