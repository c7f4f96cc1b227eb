"""Timings: each file is one line, with its schedule if its phonemes are timed."""

from collections.abc import Iterator

from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.timing_file import HEAD_BYTES, TimingFile, timing_bytes
from lipsync_lang.schedules.timing_readers import TIMING_READERS, timings_of
from lipsync_lang.text.lines.line import Line
from lipsync_lang.text.lines.line_readers import LineFile, reader

SCHEDULE_FORMAT = "schedule"

TIMING_SUFFIXES = tuple(
    sorted({s for one in TIMING_READERS.values() if not one.script for s in one.suffixes})
)
"""Suffixes of timings that are not read as scripts."""


def is_timed(source: LineFile) -> bool:
    """Test whether a file begins like a format of timed phonemes with its suffix."""
    kinds = [one for one in TIMING_READERS.ending(source.path) if not one.script]
    if not kinds:
        return False
    try:
        with source.open() as stream:
            begins = TimingFile(source.path, stream.read(HEAD_BYTES))
    except OSError:
        return False
    return any(one.sniff(begins) for one in kinds)


@reader(SCHEDULE_FORMAT, suffixes=TIMING_SUFFIXES)
def read(source: LineFile) -> Iterator[Line]:
    """Timed phonemes or words, in every readable format of timings; a file is a line."""
    content = timing_bytes(source.path) if source.content is None else source.content
    found = timings_of(TimingFile(source.path, content, encoding=source.encoding))
    for remark in found.remarks:
        source.remark(remark)
    schedule = found if isinstance(found, Schedule) else None
    text = " ".join(word.text for word in found.words)
    yield Line(text, f"{source.path}:1", source.path.stem, schedule=schedule)
