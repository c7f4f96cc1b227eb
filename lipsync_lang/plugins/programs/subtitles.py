"""Subtitles: one cue per word, from the start of its first phoneme to the end of its last.

SubRip (.srt) has no specification: cues are numbered, times are `HH:MM:SS,mmm`, and text is not
escaped. In WebVTT (.vtt, www.w3.org/TR/webvtt1), times are `HH:MM:SS.mmm`, and `&`, `<` and `>` are
escaped. Speech before time 0 is cut.
"""

from collections.abc import Iterator
from html import escape
from typing import TextIO

from lipsync_lang import OutputError
from lipsync_lang.animations.writers import Animation, writer

ARROW = "-->"
"""Separator between the two times of a cue; not allowed within its text."""


@writer("srt", suffix=".srt")
def write_srt(animation: Animation, out: TextIO) -> None:
    """Subtitles for video players: each word while it is spoken."""
    for number, (start, end, text) in enumerate(_cues(animation), 1):
        span = f"{_clock(start, ',')} {ARROW} {_clock(end, ',')}"
        out.write(f"{number}\n{span}\n{text.replace(ARROW, '→')}\n\n")


@writer("vtt", suffix=".vtt")
def write_vtt(animation: Animation, out: TextIO) -> None:
    """Subtitles for web pages: each word while it is spoken."""
    out.write("WEBVTT\n")
    for start, end, text in _cues(animation):
        span = f"{_clock(start, '.')} {ARROW} {_clock(end, '.')}"
        out.write(f"\n{span}\n{escape(text, quote=False)}\n")


def _cues(animation: Animation) -> Iterator[tuple[int, int, str]]:
    """Yield start and end in milliseconds, at least 1 ms apart, and text of each word's cue."""
    schedule = animation.schedule
    if not schedule.words:
        what = f"there are no words to write: {schedule.source} has only phonemes"
        raise OutputError(f"{what}; speak text, or give a schedule with a tier of words")
    for word in schedule.words:
        ends = schedule.times[[word.first, word.stop]] + animation.offset
        start, end = (max(0, round(1000 * seconds)) for seconds in ends.tolist())
        text = " ".join(word.text.split())
        if end > 0 and text:
            yield start, max(end, start + 1), text


def _clock(milliseconds: int, point: str) -> str:
    seconds, rest = divmod(milliseconds, 1000)
    hours, minutes = seconds // 3600, seconds // 60 % 60
    return f"{hours:02d}:{minutes:02d}:{seconds % 60:02d}{point}{rest:03d}"
