"""Schedules: timed phonemes, read from the files of many programs.

Times are seconds. A schedule is contiguous: phoneme i lasts from ``times[i]`` to
``times[i + 1]``. Silence is a phoneme like any other, written `SILENCE`. Labels are kept as
the file or the engine wrote them; a language pack turns them into common phonemes.

One file per input format; `reader` is all that makes a format known.
"""

from lipsync_lang.schedules.rows import LabelRow as LabelRow
from lipsync_lang.schedules.rows import schedule_of as schedule_of
from lipsync_lang.schedules.schedule import SILENCE as SILENCE
from lipsync_lang.schedules.schedule import Audio as Audio
from lipsync_lang.schedules.schedule import Schedule as Schedule
from lipsync_lang.schedules.schedule import Word as Word
from lipsync_lang.schedules.timed_words import TimedWord as TimedWord
from lipsync_lang.schedules.timed_words import TimedWords as TimedWords
from lipsync_lang.schedules.timed_words import timed_words_of as timed_words_of
from lipsync_lang.schedules.timing_file import TimingFile as TimingFile
from lipsync_lang.schedules.timing_readers import TIMING_READERS as TIMING_READERS
from lipsync_lang.schedules.timing_readers import Timings as Timings
from lipsync_lang.schedules.timing_readers import read_schedule as read_schedule
from lipsync_lang.schedules.timing_readers import read_timings as read_timings
from lipsync_lang.schedules.timing_readers import reader as reader
