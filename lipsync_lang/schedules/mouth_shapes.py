"""Make a schedule of timed mouth shapes.

A shape stands for several sounds that look alike. The common pack maps the labels of shapes to
common phonemes, the same for every language. A remark of the schedule warns of the loss.
"""

from collections.abc import Iterable
from operator import itemgetter

from lipsync_lang.schedules.rows import TYPICAL_SOUND_SECONDS, LabelRow, schedule_of
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.timing_file import TimingFile

Start = tuple[str, float, int | None]
"""A label, its start time, and its line in the file."""


def shapes_of(  # noqa: PLR0913 optional parts of a format
    source: TimingFile,
    rows: Iterable[LabelRow],
    *,
    notation: str,
    words: Iterable[LabelRow] = (),
    rate: float | None = None,
    remarks: Iterable[str] = (),
) -> Schedule:
    """Make a schedule of shapes; see `rows.schedule_of` for the parameters."""
    lossy = (
        f"{source.path}: has mouth shapes, not phonemes: each represents several phonemes, and "
        "their difference is lost; if you have timed phonemes of the line, give those"
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
    """Let each label last until the start of the next.

    Parameters
    ----------
    source : the file, for messages
    starts : labels with start times, in any order; of several at one time, the last counts
    rest : the label of the mouth at rest; as the last label it only ends the label before
    end : end of the last label, if the file states one
    rate : units per second of all times

    Returns
    -------
    the rows, and a remark if the end is a guess
    """
    ordered = sorted(starts, key=itemgetter(1))
    if not ordered:
        return [], []
    label, last, _ = ordered[-1]
    told: list[str] = []
    if end is None or end <= last:
        end = last
        if label != rest or len(ordered) == 1:
            end = last + TYPICAL_SOUND_SECONDS * (source.rate or rate)
            last_one = f"{source.path}: does not state when its last label, {label!r}, ends"
            told = [f"{last_one}; it is given {TYPICAL_SOUND_SECONDS:g} s"]
    ends = [start for _, start, _ in ordered[1:]] + [end]
    rows = [LabelRow(one[0], one[1], stop, one[2]) for one, stop in zip(ordered, ends, strict=True)]
    return [row for row in rows if row.end > row.start], told
