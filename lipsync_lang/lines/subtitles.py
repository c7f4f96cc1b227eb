"""Subtitles: a cue is a line."""

import re
from collections.abc import Iterator
from html import unescape

from lipsync_lang.lines.line import Line
from lipsync_lang.lines.line_readers import LineFile, reader

TIMES = re.compile(r"\s*(?:\d+:)?\d\d?:\d\d[.,]\d+\s*-->\s*(?:\d+:)?\d\d?:\d\d[.,]\d+")
VOICE = re.compile(r"<v(?:\.[^\s<>]*+)?\s++([^<>]++)>")
ASIDE = re.compile(r"(WEBVTT|NOTE|STYLE|REGION)\b")

Part = list[tuple[int, str]]


@reader("subtitles", suffixes=[".srt", ".vtt"])
def read(source: LineFile) -> Iterator[Line]:
    """Subtitles, SubRip and WebVTT: a cue is a line, its rows joined."""
    found = False
    for part in _parts(source):
        at = next((i for i, (_, text) in enumerate(part) if TIMES.match(text)), None)
        if at is None and (not found or ASIDE.match(part[0][1])):
            continue
        found = True
        rows = part if at is None else part[at + 1 :]
        name = part[at - 1][1].strip() if at else ""
        if rows:
            yield _line(source, rows, name)
    if not found:
        raise source.fault(1, "has no times (00:00:01,000 --> 00:00:02,500); is it a subtitle?")


def _parts(source: LineFile) -> Iterator[Part]:
    """Yield groups of lines, separated by empty lines."""
    part: Part = []
    for number, text in source.numbered():
        if text.strip():
            part.append((number, text))
        elif part:
            yield part
            part = []
    if part:
        yield part


def _line(source: LineFile, rows: Part, name: str) -> Line:
    whole = " ".join(re.sub(r"^\s*[-–]\s*", "", text) for _, text in rows)
    voice = VOICE.search(whole)
    speaker = voice[1].strip() if voice else ""
    return source.line(rows[0][0], unescape(whole), name=name, speaker=speaker)
