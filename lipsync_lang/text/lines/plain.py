"""Plain text, of which each row is a line, and subtitles, of which each cue is one."""

from collections.abc import Iterator
from html import unescape

from lipsync_lang.schedules.readers.subtitles import cues, joined, speaker_of
from lipsync_lang.text.lines.line_readers import Line, LineFile, reader


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
