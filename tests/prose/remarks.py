"""Texts of YAML packs and settings: the comments, and the fields that people read."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Literal

from prose.texts import CODE, PLACEHOLDER, Sentence, mark, split
from ruamel.yaml import YAML
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode

FIELDS = {
    *("title", "caveats", "reason", "reasons", "why", "weak", "absent", "aside", "lost"),
    *("description", "label", "who", "figure", "of", "data"),
}
"""Fields of packs, of `docs/published.yaml` and of forms that hold prose."""
_SHOWN = {"title", "text"}
"""Fields of tours, which are JSON and so YAML."""
_QUOTED = re.compile(r"\"(?:\\.|[^\"\\\n])*\"|(?<!\w)'[^'\n]*'")
_COMMENT = re.compile(r"(?P<code>^.*?)(?:^|(?<=\s))#+(?!:)[ \t](?P<words>.*)$")


@dataclass(frozen=True)
class _Comment:
    line: int
    words: str
    kind: Literal["block", "row", "aside"]
    """A line of a text, an indented line such as a row of a table, or words behind code."""


def sentences_of_comments(path: Path) -> Iterator[Sentence]:
    """Read the comments that begin with `#`; those on lines of their own are sentences."""
    found = _comments(path.read_text(encoding="utf-8"))
    for _, group in groupby(enumerate(found), lambda pair: (pair[1].line - pair[0], pair[1].kind)):
        rows = [row for _, row in group]
        running = rows[0].kind == "block"
        for part in [rows] if running else [[row] for row in rows]:
            text = CODE.sub(mark, "\n".join(row.words for row in part))
            yield from split(path, part[0].line, text, running=running)


def sentences_of_pack(path: Path) -> Iterator[Sentence]:
    """Read the comments of a pack, and its fields that hold prose."""
    yield from sentences_of_comments(path)
    fields = _SHOWN if path.suffix == ".json" else FIELDS
    for document in YAML(typ="safe").compose_all(path.read_text(encoding="utf-8")):
        for line, text in _fields(document, fields, prose=False):
            yield from split(path, line, CODE.sub(mark, text), running=text.endswith("."))


def _comments(text: str) -> Iterator[_Comment]:
    for number, line in enumerate(text.splitlines(), start=1):
        quoted = "" if line.lstrip().startswith("#") else _QUOTED.sub(PLACEHOLDER, line)
        if match := _COMMENT.match(quoted or line):
            alone = not match["code"].strip()
            row = "row" if match["words"].startswith(" ") else "block"
            yield _Comment(number, match["words"], row if alone else "aside")


def _fields(node: Node | None, fields: set[str], *, prose: bool) -> Iterator[tuple[int, str]]:
    if isinstance(node, MappingNode):
        for key, value in node.value:
            yield from _fields(value, fields, prose=prose or key.value in fields)
    elif isinstance(node, SequenceNode):
        for part in node.value:
            yield from _fields(part, fields, prose=prose)
    elif isinstance(node, ScalarNode) and prose and " " in node.value:
        folded = node.style in ("|", ">")
        yield node.start_mark.line + 1 + folded, node.value
