"""Find the characters of every value in a YAML text.

`source.scan` keeps where a value starts; a change in place needs to know where it ends as well.
Offsets count characters from 0; an end is exclusive.
"""

import re
from dataclasses import dataclass, field
from typing import Literal

from lipsync_lang.packs.yaml.events import Event, YamlError, parsers

_GAP = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")


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

    Raises
    ------
    YamlError
        No parser reads the text, or it is written in a form that packs do not use.
    """
    problem = YamlError(None, "no value", "", None)
    for parse in parsers(text):
        try:
            return _Walk(text).root(list(parse(text)))
        except YamlError as error:
            problem = error
    raise problem


class _Walk:
    """Turns the events of one text into spans."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.events: list[Event] = []
        self.next = 0

    def root(self, events: list[Event]) -> Span:
        """Return the span of the first document's value."""
        starts = ("Scalar", "Alias", "MappingStart", "SequenceStart")
        wanted = tuple(f"{name}Event" for name in (*starts, "MappingEnd", "SequenceEnd"))
        self.events = [event for event in events if event.__class__.__name__ in wanted]
        if not self.events:
            raise self._unusual()
        return self._value()

    def _value(self, after: int = 0) -> Span:
        """Return the span of the next value; `after` is where an empty one stands."""
        event = self.events[self.next]
        self.next += 1
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
        if name == "MappingStartEvent":
            span = Span("mapping", start, end, bool(event.flow_style))
            self._mapping(span)
        else:
            span = Span("sequence", start, end, bool(event.flow_style))
            self._sequence(span)
        last = self.events[self.next].end_mark.index
        self.next += 1
        span.end = last if span.flow or not span.entries else span.entries[-1].value.end
        return span

    def _mapping(self, span: Span) -> None:
        while self.events[self.next].__class__.__name__ != "MappingEndEvent":
            key = self.events[self.next]
            if key.__class__.__name__ != "ScalarEvent":
                raise self._unusual()
            self.next += 1
            colon = self._skip(key.end_mark.index)
            if self.text[colon : colon + 1] != ":":
                raise self._unusual()
            start = key.start_mark.index
            span.entries.append(EntrySpan(key.value, start, colon + 1, self._value(colon + 1)))

    def _sequence(self, span: Span) -> None:
        at = span.start
        while self.events[self.next].__class__.__name__ != "SequenceEndEvent":
            if span.flow:
                value = self._value(self.events[self.next].start_mark.index)
                span.entries.append(EntrySpan(None, value.start, value.start, value))
                continue
            dash = self._skip(at)
            if self.text[dash : dash + 1] != "-":
                raise self._unusual()
            value = self._value(dash + 1)
            span.entries.append(EntrySpan(None, dash, dash + 1, value))
            at = value.end

    def _skip(self, at: int) -> int:
        """Return the offset of the next character that is neither space nor comment."""
        found = _GAP.match(self.text, at)
        return at if found is None else found.end()

    @staticmethod
    def _unusual() -> YamlError:
        return YamlError(None, "a form that packs do not use", "", None)
