"""Counts over all lines of a build, and the worst lines, in constant memory.

The badness of a figure is its value as a share of its limit: above 1 it is exceeded. A limit of 0
has no shares; its figures have 1 and more, by their value.
"""

import heapq
from dataclasses import dataclass, field
from math import ceil, inf

from lipsync_lang.build.planned_line import BuiltLine, JudgedFigure, Verdict

BINS = 20
"""Number of bars of a histogram; for a figure with a limit, half of them are within it."""

MIDDLE = BINS // 2

MAX_WORST = 500
"""Maximum number of lines that a report shows in full; it counts all others."""

UNSHOWN: frozenset[Verdict] = frozenset(("passed", "doubted"))
"""Verdicts of lines that are counted; a build without a report does not name them."""

ZERO_SCALE = 10
"""Badness of a value of 1 if the limit is 0."""


@dataclass(frozen=True)
class BuildHeading:
    """Counts of a build as a whole, for the head of its reports."""

    project: str
    built: int
    """Lines made by this build."""
    up_to_date: int
    failed: int
    kept: tuple[str, ...] = ()
    """Outputs that were left alone, because somebody changed them."""
    seconds: float = 0.0


@dataclass
class Histogram:
    """Counts of lines by value."""

    counts: list[int] = field(default_factory=lambda: [0] * BINS)

    def add(self, number: int) -> None:
        """Count a line in a bar; values beyond the range are in the last one."""
        self.counts[min(max(number, 0), BINS - 1)] += 1


@dataclass
class FigureTally:
    """Counts of one limited figure over all lines."""

    name: str
    unit: str
    judged: int = 0
    over: int = 0
    worst: float = -inf
    worst_line: BuiltLine | None = None
    limits: set[float] = field(default_factory=set)
    histogram: Histogram = field(default_factory=Histogram)

    @property
    def limit(self) -> float | None:
        """The limit, if it is the same for all lines."""
        return next(iter(self.limits)) if len(self.limits) == 1 else None

    @property
    def within(self) -> int:
        """Number of bars within the limit."""
        return 1 if self.limit == 0 else MIDDLE

    def add(self, line: BuiltLine, value: float, limit: float, *, passed: bool) -> None:
        """Count the figure of a line."""
        self.judged += 1
        self.over += not passed
        if value > self.worst:
            self.worst, self.worst_line = value, line
        if limit not in self.limits and len(self.limits) < 2:  # noqa: PLR2004 a second limit means that they vary
            self.limits.add(limit)
        if limit > 0:
            bar = ceil(value / limit * MIDDLE) - 1
            bar = min(bar, MIDDLE - 1) if passed else max(bar, MIDDLE)
        else:
            bar = 0 if passed else 1 + int(value * (BINS - 1))
        self.histogram.add(bar)


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

    def __init__(self, most: int = MAX_WORST) -> None:
        self.most = most
        self.lines = self.failed = self.over = self.doubtful = 0
        self.pairs: dict[tuple[str, str], PairTally] = {}
        self.figures: dict[tuple[str, bool], FigureTally] = {}
        self.confidence = Histogram()
        self._worst: list[tuple[tuple[float, float, float], int, BuiltLine]] = []

    def add(self, line: BuiltLine) -> None:
        """Count a line."""
        self.lines += 1
        exceeded = False
        for figure in line.figures:
            value, limit = figure.value, figure.limit
            if value is None or limit is None:
                continue
            passed = figure.passed
            exceeded = exceeded or not passed
            key = figure.name, limit == 0
            counted = self.figures.get(key)
            if counted is None:
                counted = self.figures[key] = FigureTally(figure.name, figure.unit)
            counted.add(line, value, limit, passed=passed)
        failed = line.outcome == "failed"
        over = not failed and exceeded and bool(line.failed)
        pair = self.pairs.setdefault((line.line.language, line.line.character), PairTally())
        pair.lines += 1
        pair.failed += failed
        pair.over += over
        self.failed += failed
        self.over += over
        self.doubtful += exceeded and not failed and not over
        if line.confidence is not None:
            pair.aligned += 1
            pair.confidence += line.confidence
            self.confidence.add(ceil(line.confidence * BINS) - 1)
        entry = (badness(line), -self.lines, line)
        if len(self._worst) < self.most:
            heapq.heappush(self._worst, entry)
        elif self.most and entry[:2] > self._worst[0][:2]:
            heapq.heapreplace(self._worst, entry)

    def add_unshown(self, verdict: Verdict) -> None:
        """Count a line of no report by its verdict, one of `UNSHOWN`, without its figures."""
        self.lines += 1
        self.doubtful += verdict == "doubted"

    def worst(self) -> list[BuiltLine]:
        """Return the worst lines first; equally bad lines stay in order."""
        ordered = sorted(self._worst, key=lambda entry: entry[:2], reverse=True)
        return [line for _, _, line in ordered]

    @property
    def aligned(self) -> int:
        """Number of lines that were aligned with a recording."""
        return sum(pair.aligned for pair in self.pairs.values())

    @property
    def unsure(self) -> int:
        """Number of lines whose recording may not hold their text."""
        return sum(self.confidence.counts[:MIDDLE])

    @property
    def mean_confidence(self) -> float | None:
        """Mean confidence of the aligned lines; None if there are none."""
        whole = sum(pair.confidence for pair in self.pairs.values())
        return whole / self.aligned if self.aligned else None

    def passed(self) -> bool:
        """Return False if a line failed or exceeds a limit: the build fails."""
        return not self.failed and not self.over


def badness(line: BuiltLine) -> tuple[float, float, float]:
    """Return an order of lines: failed ones, unsure ones by confidence, then by worst figures."""
    failed = line.failed
    confidence = 1.0 if line.confidence is None else line.confidence
    most = max(map(share_of_limit, failed or line.figures), default=0.0)
    if line.unsure and line.outcome != "failed":
        return 2.0, 1 - confidence, most
    return 3.0 if line.outcome == "failed" else 1.0 if failed else 0.0, most, 1 - confidence


def share_of_limit(figure: JudgedFigure) -> float:
    """Return the badness of a figure; 0 if it is not judged."""
    if figure.value is None or figure.limit is None:
        return 0.0
    if figure.limit > 0:
        return figure.value / figure.limit
    return 0.0 if figure.passed else 1 + ZERO_SCALE * figure.value
