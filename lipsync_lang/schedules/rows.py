"""Conversion of rows with a label and its times to a schedule.

Files leave gaps, have rows in any order, and count in milliseconds or frames. Here they become one
contiguous schedule in seconds, or an error that names the line.

A label may be a mouth shape, which stands for several sounds that look alike. The common pack maps
the labels of shapes to common phonemes, the same for every language. A remark of the schedule warns
of the loss.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import log
from operator import attrgetter, itemgetter
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.errors import ScheduleError, count
from lipsync_lang.schedules.schedule import (
    MAX_MEDIAN_SECONDS,
    SILENCE,
    SNAP_SECONDS,
    Schedule,
    words_from_spans,
)
from lipsync_lang.schedules.timing_file import TimingFile

MILLISECONDS_PER_SECOND = 1000.0
TYPICAL_SOUND_SECONDS = 0.08

LONG_SOUND_SECONDS = 1.0
"""Longest plausible median duration in seconds; longer sounds are in another unit."""

ROUNDING_SECONDS = 0.0101
"""Seconds; aligners round times to 10 ms, so that neighbours overlap or part by that much."""

OVERLAP_SECONDS = 0.0501
"""Seconds; people who place boundaries by hand, and models that time each sound apart, let
neighbours overlap by that much."""

MAX_LABEL_CHARS = 40
"""Maximum characters of a label in a message."""

PAUSE_LABEL = re.compile(
    r"_:?|[#+]+|#h|h#|epi|\.?pau(se)?|rest|(short|s)?sil([be]|ence)?|!sil|\.sil|sp|spn|nsn|oov|unk"
    r"|&p:|sent-(start|end)|[be]_trans|\(sil\)|<[^>]*>|\[[^]]*]|\{[^}]+}",
    re.IGNORECASE,
)
"""Usual labels of a pause. One without length is no sound that shares the time of a neighbour."""

LIKELY_RATES = (MILLISECONDS_PER_SECOND, 100.0, 60.0, 30.0, 25.0, 24.0)
"""Units per second of files that do not count in seconds."""

Start = tuple[str, float, int | None]
"""A label, its start time, and its line in the file."""


class LabelRow(NamedTuple):
    """A label from `start` to `end`, in the file's unit or seconds, and its line in the file."""

    label: str
    start: float
    end: float
    line: int | None = None
    confidence: float | None = None
    """Probability that a word is said there, in [0, 1]; None if unknown."""


def listed_rows(  # noqa: PLR0913 optional parts of a format
    source: TimingFile,
    labels: object,
    starts: object,
    ends: object,
    *,
    form: str,
    line: int | None = None,
    durations: bool = False,
) -> Iterator[LabelRow]:
    """Yield rows of three lists in JSON of one length, in the file's unit.

    The values may be anything; `form` is an example of the format, for the error about anything
    else, and `line` that of the lists, if each line of the file is JSON. With `durations`, the ends
    are durations.
    """
    given = (labels, starts, ends)
    lists = [one for one in given if isinstance(one, list)]
    if len(lists) != len(given) or len(set(map(len, lists))) != 1:
        raise source.fault(f"needs three lists of one length; the form is {form}", line)
    for label, first, second in zip(*lists, strict=True):
        start, end = source.number(first, line), source.number(second, line)
        yield LabelRow(str(label), start, start + end if durations else end, line)


def schedule_of(  # noqa: PLR0913 optional parts of a format
    source: TimingFile,
    rows: Iterable[LabelRow],
    *,
    words: Iterable[LabelRow] = (),
    notation: str | None = None,
    rate: float | None = None,
    guess: bool = False,
    remarks: Iterable[str] = (),
) -> Schedule:
    """Make a schedule of rows; gaps, and the time from zero on, are silence.

    Raises ScheduleError if a time is below zero, runs backwards or overlaps another; the line is
    named.

    Parameters
    ----------
    source : the file, for messages; its `rate`, if given, overrides that of the format
    rows : labels with their times, in any order; a blank label is silence
    words : texts with their times; each gets the phonemes whose middle lies in it
    notation : of the labels, if the format has one
    rate : units per second of all times; None for seconds
    guess : guess the unit of a format that does not state one, and add a remark
    remarks : doubts about the file
    """
    in_order = attrgetter("start", "end")
    phones, spans = sorted(rows, key=in_order), sorted(words, key=in_order)
    if not phones:
        raise source.fault("has no phonemes; check that the file is complete")
    rate, told = source.rate or rate, tuple(remarks)
    if rate is None and guess:
        usual = (TYPICAL_SOUND_SECONDS, LONG_SOUND_SECONDS)
        rate, guessed = guessed_rate(source, phones, "sounds", *usual)
        told += guessed
    if rate is not None:
        phones, spans = (
            [row._replace(start=row.start / rate, end=row.end / rate) for row in given]
            for given in (phones, spans)
        )
    overlaps = Overlaps(source)
    whole = _without_gaps(source, _shared(_named(source, phones)), overlaps)
    for row in spans:
        _check_order(source, row)
    lines: list[int] = []
    if all(row.line is not None for row in whole if row.label != SILENCE):
        # A filled gap has the line of the row after it.
        below = next((row.line for row in whole[::-1] if row.line is not None), 1)
        lines = [below := row.line or below for row in whole[::-1]][::-1]
    schedule = Schedule(
        tuple(row.label for row in whole),
        np.array([0.0, *(row.end for row in whole)]),
        notation=notation,
        source=str(source.path),
        lines=tuple(lines),
        remarks=(*told, *overlaps.remarks()),
    )
    found = words_from_spans(schedule, [(row.label, row.start, row.end) for row in spans])
    # Some files have pauses among their words.
    heard = [w for w in found if set(schedule.labels[w.first : w.stop]) != {SILENCE}]
    return replace(schedule, words=tuple(heard)) if heard else schedule


