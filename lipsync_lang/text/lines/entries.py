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
from lipsync_lang.text.lines.columns import SPEAKER_COLUMNS
from lipsync_lang.text.lines.line_readers import Line, LineFile

MAX_COMMENT_CHARS = 200
"""Length within which a comment names its speaker."""

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
    asked = source.speaker
    if asked and asked.isdecimal():  # the column of a table
        asked = None
    speaks, left, commented, named = _speaker_pattern(asked), 0, False, False
    for one in given:
        text = one.text if translated else one.original or one.text
        if not text.strip() or (translated and not one.ready):
            left += 1
            continue
        speaker = one.speaker or (_named(one.notes, speaks) if one.notes else "")
        commented, named = commented or bool(one.notes), named or bool(speaker)
        for form, said in every_form(text, source.cleaning.values):
            name = f"{one.name}-{form}" if one.name and form else one.name
            yield source.line(one.number, said, name=name, speaker=speaker, original=one.original)
    if asked and commented and not named:
        source.remark(f"{source.path}: no comment has a speaker of the form '{asked}'")
    if left:
        what = count(left, "empty or untranslated entry", "empty or untranslated entries")
        source.remark(f"{source.path}: left out {what}")


def _named(notes: Iterable[str], speaks: re.Pattern[str]) -> str:
    """Return the speaker that the first note with one names."""
    rows = (row[:MAX_COMMENT_CHARS] for note in notes for row in note.split("\n"))
    found = next(filter(None, map(speaks.search, rows)), None)
    return found["speaker"].strip() if found else ""


def _speaker_pattern(asked: str | None) -> re.Pattern[str]:
    """Return the pattern of a speaker in comments, from the stated word or text around the name."""
    if asked and "{speaker}" in asked:
        around = [r"\s+".join(map(re.escape, part.split())) for part in asked.split("{speaker}", 1)]
        return re.compile(rf"{around[0]}\s*(?P<speaker>\S.*?)\s*{around[1] or '$'}", re.IGNORECASE)
    word = rf"(?:{'|'.join(map(re.escape, (asked,) if asked else SPEAKER_COLUMNS))})"
    return re.compile(
        rf"(?:^{word}|\"{word}\"|(?<!\S){word}(?==))\s*[:：=]\s*\"?(?P<speaker>[^\"=,;(（]+)",
        re.IGNORECASE,
    )


def whole_file(source: LineFile) -> TimingFile:
    """Return a file that is read as a whole, up to the size limit of timings."""
    content = timing_bytes(source.path) if source.content is None else source.content
    if not content.strip():
        raise source.fault(1, "has no content; export it again")
    return TimingFile(source.path, content, encoding=source.encoding)
