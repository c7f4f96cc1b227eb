"""Counts over all lines of a build, and the worst lines.

The badness of a figure is its value as a share of its limit: above 1 it is exceeded. A limit of 0
has no shares; its figures have 1 and more, by their value.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import inf, nan
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.production.builds.planned_line import (
    LIMIT_FACTOR,
    LIMIT_STEP,
    BuiltLine,
    JudgedFigure,
    PlannedLine,
)
from lipsync_lang.production.builds.records import packed_figures, unpacked_figures
from lipsync_lang.schedules.schedule import DOUBTFUL

BINS = 20
"""Number of bars of a histogram; for a figure with a limit, half of them are within it."""

MIDDLE = BINS // 2

MAX_WORST = 500
"""Maximum number of lines that a report shows in full; it counts all others."""

MAX_COUNTED_LINES = 4096
"""Maximum number of lines that are counted at once, in arrays of a few megabytes."""

ZERO_SCALE = 10
"""Badness of a value of 1 if the limit is 0."""


@dataclass(frozen=True)
class BuildHeading:
    """Counts of a build as a whole, for the head of its reports."""

    project: str
    built: int
    """Lines made by this build."""
    up_to_date: int
    kept: tuple[str, ...] = ()
    """Outputs that were left alone, because somebody changed them."""
    seconds: float = 0.0


class CountedLine(NamedTuple):
    """Line for the counts; the rest of it is read if it is among the worst."""

    line: PlannedLine
    failed: bool
    confidence: float | None
    heading: str
    """Name, unit and binding of its figures; see `packed_figures`."""
    figures: bytes
    whole: Callable[[], BuiltLine]
    lacking: bool = False
    """True if the recording lacks words of the text."""

    @classmethod
    def of(cls, built: BuiltLine) -> "CountedLine":
        """Return a line for the counts."""
        known = built.outcome == "failed", built.confidence, *packed_figures(built.figures)
        return cls(built.line, *known, lambda: built, bool(built.left_out))


def _blocks(lines: Iterable[CountedLine]) -> Iterator[list[tuple[int, CountedLine]]]:
    """Yield blocks of lines of a pair with the same heading, and with their numbers."""
    waiting: dict[tuple[str, str, str], list[tuple[int, CountedLine]]] = defaultdict(list)
    for number, one in enumerate(lines):
        block = waiting[one.line.language, one.line.character, one.heading]
        block.append((number, one))
        if len(block) == MAX_COUNTED_LINES:
            yield block[:]
            block.clear()
    yield from filter(None, waiting.values())


def histogram(bars: Floats) -> Ints:
    """Count lines by their bars, (BINS,); numbers beyond the range are of the last bar."""
    return np.bincount(bars.clip(0, BINS - 1).astype(int), minlength=BINS)


@dataclass
class FigureTally:
    """Counts of one limited figure over all lines."""

    name: str
    unit: str
    judged: int = 0
    over: int = 0
    worst: float = -inf
    worst_line: PlannedLine | None = None
    limits: set[float] = field(default_factory=set)
    bars: Ints = field(default_factory=lambda: np.zeros(BINS, np.intp))
    """(BINS,) lines by their distance from the limit."""

    @property
    def limit(self) -> float | None:
        """The limit, if it is the same for all lines."""
        return next(iter(self.limits)) if len(self.limits) == 1 else None

    @property
    def within(self) -> int:
        """Number of bars within the limit."""
        return 1 if self.limit == 0 else MIDDLE

    def add(
        self, lines: Sequence[CountedLine], values: Floats, limits: Floats, passed: Bools
    ) -> None:
        """Count the figure of (L,) lines."""
        self.judged += len(values)
        self.over += int(np.count_nonzero(~passed))
        worst = int(values.argmax())
        if values[worst] > self.worst:
            self.worst, self.worst_line = float(values[worst]), lines[worst].line
        self.limits |= {float(limits.min()), float(limits.max())}
        if limits[0] > 0:
            bars = np.ceil(values / limits * MIDDLE) - 1
            bars = np.where(passed, np.minimum(bars, MIDDLE - 1), np.maximum(bars, MIDDLE))
        else:
            bars = np.where(passed, 0, 1 + np.floor(values * (BINS - 1)))
        self.bars += histogram(bars)


@dataclass
class PairTally:
    """Counts of one language on one character."""

    lines: int = 0
    failed: int = 0
    over: int = 0
    aligned: int = 0
    confidence: float = 0.0
    """Sum over the aligned lines."""


class BuildTally:
    """Counts over all lines of a build, and the worst `most` lines in full."""

    def __init__(self, lines: Iterable[CountedLine], most: int = MAX_WORST) -> None:
        self.lines = self.failed = self.over = self.doubtful = self.lacking = 0
        self.pairs: dict[tuple[str, str], PairTally] = {}
        self.figures: dict[tuple[str, bool], FigureTally] = {}
        self.confidence: Ints = np.zeros(BINS, np.intp)
        """(BINS,) aligned lines by confidence."""
        # Rows of rank, two measures of badness, and the negated number of the line, so that the
        # earlier of equally bad lines is the larger row.
        ranks = [np.empty((0, 4))]
        every: dict[int, CountedLine] = {}
        for numbered in _blocks(lines):
            self.lines += len(numbered)
            # Lines with one heading have the same figures, so their values are one array.
            order = self._add([one for _, one in numbered])
            rows = np.column_stack([*order, [-number for number, _ in numbered]])
            rows = rows[np.lexsort(rows.T[::-1])[::-1][:most]]
            ranks.append(rows)
            kept = {-int(number) for number in rows[:, 3]}
            every |= {number: one for number, one in numbered if number in kept}
        ranked = np.concatenate(ranks)
        worst = ranked[np.lexsort(ranked.T[::-1])[::-1][:most]]
        self._worst = [every[-int(number)] for number in worst[:, 3]]
        self._past = int(np.count_nonzero(worst[:, 0] > 1))  # not for lacking words alone

    def _add(self, lines: Sequence[CountedLine]) -> tuple[Floats, Floats, Floats]:
        """Count (L,) lines of a pair with the same figures; return their order, (L,) each.

        Failed lines come first, then unsure ones by confidence, then those over a limit and those
        whose recording lacks words, and all by their worst figures.
        """
        values, limits, heads = unpacked_figures(lines[0].heading, [one.figures for one in lines])
        failed = np.array([one.failed for one in lines])
        stated = [nan if one.confidence is None else one.confidence for one in lines]
        confidence = np.array(stated, float)
        judged = ~(np.isnan(values) | np.isnan(limits))
        # Limits of 0 and values that are not judged divide to numbers that `where` drops.
        with np.errstate(all="ignore"):
            over = judged & (values > limits * LIMIT_FACTOR + LIMIT_STEP)
            share = np.where(
                limits > 0, values / limits, np.where(over, 1 + ZERO_SCALE * values, 0)
            )
        share = np.where(judged, share, 0.0)
        for column, (name, unit, _) in enumerate(heads):
            # A limit of 0 needs another histogram, and one measure may have both kinds.
            for zero in (False, True):
                at = np.flatnonzero(judged[:, column] & ((limits[:, column] == 0) == zero))
                if at.size:
                    tally = self.figures.setdefault((name, zero), FigureTally(name, unit))
                    own = values[at, column], limits[at, column], ~over[at, column]
                    tally.add([lines[number] for number in at.tolist()], *own)
        bad = over & np.array([binding for *_, binding in heads], bool)
        beyond, aligned = bad.any(axis=1), ~np.isnan(confidence)
        pair = self.pairs.setdefault((lines[0].line.language, lines[0].line.character), PairTally())
        pair.lines += len(lines)
        pair.failed += int(failed.sum())
        pair.over += int(beyond.sum())
        pair.aligned += int(aligned.sum())
        pair.confidence += float(confidence[aligned].sum())
        self.failed += int(failed.sum())
        self.over += int(beyond.sum())
        self.doubtful += int((over.any(axis=1) & ~failed & ~beyond).sum())
        self.confidence += histogram(np.ceil(confidence[aligned] * BINS) - 1)
        most = np.where(bad | ~beyond[:, None], share, 0.0).max(axis=1, initial=0.0)
        doubt = 1 - np.where(aligned, confidence, 1.0)
        unsure = ~failed & (doubt > 1 - DOUBTFUL)
        lacking = np.array([one.lacking for one in lines])
        self.lacking += int(lacking.sum())
        rank = np.select([failed, unsure, beyond, lacking], [4.0, 3.0, 2.0, 1.0])
        return rank, np.where(unsure, doubt, most), np.where(unsure, most, doubt)

    @cached_property
    def worst(self) -> list[BuiltLine]:
        """The worst lines first; equally bad lines stay in order."""
        return [one.whole() for one in self._worst]

    @property
    def past_limits(self) -> Iterator[BuiltLine]:
        """Yield the worst lines that exceed a limit of the project, or may have another text."""
        found = (one.whole() for one in self._worst[: self._past])
        return (one for one in found if one.failed or one.unsure)

    @property
    def aligned(self) -> int:
        """Number of lines that were aligned with a recording."""
        return sum(pair.aligned for pair in self.pairs.values())

    @property
    def unsure(self) -> int:
        """Number of lines whose recording may not hold their text."""
        return int(self.confidence[:MIDDLE].sum())

    @property
    def mean_confidence(self) -> float | None:
        """Mean confidence of the aligned lines; None if there are none."""
        whole = sum(pair.confidence for pair in self.pairs.values())
        return whole / self.aligned if self.aligned else None

    def passed(self) -> bool:
        """Return False if a line failed or exceeds a limit: the build fails."""
        return not self.failed and not self.over


def share_of_limit(figure: JudgedFigure) -> float:
    """Return the badness of a figure; 0 if it is not judged."""
    if figure.value is None or figure.limit is None:
        return 0.0
    if figure.limit > 0:
        return figure.value / figure.limit
    return 0.0 if figure.passed else 1 + ZERO_SCALE * figure.value
