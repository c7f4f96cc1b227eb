# The names of the package; each is imported from its module on first use.

from .rows import LabelRow as LabelRow
from .rows import schedule_of as schedule_of
from .schedule import SILENCE as SILENCE
from .schedule import Audio as Audio
from .schedule import Schedule as Schedule
from .schedule import Word as Word
from .timed_words import TimedWord as TimedWord
from .timed_words import TimedWords as TimedWords
from .timed_words import timed_words_of as timed_words_of
from .timing_file import TimingFile as TimingFile
from .timing_readers import TIMING_READERS as TIMING_READERS
from .timing_readers import Timings as Timings
from .timing_readers import read_schedule as read_schedule
from .timing_readers import read_timings as read_timings
from .timing_readers import reader as reader
