r"""Separate the spoken text of a line from its markup.

These are dropped, and listed in the result:

- tags: ``<i>``, ``{i}``, ``{/color}``, ``{\an8}``; the words between two tags stay,
- ruby, the small reading above a word: ``<rt>..</rt>``, ``{rt}..{/rt}``,
- placeholders whose value only the game knows: ``{name}``, ``[name]``, ``%s``, ``%(name)s``,
  ``$name``; notes in square brackets, such as ``[sighs]``, look the same and are dropped too,
- notes of music.

Doubled marks stand for themselves (``{{``, ``[[``, ``%%``), and ``\n`` is a space.

A placeholder or a note in square brackets leaves a gap: speech that the file does not contain. A
tag leaves no gap. A word in braces is a tag if a closing tag follows, or if it has a value
(``{w=0.5}``); otherwise it is a placeholder.
"""

import re
from collections.abc import Sequence
from typing import NamedTuple

RUBY = r"<(?P<r>rt|rp)\b[^<>]*>(?:(?!<r[tp]\b).)*?</(?P=r)>|\{rt\}(?:(?!\{rt\}).)*?\{/rt\}"
TAG = r"</?[A-Za-z][^<>]*>|<\d\d[\d:.,]*>"
BRACES = r"\{\{|\}\}|\{[^{}]*\}"
BRACKETS = r"\[\[|\]\]|\[[^\[\]]*(?:\[[^\[\]]*\][^\[\]]*)*\]"
PERCENT = r"%%|%\(\w+\)[-+#0]*\d*(?:\.\d+)?[a-z]|%(?:\d+\$)?[-+#0]*\d*(?:\.\d+)?[sdifuxc@](?!\w)"
DOLLAR = r"\$\{[^{}]*\}|\$[A-Za-z_]\w*"
ESCAPE = r"\\[nrt]|\\(?P<kept>[\\\"'%\[{ ])"
MUSIC = r"[♩♪♫♬]+"

MARKUP = re.compile(
    f"{RUBY}|{DOLLAR}|{TAG}|{BRACES}|{BRACKETS}|{PERCENT}|{ESCAPE}|{MUSIC}", re.DOTALL
)
DOUBLED = {"{{": "{", "}}": "}", "[[": "[", "]]": "]", "%%": "%"}
LOOSE = re.compile(r" ([,.])(?!\S)")
MARKS = frozenset("<{[%$\\}]♩♪♫♬")
CLOSING = re.compile(r"\{/(\w+)\}")
SOUNDLESS = re.compile(r"[<♩♪♫♬]|\{(?:[/\\]|rt\}|\w+=)")
"""Start of markup that leaves no gap."""


class SpokenText(NamedTuple):
    """The spoken text, the markup dropped, in order, and the offsets of gaps in the text."""

    text: str
    dropped: tuple[str, ...] = ()
    gaps: tuple[int, ...] = ()


def spoken(text: str) -> SpokenText:
    """Return the spoken part of a text.

    >>> spoken("Hello, {i}dear{/i} [name]!").text
    'Hello, dear !'
    """
    if MARKS.isdisjoint(text):
        return SpokenText(" ".join(text.split()))
    closed = {f"{{{name}}}" for name in CLOSING.findall(text)}
    left: list[str] = []
    dropped: list[str] = []
    gaps: list[int] = []
    done = solid = 0
    for found in MARKUP.finditer(text):
        whole = found[0]
        left += text[done : found.start()], _said(found)
        solid += sum(map(_solid, left[-2:]))
        done = found.end()
        if whole not in DOUBLED and whole[0] != "\\":
            dropped.append(whole)
            if whole not in closed and not SOUNDLESS.match(whole):
                gaps.append(solid)
    said = LOOSE.sub(r"\1", " ".join("".join([*left, text[done:]]).split()))
    return SpokenText(said, tuple(dropped), _places(said, gaps))


def _said(found: re.Match[str]) -> str:
    """Return the text that an escape or a doubled mark stands for; other markup has none."""
    if found[0][0] == "\\":
        return found["kept"] or " "
    return DOUBLED.get(found[0], "")


def _solid(text: str) -> int:
    """Count the characters that are not spaces."""
    return len("".join(text.split()))


def _places(text: str, counts: Sequence[int]) -> tuple[int, ...]:
    """Turn counts of preceding characters, without spaces, into offsets in a text.

    Gaps are counted without spaces, because dropping markup changes the spaces around it.
    """
    if not counts:
        return ()
    ends = [0, *(at for at, character in enumerate(text, 1) if not character.isspace())]
    return tuple(ends[count] for count in counts)
