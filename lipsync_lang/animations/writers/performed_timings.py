"""The timings that an animation was performed by, in formats that people correct them in.

The files are read back with `--schedule`. Times are on the timeline of output files: the sound
begins at the offset.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import TextIO

from lipsync_lang.animations.writers import Animation, writer
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.writers.elan import elan_text
from lipsync_lang.schedules.writers.json import json_text
from lipsync_lang.schedules.writers.tables import label_track_text, table_text
from lipsync_lang.schedules.writers.textgrid import textgrid_text


def _cut(animation: Animation) -> Iterable[str]:
    """Yield a remark if phonemes lie before the start of the file."""
    if _moved(animation).start < 0:
        yield ("sounds before time 0 are left out of the timings; use a larger `offset`")


def _wordless(animation: Animation) -> Iterable[str]:
    """Yield a remark on words, which a label track cannot hold beside the phonemes."""
    yield from _cut(animation)
    if animation.schedule.words:
        yield "a label track has only phonemes; a TextGrid also has words"


@writer("textgrid", suffix=".textgrid", remarks=_cut)
def write_textgrid(animation: Animation, out: TextIO) -> None:
    """Timings for Praat: tiers of words, phones and confidences."""
    out.write(textgrid_text(_moved(animation)))


@writer("elan", suffix=".eaf", remarks=_cut)
def write_elan(animation: Animation, out: TextIO) -> None:
    """Timings for ELAN: tiers of words, phones and confidences."""
    out.write(elan_text(_moved(animation)))


@writer("audacity", suffix=".labels.txt", remarks=_wordless)
def write_label_track(animation: Animation, out: TextIO) -> None:
    """Timings for Audacity: a label track of phonemes."""
    out.write(label_track_text(_moved(animation)))


@writer("timings-csv", suffix=".timings.csv", remarks=_cut)
def write_table(animation: Animation, out: TextIO) -> None:
    """Timings as a table: begin, end, label and type of each word and phone."""
    out.write(table_text(_moved(animation)))


@writer("timings-json", suffix=".timings.json")
def write_timings(animation: Animation, out: TextIO) -> None:
    """Timings as JSON: phonemes with stress, words with emphasis and confidence."""
    out.write(json_text(_moved(animation)) + "\n")


def _moved(animation: Animation) -> Schedule:
    """Return the schedule on the timeline of output files."""
    # an offset makes room before the first sound, in the animation as in its sound
    schedule = animation.schedule
    return replace(schedule, times=schedule.times + animation.offset)