def guessed_rate(
    source: TimingFile, rows: Sequence[LabelRow], things: str, typical: float, longest: float
) -> tuple[float | None, tuple[str, ...]]:
    """Return the likely units per second and a remark about them; None for seconds.

    The rows time `things`, which last `typical` seconds, and `longest` seconds at most in a
    plausible median. Frames are whole: times with fractions are seconds, or milliseconds if no
    schedule has so many seconds.
    """
    from statistics import median

    lengths = [row.end - row.start for row in rows if row.label and row.end > row.start]
    middle = median(lengths) if lengths else 0.0
    rates: tuple[float, ...] = LIKELY_RATES
    if any(time % 1 for row in rows for time in (row.start, row.end)):
        rates, longest = (MILLISECONDS_PER_SECOND,), max(longest, MAX_MEDIAN_SECONDS)
    if middle <= longest:
        return None, ()
    # by logarithms, because units differ by factors
    rate = min(rates, key=lambda one: abs(log(middle / one / typical)))
    unit = "milliseconds" if rate == MILLISECONDS_PER_SECOND else f"frames at {rate:g} a second"
    told = (
        f"{source.path}: its {things} would last {middle:g} s each, so its times are read as "
        f"{unit}; if they are not, state how many make a second (`rate={rate:g}`)"
    )
    return rate, (told,)


def _named(source: TimingFile, rows: Iterable[LabelRow]) -> Iterator[LabelRow]:
    """Yield rows with one label of silence; a pause without length is left out."""
    for row in rows:
        if row.start < 0 or row.end < row.start:
            check_span(source, row)
        label = row.label.strip() or SILENCE
        if label.casefold() in source.silences:
            label = SILENCE
        if row.end - row.start >= SNAP_SECONDS or not is_pause(label):
            yield row if label == row.label else row._replace(label=label)


def is_pause(label: str) -> bool:
    """Return True for a usual label of a pause, whatever the language."""
    return PAUSE_LABEL.fullmatch(label) is not None


class Overlaps:
    """The overlaps of neighbours in a file that are parted in the middle, for a remark."""

    def __init__(self, source: TimingFile) -> None:
        self.source = source
        self.found: list[tuple[float, LabelRow]] = []

    def parts(self, row: LabelRow, before: LabelRow) -> bool:
        """Return True, and keep the overlap, if the middle leaves both rows most of their time."""
        by = before.end - row.start
        parted = by <= OVERLAP_SECONDS and by < min(row.end - row.start, before.end - before.start)
        if parted:
            self.found.append((by, row))
        return parted

    def remarks(self) -> Iterator[str]:
        """Yield a remark, if there is an overlap."""
        if self.found:
            by, row = max(self.found, key=itemgetter(0))
            often = count(len(self.found), "time")
            yield (
                f"{self.source.path}: neighbours overlap by up to {by:.3f} s ({often}, such as "
                f"{_told(row)}); their boundary is put in the middle"
            )


