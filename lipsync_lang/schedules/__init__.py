"""Schedules: timed phonemes, read from the files of many programs.

Times are seconds. A schedule is contiguous: phoneme i lasts from ``times[i]`` to
``times[i + 1]``. Silence is a phoneme like any other, written `SILENCE`. Labels are kept as
the file or the engine wrote them; a language pack turns them into common phonemes.

One file per input format; `reader` is all that makes a format known.
"""

from lipsync_lang.schedules.schedule import SILENCE, Audio, Schedule, Word
from lipsync_lang.schedules.timed_words import TimedWord, TimedWords
from lipsync_lang.schedules.timing_readers import (
    TIMING_READERS,
    read_schedule,
    read_timings,
    reader,
)

__all__ = [
    "SILENCE",
    "TIMING_READERS",
    "Audio",
    "Schedule",
    "TimedWord",
    "TimedWords",
    "Word",
    "read_schedule",
    "read_timings",
    "reader",
]
