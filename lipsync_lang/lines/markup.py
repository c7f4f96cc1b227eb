r"""What of a written line is spoken.

Left out, and returned so that it can be named:

- tags: ``<i>``, ``{i}``, ``{/color}``, ``{\an8}``; the words between two tags stay,
- ruby, the small reading above a word: ``<rt>..</rt>``, ``{rt}..{/rt}``,
- placeholders whose value only the game knows: ``{name}``, ``[name]``, ``%s``, ``%(name)s``,
  ``$name``; what stands in square brackets for people, ``[sighs]``, is not spoken either,
- notes of music.

Doubled marks stand for themselves (``{{``, ``[[``, ``%%``), and ``\n`` is a space.

Where a placeholder or a note in brackets was, something is heard that the text does not tell: a
gap. A tag leaves none. One in braces is a tag where it is closed, or has a value (``{w=0.5}``).
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
"""What markup begins with in whose place nothing is heard."""


class SpokenText(NamedTuple):
    """What of a text is spoken, what was dropped in order, and where in the former the gaps are."""

    text: str
    dropped: tuple[str, ...] = ()
    gaps: tuple[int, ...] = ()


def spoken(text: str) -> SpokenText:
    """Tell what of a text is spoken."""
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
    """Return what markup says itself."""
    if found[0][0] == "\\":
        return found["kept"] or " "
    return DOUBLED.get(found[0], "")


def _solid(text: str) -> int:
    """Count characters that are no spaces."""
    return len("".join(text.split()))


def _places(text: str, counts: Sequence[int]) -> tuple[int, ...]:
    """Return where in a text so many of its characters, spaces apart, have gone before."""
    if not counts:
        return ()
    ends = [0, *(at for at, character in enumerate(text, 1) if not character.isspace())]
    return tuple(ends[count] for count in counts)
