"""`Schedule`, the common form of timed phonemes.

Times are seconds. Phoneme i lasts from ``times[i]`` to ``times[i + 1]``.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from math import isfinite, nan
from pathlib import Path
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.errors import OutputError, ScheduleError

SILENCE = "_"
"""The label of silence, in every notation."""

DOUBTFUL = 0.5
"""Confidence below which a line, or a word, is in doubt."""

OTHER_ORDER = "the words fit better in another order"
"""Start of a remark about which no other aligner is asked: few tell the order of words."""

STRESSES = (None, 0, 1, 2)
"""Values of stress: unmarked, none, primary and secondary."""

MAX_EMPHASIS = 2.0
"""Maximum emphasis of a word, twice that of the pose set."""

SNAP_SECONDS = 5e-4
"""Seconds; smaller gaps and overlaps between neighbours are rounding errors, and are closed."""

MAX_SCHEDULE_SECONDS = 86_400.0
"""Latest boundary in seconds; later times must be in another unit."""

MAX_MEDIAN_SECONDS = 10.0
"""Longest median duration of sounds in seconds; longer ones must be in another unit."""


@dataclass(frozen=True, eq=False)
class Audio:
    """Mono sound: int16 samples at a rate in hertz.

    `usual_level` is the level of ordinary speech from this source in dBFS, None if unknown.
    """

    samples: npt.NDArray[np.int16]
    rate: int
    usual_level: float | None = None

    @property
    def seconds(self) -> float:
        """Length of the sound."""
        return len(self.samples) / self.rate


@dataclass(frozen=True)
class Word:
    """A word and its phonemes: ``labels[first:stop]``.

    `emphasis` opens the mouth wider over the word: 0 not at all, 1 as the pose set says, up to 2.
    `confidence` is the probability that the word is said there, in [0, 1]; None if unknown.
    `start` and `end` are in seconds; the words of a schedule have them from its times. `relabelled`
    is True if a person changed its phonemes: they stand, even if the language lists its sounds.
    """

    text: str
    first: int
    stop: int
    emphasis: float = 0.0
    confidence: float | None = None
    start: float = field(default=nan, compare=False)
    end: float = field(default=nan, compare=False)
    relabelled: bool = False


@dataclass(frozen=True, eq=False)
class Schedule:
    """Contiguous timed phonemes, with optional words and sound.

    Parameters
    ----------
    labels : n phonemes, in one notation
    times : (n + 1,) boundaries in seconds, strictly rising
    words : in order, not overlapping
    notation : the labels' notation, or None to let the language pack recognise it
    language : name of the labels' language pack, if known
    audio : the sound; it starts at time zero
    estimated : True if the times come from a rule instead of a voice
    source : name of this schedule in messages
    unread : characters of the original text that could not be read
    dropped : markup of the original text that is not spoken, in order
    left_out : words of the text that the sound lacks, in order
    likely : the likeliest labels of each phoneme, best first, with their probability, where the
        sound alone was heard; empty otherwise
    lines : line in the file of each label; empty if unknown
    remarks : doubts about the schedule
    recognised : True if speech recognition found the words, so that they may be wrong
    confidence : in [0, 1], the fit of times or words to the sound; None if unknown
    stress : 1 for primary, 2 for secondary and 0 for no stress of each phoneme, None where nothing
        marks it; empty if the labels themselves carry the marks
    """

    labels: tuple[str, ...]
    times: npt.NDArray[np.float64]
    words: tuple[Word, ...] = ()
    notation: str | None = None
    language: str | None = None
    audio: Audio | None = None
    estimated: bool = False
    source: str = field(default="schedule")
    unread: tuple[str, ...] = ()
    lines: tuple[int, ...] = ()
    remarks: tuple[str, ...] = ()
    recognised: bool = False
    confidence: float | None = None
    stress: tuple[int | None, ...] = ()
    dropped: tuple[str, ...] = ()
    likely: tuple[tuple[tuple[str, float], ...], ...] = ()
    left_out: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Raise an error for faulty times, labels and words."""
        try:
            # A copy, which the caller's array cannot change.
            times = np.array(self.times, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            raise ScheduleError(f"{self.source}: boundaries must be numbers of seconds") from None
        times.setflags(write=False)
        object.__setattr__(self, "times", times)
        for name in ("labels", "words", "stress"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        _check(self.source, self.labels, times)
        _check_words(self.source, self.words, len(self.labels))
        at = times.tolist()
        timed = (replace(word, start=at[word.first], end=at[word.stop]) for word in self.words)
        object.__setattr__(self, "words", tuple(timed))
        if self.stress and len(self.stress) != len(self.labels):
            counts = f"{len(self.stress)} stresses for {len(self.labels)} phonemes"
            raise ScheduleError(f"{self.source}: {counts}; give each one")
        for number, one in enumerate(self.stress):
            # True equals 1.
            if isinstance(one, bool) or one not in STRESSES:
                what = f"stress is {one!r}; it is 0 (none), 1 (primary), 2 (secondary) or null"
                raise ScheduleError(f"{self.source}: phoneme {number}: {what}")

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle by fields, so that a copy's times are read-only as well."""
        return type(self), tuple(getattr(self, f.name) for f in fields(self))

    def place(self, index: int) -> str:
        """Return the place of phoneme `index` in the file, for messages."""
        return f"{self.source}:{self.lines[index]}" if self.lines else self.source

    @classmethod
    def from_intervals(
        cls, intervals: Iterable[tuple[str, float, float]], *, source: str = "schedule", **rest: Any
    ) -> Self:
        """Build a schedule from (label, start, end) rows.

        Neighbours may be apart or overlap by `SNAP_SECONDS`; a larger gap or overlap is an error.

        Examples
        --------
        >>> ll.Schedule.from_intervals([("M", 0.0, 0.1), ("AA", 0.1, 0.3)]).end
        0.3
        """
        labels: list[str] = []
        times: list[float] = []
        for number, (label, start, end) in enumerate(intervals):
            here = f"{source}: phoneme {number} ({label!r})"
            _check_numbers(here, start, end)
            if times and start > times[-1] + SNAP_SECONDS:
                raise ScheduleError(
                    f"{here} starts at {start:g} s, but the previous one ends at {times[-1]:g} s: "
                    f"a gap. Write silence there: ({SILENCE!r}, {times[-1]:g}, {start:g})"
                )
            if times and start < times[-1] - SNAP_SECONDS:
                raise ScheduleError(
                    f"{here} starts at {start:g} s, before the previous one ends at {times[-1]:g} "
                    "s: they overlap. Move one of the two boundaries, or put the rows in order"
                )
            _check_length(here, times[-1] if times else start, end)
            times = times or [start]
            labels.append(label)
            times.append(end)
        return cls(tuple(labels), np.array(times, dtype=np.float64), source=source, **rest)

    @property
    def start(self) -> float:
        """Seconds at which the first phoneme starts."""
        return float(self.times[0])

    @property
    def end(self) -> float:
        """Seconds at which the last phoneme ends."""
        return float(self.times[-1])

    def moved(self, seconds: float) -> Self:
        """Return a copy shifted by some seconds, without its sound."""
        return replace(self, times=self.times + seconds, audio=None)

    def stretched(self, factor: float) -> Self:
        """Return a copy slowed down by a factor, with the same start and without its sound."""
        return replace(self, times=self.start + (self.times - self.start) * factor, audio=None)

    def resting(self, seconds: float) -> Self:
        """Return a copy with some seconds of silence at its end.

        Examples
        --------
        >>> ll.Schedule(("M",), [0, 0.1]).resting(2).labels
        ('M', '_')
        """
        if not 0 <= seconds <= MAX_SCHEDULE_SECONDS:
            raise ScheduleError(f"{seconds:g} s of rest; give a number of seconds from 0")
        if seconds == 0:
            return self
        return replace(
            self, labels=(*self.labels, SILENCE), times=np.append(self.times, self.end + seconds),
            stress=(*self.stress, None) if self.stress else (),
            lines=(*self.lines, self.lines[-1]) if self.lines else (),
            likely=(*self.likely, ()) if self.likely else (),
        )  # fmt: skip

    def weighed(self, count: int) -> list[Self]:
        """Return copies with the likely labels of each phoneme, each in its share of the copies.

        A phoneme whose label is none of its likely ones keeps it. Empty if no label is unsure.
        """
        if not any(self.likely) or len(self.likely) != len(self.labels):
            return []
        shares, columns = (np.arange(count) + 0.5) / count, []
        for label, likely in zip(self.labels, self.likely, strict=True):
            told = likely if label in dict(likely) else ((label, 1.0),)
            names, chances = zip(*told, strict=True)
            sums = np.cumsum(chances)
            columns.append([names[n] for n in sums.searchsorted(shares * sums[-1])])
        return [replace(self, labels=row, likely=()) for row in zip(*columns, strict=True)]

    def save(self, path: str | Path) -> None:
        """Write the timings to a file; its suffix names the format, and readers read it back.

        The formats are JSON, TextGrid (Praat), eaf (ELAN), csv, and txt (Audacity). Raises
        OutputError if no format has the suffix, or the file cannot be written.

        Examples
        --------
        >>> ll.Schedule(("M",), [0, 0.1]).save("line.TextGrid")
        >>> ll.read_schedule("line.TextGrid").labels
        ('M',)
        """
        from lipsync_lang.base.files import argument_path, atomic
        from lipsync_lang.schedules.writers import TIMING_WRITERS

        target = argument_path(path)
        texts = {f".{suffix.lower()}": text_of for suffix, text_of in TIMING_WRITERS.items()}
        text_of = texts.get(target.suffix.lower())
        if text_of is None:
            what = f"timings cannot be written as '{target.suffix}'"
            raise OutputError(f"{target}: {what}; use the suffix {', '.join(texts)}")
        with atomic(target) as stream:
            stream.write(text_of(self).encode("utf-8"))

    def word_at(self, index: int) -> Word | None:
        """Return the word of phoneme `index`, or None."""
        return next((w for w in self.words if w.first <= index < w.stop), None)

    def __len__(self) -> int:
        return len(self.labels)


def words_from_spans(
    schedule: Schedule,
    spans: list[tuple[str, float, float]],
    facts: Sequence[Mapping[str, Any]] = (),
) -> tuple[Word, ...]:
    """Give each timed word the phonemes whose middle lies in it; drop words without phonemes.

    `spans` are the text, start and end of each word; `facts` are further fields of each word, or
    empty.
    """
    middles = (schedule.times[:-1] + schedule.times[1:]) / 2
    words: list[Word] = []
    for number, (text, start, end) in enumerate(spans):
        here = f"{schedule.source}: word {number} ({text!r})"
        _check_numbers(here, start, end)
        if end < start:
            _check_length(here, start, end)
        first, stop = (int(i) for i in middles.searchsorted([start, end]))
        # Words may overlap in a file; a phoneme belongs to one of them.
        if words:
            first = max(first, words[-1].stop)
        if text.strip() and first < stop:
            words.append(Word(text, first, stop, **(facts[number] if facts else {})))
    return tuple(words)


def _check_numbers(here: str, *times: Any) -> None:
    for one in times:
        number = isinstance(one, (int, float, np.number))
        if not number or isinstance(one, (bool, np.complexfloating)):
            raise ScheduleError(f"{here}: {one!r} is not a time; times are numbers of seconds")
        try:
            finite = isfinite(float(one))
        except OverflowError:
            finite = False
        if not finite:
            raise ScheduleError(f"{here}: time is {one}; every time must be a finite number")


def _check_length(here: str, start: float, end: float) -> None:
    if end == start:
        what = "has no length; give it some time, or leave it out"
        raise ScheduleError(f"{here}, {start:g} to {end:g} s, {what}")
    if end < start:
        what = "ends before it starts: times run backwards; put them in order"
        raise ScheduleError(f"{here}, {start:g} to {end:g} s, {what}")


def _check(source: str, labels: Sequence[str], times: npt.NDArray[np.float64]) -> None:
    if not labels:
        raise ScheduleError(f"{source}: has no phonemes; give at least one, with its start and end")
    for number, label in enumerate(labels):
        if not isinstance(label, str):
            raise ScheduleError(f"{source}: phoneme {number}: {label!r} is not a label; use text")
    if times.shape != (len(labels) + 1,):
        what = f"{len(labels)} phonemes need {len(labels) + 1} boundaries, got {times.size}"
        raise ScheduleError(f"{source}: {what}")
    if not np.isfinite(times).all():
        at = int(np.flatnonzero(~np.isfinite(times))[0])
        raise ScheduleError(f"{source}: boundary {at} is {times[at]}; times must be finite numbers")
    steps = np.diff(times)
    if (steps <= 0).any():
        at = int(np.flatnonzero(steps <= 0)[0])
        _check_length(f"{source}: phoneme {at} ({labels[at]!r})", times[at], times[at + 1])
    latest = max(-float(times[0]), float(times[-1]))
    mend = "write times in seconds, not in milliseconds, samples or frames"
    if latest > MAX_SCHEDULE_SECONDS:
        raise ScheduleError(f"{source}: reaches {latest:g} s, more than a day; {mend}")
    # No median is above the longest, so nearly all schedules are done here.
    if steps.max() <= MAX_MEDIAN_SECONDS:
        return
    sounds = steps[[label != SILENCE for label in labels]]
    if sounds.size and np.median(sounds) > MAX_MEDIAN_SECONDS:
        raise ScheduleError(f"{source}: its sounds last {np.median(sounds):g} s each; {mend}")


def _check_words(source: str, words: Sequence[Word], count: int) -> None:
    for word in words:
        if not 0 <= word.first < word.stop <= count:
            what = f"covers phonemes {word.first} to {word.stop - 1}, but the schedule has"
            raise ScheduleError(f"{source}: word {word.text!r} {what} 0 to {count - 1}")
        is_number = isinstance(word.emphasis, (int, float, np.number))
        is_bool = isinstance(word.emphasis, bool)
        if is_bool or not is_number or not 0 <= word.emphasis <= MAX_EMPHASIS:
            what = f"emphasis is {word.emphasis!r}; it is a number from 0 to {MAX_EMPHASIS:g}"
            raise ScheduleError(f"{source}: word {word.text!r}: {what}")
    for left, right in pairwise(words):
        if right.first < left.stop:
            what = f"words {left.text!r} and {right.text!r} share phoneme {right.first}"
            raise ScheduleError(f"{source}: {what}; list words in order and without overlap")


AT_REST = Schedule((SILENCE,), np.array([0.0, 0.1]))
"""Silence, for a mouth at rest."""
