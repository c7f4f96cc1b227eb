"""Timed phonemes: a file is a line, and its phonemes come as they are."""

from collections.abc import Iterator

from lipsync_lang.lines.line import Line
from lipsync_lang.lines.registry import Source, reader
from lipsync_lang.schedules.registry import load_readers, read_schedule

NAME = "schedule"


def suffixes() -> list[str]:
    """Return the suffixes of every format that holds timed phonemes."""
    return sorted({suffix for one in load_readers().values() for suffix in one.suffixes})


@reader(NAME, suffixes=suffixes())
def read(source: Source) -> Iterator[Line]:
    """Timed phonemes, in every format that schedules are read from; a file is a line."""
    schedule = read_schedule(source.path)
    text = " ".join(word.text for word in schedule.words)
    yield Line(text, f"{source.path}:1", source.path.stem, schedule=schedule)
