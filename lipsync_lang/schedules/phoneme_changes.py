"""Phoneme changes: spans of a schedule's phonemes that a person replaced by other labels.

A change is [first phoneme, labels before, labels now], counted in the schedule without changes.
It keeps the time of its span: as many labels as before keep their boundaries, and others share the
time equally. Changes are in order and do not overlap.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.schedules.schedule import Schedule

PhonemeChange = tuple[int, Sequence[str], Sequence[str]]
"""The first phoneme of a span, its labels before, and its labels now."""


def misfit(schedule: Schedule, changes: Sequence[PhonemeChange]) -> str:
    """Say which phoneme of a schedule differs from the labels before; empty if none does."""
    end = 0
    for first, was, _ in changes:
        for index, label in enumerate(was, first):
            found = schedule.labels[index] if index < len(schedule) else None
            if found != label:
                here = f"phoneme {index} was '{label}'"
                return f"{here}, and is '{found}' now" if found else f"{here}, and is missing now"
        if first < end:
            return f"phoneme {first} is changed twice"
        end = first + len(was)
    return ""


def with_changes(schedule: Schedule, changes: Sequence[PhonemeChange]) -> Schedule:
    """Return a schedule with other phonemes; their words stay.

    Raises ScheduleError if a word would have no phoneme left.

    Examples
    --------
    >>> from lipsync_lang.schedules.phoneme_changes import with_changes
    >>> with_changes(ll.Schedule(("M", "AA"), [0, 0.1, 0.3]), [(1, ["AA"], ["AH", "T"])]).labels
    ('M', 'AH', 'T')
    """
    # From the last on, so that the numbers of those before still count.
    for first, was, now in reversed(changes):
        schedule = _changed(schedule, first, tuple(was), tuple(now))
    return schedule


def composed(
    opened: Schedule, changes: Sequence[PhonemeChange], span: tuple[int, int], now: Sequence[str]
) -> list[PhonemeChange]:
    """Add a change to others; `now` replaces a `span` that is counted after the others."""
    labels = with_changes(opened, changes).labels
    low, high = span
    kept: list[tuple[int, PhonemeChange]] = []
    shift = 0
    for first, was, after in changes:
        start, stop = first + shift, first + shift + len(after)
        if start < span[1] and span[0] < stop:
            low, high = min(low, start), max(high, stop)
        else:
            kept.append((start, (first, was, after)))
        shift += len(after) - len(was)
    before = sum(len(after) - len(was) for at, (_, was, after) in kept if at < low)
    behind = sum(len(after) - len(was) for at, (_, was, after) in kept if at >= high)
    old = opened.labels[low - before : len(opened) - (len(labels) - high - behind)]
    new = (*labels[low : span[0]], *now, *labels[span[1] : high])
    own = [] if old == new else [(low - before, list(old), list(new))]
    return sorted([*(one for _, one in kept), *own], key=lambda one: one[0])


def spread(times: Floats, first: int, stop: int, count: int) -> Floats:
    """Return boundaries of a schedule whose phonemes `first` to `stop` become `count` others."""
    if count == stop - first:
        return times
    inner = np.linspace(times[first], times[stop], count + 1)
    return np.concatenate((times[:first], inner, times[stop + 1 :]))


def _changed(
    schedule: Schedule, first: int, was: tuple[str, ...], now: tuple[str, ...]
) -> Schedule:
    stop = first + len(was)

    def moved(edge: int) -> int:
        inside = _edge(was, now, min(edge, stop) - first)
        return edge if edge <= first else first + inside + max(edge - stop, 0)

    words = tuple(
        replace(
            one,
            first=moved(one.first),
            stop=moved(one.stop),
            relabelled=one.relabelled or (one.first < stop and first < one.stop),
        )
        for one in schedule.words
    )
    empty = next((one for one in words if one.first == one.stop), None)
    if empty is not None:
        raise ScheduleError(
            f"{schedule.source}: the word '{empty.text}' would have no phoneme left; relabel its "
            "last one, or leave the word out of the text"
        )
    marks = schedule.stress[first:stop]
    known = dict(zip(was, marks, strict=False))
    usual = marks if len(was) == len(now) else (None,) * len(now)
    # A label that stays keeps its stress, wherever it stands now.
    stress = tuple(known.get(label, mark) for label, mark in zip(now, usual, strict=False))

    def placed(of_each: tuple[Any, ...], own: tuple[Any, ...]) -> tuple[Any, ...]:
        return (*of_each[:first], *own, *of_each[stop:]) if of_each else ()

    return replace(
        schedule,
        labels=placed(schedule.labels, now),
        times=spread(schedule.times, first, stop, len(now)),
        words=words,
        stress=placed(schedule.stress, stress),
        lines=placed(schedule.lines, schedule.lines[first : first + 1] * len(now)),
        likely=placed(schedule.likely, ((),) * len(now)),
    )


def _edge(was: Sequence[str], now: Sequence[str], edge: int) -> int:
    """Return the place among new labels of an edge of a word among the labels before."""
    after = len(was) - edge
    if after <= _common(was[::-1], now[::-1]):
        return len(now) - after
    alike = len(was) == len(now) or edge <= _common(was, now)
    return edge if alike else min(edge, len(now) - 1)


def _common(one: Sequence[str], other: Sequence[str]) -> int:
    """Count the equal labels at the start of two lists."""
    pairs = enumerate(zip(one, other, strict=False))
    return next((n for n, (a, b) in pairs if a != b), min(len(one), len(other)))


def excerpt(line: Schedule, first: int, stop: int) -> Schedule:
    """Return the phonemes from `first` until `stop` of a line, with their words."""
    words = tuple(
        replace(w, first=max(w.first, first) - first, stop=min(w.stop, stop) - first)
        for w in line.words
        if first <= w.first < stop
    )
    return replace(
        line, labels=line.labels[first:stop], times=line.times[first : stop + 1],
        words=words, stress=line.stress[first:stop], lines=line.lines[first:stop],
        likely=line.likely[first:stop],
    )  # fmt: skip
