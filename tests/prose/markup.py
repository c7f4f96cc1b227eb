"""Texts of HTML pages and templates: the visible words, and those of attributes."""

import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path

from prose.texts import PLACEHOLDER, Sentence, blank, is_prose, mark, split

_VALUE = re.compile(r"\{\{.*?\}\}", re.DOTALL)
_BRANCH = re.compile(r"\{%-? *(?:else|elif)\b.*?%\}")
_STATEMENT = re.compile(r"\{%.*?%\}|\{#.*?#\}", re.DOTALL)
_STRING = re.compile(r"\"([^\"\n]*)\"")
_INLINE = {"a", "abbr", "b", "bdi", "em", "i", "mark", "small", "span", "strong", "sub", "sup"}
_CODE = {"code", "kbd", "samp", "var"}
_UNSEEN = {"script", "style", "template"}
_SPOKEN = {"title", "aria-label", "placeholder", "alt"}
"""Attributes that hold words."""


def sentences_of_markup(path: Path) -> Iterator[Sentence]:
    """Read the visible texts of a page; values of templates are placeholders."""
    source = path.read_text(encoding="utf-8")
    reader = _Reader()
    reader.feed(_STATEMENT.sub(blank, _BRANCH.sub(". ", _VALUE.sub(mark, source))))
    reader.close()
    reader.flush()
    for line, text in [*reader.found, *_strings(source)]:
        yield from split(path, line, text, running=text.rstrip().endswith("."))


def _strings(source: str) -> Iterator[tuple[int, str]]:
    """Find texts of two words or more in the values and statements of a template."""
    for code in (*_VALUE.finditer(source), *_STATEMENT.finditer(source)):
        for string in _STRING.finditer(code[0]):
            if is_prose(string[1]):
                yield source.count("\n", 0, code.start() + string.start()) + 1, string[1]


class _Reader(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[int, str]] = []
        self._held = ""
        self._line = 1
        self._inside: list[str] = []

    def flush(self) -> None:
        """End the text of a block."""
        if self._held.strip(f"{PLACEHOLDER} \n"):
            self.found.append((self._line, self._held))
        self._held = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in _SPOKEN and value and " " in value:
                self.found.append((self.getpos()[0], value))
        if tag in _CODE | _UNSEEN:
            self._inside.append(tag)
        elif tag not in _INLINE:
            self.flush()

    def handle_endtag(self, tag: str) -> None:
        if self._inside and tag == self._inside[-1]:
            self._inside.pop()
            self._held += PLACEHOLDER * (tag in _CODE)
        elif tag not in _INLINE:
            self.flush()

    def handle_data(self, data: str) -> None:
        if self._inside:
            return
        if not self._held.strip():
            self._line = self.getpos()[0]
            self._held = ""
        self._held += data
