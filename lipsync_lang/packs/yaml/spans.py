"""Find the characters of every value in a YAML text.

`building.scan` keeps where a value starts; a change in place needs to know where it ends as well.
Offsets count characters from 0; an end is exclusive.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Literal

from lipsync_lang.packs.yaml.events import Event, YamlError, events

_GAP = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_VALUE_EVENT = re.compile("(?:Scalar|Alias|(?:Mapping|Sequence)(?:Start|End))Event")


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
    """End of the colon or the dash; where a block's value has no character, one can be put here."""
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
            colon = self._skip(key.end_mark.index)
            if key.__class__.__name__ != "ScalarEvent" or self.text[colon : colon + 1] != ":":
                raise _unusual()
            value = self.value(next(self.events), colon + 1)
            span.entries.append(EntrySpan(key.value, key.start_mark.index, colon + 1, value))
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
