"""Fluent: a message for each name, its attributes, and each variant of a selector.

Terms, such as ``-brand``, are said where a message names them. Comments may name the speaker.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field

from lipsync_lang.text.lines.choices import chosen
from lipsync_lang.text.lines.entries import ScriptEntry, entry_lines
from lipsync_lang.text.lines.line_readers import Line, LineFile, reader

FLUENT_START = re.compile(r"(-?[A-Za-z][\w-]*)\s*=\s*(.*)")
FLUENT_ATTRIBUTE = re.compile(r"\s+\.([A-Za-z][\w-]*)\s*=\s*(.*)")
FLUENT_COMMENT = re.compile(r"#{1,3}(?:\s(.*))?")
FLUENT_TERM = re.compile(r"\{\s*(-[A-Za-z][\w-]*)\s*(\([^(){}]*\))?\s*\}")
FLUENT_ARGUMENT = re.compile(r"([\w-]+)\s*:\s*\"?([^\",()]*)\"?")
CONTINUED = re.compile(r"[ \t]+\S|[ \t]*\}")
MAX_TERM_DEPTH = 4
"""Maximum depth of terms within terms."""


@dataclass
class _Message:
    """A message, a term or an attribute, whose rows are read one by one."""

    line: int
    name: str
    rows: list[str]
    notes: list[str] = field(default_factory=list)


@reader("fluent", suffixes=[".ftl"])
def read(source: LineFile) -> Iterator[Line]:
    """Fluent's .ftl: messages and attributes, with each variant of a selector."""
    messages = list(_messages(source))
    terms = {one.name: " ".join(one.rows) for one in messages if one.name.startswith("-")}
    found = (
        ScriptEntry(
            one.line, one.name, _with_terms(" ".join(one.rows), terms), notes=tuple(one.notes)
        )
        for one in messages
        if not one.name.startswith("-") and any(map(str.strip, one.rows))
    )
    return entry_lines(source, found)


def _messages(source: LineFile) -> Iterator[_Message]:
    message, whole = None, ""
    notes: list[str] = []
    for number, row in source.numbered():
        comment = FLUENT_COMMENT.fullmatch(row)
        attribute = FLUENT_ATTRIBUTE.fullmatch(row) if message else None
        start = FLUENT_START.fullmatch(row)
        if comment:
            notes.append(comment[1] or "")
        elif attribute or start:
            if message:
                yield message
            name, text = (attribute or start or row)[1], (attribute or start or row)[2]
            whole = whole if attribute else name
            # A comment is about the attributes of its message, too.
            about = message.notes if attribute and message else notes
            message = _Message(number, f"{whole}.{name}" if attribute else name, [text], about)
            notes = []
        elif message and CONTINUED.match(row):
            message.rows.append(row.strip())
        elif row.strip():
            what = f"not Fluent: {row.strip()[:40]}; write `name = text`, and indent its rows"
            raise source.fault(number, what)
    if message:
        yield message


def _with_terms(text: str, terms: dict[str, str]) -> str:
    """Return a text with the terms that it names, each in the form that its arguments select."""

    def term(found: re.Match[str]) -> str:
        arguments = dict(FLUENT_ARGUMENT.findall(found[2] or ""))
        return chosen(terms.get(found[1], found[0]), arguments)

    for _ in range(MAX_TERM_DEPTH):
        text, count = FLUENT_TERM.subn(term, text)
        if not count:
            break
    return text
