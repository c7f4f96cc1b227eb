r"""Choices in braces: alternative texts, of which a game reads one.

- ICU messages: ``{n, plural, one {# coin} other {# coins}}``, and ``select`` alike,
- Fluent: ``{ $n -> [one] a coin *[other] coins }``,
- Ink: ``{first time|second time}``, ``{met: Hello again|Hello}``.

The branch of a known value is taken; else the general one (``other``, the starred one), or in Ink
the first that has words.
"""

import re
from collections.abc import Mapping

MAX_DEPTH = 8
"""Maximum depth of choices within choices."""

ICU = re.compile(r"\s*\$?([\w.-]+)\s*,\s*(?:plural|select|selectordinal)\s*,")
FLUENT = re.compile(r"\s*\$?-?([\w.-]+)(?:\([^()]*\))?\s*->")
INK_CHOICE = re.compile(r"\s*[&!~]?\s*(?:\w[\w .()!=<>&]{0,80}:(?=\s))?")
BRANCH = re.compile(r"(?:^|(?<=[\s}]))(=\d+|\w+)\s*\{")
FLUENT_VARIANT = re.compile(r"(\*?)\[\s*([\w.-]+)\s*\]")
LITERAL = re.compile(r"\s*\"([^\"{}]*)\"\s*")


def chosen(text: str, values: Mapping[str, str], depth: int = 0) -> str:
    """Return a text with one branch in place of each choice; other braces are kept.

    >>> chosen("I have {n, plural, one {a coin} other {# coins}}.", {"n": "3"})
    'I have 3 coins.'
    """
    if "{" not in text or depth > MAX_DEPTH:
        return text
    ends = _ends(text)
    out: list[str] = []
    at = 0
    while (start := text.find("{", at)) >= 0:
        end = ends.get(start)
        branch = None if end is None else _branch(text[start + 1 : end], values)
        if end is None or branch is None:
            out.append(text[at : start + 1])
            at = start + 1
        else:
            out += text[at:start], chosen(branch, values, depth + 1)
            at = end + 1
    return "".join([*out, text[at:]])


def _ends(text: str) -> dict[int, int]:
    """Map each opening brace to its closing one; those of inner choices only to `MAX_DEPTH`."""
    opened: list[int] = []
    ends: dict[int, int] = {}
    for found in re.finditer(r"[{}]", text):
        if found[0] == "{":
            opened.append(found.start())
        elif opened:
            start = opened.pop()
            if len(opened) < MAX_DEPTH:
                ends[start] = found.start()
    return ends


def _branch(inner: str, values: Mapping[str, str]) -> str | None:
    """Return the branch of a choice; None for braces of another kind."""
    if found := ICU.match(inner):
        return _of_icu(inner[found.end() :], found[1], values)
    if found := FLUENT.match(inner):
        return _of_fluent(inner[found.end() :], values.get(found[1]))
    if found := LITERAL.fullmatch(inner):
        return found[1]
    found = INK_CHOICE.match(inner)
    head = found.end() if found else 0
    if "|" not in inner and not (head and inner[:head].rstrip().endswith(":")):
        return None
    ways, depth, start = inner[head:], 0, 0
    for mark in re.finditer(r"[{}|]|\Z", ways):
        depth += {"{": 1, "}": -1}.get(mark[0], 0)
        # A bar outside inner braces ends a branch, and so does the end, whatever is open.
        if not mark[0] or (mark[0] == "|" and depth == 0):
            if way := ways[start : mark.start()].strip():
                return way
            start = mark.end()
    return ""


def _of_icu(branches: str, name: str, values: Mapping[str, str]) -> str | None:
    ends = _ends(branches)
    found: dict[str, str] = {}
    at = 0
    while match := BRANCH.search(branches, at):
        end = ends.get(match.end() - 1)
        if end is None:
            return None
        found[match[1]] = branches[match.end() : end]
        at = end + 1
    if not found:
        return None
    value = values.get(name)
    general = found.get("other", next(reversed(found.values())))
    counted = "one" if value == "1" else "other"
    branch = found.get(f"={value}", found.get(value or "", found.get(counted, general)))
    return branch.replace("#", f"{{{name}}}" if value is None else value)


def _of_fluent(variants: str, value: str | None) -> str | None:
    found = list(FLUENT_VARIANT.finditer(variants))
    if not found:
        return None
    stops = [one.start() for one in found[1:]] + [len(variants)]
    ends = zip(found, stops, strict=True)
    texts = {one[2]: variants[one.end() : stop].strip() for one, stop in ends}
    general = next((one[2] for one in found if one[1]), found[-1][2])
    return texts.get(value or "", texts.get("one" if value == "1" else general, texts[general]))
