"""Texts of JavaScript: strings and templates of two words or more, and summaries of comments."""

import re
from collections.abc import Iterator
from pathlib import Path

from prose.texts import PLACEHOLDER, Sentence, is_prose, split

_TOKEN = re.compile(
    r"""/\*\*(?P<summary>.*?)\*/
    | //[^\n]* | /\*.*?\*/
    | "(?P<double>(?:\\.|[^"\\\n])*)" | '(?P<single>(?:\\.|[^'\\\n])*)'
    | (?P<template>`)
    | (?<=[(,=:\[!&|?{};>])\s*/(?![*/])(?:\\.|\[(?:\\.|[^\]\\\n])*\]|[^/\\\n\[])+/  # a pattern
    | [{}]""",
    re.VERBOSE | re.DOTALL,
)
_PIECE = re.compile(r"(?P<end>`)|(?P<value>\$\{)|\\.|[^`\\$]+|\$", re.DOTALL)
_ESCAPE = re.compile(r"\\(?:u\{?[0-9a-fA-F]+\}?|x..|.)", re.DOTALL)

Found = list[tuple[int, str, bool]]
"""Offset, text, and True for comments."""


def sentences_of_script(path: Path) -> Iterator[Sentence]:
    """Read what a script shows, and the summaries of its comments."""
    source = path.read_text(encoding="utf-8")
    found: Found = []
    if _code(f"{source}}}", 0, found) != len(source) + 1:
        raise ValueError(f"{path}: braces do not match, so texts and code were confused")
    for offset, text, comment in sorted(found):
        if comment or (is_prose(text) and ";\n" not in text):
            line = source.count("\n", 0, offset) + 1
            yield from split(path, line, text, running=comment or text.endswith("."))


def _code(source: str, at: int, found: Found) -> int:
    """Collect the texts of code up to the brace that closes it, and return its end."""
    depth = 0
    while match := _TOKEN.search(source, at):
        at = match.end()
        kind = match.lastgroup
        if kind == "template":
            at = _template(source, at, found)
        elif kind == "summary":
            found.append((match.start(), _summary(match[kind]), True))
        elif kind:
            found.append((match.start(), _ESCAPE.sub(" ", match[kind]), False))
        elif match[0] == "{":
            depth += 1
        elif match[0] == "}":
            if not depth:
                return at
            depth -= 1
    return -1


def _template(source: str, start: int, found: Found) -> int:
    """Collect a template, and the texts of the values in it, and return its end."""
    at, parts = start, ""
    while (match := _PIECE.match(source, at)) and not match["end"]:
        at = match.end()
        if match["value"]:
            at = _code(source, at, found)
            parts += PLACEHOLDER
        else:
            parts += _ESCAPE.sub(" ", match[0])
    found.append((start, parts, False))
    return at + 1


def _summary(comment: str) -> str:
    """Keep a comment up to its first tag or empty line."""
    lines = "\n".join(re.sub(r"^\s*\*? ?", "", line) for line in comment.splitlines())
    return re.split(r"(?:^|\s|\{)@\w|\S\n\n", lines, maxsplit=1)[0]
