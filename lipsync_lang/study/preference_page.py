"""Report of a study as a self-contained HTML page, styled like the coverage page.

Plots are SVG stretched to the available width, each with a text name. The page has no script.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, NamedTuple

from lipsync_lang.reports.pages import PageEnvironment
from lipsync_lang.reports.wording import NBSP
from lipsync_lang.study import study_text
from lipsync_lang.study.answer_sorting import reasons
from lipsync_lang.study.bradley_terry import Ranking
from lipsync_lang.study.comparisons import Comparison
from lipsync_lang.study.distributions import Interval
from lipsync_lang.study.study_report import StudyReport
from lipsync_lang.study.study_text import EVERYBODY

PLOT_WIDTH = 1000
"""Width of a plot in units of the plot."""

MAX_PAGE_NAMED = 200
"""Maximum number of single faults on the page."""

WEAKEST, STRONGEST = 1, 5
"""Ends of the scale of strength."""


class Dot(NamedTuple):
    """A value with its interval, in units of a plot's width."""

    class_: str
    at: float
    interval: tuple[float, float] | None
    """Start and length."""
    height: int = 10
    """Height of its middle, 0 to 20 from the top."""


@dataclass(frozen=True)
class PlotRow:
    """A row of a plot: a name, values with intervals, and their text."""

    label: str
    words: str
    dots: tuple[Dot, ...]


@dataclass(frozen=True)
class Plot:
    """A plot of rows over one scale."""

    title: str
    caption: str
    rows: tuple[PlotRow, ...]
    ticks: tuple[tuple[str, float], ...]
    """Text and position of each mark, in percent of the width; the vertical line is at 50."""


def report_page(report: StudyReport) -> str:
    """Return the page."""
    found = reasons(report.answers.set_aside)
    values = {
        "report": report,
        "answers": report.answers,
        "pairs": _pairs(report),
        "rankings": [(one, _strength_plot(one)) for one in report.rankings],
        "heads": _pairs(report) if not report.rankings else [],
        "best": {one.question: one for one in report.rankings if one.methods},
        "aside": found,
        "rules": report.rules.words,
        "named": report.answers.set_aside[:MAX_PAGE_NAMED],
        "whole": sum(whole for whole, _ in found.values()),
    }
    return _environment().page("study_report.html", values, "study_report.css")


def _pairs(report: StudyReport) -> list[dict[str, Any]]:
    """Return views of two methods on one question for the template."""
    keys = dict.fromkeys((one.question, one.first, one.second) for one in report.comparisons)
    views = []
    for question, first, second in keys:
        rows = tuple(
            one
            for one in report.comparisons
            if (one.question, one.first, one.second) == (question, first, second)
        )
        view = {"question": question, "first": first, "second": second, "rows": rows}
        views.append({**view, "shares": _shares(rows), "strengths": _strengths(rows)})
    return views


def _shares(rows: Sequence[Comparison]) -> Plot:
    """Plot the share of the first method, 0 to 100 %."""
    first, second = rows[0].first, rows[0].second
    drawn = tuple(
        PlotRow(
            one.character or EVERYBODY,
            _percents(one.share, one.clustering.interval or one.interval),
            (_dot("first", one.share, one.clustering.interval or one.interval, 0, 1),),
        )
        for one in rows
    )
    return Plot(
        f"Choices for {first}",
        f"Values to the right of the line favour {first}, those to the left {second}. Bars are "
        f"95{NBSP}% intervals by raters.",
        drawn,
        tuple((f"{part}{NBSP}%", float(part)) for part in (0, 25, 50, 75, 100)),
    )


def _strengths(rows: Sequence[Comparison]) -> Plot:
    """Plot the mean strengths of the preferences for both methods."""
    first, second = rows[0].first, rows[0].second

    def dots(one: Comparison) -> tuple[Dot, ...]:
        both = (("first", one.strength_of_first, 6), ("second", one.strength_of_second, 14))
        return tuple(
            _dot(class_, mean.mean, mean.interval, WEAKEST, STRONGEST)._replace(height=height)
            for class_, mean, height in both
            if mean
        )

    def words(one: Comparison) -> str:
        both = (one.strength_of_first, one.strength_of_second)
        return " / ".join(f"{mean.mean:.2f}" if mean else "–" for mean in both)

    return Plot(
        "Mean strength",
        f"Strength of the preferences for {first} (filled) and for {second} (open), from 1 (weak) "
        "to 5 (strong).",
        tuple(PlotRow(one.character or EVERYBODY, words(one), dots(one)) for one in rows),
        tuple((str(n), 100 * _part(n, WEAKEST, STRONGEST)) for n in range(WEAKEST, STRONGEST + 1)),
    )


def _strength_plot(ranking: Ranking) -> Plot | None:
    """Plot the strengths of several methods; None if there are none."""
    if not ranking.methods:
        return None
    ends = [one.interval or Interval(one.strength, one.strength) for one in ranking.methods]
    most = max(0.5, *(abs(end) for interval in ends for end in interval))
    rows = tuple(
        PlotRow(
            one.method,
            f"{one.strength:+.2f}",
            (_dot("first", one.strength, one.interval, -most, most),),
        )
        for one in ranking.methods
    )
    return Plot(
        f"{ranking.question.capitalize()}, {ranking.character or EVERYBODY}",
        "",
        rows,
        ((f"{-most:.2g}", 0.0), ("0", 50.0), (f"{most:+.2g}", 100.0)),
    )


def _dot(class_: str, at: float, interval: Interval | None, low: float, high: float) -> Dot:
    ends = None
    if interval is not None:
        left, right = (min(max(_part(end, low, high), 0), 1) for end in interval)
        ends = (round(PLOT_WIDTH * left, 1), round(PLOT_WIDTH * (right - left), 1))
    return Dot(class_, round(PLOT_WIDTH * _part(at, low, high), 1), ends)


def _part(value: float, low: float, high: float) -> float:
    return (value - low) / (high - low)


def _percents(share: float, interval: Interval) -> str:
    return (
        f"{100 * share:.0f}{NBSP}% ({100 * interval.low:.0f} to {100 * interval.high:.0f}{NBSP}%)"
    )


@cache
def _environment() -> PageEnvironment:
    environment = PageEnvironment(__package__, "report_templates")
    environment.globals |= {
        "WIDTH": PLOT_WIDTH,
        "EVERYBODY": EVERYBODY,
        "percents": study_text.percents,
        "percent": study_text.percent,
        "probability": study_text.probability,
        "equal_strengths": study_text.equal_strengths,
        "strength": lambda mean: study_text.strength(mean).replace("-", "–"),
        "share_in_words": _percents,
    }
    return environment
