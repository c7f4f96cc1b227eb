"""Mouth shapes with their times, made into a schedule.

A shape stands for several sounds that look alike. Its label is read in a notation of mouth
shapes, which the common pack maps to common phonemes in every language; what told the sounds
apart is lost, and the schedule says so.
"""

from collections.abc import Iterable
from operator import itemgetter

from lipsync_lang.schedules.rows import SOUND, LabelRow, schedule_of
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.timing_file import TimingFile

Start = tuple[str, float, int | None]
"""A label, when it starts, and the line it stands in."""


def shapes_of(  # noqa: PLR0913 each says one thing that a format may
    source: TimingFile,
    rows: Iterable[LabelRow],
    *,
    notation: str,
    words: Iterable[LabelRow] = (),
    rate: float | None = None,
    remarks: Iterable[str] = (),
) -> Schedule:
    """Make a schedule of shapes, as `rows.schedule_of` does of sounds."""
    lossy = (
        f"{source.path}: holds mouth shapes, not sounds: each stands for several sounds, and what "
        "tells them apart is lost; give timed phonemes of the line where there are some"
    )
    remarks = (lossy, *remarks)
    return schedule_of(source, rows, words=words, notation=notation, rate=rate, remarks=remarks)


def until_next(
    source: TimingFile,
    starts: Iterable[Start],
    *,
    rest: str,
    end: float | None = None,
    rate: float = 1.0,
) -> tuple[list[LabelRow], list[str]]:
    """Let each label last until the next one starts.

    Parameters
    ----------
    source : the file, for messages
    starts : labels and when they start, in any order; of several at one time, the last counts
    rest : the label of the mouth at rest; at the end it says when the one before it ends
    end : when the last one ends, where the file tells
    rate : units per second of all times

    Returns
    -------
    the rows, and a word where the end had to be guessed
    """
    ordered = sorted(starts, key=itemgetter(1))
    if not ordered:
        return [], []
    label, last, _ = ordered[-1]
    told: list[str] = []
    if end is None or end <= last:
        end = last
        if label != rest or len(ordered) == 1:
            end = last + SOUND * (source.rate or rate)
            last_one = f"{source.path}: does not say when its last label, {label!r}, ends"
            told = [f"{last_one}; it is given {SOUND:g} s"]
    ends = [start for _, start, _ in ordered[1:]] + [end]
    rows = [LabelRow(one[0], one[1], stop, one[2]) for one, stop in zip(ordered, ends, strict=True)]
    return [row for row in rows if row.end > row.start], told
