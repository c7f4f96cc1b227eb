"""Timed phonemes: a file is a line, and its phonemes come as they are."""

from collections.abc import Iterator
from pathlib import Path

from lipsync_lang.lines.line import Line
from lipsync_lang.lines.registry import Source, reader
from lipsync_lang.schedules.registry import load_readers, read_schedule
from lipsync_lang.schedules.timing_file import HEAD
from lipsync_lang.schedules.timing_file import Source as Timings

NAME = "schedule"


def suffixes() -> list[str]:
    """Return the suffixes of every format that holds timed phonemes."""
    return sorted({suffix for one in load_readers().values() for suffix in one.suffixes})


def is_timed(path: Path) -> bool:
    """Tell whether a file begins like a format of timed phonemes that has its suffix."""
    readers = [one for one in load_readers().values() if path.suffix.lower() in one.suffixes]
    try:
        with path.open("rb") as stream:
            begins = Timings(path, stream.read(HEAD))
    except OSError:
        return False
    return any(one.looks(begins) for one in readers)


@reader(NAME, suffixes=suffixes())
def read(source: Source) -> Iterator[Line]:
    """Timed phonemes, in every format that schedules are read from; a file is a line."""
    schedule = read_schedule(source.path, encoding=source.encoding)
    for remark in schedule.remarks:
        source.remark(remark)
    text = " ".join(word.text for word in schedule.words)
    yield Line(text, f"{source.path}:1", source.path.stem, schedule=schedule)
