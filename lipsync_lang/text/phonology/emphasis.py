r"""Emphasis in a text: ``I *never* said so`` stresses a word, and no asterisk is spoken.

One to three asterisks enclose one or more words, or the whole text. Asterisks that begin within a
word or number (``2*3*4``), enclose no word, have no partner or stand after a backslash (``\*``)
emphasise nothing, and are left out; between two letters or digits a space is left.
"""

import re
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from operator import itemgetter
from typing import NamedTuple

EMPHASIS_MARK = re.compile(
    r"\\\*|(?<!\*)(?P<mark>\*{1,3})(?=[^\s*])(?P<said>(?:[^*\\]|\\.)*?)(?<=\S)(?P=mark)(?!\*)",
    re.DOTALL,
)
ESCAPED_STAR = r"\*"
RUN, ESCAPES = re.compile(r"\*+"), re.compile(r"(?:\\\*)+")
MAX_MARKED_CHARS = 1000
"""Maximum length of an emphasised passage, which also limits the search for a closing asterisk."""

REACH_CHARS = 10_000
"""Maximum distance of a word from the one before it."""


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
    for start, stop, passage in _marks(text):
        before, after = text[max(start - 1, 0) : start], text[stop : stop + 1]
        gap = " " if before.isalnum() and after.isalnum() else ""  # words do not run together
        said = gap if passage is None else passage
        parts += text[done:start], said
        length += start - done + len(said)
        spans += [] if passage is None else [(length - len(said), length)]
        done = stop
    return EmphasisedText("".join([*parts, text[done:]]), tuple(spans))


def _marks(text: str) -> Iterator[tuple[int, int, str | None]]:
    """Yield each mark of a text: start, end, and the passage that it emphasises, if any."""
    at = 0
    while at < len(text):
        start = text.find("*", at)
        if start < 0:
            return
        if text[max(start - 1, at) : start + 1] == ESCAPED_STAR:
            at = ESCAPES.match(text, start - 1).end()  # type: ignore[union-attr]  # at least one
            yield start - 1, at, None
            continue
        found = EMPHASIS_MARK.match(text, start, start + MAX_MARKED_CHARS)
        before = text[max(start - 1, 0) : start]
        within = before.isdigit() or before.lower() != before.upper()  # a letter with case
        if found and not within and any(map(str.isalnum, found["said"])):
            at = found.end()
            yield start, at, found["said"].replace(ESCAPED_STAR, "")
        else:
            at = start + len(RUN.match(text, start)[0])  # type: ignore[index]  # at least one
            yield start, at, None


def touched(words: Iterable[str], text: str, spans: Sequence[tuple[int, int]]) -> list[bool]:
    """Return, for each word of a text in order, True if an emphasised span touches it."""
    found: list[bool] = []
    at, ahead = 0, deque(spans)
    for word in words:
        first = next(iter(word.split()), word)
        start = text.find(first, at, at + REACH_CHARS + len(first))
        if start >= 0:
            at = start + len(first)
            while ahead and ahead[0][1] <= start:
                ahead.popleft()
        found.append(start >= 0 and bool(ahead) and ahead[0][0] < at)
    return found


def as_marked(text: str, stated: str | None) -> str:
    """Return what a line's statement writes for a text, if both differ in marks alone.

    >>> as_marked("the big dog", "the *big* dog")
    'the *big* dog'
    """
    same = stated is not None and emphasised(stated).text == emphasised(text).text
    return stated if stated and same else text


def with_mark(text: str, spoken: Sequence[str], left_out: Sequence[str], number: int) -> str | None:
    """Emphasise one of the words that are left out of a text; None if it is not found.

    `spoken` are the other words of the text, in order, and `left_out[number]` is the word to mark.

    >>> with_mark("the dog saw the cat", ["the", "dog", "saw", "cat"], ["the"], 0)
    'the dog saw *the* cat'
    """
    at, lacking, others = 0, deque(left_out[: number + 1]), deque(spoken)
    while lacking:
        # The next word of the text is the first of either, the longer one if both begin there.
        rows = [(text.find(some[0], at), -len(some[0]), some) for some in (others, lacking) if some]
        start, length, some = min(rows, key=itemgetter(0, 1))
        some.popleft()
        if start < 0 and some is lacking:
            return None
        at = max(at, start - length)
    marked = f"{text[:start]}*{text[start:at]}*{text[at:]}"
    return marked if len(emphasised(marked).spans) > len(emphasised(text).spans) else None
