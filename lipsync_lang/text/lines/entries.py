"""Entries of files for translation: each form of an entry is a line.

If any entry of a file has a translation, the lines are the translations, and a remark counts the
entries left out; else they are the originals. A note may name the speaker, as in ``Speaker: Bob``.
"""

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from lipsync_lang.base.errors import count
from lipsync_lang.schedules.timing_file import TimingFile, timing_bytes
from lipsync_lang.text.lines.choices import every_form
from lipsync_lang.text.lines.gettext import MAX_COMMENT_CHARS, speaker_pattern
from lipsync_lang.text.lines.line_readers import Line, LineFile

MAX_ENTRY_DEPTH = 64
"""Maximum depth of lists, objects and elements in a file."""


class ScriptEntry(NamedTuple):
    """An entry: its place, its name, and its texts as they are written."""

    number: int
    name: str
    text: str
    original: str = ""
    speaker: str = ""
    notes: tuple[str, ...] = ()
    ready: bool = True
    """False if the translation is not done."""


def entry_lines(source: LineFile, entries: Iterable[ScriptEntry]) -> Iterator[Line]:
    """Yield the lines of the entries of a file."""
    given = list(entries)
    translated = any(one.ready and one.text.strip() for one in given)
    speaks = speaker_pattern(source.speaker)
    left = 0
    for one in given:
        text = one.text if translated else one.original or one.text
        if not text.strip() or (translated and not one.ready):
            left += 1
            continue
        speaker = one.speaker or (_named(one.notes, speaks) if one.notes else "")
        for form, said in every_form(text, source.cleaning.values):
            name = f"{one.name}-{form}" if one.name and form else one.name
            yield source.line(one.number, said, name=name, speaker=speaker, original=one.original)
    if left:
        what = count(left, "empty or untranslated entry", "empty or untranslated entries")
        source.remark(f"{source.path}: left out {what}")


def _named(notes: Iterable[str], speaks: re.Pattern[str]) -> str:
    """Return the speaker that the first note with one names."""
    rows = (row[:MAX_COMMENT_CHARS] for note in notes for row in note.split("\n"))
    found = next(filter(None, map(speaks.search, rows)), None)
    return found["speaker"].strip() if found else ""


def whole_file(source: LineFile) -> TimingFile:
    """Return a file that is read as a whole, up to the size limit of timings."""
    content = timing_bytes(source.path) if source.content is None else source.content
    if not content.strip():
        raise source.fault(1, "has no content; export it again")
    return TimingFile(source.path, content, encoding=source.encoding)
