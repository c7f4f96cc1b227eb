"""Charts of one report, as numbers for the templates: distribution, running total, map.

Shapes are SVG paths stretched to the available width: x in ranks, y in thousandths from the top.
Text is separate HTML, so that it keeps its size on a telephone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from math import ceil, floor, log10
from typing import NamedTuple

from lipsync_lang.base.presentation.pages import CHART_HEIGHT
from lipsync_lang.base.presentation.wording import NBSP
from lipsync_lang.reports.coverage.page.states import StateRow

SHADES, GAMMA = 9, 0.4
"""Number of shades of the map, and the exponent that separates rare bigrams."""

MAX_TICKS = 5
LATE_SHARE = 0.78
"""Share of the width from which a mark's label is on its left."""

WHOLE_SHARE = "100"
HANGING_HEIGHTS, STANDING_HEIGHTS = (0.7, 0.5, 0.3), (0.08, 0.26, 0.44)
"""End heights of the labels of marks, from the first mark on; 0 is the top."""


class Mark(NamedTuple):
    """A line at the rank where a share of all occurrences is reached."""

    class_: str
    style: str
    share: str
    rank: int


@dataclass(frozen=True)
class Chart:
    """A chart over the ranks of a report's bigrams."""

    title: str
    description: str
    width: int
    shapes: Sequence[tuple[str, str]]
    """Class and SVG path of each."""
    ticks: Sequence[tuple[str, str]]
    """Text and CSS position of each, as of `ranks`."""
    marks: Sequence[Mark]
    ranks: Sequence[tuple[str, str]]


class Cell(NamedTuple):
    """A bigram on the map."""

    number: int
    shade: int
    row: StateRow


def distribution(rows: Sequence[StateRow], codes: str, needed: Mapping[str, int]) -> Chart:
    """Chart the share of each bigram, by rank, in the colour of its status (figure 2)."""
    most = max((row["percent"] for row in rows), default=0) or 1
    step = _step(most)
    top = ceil(round(most / step, 6)) * step
    outlines = dict.fromkeys(sorted(set(codes)), "")
    rank = 0
    for code, group in groupby(zip(rows, codes, strict=True), key=lambda pair: pair[1]):
        heights = [CHART_HEIGHT - round(row["percent"] * CHART_HEIGHT / top) for row, _ in group]
        steps = "".join(f"V{height}h1" for height in heights)  # adjacent bars share a piece
        outlines[code] += f"M{rank} {CHART_HEIGHT}{steps}V{CHART_HEIGHT}z"
        # One path for each status: thousands of bars as elements of their own would slow a browser
        # down.
        rank += len(heights)
    return Chart(
        "Distribution",
        "Occurrences of each bigram, most frequent first, coloured by status.",
        len(rows),
        [(f"s{code}", outline) for code, outline in outlines.items()],
        [_tick(n * step, n * step / top) for n in range(round(top / step) + 1)],
        _marks(needed, len(rows), STANDING_HEIGHTS, standing=True),
        _ranks(len(rows)),
    )


def running(rows: Sequence[StateRow], needed: Mapping[str, int]) -> Chart:
    """Chart the running share of all occurrences, by rank."""
    line = "".join(
        f"V{CHART_HEIGHT - round(row['running'] * CHART_HEIGHT / 100)}h1" for row in rows
    )
    start = f"M0 {CHART_HEIGHT}{line}"
    return Chart(
        "Running total",
        "Share of all occurrences that the most frequent bigrams make up together.",
        len(rows),
        [("under", f"{start}V{CHART_HEIGHT}z"), ("line", start)],
        [_tick(percent, percent / 100) for percent in (0, 25, 50, 75, 100)],
        _marks(needed, len(rows), HANGING_HEIGHTS, standing=False),
        _ranks(len(rows)),
    )


def heat_map(
    rows: Sequence[StateRow], phonemes: Sequence[str]
) -> tuple[list[str], list[list[Cell | None]]]:
    """Return the axis of the map, and its cells: first phonemes down, second ones across."""
    numbers = {row["bigram"]: number for number, row in enumerate(rows)}
    named = {half for name in numbers for half in name.partition("-")[::2]}
    axis = [phoneme for phoneme in phonemes if phoneme in named]
    axis += sorted(named - set(axis))
    most = max((row["count"] for row in rows), default=0) or 1

    def cell(bigram: str) -> Cell | None:
        if bigram not in numbers:
            return None
        row = rows[numbers[bigram]]
        return Cell(numbers[bigram], ceil(SHADES * (row["count"] / most) ** GAMMA), row)

    return axis, [[cell(f"{first}-{second}") for second in axis] for first in axis]


def _step(most: float) -> float:
    """Return the smallest step of 1, 2, 5 or 10 times a power of ten with few ticks."""
    rough = most / MAX_TICKS
    size: float = 10.0 ** floor(log10(rough))
    return next(size * times for times in (1, 2, 5, 10) if size * times >= rough)


def _tick(percent: float, height: float) -> tuple[str, str]:
    return f"{percent:g}{NBSP}%", _placed(bottom=height)


def _marks(
    needed: Mapping[str, int], width: int, heights: Sequence[float], *, standing: bool
) -> list[Mark]:
    """Mark the ranks at which shares of all occurrences are reached; labels avoid other marks."""
    shares = [share for share in needed if share != WHOLE_SHARE]
    marks = []
    for share, height in zip(shares, heights, strict=False) if width else ():
        left = needed[share] / width
        end = {"top": height} if standing else {"bottom": 1 - height}
        classes = f"mark{' stands' if standing else ''}{' late' if left > LATE_SHARE else ''}"
        marks.append(Mark(classes, _placed(left=left, **end), share, needed[share]))
    return marks


def _ranks(width: int) -> list[tuple[str, str]]:
    step = max(1, round(_step(width))) if width else 1
    round_ones = (rank for rank in range(step, width, step) if 1 < rank < width - step / 2)
    ranks = dict.fromkeys((1, *round_ones, width)) if width else ()
    return [(f"{rank:,}", _placed(left=(rank - 0.5) / width)) for rank in ranks]


def _placed(**sides: float) -> str:
    return ";".join(f"{side}:{100 * share:.2f}%" for side, share in sides.items())
