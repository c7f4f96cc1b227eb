"""Switch: one pose at a time, for drawn faces.

Conventions: (P, T) is poses by frames; the result is 0 or 1.

The paper has no such stage. A drawn mouth that changes too often flickers, so each pose is shown
for a least time. Contacts come first, and a pose between two equal contacts stays. Of the other
runs the shortest gives way, until every run lasts. A frame may therefore depend on the whole line,
though rarely beyond a few phonemes. Between two equally strong poses, a small change may show the
other.
"""

from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from itertools import pairwise

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints

REST = 0.25
"""Minimum weight of a shown pose; below it, the face is at rest."""

NONE = -1
"""Index of the face at rest."""

FREE = -2
"""Index for frames without a contact."""


def switch(curves: Floats, barred: Bools, forced: Ints, frames: int) -> Floats:
    """Show only the strongest pose, each for a minimum number of frames: (P, T) of 0 and 1.

    Parameters
    ----------
    curves : (P, T)
    barred : (P, T) poses that a contact keeps down
    forced : (T,) the pose that a contact holds up, `NONE` where it only keeps others down, `FREE`
        where there is none
    frames : how many frames a pose is shown at least; a contact may cut others short
    """
    shown = np.where(barred, 0.0, curves)
    best = np.argmax(shown, axis=0)
    best = np.where(shown.max(axis=0, initial=0.0) < REST, NONE, best)
    held = forced != FREE
    best = np.where(held & (forced != NONE), forced, best)
    best, held = _widen(best, held, frames)
    best = _settle(best, held, shown, frames)
    out = np.zeros(curves.shape)
    at = np.flatnonzero(best != NONE)
    out[best[at], at] = 1.0
    return out


def _runs(values: Ints) -> Ints:
    """Return where runs of equal values begin, and the end: (R + 1,)."""
    return np.concatenate(([0], np.flatnonzero(np.diff(values)) + 1, [len(values)]))


def _widen(best: Ints, held: Bools, frames: int) -> tuple[Ints, Bools]:
    """Extend contacts to the minimum time, as far as the gaps between them allow."""
    spans = [(int(a), int(b)) for a, b in pairwise(_runs(best + len(best) * held)) if held[a]]
    gaps = [later - b for (_, b), (later, _) in pairwise(spans)]
    rooms = [len(best), *(max(0, gap - frames) // 2 for gap in gaps), len(best)]
    wide_best, wide_held = best.copy(), held.copy()
    for (a, b), before, after in zip(spans, rooms, rooms[1:], strict=False):
        short = max(0, frames - (b - a))
        early = min((short + 1) // 2, before, a)
        low, high = a - early, b + min(short - early, after)
        wide_best[low:high] = best[a]
        wide_held[low:high] = True
    return wide_best, wide_held


@dataclass
class _PoseRun:
    """Some frames of one pose, between two others."""

    number: int
    start: int
    stop: int
    pose: int
    held: bool
    before: "_PoseRun | None" = None
    after: "_PoseRun | None" = None
    gone: bool = False

    @property
    def frames(self) -> int:
        return self.stop - self.start

    def take(self, other: "_PoseRun") -> None:
        """Merge with the next run, which has the same pose."""
        self.stop, self.held = other.stop, self.held or other.held
        self.after, other.gone = other.after, True
        if other.after is not None:
            other.after.before = self


def _settle(best: Ints, held: Bools, shown: Floats, frames: int) -> Ints:
    """Remove the shortest runs, one by one, until the others are long enough."""
    runs = [
        _PoseRun(number, int(a), int(b), int(best[a]), bool(held[a:b].any()))
        for number, (a, b) in enumerate(pairwise(_runs(best)))
    ]
    for one, other in pairwise(runs):
        one.after, other.before = other, one
    # numbers break ties from the left, so that equal lines give equal results
    waiting = [(run.frames, run.number) for run in runs if not run.held]
    heapify(waiting)
    while waiting:
        length, number = heappop(waiting)
        run = runs[number]
        # entries of runs that grew since are outdated; each growth pushed a new entry
        if run.gone or run.held or length != run.frames or length >= frames:
            continue
        # only this run parts two equal contacts, as a vowel does
        alike = run.before and run.after and run.before.pose == run.after.pose
        early, late = held[max(0, run.start - frames) : run.start], held[run.stop :][:frames]
        if alike and early.any() and late.any():
            continue
        for other in _let_go(run, shown):
            heappush(waiting, (other.frames, other.number))
    out = best.copy()
    for run in runs:
        if not run.gone:
            out[run.start : run.stop] = run.pose
    return out


def _let_go(run: _PoseRun, shown: Floats) -> list[_PoseRun]:
    """Give a run's frames to its neighbours; return the lengthened runs."""
    before, after = run.before, run.after
    if before is None or after is None:  # at the ends the face is at rest
        return []
    one, other = (
        shown[pose, run.start : run.stop] if pose != NONE else np.full(run.frames, REST)
        for pose in (before.pose, after.pose)
    )
    # the cut keeps most weight: up to it the lead of the pose before adds up to the most
    cut = run.start + int(np.argmax(np.concatenate(([0.0], np.cumsum(one - other)))))
    before.stop, after.start = cut, cut
    before.after, after.before, run.gone = after, before, True
    if before.pose == after.pose:
        before.take(after)
    return [other for other in (before, after) if not other.gone]
