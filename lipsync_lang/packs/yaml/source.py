"""YAML as plain data, each value with its place in the file.

Conventions: lines and columns count from 1, columns in characters. Plain scalars follow the
YAML 1.2 core schema, so that ``no``, ``on`` and ``1:30`` stay text; keys are always the text
that stands in the file, so that a phoneme may be called ``2``, ``~`` or ``null``. Tags, merge
keys and a second document are faults. Reading is iterative and bounded: no file, however
made, takes the program down.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from lipsync_lang.errors import PackError
from lipsync_lang.packs.yaml.faults import Fault, PackFaults, shown

LARGEST = 2**20
"""Bytes; a larger file is not a pack."""

Loc = tuple[str | int, ...]

Data = Any
"""Dicts with text keys, tuples, text, numbers, booleans and None, as YAML holds them."""


class Position(NamedTuple):
    """A place in a text, from 1."""

    line: int
    column: int


TOP = Position(1, 1)


class SourceMark(NamedTuple):
    """Where a value starts, and the marks of what it holds.

    `inner` maps a mapping's keys to (line and column of the key, mark of the value), and
    lists the marks of a sequence's items.
    """

    line: int
    column: int
    inner: "dict[str, tuple[Position, SourceMark]] | list[SourceMark] | None" = None


@dataclass(frozen=True, eq=False)
class YamlSource:
    """A YAML file as plain data, with the place of every value.

    Parameters
    ----------
    path : the file
    data : dicts, tuples, text, numbers, booleans and None
    faults : what the reader found wrong without having to stop
    """

    path: Path
    data: Data
    root: SourceMark = field(default=SourceMark(1, 1), repr=False)
    faults: tuple[Fault, ...] = ()

    def where(self, loc: Sequence[str | int], *, key: bool = False) -> Position:
        """Return the place of the value at `loc`, or of its key.

        Steps that the file does not have are passed over, so that the place is that of the
        nearest value it does have. A text step into a list finds the item of that text.
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
        """Return how many steps of `loc` the file has before the first that it does not."""
        mark, data = self.root, self.data
        for count, step in enumerate(loc):
            found = _step(mark, data, step)
            if found is None:
                return count
            _, mark, data = found
        return len(loc)

    def at(self, loc: Sequence[str | int]) -> Data:
        """Return the value at `loc`, passing over steps that the file does not have."""
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


def read_yaml(path: Path, content: bytes | None = None) -> YamlSource:
    """Read a YAML file, or `content` in its place.

    Raises
    ------
    PackError
        The file cannot be opened.
    PackFaults
        It is not sound YAML; every fault of it that can be seen at once.
    """
    if content is None:
        content = read_bytes(path)
    source = scan(path, content)
    if source.faults:
        raise PackFaults(source.faults)
    return source


def read_bytes(path: Path) -> bytes:
    """Return what a pack file holds; a file that cannot be opened is a `PackError`."""
    try:
        with path.open("rb") as stream:
            return stream.read(LARGEST + 1)
    except OSError as error:
        raise PackError(f"{shown(path)}: cannot be read: {error.strerror or error}") from None


def scan(path: Path, content: bytes) -> YamlSource:
    """Read YAML as far as it goes, keeping what is wrong in ``Source.faults``.

    `Source.data` is None after a fault that leaves no data to trust.
    """
    from lipsync_lang.packs.yaml.building import build

    return build(path, content)


def _step(
    mark: SourceMark, data: Data, step: str | int
) -> tuple[Position, SourceMark, Data] | None:
    """Go one step down from a value: (place of the key or item, its mark, its data)."""
    inner = mark.inner
    if isinstance(inner, dict):
        found = inner.get(step) if isinstance(step, str) else None
        return (*found, data[step]) if found else None
    if inner is None:
        return None
    if isinstance(step, str):
        step = data.index(step) if step in data else -1
    if not 0 <= step < len(inner):
        return None
    return Position(inner[step].line, inner[step].column), inner[step], data[step]
