"""Set, insert and delete values at locations of a pack's text, and keep every other character.

A pack is cut into parts at the keys of its root, and at those of the block mappings below: a bank
of 441 bigrams has 441 parts and a few more. A change parses and rewrites one part alone, so it
takes milliseconds in any pack. Parts are never changed; a text before and after a change shares all
others.
"""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Final, NamedTuple, Self

from lipsync_lang.base.errors import PackError
from lipsync_lang.base.files import atomic
from lipsync_lang.packs.finding import pack_name
from lipsync_lang.packs.models.validation import validated
from lipsync_lang.packs.yaml.building import read_yaml, scan
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.packs.yaml.pack_files import MAX_PACK_BYTES, read_bytes, shown
from lipsync_lang.packs.yaml.rewriting import RewriteError, rewritten, same
from lipsync_lang.packs.yaml.source import FILE_START, Data, Loc, Position, SourceMark, YamlSource


class _Absent:
    """The type of `ABSENT`."""

    def __repr__(self) -> str:
        return "ABSENT"


ABSENT: Final = _Absent()
"""Stands for no value: setting it deletes the entry."""

Change = tuple[Loc, Any]
"""A location and its new value, or `ABSENT`."""

INDEPENDENT = "bigrams"
"""The long mapping of packs; the model of a pack checks its entries one by one."""

_ALIAS_OR_LINE_END = re.compile(r"(?:^|[\s\[{,:-])\*\S|[\x85\u2028\u2029]|\r(?!\n)")
"""Aliases, whose values are stated elsewhere, and unusual line ends: such a text is not cut."""


class TextPart(NamedTuple):
    """Whole lines of a text: an entry with the comments behind it.

    `loc` is () for a text that is not cut. `value` is None for the lines before the first key, and
    for a key whose entries are parts.
    """

    loc: Loc
    text: str
    value: Data = None


HEAD_LOC: Final[Loc] = ("", "")
"""Location of the lines before the first key."""


