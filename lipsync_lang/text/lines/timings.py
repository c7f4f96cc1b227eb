"""Timings: each file is one line, with its schedule if its phonemes are timed."""

from collections.abc import Iterator

from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.timing_file import TimingFile, timing_bytes
from lipsync_lang.schedules.timing_readers import TIMING_READERS, timings_of
from lipsync_lang.text.lines.line_readers import SCHEDULE_FORMAT, Line, LineFile, reader

TIMING_SUFFIXES = tuple(
    sorted({s for one in TIMING_READERS.values() if not one.script for s in one.suffixes})
)
"""Suffixes of timings that are not read as scripts."""


@reader(SCHEDULE_FORMAT, suffixes=TIMING_SUFFIXES)
def read(source: LineFile) -> Iterator[Line]:
    """Timings of phonemes or words, in every format that is read: a file is one line."""
    content = timing_bytes(source.path) if source.content is None else source.content
    found = timings_of(TimingFile(source.path, content, encoding=source.encoding))
    for remark in found.remarks:
        source.remark(remark)
    schedule = found if isinstance(found, Schedule) else None
    text = " ".join(word.text for word in found.words)
    yield Line(text, f"{source.path}:1", source.path.stem, schedule=schedule)
