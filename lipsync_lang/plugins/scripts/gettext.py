"""Translations of gettext: each entry and each of its plural forms is a line.

The lines of a template are its originals. Fuzzy entries count as not translated, and obsolete ones
are left out. A comment may name the speaker: ``#. Speaker: Bob``, ``#. [message]: speaker=Bob``.
"""

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import chain

from lipsync_lang.text.lines.entries import ScriptEntry, entry_lines
from lipsync_lang.text.lines.line_readers import Line, LineFile, reader

ENTRY_LINE = re.compile(r'\s*(?:(msgctxt|msgid_plural|msgid|msgstr)(?:\[(\d+)\])?\s*)?"(.*)"\s*$')
ESCAPED_CHARACTER = re.compile(r"\\(.)", re.DOTALL)
ESCAPES = {"n": "\n", "t": "\t", "r": "\r", "a": "", "b": "", "f": "", "v": ""}
COMMENT = re.compile(r"#\.?\s+(.*)")
CHARSET = re.compile(rb"charset=([\w.:-]+)", re.ASCII)


@dataclass
class Entry:
    """An entry: its texts by key (`msgstr 1` is a plural form), and their lines."""

    texts: dict[str, str] = field(default_factory=dict)
    places: dict[str, int] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    fuzzy: bool = False

    def forms(self) -> Iterator[ScriptEntry]:
        """Yield each translation, or each original if there is none."""
        done = [k for k, text in self.texts.items() if k.startswith("msgstr") and text.strip()]
        for key in done or [k for k in self.texts if k.startswith("msgid")]:
            said, original = (key, "msgid") if done else ("", key)
            yield ScriptEntry(
                self.places[key],
                self.texts.get("msgctxt", ""),
                self.texts.get(said, ""),
                self.texts[original],
                notes=tuple(self.notes),
                ready=not self.fuzzy,
            )


@reader("gettext", suffixes=[".po", ".pot"])
def read(source: LineFile) -> Iterator[Line]:
    """Translations of gettext; untranslated entries give their originals."""
    if not source.encoding:
        # A file that cannot be opened is reported below, in the words of all readers.
        with suppress(OSError), source.open() as stream:
            found = CHARSET.search(stream.read(4096))
            name = found[1].decode().lower() if found else "charset"
            # A template states the word "CHARSET"; UTF-8 unasked may begin with its mark.
            if name not in ("charset", "utf-8", "utf8"):
                source = replace(source, encoding=name)
    used = (entry.forms() for entry in _entries(source) if entry.texts.get("msgid"))
    return entry_lines(source, chain.from_iterable(used))


def _entries(source: LineFile) -> Iterator[Entry]:
    entry, key = Entry(), ""
    for number, text in source.numbered():
        if text.lstrip().startswith("#") or not text.strip():
            if entry.texts.keys() - {"msgctxt"}:
                yield entry
                entry, key = Entry(), ""
            if text.startswith("#~"):  # comments of an obsolete entry
                entry = Entry()
            entry.fuzzy |= text.startswith("#,") and "fuzzy" in text
            if told := COMMENT.match(text):
                entry.notes.append(told[1])
            continue
        found = ENTRY_LINE.match(text)
        if found is None or not (found[1] or key):
            raise source.fault(number, f'not gettext: {text.strip()[:40]}; write msgid "..."')
        if found[1] in ("msgctxt", "msgid") and "msgid" in entry.texts:
            yield entry
            entry = Entry()
        if found[1]:
            key = f"{found[1]} {found[2] or ''}".rstrip()
            entry.places[key] = number
        more = ESCAPED_CHARACTER.sub(lambda one: ESCAPES.get(one[1], one[1]), found[3])
        entry.texts[key] = entry.texts.get(key, "") + more
    if entry.texts.keys() - {"msgctxt"}:
        yield entry