@dataclass(frozen=True, eq=False)
class SplicedText:
    r"""A pack's text in parts; `changed` returns another one.

    `sound` is False if the text did not fit its model when it was read.

    >>> from pathlib import Path
    >>> text = b"kind: bank\nformat: 1\nname: b\nposeset: f\nbigrams: {}  # none\n"
    >>> pack = SplicedText.read(Path("b.yaml"), text)
    >>> print(pack.changed([(("style",), "sad")]).content.decode(), end="")
    kind: bank
    format: 1
    name: b
    poseset: f
    bigrams: {}  # none
    style: sad
    """

    path: Path
    parts: tuple[TextPart, ...] = field(repr=False)
    sound: bool = True

    @classmethod
    def read(cls, path: Path, content: bytes) -> Self:
        """Cut a pack into parts; raise `PackFaults` for content that is not sound YAML."""
        return cls.of(read_yaml(path, content), content)

    @classmethod
    def of(cls, source: YamlSource, content: bytes) -> Self:
        """Cut a pack that was read already."""
        _, faults = validated(source, name=pack_name(source.path))
        return cls(source.path, tuple(_parts(source, content.decode("utf-8"))), not faults)

    @cached_property
    def content(self) -> bytes:
        """The text as bytes."""
        return "".join(part.text for part in self.parts).encode()

    @cached_property
    def data(self) -> Data:
        """The text as data; a mapping that is not changed is shared, so change none."""
        data: dict[str, Data] = {}
        for loc, _, value in self.parts:
            if not loc:
                return value
            if loc is HEAD_LOC:
                continue
            if len(loc) == 1:
                data[str(loc[0])] = {} if value is _ENTRIES else value
            else:
                data[str(loc[0])][loc[1]] = value
        return data

    @cached_property
    def _numbers(self) -> dict[Loc, int]:
        """Number of each part by its location."""
        return {part.loc: number for number, part in enumerate(self.parts)}

    def at(self, loc: Loc) -> Data:
        """Return the value at a location, or `ABSENT`."""
        return get(self.data, loc)

    def place(self, loc: Loc) -> Position:
        """Return the place of the key of a part; that of the whole text if it is none."""
        number = self._numbers.get(loc)
        if number is None:
            return FILE_START
        before = sum(part.text.count("\n") for part in self.parts[:number])
        return Position(before + 1, len(_margin(self.parts[number].text)) + 1)

    def changed(self, changes: Sequence[Change]) -> Self:
        """Return the text with values set, inserted or deleted, in order.

        Raise `PackFaults` if the pack would be faulty, and `PackError` for a location within a
        value that has no entries.
        """
        # each change sees those before it, so that two may meet in one entry
        made = self
        for loc, value in changes:
            made = made._spliced(loc, plain(value))
        if made is not self:
            # a sound bank of 441 bigrams needs no second look at the 440 that stay
            entries = {loc[1] for loc, _ in changes if loc[:1] == (INDEPENDENT,) != loc}
            _refuse_faults(made, entries if self.sound else set())
        return made if made is self else replace(made, sound=True)

    def only(self, entries: Collection[str | int]) -> YamlSource:
        """Return the data with these of the independent entries alone, without their places."""
        some = self.data.get(INDEPENDENT) or {}
        chosen = {key: some[key] for key in entries if key in some}
        return YamlSource(self.path, {**self.data, INDEPENDENT: chosen})

    def checked(self) -> Self:
        """Return the text itself; raise `PackFaults` if the pack is faulty."""
        if not self.sound:
            _refuse_faults(self, set())
        return self

    def _spliced(self, loc: Loc, value: Data) -> Self:
        """Return the text with one value changed."""
        old = self.at(loc)
        # a value that is there keeps its spelling: 0.50 stays 0.50
        if old is value or (ABSENT not in (old, value) and same(old, value)):
            return self
        number = self._numbers.get(loc[:2], self._numbers.get(loc[:1]))
        if number is None:  # a new key of the root goes behind the last that has no parts
            whole = [n for n, part in enumerate(self.parts) if len(part.loc) == 1]
            whole = [n for n in whole if self.parts[n].value is not _ENTRIES]
            return self._in_part(whole[-1], loc, value) if whole else self._in_whole(loc, value)
        first = stop = self._numbers[loc[:1]]
        while stop < len(self.parts) and self.parts[stop].loc[:1] == loc[:1]:
            stop += 1
        if value is ABSENT and len(loc) == 1:
            return self._without(first, stop)
        if value is ABSENT and loc == self.parts[number].loc and stop - first > 2:  # noqa: PLR2004 the key and one entry
            return self._without(number, number + 1)
        entries = self.parts[number].value is _ENTRIES
        if (len(loc) == 1 and entries) or (value is ABSENT and loc == self.parts[number].loc):
            return self._in_whole(loc, value)
        return self._in_part(stop - 1 if entries else number, loc, value)

    def _in_part(self, number: int, loc: Loc, value: Data) -> Self:
        """Change a value within a part, or insert an entry behind it."""
        part = self.parts[number]
        old = {str(part.loc[-1]): part.value}
        made = _rewritten(self.path, part.text, old, loc[len(part.loc) - 1 :], value)
        return self._with(number, number + 1, _cut(*made, part.loc[:-1]))

    def _in_whole(self, loc: Loc, value: Data) -> Self:
        """Change a value that needs the whole text."""
        text = "".join(part.text for part in self.parts)
        made = _rewritten(self.path, text, self.data, loc, value)
        return replace(self, parts=tuple(_parts(*made)))

    def _without(self, first: int, stop: int) -> Self:
        """Delete parts; the comments behind the last of them stay."""
        lines = self.parts[stop - 1].text.splitlines(keepends=True)
        end = len(lines)
        while end and (not lines[end - 1].strip() or lines[end - 1].lstrip().startswith("#")):
            end -= 1
        rest = "".join(lines[end:])
        before = self.parts[first - 1] if first else TextPart(HEAD_LOC, "")
        return self._with(max(first - 1, 0), stop, [before._replace(text=before.text + rest)])

    def _with(self, first: int, stop: int, made: Iterable[TextPart]) -> Self:
        return replace(self, parts=(*self.parts[:first], *made, *self.parts[stop:]))


def _refuse_faults(pack: SplicedText, entries: Collection[str | int]) -> None:
    """Raise the faults of a pack; of independent entries, if any are named, check only these."""
    source = pack.only(entries) if entries else YamlSource(pack.path, pack.data)
    _, faults = validated(source, name=pack_name(pack.path))
    if faults or len(pack.content) > MAX_PACK_BYTES:
        # once more from the text, because data alone have no places
        _, faults = validated(scan(pack.path, pack.content), name=pack_name(pack.path))
        raise PackFaults(faults)


_ENTRIES: Final = object()
"""Value of a part whose entries are parts of their own."""


def spliced(source: YamlSource, content: bytes, changes: Sequence[Change]) -> bytes:
    """Return the bytes of a pack with values changed, as `SplicedText.changed` does.

    `source` is the pack as read from `content`.
    """
    return SplicedText.of(source, content).changed(changes).content


def rewrite(path: Path, changes: Sequence[Change]) -> None:
    """Change values of a pack's file, as `SplicedText.changed` does."""
    content = SplicedText.read(path, read_bytes(path)).changed(changes).content
    with atomic(path, durable=True) as stream:
        stream.write(content)


def get(data: Data, loc: Loc) -> Data:
    """Return the value at a location of plain data, or `ABSENT`."""
    for step in loc:
        if isinstance(data, tuple):
            data = dict(enumerate(data))
        if not isinstance(data, dict) or step not in data:
            return ABSENT
        data = data[step]
    return data


