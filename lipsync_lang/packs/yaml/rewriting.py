"""Rewrite a YAML text for a new value, and touch only the characters that must change.

The old value and the new one are compared. A scalar is replaced in its place; an entry of a block
is inserted or deleted with its lines; a collection on one line keeps the text of its other items.

`building.scan` keeps where a value starts; a change in place needs to know where it ends as well:
a `Span`. Offsets count characters from 0; an end is exclusive.
"""

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from itertools import takewhile
from typing import Literal

from lipsync_lang.packs.yaml.events import Event, YamlError, events
from lipsync_lang.packs.yaml.source import Data
from lipsync_lang.packs.yaml.value_text import (
    INDENT,
    as_scalar,
    block_lines,
    on_one_line,
    wants_block,
)

_GAP = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_VALUE_EVENT = re.compile("(?:Scalar|Alias|(?:Mapping|Sequence)(?:Start|End))Event")

Items = Mapping[str | int, Data]


@dataclass(slots=True)
class Span:
    """The characters of a value, and those of the values inside."""

    kind: Literal["scalar", "mapping", "sequence", "alias"]
    start: int
    end: int
    flow: bool = False
    """True for a mapping in braces or a sequence in brackets."""
    quote: str = ""
    """Quotes of a scalar, or the sign of a block scalar (`|`, `>`)."""
    entries: "list[EntrySpan]" = field(default_factory=list)


@dataclass(slots=True)
class EntrySpan:
    """A key with its value, or an item of a sequence."""

    key: str | None
    start: int
    """Start of the key, of an item in brackets, or of an item's dash."""
    after: int
    """End of the colon, the dash, or a key alone; a value without a character can be put here."""
    value: Span


def spans(text: str) -> Span:
    """Return the span of the text's root value.

    Raise `YamlError` if no parser reads the text, or if it has a form that packs do not use.
    """
    found = [e for e in events(text) if _VALUE_EVENT.fullmatch(e.__class__.__name__)]
    if not found:
        raise _unusual()
    walk = _Walk(text, iter(found))
    return walk.value(next(walk.events))


class _Walk:
    """Turns the events of one text into spans."""

    def __init__(self, text: str, events: Iterator[Event]) -> None:
        self.text, self.events = text, events

    def value(self, event: Event, after: int = 0) -> Span:
        """Return the span of the value of an event; `after` is where an empty one stands."""
        name, start, end = event.__class__.__name__, event.start_mark.index, event.end_mark.index
        if name == "AliasEvent":
            return Span("alias", start, end)
        if name == "ScalarEvent":
            quote = event.style or ""
            if not quote and not event.value:
                return Span("scalar", after, after)
            # the parser ends a block scalar after the blank lines behind it
            if quote in ("|", ">"):
                end = max(start, len(self.text[:end].rstrip()))
            return Span("scalar", start, end, quote=quote)
        mapping = name == "MappingStartEvent"
        span = Span("mapping" if mapping else "sequence", start, end, bool(event.flow_style))
        last = self._mapping(span) if mapping else self._sequence(span)
        span.end = last if span.flow or not span.entries else span.entries[-1].value.end
        return span

    def _mapping(self, span: Span) -> int:
        """Add the entries of a mapping; return the end of its last event."""
        key = next(self.events)
        while key.__class__.__name__ != "MappingEndEvent":
            end = self._skip(key.end_mark.index)
            colon = self.text[end : end + 1] == ":"
            if key.__class__.__name__ != "ScalarEvent" or not (colon or span.flow):
                raise _unusual()
            after = end + 1 if colon else key.end_mark.index  # a key alone, as in `{a, b}`
            value = self.value(next(self.events), after)
            span.entries.append(EntrySpan(key.value, key.start_mark.index, after, value))
            key = next(self.events)
        return int(key.end_mark.index)

    def _sequence(self, span: Span) -> int:
        """Add the items of a sequence; return the end of its last event."""
        at = span.start
        item = next(self.events)
        while item.__class__.__name__ != "SequenceEndEvent":
            if span.flow:
                value = self.value(item, item.start_mark.index)
                span.entries.append(EntrySpan(None, value.start, value.start, value))
            else:
                dash = self._skip(at)
                if self.text[dash : dash + 1] != "-":
                    raise _unusual()
                value = self.value(item, dash + 1)
                span.entries.append(EntrySpan(None, dash, dash + 1, value))
                at = value.end
            item = next(self.events)
        return int(item.end_mark.index)

    def _skip(self, at: int) -> int:
        """Return the offset of the next character that is neither space nor comment."""
        found = _GAP.match(self.text, at)
        return at if found is None else found.end()


