"""Timed phonemes: each file is one line with its schedule."""

from collections.abc import Iterator

from lipsync_lang.lines.line import Line
from lipsync_lang.lines.line_readers import LineFile, reader
from lipsync_lang.schedules.timing_file import HEAD_BYTES, TimingFile, read_timings
from lipsync_lang.schedules.timing_readers import READERS, schedule_of

NAME = "schedule"


def is_timed(source: LineFile) -> bool:
    """Tell whether a file begins like a format of timed phonemes that has its suffix."""
    try:
        with source.open() as stream:
            begins = TimingFile(source.path, stream.read(HEAD_BYTES))
    except OSError:
        return False
    return any(one.sniff(begins) for one in READERS.ending(source.path))


@reader(NAME, suffixes=READERS.suffixes())
def read(source: LineFile) -> Iterator[Line]:
    """Timed phonemes, in every format that schedules are read from; a file is a line."""
    content = read_timings(source.path) if source.content is None else source.content
    schedule = schedule_of(TimingFile(source.path, content, encoding=source.encoding))
    for remark in schedule.remarks:
        source.remark(remark)
    text = " ".join(word.text for word in schedule.words)
    yield Line(text, f"{source.path}:1", source.path.stem, schedule=schedule)
