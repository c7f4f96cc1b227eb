"""Change a pack file and keep its comments, order and untouched lines.

ruamel.yaml dumps the document twice, before and after the change. Only lines that differ between
the two dumps go into the author's text. So an untouched line keeps its spacing, quotes and line
end, even where ruamel.yaml would write it differently.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from difflib import SequenceMatcher
from io import StringIO
from pathlib import Path
from typing import Any

from lipsync_lang.errors import PackError
from lipsync_lang.files import atomic
from lipsync_lang.packs.yaml.source import Data, scan

LINE_CHARS = 4096
"""Line width in characters; large enough that ruamel.yaml never folds a line."""

Document = Any
"""ruamel.yaml's `CommentedMap`, which is untyped."""


def write_edited(path: Path, content: bytes) -> None:
    """Write a whole pack file; raise `OutputError` if that fails."""
    with atomic(path, durable=True) as stream:
        stream.write(content)


def redumped(text: str, change: Callable[[Document], None]) -> str:
    """Return a YAML text after a change of its document.

    Parameters
    ----------
    text : sound YAML
    change : gets the text as a mapping, and changes it in place

    Raises
    ------
    PackError
        The text has a form that cannot be dumped.
    """
    newline = "\r\n" if "\r\n" in text else "\n"
    lines = text.replace("\r\n", "\n")
    document = _load(lines)
    before = _dump(document, lines)
    change(document)
    after = _dump(document, lines)
    merged = _transfer(lines, before, after)
    if _data(merged) != _data(after):
        merged = after  # the merge lost part of the change, so give up the author's formatting
    return text if after == before else merged.replace("\n", newline)


def _data(text: str) -> Data:
    return scan(Path(), text.encode()).data


def flow(value: object) -> Document:
    """Return plain data as a document that is dumped on one line: ``[[0, 0], [1, 1]]``."""
    from ruamel.yaml.comments import CommentedMap, CommentedSeq

    made: Document
    if isinstance(value, Mapping):
        made = CommentedMap({key: flow(inner) for key, inner in value.items()})
    elif isinstance(value, Sequence) and not isinstance(value, str):
        made = CommentedSeq([flow(inner) for inner in value])
    else:
        return value
    made.fa.set_flow_style()
    return made


def _yaml(text: str) -> Document:
    """Return a ruamel.yaml instance with the indentation of a text."""
    from ruamel.yaml import YAML

    yaml = YAML()
    yaml.width = LINE_CHARS
    yaml.preserve_quotes = True
    yaml.allow_unicode = True
    mapping, offset = _indents(text)
    yaml.indent(mapping=mapping, sequence=offset + 2, offset=offset)
    return yaml


def _indents(text: str) -> tuple[int, int]:
    """Return the indentation of mappings and of list dashes in a text, in spaces."""
    block = re.compile(
        r"^( *)[^\s#-][^\n]*:[ \t]*(?:#[^\n]*)?\n(?:[ \t]*(?:#[^\n]*)?\n)*( *)(- )?", re.MULTILINE
    )
    found = [(len(m[2]) - len(m[1]), bool(m[3])) for m in block.finditer(text)]
    mapping = next((by for by, dash in found if by > 0 and not dash), 2)
    return mapping, next((by for by, dash in found if by >= 0 and dash), mapping)


def _load(text: str) -> Document:
    from ruamel.yaml.error import YAMLError

    try:
        return _yaml(text).load(text)
    except (YAMLError, ValueError, TypeError) as error:
        raise PackError(f"the file cannot be edited here: {error}") from None


def _dump(document: Document, text: str) -> str:
    out = StringIO()
    _yaml(text).dump(document, out)
    return out.getvalue()


def _transfer(text: str, before: str, after: str) -> str:
    """Apply the changes from `before` to `after` to `text`, which has the same data as `before`."""
    own, old, new = (t.splitlines(keepends=True) for t in (text, before, after))
    place = _places(own, old)
    out: list[str] = []
    for tag, start, stop, first, last in _opcodes(old, new):
        out += own[place[start] : place[stop]] if tag == "equal" else new[first:last]
    return "".join(out)


def _places(own: Sequence[str], old: Sequence[str]) -> list[int]:
    """Map each line boundary of `old` to one of `own`; lines are compared without spaces."""
    bare, bare_old = (["".join(line.split()) for line in lines] for lines in (own, old))
    place = [0] * (len(old) + 1)
    for _, first, last, start, stop in _opcodes(bare, bare_old):
        even = last - first == stop - start
        for index in range(start, stop):
            place[index] = first + (index - start) if even else first
    place[0], place[len(old)] = 0, len(own)
    return place


def _opcodes(one: Sequence[str], other: Sequence[str]) -> list[tuple[str, int, int, int, int]]:
    """Return difflib's opcodes between two texts.

    `SequenceMatcher` is quadratic, so the common head and tail are cut off first.
    """
    short = min(len(one), len(other))
    head = next((n for n in range(short) if one[n] != other[n]), short)
    tail = next((n for n in range(short - head) if one[-1 - n] != other[-1 - n]), short - head)
    middle = SequenceMatcher(
        None, one[head : len(one) - tail], other[head : len(other) - tail], autojunk=False
    ).get_opcodes()
    moved = [(tag, a + head, b + head, c + head, d + head) for tag, a, b, c, d in middle]
    start = [("equal", 0, head, 0, head)] if head else []
    end = [("equal", len(one) - tail, len(one), len(other) - tail, len(other))] if tail else []
    return [*start, *moved, *end]