def put(data: Data, loc: Loc, value: Data) -> Data:
    """Return plain data with a value set or deleted; nothing given is changed.

    Raise `PackError` for a location within a value that has no such entries.
    """
    if not loc:
        return value
    step, *rest = loc
    if isinstance(step, int):
        if not isinstance(data, tuple) or not 0 <= step <= len(data):
            raise PackError(f"there is no list with an item {step + 1} to change")
        gone = value is ABSENT and not rest
        inner = data[step] if step < len(data) else {}
        made = () if gone else (put(inner, tuple(rest), value),)
        return (*data[:step], *made, *data[step + 1 :])
    if data is not None and not isinstance(data, dict):
        raise PackError(f"`{step}` cannot be set within a value that is not a mapping")
    inner = (data or {}).get(step)
    if value is ABSENT and (not rest or inner is None):
        return {key: one for key, one in (data or {}).items() if key != step or rest}
    return {**(data or {}), step: put(inner, tuple(rest), value)}


def plain(value: Any) -> Data:
    """Return a value as the scanner would: dicts, tuples, text, numbers, booleans and None."""
    if isinstance(value, Mapping):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, str):
        return tuple(plain(one) for one in value)
    # numpy's float64 is a float, and would be written as `np.float64(0.5)`
    return float(value) if isinstance(value, float) else value


def _rewritten(path: Path, text: str, old: Data, loc: Loc, value: Data) -> tuple[YamlSource, str]:
    """Return a text with data `old` with one value changed, as data too.

    Raise `PackError` for a value that is stated in a way that allows no change.
    """
    new = put(old, loc, value)
    with suppress(RewriteError):
        made = rewritten(text, old, new)
        source = scan(path, made.encode())
        # The text is checked rather than trusted: an alias, say, would change in two places.
        if not source.faults and same(source.data, new) and _margin(made) == _margin(text):
            return source, made
    where = "/".join(map(str, loc))
    raise PackError(
        f"{shown(path)}: `{where}` cannot be changed here, perhaps because of an alias (`*name`); "
        "change it in the file"
    )


def _margin(text: str) -> str:
    """Return the spaces before the first key of a part."""
    return text[: len(text) - len(text.lstrip(" "))]


def _parts(source: YamlSource, text: str) -> Iterator[TextPart]:
    """Yield the parts of a whole text."""
    lines = text.splitlines(keepends=True)
    starts = _starts(source.root, lines)
    if not starts or _ALIAS_OR_LINE_END.search(text):
        yield TextPart((), text, source.data)
        return
    if starts[0][1]:
        yield TextPart(HEAD_LOC, "".join(lines[: starts[0][1]]))
    yield from _cut(source, text, ())


def _cut(source: YamlSource, text: str, above: Loc) -> Iterator[TextPart]:
    """Yield the parts of a text that starts with a key; `above` is the location of its mapping."""
    lines = text.splitlines(keepends=True)
    for key, first, stop, mark in _entries(source.root, lines):
        value = source.data[key]
        inner = [] if above else _entries(mark, lines, stop)
        if not inner or inner[0][1] == first:
            yield TextPart((*above, key), "".join(lines[first:stop]), value)
            continue
        yield TextPart((key,), "".join(lines[first : inner[0][1]]), _ENTRIES)
        for name, at, end, _ in inner:
            yield TextPart((key, name), "".join(lines[at:end]), value[name])


def _entries(
    mark: SourceMark, lines: Sequence[str], stop: int | None = None
) -> list[tuple[str, int, int, SourceMark]]:
    """Return key, first line, stop and mark of each entry of a block mapping."""
    starts = _starts(mark, lines)
    stops = [*(row for _, row, _ in starts[1:]), len(lines) if stop is None else stop]
    # Without any start, there is a stop nevertheless.
    pairs = zip(starts, stops, strict=False)
    return [(key, row, end, inner) for (key, row, inner), end in pairs]


def _starts(mark: SourceMark, lines: Sequence[str]) -> list[tuple[str, int, SourceMark]]:
    """Return each key of a block mapping with its line and mark; empty for other values."""
    if not isinstance(mark.inner, dict):
        return []
    found = [(key, at.line - 1, inner) for key, (at, inner) in mark.inner.items()]
    columns = {at.column - 1 for at, _ in mark.inner.values()}
    rows = [row for _, row, _ in found]
    block = bool(found) and (mark.line, mark.column) == next(iter(mark.inner.values()))[0]
    # Two keys on one line cannot be parted by lines.
    apart = block and len(columns) == 1 and rows == sorted(set(rows))
    return found if apart and not any(lines[row][: min(columns)].strip(" ") for row in rows) else []