def _unusual() -> YamlError:
    return YamlError(None, "a form that packs do not use", "", None)


class RewriteError(Exception):
    """The text is written in a form that is not rewritten in place."""


def rewritten(text: str, old: Data, new: Data) -> str:
    """Return a text with data `old` as one with data `new`.

    Raise `RewriteError` for a form that cannot be rewritten here; the caller needs another way.
    """
    try:
        root = spans(text)
    except YamlError as error:
        raise RewriteError(error.problem) from None
    edits = _Edits(text)
    edits.close_block_scalar(root)
    edits.change(root, old, new)
    return edits.applied(0, len(text))


def same(one: Data, other: Data) -> bool:
    """Return True for equal values with keys in the same order."""
    if isinstance(one, dict) and isinstance(other, dict):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    # True equals 1 in Python, but not in YAML.
    return isinstance(one, bool) is isinstance(other, bool) and bool(one == other)


class _Edits:
    """Replacements of characters of one text, collected and applied together."""

    def __init__(self, text: str) -> None:
        self.text = text
        # A file of Windows keeps its line ends.
        self.newline = "\r\n" if "\r\n" in text else "\n"
        self.found: list[tuple[int, int, str]] = []

    def applied(self, start: int, end: int) -> str:
        """Return a part of the text with the edits that lie within."""
        out: list[str] = []
        # By both ends, so that an insertion comes before a deletion that starts at its place.
        for first, last, new in sorted(self.found, key=lambda edit: edit[:2]):
            if start <= first and last <= end:
                out += [self.text[start:first], new]
                start = max(start, last)
        return "".join([*out, self.text[start:end]])

    def close_block_scalar(self, root: Span) -> None:
        """Keep a block scalar at the end of the text without a line end when lines follow."""
        last = root
        while last.entries:
            last = last.entries[-1].value
        if last.quote in {"|", ">"} and not self.text.endswith("\n"):
            # A following line would give it a line end, which `-` strips again.
            self.put(last.start + 1, last.start + 1, "-")

    def put(self, start: int, end: int, new: str) -> None:
        """Replace characters."""
        self.found.append((start, end, new))

    def change(self, span: Span, old: Data, new: Data, within: EntrySpan | None = None) -> None:
        """Turn the value of a span from `old` into `new`; `within` is its entry.

        A value in a form that takes no smaller change is written anew as a whole.
        """
        if same(old, new):
            return
        # an attempt that fails half-way must leave no edits
        found = list(self.found)
        before, after = _items(span, old), _items(span, new)
        if not before or not after:
            self._replace(span, new, within)
            return
        try:
            if span.kind == "mapping":
                self._mapping(span, before, after, new, within)
            else:
                self._sequence(span, list(before.values()), list(after.values()), new, within)
        except RewriteError:
            self.found = found
            self._replace(span, new, within)

    def _replace(self, span: Span, new: Data, within: EntrySpan | None) -> None:
        """Replace a whole value; `within` is the key that it belongs to, or its item."""
        if span.kind == "mapping" and not span.flow and within is None:
            raise RewriteError("the root is replaced")
        keyed = within is not None and within.key is not None
        if keyed and within is not None and wants_block(new) and self._own_line(within.start):
            # A mapping becomes the lines below its key.
            if self._multiline(within.after, span.start):
                self._delete_lines(span.start, span.end)
            else:
                blank = len(self.text[: span.start].rstrip(" \t"))
                self.put(max(blank, within.after), span.end, "")
            lines = block_lines(new, self._column(within.start) + INDENT)
            self._insert_lines(self._line_end(span.end), lines)
            return
        line = _quoted(new, span.quote)
        if keyed and within is not None and self._multiline(within.after, span.start):
            self.put(within.after, within.after, f" {line}")
            self._delete_lines(span.start, span.end)
        else:
            empty = within is not None and span.start == span.end == within.after
            colon = ":" if keyed and self.text[span.start - 1 : span.start] != ":" else ""
            self.put(span.start, span.end, f"{colon} {line}" if empty else line)

    def _mapping(
        self, span: Span, before: Items, after: Items, new: Data, within: EntrySpan | None
    ) -> None:
        kept = [key for key in after if key in before]
        if kept != [key for key in before if key in after] or not kept:
            self._reordered(span, after, new, within)
            return
        entries = {str(entry.key): entry for entry in span.entries}
        for key in kept:
            self.change(entries[str(key)].value, before[key], after[key], entries[str(key)])
        if list(after) == list(before):
            return
        if span.flow:
            names = list(map(str, after))
            added = [key for key in names if key not in before]
            made = {key: f"{as_scalar(key)}: {on_one_line(after[key])}" for key in added}
            self._flow(span, list(map(str, before)), names, made)
            return
        for key in before:
            if key not in after:
                self._delete_lines(entries[str(key)].start, entries[str(key)].value.end)
        self._insert_keys(span, entries, before, after)

    def _reordered(self, span: Span, after: Items, new: Data, within: EntrySpan | None) -> None:
        """Replace a mapping that shares no key with the new one, or has them in another order."""
        if span.flow:
            self._replace(span, new, within)
        elif within is None or not self._own_line(span.start):
            raise RewriteError("entries of the pack are put in another order")
        else:
            lines = block_lines(after, self._column(span.start))  # type: ignore[arg-type]
            self._insert_lines(self._line_start(span.start), lines)
            self._delete_lines(span.start, span.end)

    def _insert_keys(
        self, span: Span, entries: Mapping[str, EntrySpan], before: Items, after: Items
    ) -> None:
        """Insert the lines of new keys, each behind the key before it."""
        indent = self._column(span.entries[0].start)
        first = next(entries[str(key)] for key in after if key in before)
        if not self._own_line(first.start) and next(iter(after)) not in before:
            raise RewriteError("a key before one that does not start a line")
        at = self._line_start(first.start)
        model = first
        for key, value in after.items():
            if key in before:
                model = entries[str(key)]
                at = self._line_end(model.value.end)
                continue
            self._insert_lines(at, self._entry_lines(str(key), value, model, indent))

    def _entry_lines(self, key: str, value: Data, model: EntrySpan, indent: int) -> list[str]:
        """Return the lines of a new entry in the form of a neighbour."""
        near = model.value
        as_block = near.kind == "mapping" and not near.flow
        if isinstance(value, Mapping) and value and (as_block or wants_block(value)):
            lines = [f"{as_scalar(key)}:", *block_lines(value, INDENT)]
        else:
            column = self._column(near.start) - indent
            beside = not self._multiline(model.after, near.start)
            aligned = beside and near.kind != "scalar" and isinstance(value, (dict, tuple))
            width = column - 1 if aligned else 0
            lines = [f"{as_scalar(key) + ':':<{width}} {on_one_line(value)}"]
        return [" " * indent + line for line in lines]

    def _sequence(
        self, span: Span, before: list[Data], after: list[Data], new: Data, within: EntrySpan | None
    ) -> None:
        if len(before) == len(after):
            for entry, one, other in zip(span.entries, before, after, strict=True):
                self.change(entry.value, one, other, entry)
            return
        head = _common(before, after)
        room = min(len(before), len(after)) - head
        tail = min(_common(before[::-1], after[::-1]), room)
        last = len(before) - tail
        if span.flow:
            old = list(map(str, range(len(before))))
            made = {f"+{n}": on_one_line(after[n]) for n in range(head, len(after) - tail)}
            self._flow(span, old, [*old[:head], *made, *old[last:]], made)
            return
        if not head and not tail:
            self._replace(span, new, within)
            return
        for entry in span.entries[head:last]:
            self._delete_lines(entry.start, entry.value.end)
        indent = " " * self._column(span.start)
        lines = [f"{indent}- {on_one_line(one)}" for one in after[head : len(after) - tail]]
        if head:
            at = self._line_end(span.entries[head - 1].value.end)
        elif self._own_line(span.entries[last].start):
            at = self._line_start(span.entries[last].start)
        else:
            raise RewriteError("an item before one that does not start a line")
        self._insert_lines(at, lines)

    def _flow(self, span: Span, old: list[str], new: list[str], made: Mapping[str, str]) -> None:
        """Insert and delete entries of a collection in brackets, `made` being new ones."""
        entries = dict(zip(old, span.entries, strict=True))
        if self._multiline(span.start, span.end):
            self._spread(entries, new, made)
            return
        gap = ", "
        if len(old) > 1:
            gap = self.text[span.entries[0].value.end : span.entries[1].start]
        parts = [
            made[key] if key in made else self.applied(entries[key].start, entries[key].value.end)
            for key in new
        ]
        # The parts have the edits within them already.
        for entry in span.entries:
            self._drop(entry.start, entry.value.end)
        inside = (gap if gap.strip() == "," else ", ").join(parts)
        self.put(span.entries[0].start, span.entries[-1].value.end, inside)

    def _spread(
        self, entries: Mapping[str, EntrySpan], new: list[str], made: Mapping[str, str]
    ) -> None:
        """Insert and delete entries in brackets over several lines; a comma may end them.

        An entry goes with its comma, and with its line if nothing else is on it.
        """
        for entry in (entries[key] for key in entries if key not in new):
            start, end = entry.start, entry.value.end
            self._drop(start, end)
            rest = self.text[end:].lstrip(" \t")
            if rest.startswith(","):
                end = len(self.text) - len(rest[1:].lstrip(" \t"))
            if self._own_line(start) and not self._rest(end).strip():
                start, end = self._line_start(start), self._line_end(end)
            self.put(start, end, "")
        near = next((entries[key] for key in new if key in entries), None)
        if near is None:
            raise RewriteError("brackets over several lines lose every item")
        first = list(takewhile(lambda key: key in made, new))
        if first:
            self.put(near.start, near.start, "".join(f"{made[key]}, " for key in first))
        for key in new[len(first) :]:
            if key in entries:
                near = entries[key]
                continue
            # a comment behind the entry would swallow what follows on its line
            alone = self._own_line(near.start) and "#" not in self._rest(near.value.end)
            between = self.newline + " " * self._column(near.start) if alone else " "
            self.put(near.value.end, near.value.end, f",{between}{made[key]}")

    def _rest(self, at: int) -> str:
        """Return the rest of a line."""
        return self.text[at : self._line_end(at)]

    def _drop(self, start: int, end: int) -> None:
        self.found = [edit for edit in self.found if not (start <= edit[0] and edit[1] <= end)]

    def _line_start(self, at: int) -> int:
        return self.text.rfind("\n", 0, at) + 1

    def _line_end(self, at: int) -> int:
        found = self.text.find("\n", at)
        return len(self.text) if found < 0 else found + 1

    def _column(self, at: int) -> int:
        return at - self._line_start(at)

    def _own_line(self, at: int) -> bool:
        """Return True if only spaces precede a character in its line."""
        return not self.text[self._line_start(at) : at].strip()

    def _multiline(self, start: int, end: int) -> bool:
        return "\n" in self.text[start:end]

    def _insert_lines(self, at: int, lines: list[str]) -> None:
        new = "".join(f"{line}{self.newline}" for line in lines)
        if at == len(self.text) and self.text and not self.text.endswith("\n"):
            # A text without a line end at its end gets none.
            new = self.newline + new.removesuffix(self.newline)
        self.put(at, at, new)

    def _delete_lines(self, start: int, end: int) -> None:
        if not self._own_line(start):
            raise RewriteError("an entry that does not start a line is deleted")
        self.put(self._line_start(start), self._line_end(end), "")


def _items(span: Span, value: Data) -> Items | None:
    """Return the entries of a collection that the span shows entry by entry; None otherwise."""
    if span.kind == "mapping" and isinstance(value, dict):
        return value
    if span.kind == "sequence" and isinstance(value, tuple):
        return dict(enumerate(value))
    return None


def _common(one: list[Data], other: list[Data]) -> int:
    """Return the number of leading items that two lists share."""
    pairs = takewhile(lambda pair: same(*pair), zip(one, other, strict=False))
    return sum(1 for _ in pairs)


def _quoted(value: Data, quote: str) -> str:
    """Return a value on one line, text in the quotes that the old text had."""
    if isinstance(value, str) and quote == "'" and value.isprintable():
        return "'" + value.replace("'", "''") + "'"
    if isinstance(value, str) and quote == '"':
        return json.dumps(value, ensure_ascii=False)
    return on_one_line(value)
