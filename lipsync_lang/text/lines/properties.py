"""Java's properties: ``name = text``, with ``#`` and ``!`` before comments."""

import re
from collections.abc import Iterator
from itertools import chain

from lipsync_lang.text.lines.line_readers import Line, LineFile, reader

PROPERTY = re.compile(r"\s*((?:\\.|[^\s:=\\])+)\s*[:=\s]\s*(.*)", re.DOTALL)
PROPERTY_ESCAPE = re.compile(r"\\(?:u([0-9A-Fa-f]{4})|([:=#! \\]))")


@reader("properties", suffixes=[".properties"])
def read(source: LineFile) -> Iterator[Line]:
    """Java's .properties: a text for each name; a backslash at the end continues a text."""
    begun, first = "", 0
    # An empty row at the end closes a text that the last row would continue.
    for number, row in chain(source.numbered(), [(0, "")]):
        if not begun and (not row.strip() or row.lstrip()[0] in "#!"):
            continue
        first = first if begun else number
        begun += row.strip() if begun else row
        # Two backslashes are one that is text.
        if (len(begun) - len(begun.rstrip("\\"))) % 2:
            begun = begun[:-1]
            continue
        found, begun = PROPERTY.fullmatch(begun), ""
        if found and found[2].strip():
            yield source.line(first, PROPERTY_ESCAPE.sub(unescaped, found[2]), name=found[1])


def unescaped(found: re.Match[str]) -> str:
    """Return the character that an escape stands for."""
    return chr(int(found[1], 16)) if found[1] else found[2]
