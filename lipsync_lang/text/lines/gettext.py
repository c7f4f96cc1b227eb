"""Translations of gettext: each entry and each of its plural forms is a line.

If a file has any translation, its lines are the translations, and a remark counts the entries left
out. The lines of a template are its originals. Fuzzy and obsolete entries are left out. A comment
may name the speaker, as in ``#. Speaker: Bob`` and ``#. [message]: speaker=Bob``.
"""

import re
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace

from lipsync_lang.text.lines.columns import SPEAKER_COLUMNS
from lipsync_lang.text.lines.line_readers import Line, LineFile, reader

ENTRY_LINE = re.compile(r'\s*(?:(msgctxt|msgid_plural|msgid|msgstr)(?:\[(\d+)\])?\s*)?"(.*)"\s*$')
ESCAPED_CHARACTER = re.compile(r"\\(.)", re.DOTALL)
ESCAPES = {"n": "\n", "t": "\t", "r": "\r", "a": "", "b": "", "f": "", "v": ""}
COMMENT = re.compile(r"#\.?\s+(.*)")
MAX_COMMENT_CHARS = 200
"""Length within which a comment names its speaker."""

CHARSET = re.compile(rb"charset=([\w.:-]+)", re.ASCII)


@dataclass
class Entry:
    """An entry: its texts by key (`msgstr 1` is a plural form), and their lines."""

    texts: dict[str, str] = field(default_factory=dict)
    places: dict[str, int] = field(default_factory=dict)
    fuzzy: bool = False
    speaker: str = ""

    def forms(self, kind: str) -> list[tuple[int, str]]:
        """Return (line, text) of each form of the original (`msgid`) or translation (`msgstr`)."""
        found = [(key, text) for key, text in self.texts.items() if key.startswith(kind)]
        return [(self.places[key], text) for key, text in found if text.strip()]


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
    # A first pass, up to the first translation, tells whether the file has any.
    sound = (one for one in _entries(source) if one.texts.get("msgid") and not one.fuzzy)
    kind = "msgstr" if any(entry.forms("msgstr") for entry in sound) else "msgid"
    left, named = 0, source.speaker is None or source.speaker.isdecimal()
    for entry in _entries(source):
        named |= bool(entry.speaker)
        if entry.fuzzy or not entry.texts.get("msgid"):
            left += entry.fuzzy and bool(entry.texts.get("msgid"))
            continue
        texts = entry.forms(kind)
        left += not texts
        for number, text in texts:
            name, original = entry.texts.get("msgctxt", ""), entry.texts["msgid"]
            yield source.line(number, text, name=name, speaker=entry.speaker, original=original)
    if not named:
        source.remark(f"{source.path}: no comment has a speaker of the form '{source.speaker}'")
    if left:
        source.remark(f"{source.path}: left out {left} entries that are fuzzy or not translated")


def _entries(source: LineFile) -> Iterator[Entry]:
    entry, key, speaks = Entry(), "", speaker_pattern(source.speaker)
    for number, text in source.numbered():
        if text.lstrip().startswith("#") or not text.strip():
            if entry.texts.keys() - {"msgctxt"}:
                yield entry
                entry, key = Entry(), ""
            if text.startswith("#~"):  # comments of an obsolete entry
                entry = Entry()
            entry.fuzzy |= text.startswith("#,") and "fuzzy" in text
            told = COMMENT.match(text)
            if told and not entry.speaker and (found := speaks.search(told[1][:MAX_COMMENT_CHARS])):
                entry.speaker = found["speaker"].strip()
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


def speaker_pattern(asked: str | None) -> re.Pattern[str]:
    """Return the pattern of a speaker in comments, from the stated word or text around the name."""
    if asked and "{speaker}" in asked:
        around = [r"\s+".join(map(re.escape, part.split())) for part in asked.split("{speaker}", 1)]
        return re.compile(rf"{around[0]}\s*(?P<speaker>\S.*?)\s*{around[1] or '$'}", re.IGNORECASE)
    words = SPEAKER_COLUMNS if asked is None or asked.isdecimal() else (asked,)
    word = rf"(?:{'|'.join(map(re.escape, words))})"
    return re.compile(
        rf"(?:^{word}|\"{word}\"|(?<!\S){word}(?==))\s*[:：=]\s*\"?(?P<speaker>[^\"=,;(（]+)",
        re.IGNORECASE,
    )
