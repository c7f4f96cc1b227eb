"""Texts to lint, with their places: the prose of Markdown pages and the words of Python modules."""

import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

_HIDDEN = re.compile(
    r"\A---\n.*?\n---\n"  # front matter
    r"|^(?P<fence> *(`{3,}|~{3,}))[^\n]*\n.*?\n *\2[ \t]*$"  # code blocks
    r"|<!-- lint: off -->.*?<!-- lint: on -->"  # examples of what not to write
    r"|!\[[^\]]*\](?=\()"  # descriptions of pictures, which may be long
    r"|<!--.*?-->|<[a-zA-Z/][^>\n]*>|\{%.*?%\}"  # comments, tags and statements of templates
    r"|^\[[^\]]+\]: .*?$"  # targets of links
    r"|^ *\|?[-:| ]{3,}\|[-:| ]*$",  # rules below the head of a table
    re.MULTILINE | re.DOTALL,
)
CODE = re.compile(r"(`+)(?!`).+?(?<!`)\1(?!`)", re.DOTALL)
_TARGET = re.compile(r"(?<=\])\([^()\s]*(?:\([^()]*\))?[^()\s]*\)")
_BLOCK = re.compile(r"^\s*(?:[-*+] |\d+\. |#+ |> ?|!!! \w+ ?|:   )")
_STOP = re.compile(r"[.!?][\"')\]*_]*\s+(?=[\"'(\[*_]*[\w\x00])")
_SHORTENED = re.compile(r"(?:\b(?:e\.g|i\.e|etc|vs|al|ca|cf|No|Dr|Fig|pp?))\.$")
PLACEHOLDER = "\x00"
"""Stands for code and for the values of an f-string: one word, and never a part of a pattern."""


_WORDS = re.compile(rf"[a-z][,:;]? +[\"'(]?[a-z{PLACEHOLDER}]|{PLACEHOLDER}[,:;]? +[\"'(]?[a-z]")


@dataclass(frozen=True)
class Sentence:
    """A sentence of prose, and the line on which it begins."""

    path: Path
    line: int
    text: str
    running: bool
    """False in tables and headings, which need not be sentences."""


def sentences_of_page(path: Path) -> Iterator[Sentence]:
    """Read the sentences of a Markdown page; code is one placeholder a span."""
    text = _HIDDEN.sub(blank, path.read_text(encoding="utf-8"))
    text = _TARGET.sub(blank, CODE.sub(mark, text))
    for line, block in _blocks(text.splitlines()):
        if block.lstrip().startswith("|"):
            for cell in block.strip().strip("|").split("|"):
                yield from split(path, line, cell, running=False)
        else:
            running = not block.lstrip().startswith("#")
            yield from split(path, line, block, running=running)


def sentences_of_module(path: Path, *, messages: bool = True) -> Iterator[Sentence]:
    """Read the summaries of docstrings, and every text of two words or more, of a module."""
    nodes = [
        node
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, (ast.Expr, ast.Constant, ast.JoinedStr))
    ]
    documented = {id(node.value) for node in nodes if _is_text(node)}
    inner = {id(part) for node in nodes if isinstance(node, ast.JoinedStr) for part in node.values}
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in inner:
            text = node.value
            if id(node) in documented:
                text = text.strip().partition("\n\n")[0]
        elif isinstance(node, ast.JoinedStr):
            text = "".join(_said(part) for part in node.values)
        else:
            continue
        if is_prose(text) and (messages or id(node) in documented):
            text = CODE.sub(mark, text)
            yield from split(path, node.lineno, text, running=id(node) in documented)


def is_prose(text: str) -> bool:
    """Tell whether a text has two words or more."""
    return _WORDS.search(text) is not None


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _said(part: ast.expr) -> str:
    return part.value if isinstance(part, ast.Constant) else PLACEHOLDER


def blank(match: re.Match[str]) -> str:
    """Replace a passage by its line breaks alone, so that lines keep their numbers."""
    return re.sub(r"[^\n]", "", match[0])


def mark(match: re.Match[str]) -> str:
    """Replace a passage by a placeholder, behind its line breaks."""
    return "\n" * match[0].count("\n") + PLACEHOLDER


def _blocks(lines: list[str]) -> Iterator[tuple[int, str]]:
    """Join the lines of each paragraph, heading, item and row, with the number of the first."""
    first, held = 0, []
    for number, line in enumerate([*lines, ""], start=1):
        row = line.lstrip().startswith("|")
        opens = _BLOCK.match(line)
        if held and (not line.strip() or opens or row):
            yield first, "\n".join(held)
            held = []
        if not line.strip():
            continue
        if not held:
            first = number
        held.append(_BLOCK.sub(lambda match: "# " if "#" in match[0] else "", line))
        if row or (opens and "#" in opens[0]):
            yield first, held.pop()


def split(path: Path, line: int, text: str, *, running: bool) -> Iterator[Sentence]:
    """Split a block into sentences."""
    start = 0
    ends = [
        match.end()
        for match in _STOP.finditer(text)
        if not _SHORTENED.search(text[: match.start() + 1])
    ]
    for end in [*ends, len(text)]:
        part = text[start:end]
        if words := " ".join(part.split()):
            above = text[:start].count("\n") + part[: len(part) - len(part.lstrip())].count("\n")
            yield Sentence(path, line + above, words.lstrip("# "), running)
        start = end
