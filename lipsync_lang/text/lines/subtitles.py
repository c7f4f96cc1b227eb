"""Subtitles: each cue is a line."""

from collections.abc import Iterator
from html import unescape

from lipsync_lang.schedules.readers.subtitles import cues, joined, speaker_of
from lipsync_lang.text.lines.line_readers import Line, LineFile, reader


@reader("subtitles", suffixes=[".srt", ".vtt"])
def read(source: LineFile) -> Iterator[Line]:
    """Subtitles, SubRip and WebVTT: a cue is a line, its rows joined."""
    found = False
    for rows, name, _ in cues(source.numbered()):
        found = True
        if rows:
            whole = joined(rows)
            speaker = speaker_of(rows)
            yield source.line(rows[0][0], unescape(whole), name=name, speaker=speaker)
    if not found:
        what = "has no times (00:00:01,000 --> 00:00:02,500); check that it is a subtitle file"
        raise source.fault(1, what)
