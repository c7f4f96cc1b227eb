"""Assignment of an engine's phonemes to words in the original spelling.

Engines mark words by text position, with irregularities: "10,000" has several marks, "of the" a
single one, and a mark may be on the space or dash before its word. The text is split into
tokens, and each mark is assigned to a token.
"""

import re
import unicodedata
from bisect import bisect_left
from collections.abc import Sequence
from itertools import pairwise

from lipsync_lang.schedules import SILENCE, Word

_WORD_TOKEN = re.compile(
    r"""(?: [^\s!?;"…()\[\]{}<>«»“”„‹›–—―、。，！？；：・¿¡।፡።.,:-]   # what a token is made of,
        | (?<![.]) [.] (?![.]) | (?<!-) - (?!-)                     # alone: 3.5, U.S.A., well-known
        | (?<=\d) [,:] (?=\d) )+                                    # between digits: 1,000 or 12:30
    """,
    re.VERBOSE,
)
_SPOKEN_MARKS = "%&@#§‰"
_UNSPACED_CATEGORIES = {"Lo", "Lm", "Mn", "Mc"}
_MOST_SKIPPED = 3
"""Maximum extra tokens per mark; beyond it, unmarked tokens count as silent."""


def find_words(
    text: str, marks: Sequence[tuple[int, int]], labels: Sequence[str]
) -> tuple[Word, ...]:
    """Return the words of a text with the phonemes of each.

    Parameters
    ----------
    text : the spoken text
    marks : (character position from 0, index of the first phoneme from there on), by phoneme
    labels : the phonemes, `SILENCE` among them

    Returns
    -------
    Words in order, without the silence around them; a word without phonemes is left out
    """
    tokens = [match.span() for match in _WORD_TOKEN.finditer(text)]
    starts = _starts(text, tokens, [position for position, _ in marks])
    punctuation = {c for c in text if unicodedata.category(c)[0] == "P"}
    silent = "".join(punctuation - set(_SPOKEN_MARKS))
    words: list[Word] = []
    groups = [n for n, start in enumerate(starts) if n == 0 or start != starts[n - 1]]
    for this, following in pairwise([*groups, len(marks)]):
        stop = marks[following][1] if following < len(marks) else len(labels)
        until = starts[following] if following < len(marks) else len(text)
        sounding = [n for n in range(marks[this][1], stop) if labels[n] != SILENCE]
        if not sounding:
            continue
        first, stop = sounding[0], sounding[-1] + 1
        start = starts[this]
        inside = [(max(a, start), min(b, until)) for a, b in tokens if b > start and a < until]
        # Tokens without a mark of their own belong to the word before.
        rest = [span for span in inside[1:] if any(c.isalnum() for c in text[slice(*span)])]
        spans = inside[:1] + (rest if len(rest) <= _MOST_SKIPPED else [])
        # Without the punctuation around each; a token of only punctuation is unchanged.
        bare = (text[a:b].strip(silent) or text[a:b] for a, b in spans)
        spelling = " ".join(filter(None, bare))
        if not inside:
            spelling = "".join(text[start:until].split(maxsplit=1)[:1]) or text.strip()
        words.append(Word(spelling, first, stop))
    return tuple(words)


def _starts(text: str, tokens: Sequence[tuple[int, int]], positions: Sequence[int]) -> list[int]:
    """Return the word start of each mark, in non-decreasing order."""
    # Tokens with a letter, a digit or a named symbol are said.
    said = [
        any(
            c.isalnum() or c in _SPOKEN_MARKS or unicodedata.category(c)[0] == "S"
            for c in text[slice(*token)]
        )
        for token in tokens
    ]
    inside = [-1] * (len(text) + 1)
    for number, (start, end) in enumerate(tokens):
        inside[start:end] = [number] * (end - start)
    begins = [start for start, _ in tokens]
    positions = [min(max(p, 0), len(text)) for p in positions]
    claimed = {inside[p] for p in positions}
    starts: list[int] = []
    for position in positions:
        token = inside[position]
        if token < 0 or not said[token]:
            ahead = bisect_left(begins, position + (token >= 0))
            if ahead < len(tokens) and ahead not in claimed:
                token = ahead
                claimed.add(ahead)
            elif token < 0 and starts:
                starts.append(starts[-1])
                continue
        start = tokens[token][0] if token >= 0 else position
        # A mark inside a token starts a word in scripts without spaces, whose letters have no case.
        around = text[position - 1 : position + 1] if position > start else ""
        if around and {unicodedata.category(c) for c in around} <= _UNSPACED_CATEGORIES:
            start = position
        starts.append(max([start, *starts[-1:]]))
    return starts
