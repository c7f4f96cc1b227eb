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
from lipsync_lang.packs.models.validation import validated
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.packs.yaml.source import Data, YamlSource, read_bytes, read_yaml, scan

LINE_CHARS = 4096
"""Line width in characters; large enough that ruamel.yaml never folds a line."""

Document = Any
"""ruamel.yaml's `CommentedMap`, which is untyped."""


def edit_pack(path: Path, change: Callable[[Document], None], *, create: str | None = None) -> None:
    """Change a pack in its file.

    Parameters
    ----------
    path : the pack
    change : gets the file as a mapping, and changes it in place
    create : initial text if the file does not exist

    Raises
    ------
    PackFaults
        The file is faulty, or would be after the change; it stays as it was.
    PackError
        The file cannot be opened, or does not exist and `create` is not given.
    OutputError
        The file cannot be written.
    """
    content = create.encode() if create is not None and not path.exists() else read_bytes(path)
    edited = edited_text(path, content, change)
    if edited != content or not path.exists():
        write_edited(path, edited)


def write_edited(path: Path, content: bytes) -> None:
    """Write a whole pack file; raise `OutputError` if that fails."""
    with atomic(path, durable=True) as stream:
        stream.write(content)


def add_entries(
    source: YamlSource, content: bytes, field: str, entries: Mapping[str, Sequence[str]]
) -> bytes:
    """Append entries to a top-level mapping of a pack.

    The entries are inserted as lines of text, which is far quicker than dumping the document.
    ruamel.yaml is used only for a mapping in braces, into which no lines can be inserted.

    Parameters
    ----------
    source : the pack as read from `content`
    content : the file's bytes
    field : the name of the mapping
    entries : the lines of each entry, without indentation, by key

    Returns
    -------
    The new bytes of the file

    Raises
    ------
    PackFaults
        The pack would be faulty with the entries.
    """
    expected = [*(source.data.get(field) or {}), *entries]
    merged = _with_lines(source, content.decode("utf-8"), field, entries).encode()
    written = scan(source.path, merged)
    if written.faults or not _extends(written.data, source.data, field, expected):

        def change(document: Document) -> None:
            there = document.get(field)
            added = _load("".join(f"{line}\n" for lines in entries.values() for line in lines))
            if there:
                there.update(added)
                there.fa.set_block_style()
            else:
                document[field] = added

        return edited_text(source.path, content, change)
    _, faults = validated(written, name=_name(source.path))
    if faults:
        raise PackFaults(faults)
    return merged


def _extends(data: Data, old: Data, field: str, expected: Sequence[str]) -> bool:
    """Return True if `data` is `old` with new keys in one field, and `expected` lists its keys."""
    if not isinstance(data, dict) or not isinstance(data.get(field), dict):
        return False
    before = old.get(field) or {}
    return (
        list(data[field]) == expected
        and {**data, field: None} == {**old, field: None}
        and all(data[field][key] == value for key, value in before.items())
    )


def _with_lines(
    source: YamlSource, text: str, field: str, entries: Mapping[str, Sequence[str]]
) -> str:
    """Insert lines after the last line of a field that is neither blank nor a comment."""
    newline = "\r\n" if "\r\n" in text else "\n"
    lines = text.split("\n")
    inner = source.root.inner if isinstance(source.root.inner, dict) else {}
    indent, end = 2, len(lines)
    if field in inner:
        key, value = inner[field]
        if isinstance(value.inner, dict) and value.inner:
            indent = value.column - 1
        elif isinstance(value.inner, dict):  # `field: {}`
            row = lines[value.line - 1]
            lines[value.line - 1] = re.sub(r"[ \t]*\{[ \t]*\}", "", row, count=1)
        end = min((at.line - 1 for at, _ in inner.values() if at > key), default=end)
    else:
        lines[end - 1 : end] = [*filter(None, lines[end - 1 : end]), f"{field}:", ""]
        end = len(lines)
    while end and (not lines[end - 1].strip() or lines[end - 1].lstrip().startswith("#")):
        end -= 1
    made = [" " * indent + line for added in entries.values() for line in added]
    if newline == "\r\n":
        made = [f"{line}\r" for line in made]
    if end == len(lines):  # the file ends without an end of line
        lines[end - 1] += newline[:-1]
        made[-1] = made[-1].rstrip("\r")
    return "\n".join([*lines[:end], *made, *lines[end:]])


def edited_text(path: Path, content: bytes, change: Callable[[Document], None]) -> bytes:
    """Return the bytes of a pack file after a change; see `edit_pack`."""
    read_yaml(path, content)
    text = content.decode("utf-8")
    newline = "\r\n" if "\r\n" in text else "\n"
    lines = text.replace("\r\n", "\n")
    document = _load(lines)
    before = _dump(document, lines)
    change(document)
    after = _dump(document, lines)
    if after == before:
        return content
    written = scan(path, after.encode())
    merged = _transfer(lines, before, after).replace("\n", newline).encode()
    source = scan(path, merged)
    if source.faults or source.data != written.data:
        # Safety net: if the merge loses part of the change, give up the author's formatting.
        merged, source = after.replace("\n", newline).encode(), written
    _, faults = validated(source, name=_name(path))
    if faults:
        raise PackFaults(faults)
    return merged


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


def _name(path: Path) -> str:
    """Return the name a pack in this file must have: the file's, or for a pose set the folder's."""
    from lipsync_lang.packs.finding import POSESET

    return path.parent.name if path.name == POSESET else path.stem


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
