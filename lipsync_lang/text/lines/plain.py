"""Plain text, of which each row is a line; cues of subtitles; Java's properties; timings."""

import re
from collections.abc import Iterator
from html import unescape
from itertools import chain

from lipsync_lang.schedules.readers.subtitles import cues, joined, speaker_of
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.timing_file import TimingFile, timing_bytes
from lipsync_lang.schedules.timing_readers import TIMING_READERS, timings_of
from lipsync_lang.text.lines.line_readers import SCHEDULE_FORMAT, Line, LineFile, reader

TIMING_SUFFIXES = tuple(
    sorted({s for one in TIMING_READERS.values() if not one.script for s in one.suffixes})
)
"""Suffixes of timings that are not read as scripts."""

PROPERTY = re.compile(r"\s*((?:\\.|[^\s:=\\])+)\s*[:=\s]\s*(.*)", re.DOTALL)
PROPERTY_ESCAPE = re.compile(r"\\(?:u([0-9A-Fa-f]{4})|([:=#! \\]))")


@reader("text", suffixes=[".txt"])
def read_text(source: LineFile) -> Iterator[Line]:
    """Plain text: each row is a line; empty rows are skipped."""
    for number, text in source.numbered():
        if text.strip():
            yield source.line(number, text)


@reader("subtitles", suffixes=[".srt", ".vtt"])
def read_subtitles(source: LineFile) -> Iterator[Line]:
    """Subtitles, SubRip and WebVTT: a cue is a line, its rows joined."""
    found = False
    for rows, name, _ in cues(source.numbered()):
        found = True
        if rows:
            said, speaker = unescape(joined(rows)), speaker_of(rows)
            yield source.line(rows[0][0], said, name=name, speaker=speaker)
    if not found:
        what = "has no times (00:00:01,000 --> 00:00:02,500); check that it is a subtitle file"
        raise source.fault(1, what)


@reader("properties", suffixes=[".properties"])
def read_properties(source: LineFile) -> Iterator[Line]:
    """Java's .properties: `name = text`; a backslash at the end continues a text."""
    begun, first = "", 0
    # An empty row at the end closes a text that the last row would continue.
    for number, row in chain(source.numbered(), [(0, "")]):
        if not begun and (not row.strip() or row.lstrip()[0] in "#!"):
            continue
        first = first if begun else number
        begun += row.strip() if begun else row
        # Two backslashes are one that is text.
        if (len(begun) - len(begun.rstrip("\\"))) % 2:
            begun = begun[:-1]
            continue
        found, begun = PROPERTY.fullmatch(begun), ""
        if found and found[2].strip():
            yield source.line(first, PROPERTY_ESCAPE.sub(unescaped, found[2]), name=found[1])


def unescaped(found: re.Match[str]) -> str:
    """Return the character that an escape stands for."""
    return chr(int(found[1], 16)) if found[1] else found[2]


@reader(SCHEDULE_FORMAT, suffixes=TIMING_SUFFIXES)
def read_timings(source: LineFile) -> Iterator[Line]:
    """Timings of phonemes or words, in every format that is read: a file is one line."""
    content = timing_bytes(source.path) if source.content is None else source.content
    found = timings_of(TimingFile(source.path, content, encoding=source.encoding))
    for remark in found.remarks:
        source.remark(remark)
    schedule = found if isinstance(found, Schedule) else None
    text = " ".join(word.text for word in found.words)
    yield Line(text, f"{source.path}:1", source.path.stem, schedule=schedule)