def _without_gaps(
    source: TimingFile, rows: Iterable[LabelRow], overlaps: Overlaps
) -> list[LabelRow]:
    """Fill gaps with silence and close those due to rounding; raise an error for long overlaps."""
    filled: list[LabelRow] = []
    end = 0.0
    for stated in rows:
        row = stated
        if row.start == end < row.end and row.label != SILENCE:
            filled.append(row)
            end = row.end
            continue
        middle = (row.start + end) / 2
        # a program that rounds each time by itself: both neighbours give half
        rounded = SNAP_SECONDS < abs(row.start - end) <= ROUNDING_SECONDS
        if not rounded and filled and row.start < end - SNAP_SECONDS:
            rounded = overlaps.parts(row, filled[-1])
        if filled and rounded and filled[-1].start < middle:
            filled[-1] = filled[-1]._replace(end=middle)
            row, end = row._replace(start=middle), middle
        if row.start < end - SNAP_SECONDS:
            raise overlap(source, row, filled[-1])
        if row.end <= max(row.start, end):
            raise without_length(source, row)
        if row.start > end + SNAP_SECONDS:
            _append(filled, LabelRow(SILENCE, end, row.start, None))
            end = row.start
        _append(filled, LabelRow(row.label, end, row.end, row.line))
        end = row.end
    return filled


def _shared(rows: Iterable[LabelRow]) -> Iterator[LabelRow]:
    """Yield rows; those without length have equal shares of the time of a neighbour or a gap."""
    given = list(rows)
    if all(row.end - row.start >= SNAP_SECONDS for row in given):
        yield from given
        return
    ahead: list[list[LabelRow]] = []  # sounds without length, and the one after them
    for row in given:
        waiting = ahead and _one_time(ahead[-1][0].start, ahead[-1][-1].end, row.start)
        ahead += [[*ahead.pop(), row] if waiting else [row]]
    # the last sounds have none after them, and share the time of the one before
    groups: list[list[LabelRow]] = []
    for group in ahead:
        late = groups and _one_time(group[0].start, group[-1].end, groups[-1][-1].end)
        groups += [groups.pop() + group if late else group]
    timed = [not _one_time(group[0].start, group[-1].end) for group in groups]
    if any(timed) and not any(timed[-2:]):
        groups[-2:] = [groups[-2] + groups[-1]]
    for number, group in enumerate(groups):
        start, stop = group[0].start, group[-1].end
        if any(timed) and _one_time(start, stop):
            # sounds without a neighbour have the gap after them, or at the end the one before
            most = TYPICAL_SOUND_SECONDS * len(group)
            if group is groups[-1]:
                start = max(start - most, groups[number - 1][-1].end)
            else:
                stop = min(start + most, groups[number + 1][0].start)
        if len(group) == 1:
            yield group[0]._replace(start=start, end=stop)
            continue
        bounds = [start + (stop - start) * at / len(group) for at in range(len(group))]
        spans = zip(group, bounds, [*bounds[1:], stop], strict=True)
        yield from (row._replace(start=start, end=stop) for row, start, stop in spans)


def _one_time(*times: float) -> bool:
    """Return True for times that are one; the sum of a start and a length is rounded."""
    return max(times) - min(times) < SNAP_SECONDS


def check_span(source: TimingFile, row: LabelRow) -> None:
    """Raise an error for a row that starts below zero, or ends before it starts."""
    if row.start < -SNAP_SECONDS:
        what = "starts below 0; shift all times so that the sound starts at 0"
        raise source.fault(f"{_told(row)}, {what}", row.line)
    _check_order(source, row)


def _check_order(source: TimingFile, row: LabelRow) -> None:
    if row.end < row.start:
        raise source.fault(f"{_told(row)}, ends before it starts; swap its times", row.line)


def overlap(source: TimingFile, row: LabelRow, before: LabelRow) -> ScheduleError:
    """Return the error for a row that starts before the one before it ends."""
    return source.fault(
        f"{_told(row)}, starts before {before.label!r} ends ({before.end:g} s): they overlap; "
        "move one of the two boundaries, or keep one speaker in the file",
        row.line,
    )


def without_length(source: TimingFile, row: LabelRow) -> ScheduleError:
    """Return the error for a row that ends where it starts."""
    what = "has no length; give it some time, or leave it out"
    return source.fault(f"{_told(row)}, {what}", row.line)


def _told(row: LabelRow) -> str:
    """Return a row with its times, for messages."""
    return f"{row.label.strip()[:MAX_LABEL_CHARS] or SILENCE!r}, {row.start:g} to {row.end:g} s"


def _append(rows: list[LabelRow], row: LabelRow) -> None:
    # two silences side by side would be a bigram of their own
    if rows and rows[-1].label == row.label == SILENCE:
        row = row._replace(start=rows.pop().start)
    rows.append(row)


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

    Labels come in any order; of several at one time, the last counts. As the last label, `rest`
    only ends the label before. `rate` is the units per second of all times, and `end` that of the
    last label, if the file states one; the remark says if it is a guess.
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
    # of several labels at one time, all but the last have no length
    return [row for row in rows if row.end > row.start], told
