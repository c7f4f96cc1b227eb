"""Read a YAML file into plain data, and keep the place of each value.

Conventions: lines and columns count from 1, columns in characters. Plain scalars follow the
YAML 1.2 core schema: ``no``, ``on`` and ``1:30`` stay text. Keys always stay text: a phoneme may
be called ``2``, ``~`` or ``null``. Tags, merge keys and a second document are faults. Size,
nesting and aliases are limited, so that no file can crash the program.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.packs.yaml.pack_files import shown

Loc = tuple[str | int, ...]

Data = Any
"""A YAML value: dict with text keys, tuple, text, number, boolean or None."""


class Position(NamedTuple):
    """A place in a text; line and column count from 1."""

    line: int
    column: int


FILE_START = Position(1, 1)

BETWEEN_SPELLINGS = " | "
"""Between spellings that share a key, and so a value."""


class SourceMark(NamedTuple):
    """The place of a value, and the marks of the values inside.

    For a mapping, `inner` maps each key to (place of the key, mark of the value). For a sequence,
    `inner` lists the marks of the items.
    """

    line: int
    column: int
    inner: "dict[str, tuple[Position, SourceMark]] | list[SourceMark] | None" = None


@dataclass(frozen=True, eq=False)
class YamlSource:
    """A YAML file as plain data (dicts, tuples, text, numbers, booleans and None), with its places.

    `root` is the mark of `data`, and `faults` are mistakes in the YAML. `text` is empty after a
    fault that stops the reader.
    """

    path: Path
    data: Data
    root: SourceMark = field(default=SourceMark(1, 1), repr=False)
    faults: tuple[Fault, ...] = ()
    text: str = field(default="", repr=False)

    @cached_property
    def decimal_commas(self) -> frozenset[int]:
        """Lines with a comma between two digits."""
        lines = enumerate(self.text.split("\n"), 1)
        return frozenset(number for number, line in lines if re.search("[0-9],[0-9]", line))

    def where(self, loc: Sequence[str | int], *, key: bool = False) -> Position:
        """Return the place of the value at `loc`, or of its key.

        Steps missing from the file are skipped: the result is then the place of the nearest
        ancestor. A text step into a list finds the first item equal to that text.
        """
        mark, place = self.root, Position(self.root.line, self.root.column)
        data = self.data
        for step in loc:
            found = _step(mark, data, step)
            if found is not None:
                at, mark, data = found
                place = at if key else Position(mark.line, mark.column)
        return place

    def known(self, loc: Sequence[str | int]) -> int:
        """Return the number of leading steps of `loc` that exist in the file."""
        mark, data = self.root, self.data
        for count, step in enumerate(loc):
            found = _step(mark, data, step)
            if found is None:
                return count
            _, mark, data = found
        return len(loc)

    def at(self, loc: Sequence[str | int]) -> Data:
        """Return the value at `loc`; steps missing from the file are skipped."""
        mark, data = self.root, self.data
        for step in loc:
            found = _step(mark, data, step)
            if found is not None:
                _, mark, data = found
        return data

    def fault(
        self, loc: Sequence[str | int], code: str, what: str, hint: str = "", *, key: bool = False
    ) -> Fault:
        """Return a fault at `loc`."""
        return Fault(shown(self.path), *self.where(loc, key=key), code, what, hint)


def _step(
    mark: SourceMark, data: Data, step: str | int
) -> tuple[Position, SourceMark, Data] | None:
    """Go one step down from a value; return (place of key or item, mark, data), or None."""
    inner = mark.inner
    if isinstance(inner, dict):
        if step not in inner:
            # one of several spellings that share the key
            step = next((key for key in inner if step in key.split(BETWEEN_SPELLINGS)), "")
        found = inner.get(step) if isinstance(step, str) else None
        return (*found, data[step]) if found else None
    if inner is None:
        return None
    if isinstance(step, str):
        step = data.index(step) if step in data else -1
    if not 0 <= step < len(inner):
        return None
    return Position(inner[step].line, inner[step].column), inner[step], data[step]
