"""Report of a study as a self-contained HTML page, styled like the coverage page.

Plots are SVG stretched to the available width, each with a text name. The page has no script.
"""

from collections.abc import Sequence
from functools import cache
from typing import Any

from lipsync_lang.base.presentation.pages import PageEnvironment
from lipsync_lang.plugins.study import study_text
from lipsync_lang.plugins.study.answer_sorting import reasons
from lipsync_lang.plugins.study.bradley_terry import Ranking
from lipsync_lang.plugins.study.comparisons import Comparison, Interval
from lipsync_lang.plugins.study.study_report import StudyReport
from lipsync_lang.plugins.study.study_text import EVERYBODY

NBSP = "\N{NO-BREAK SPACE}"

PLOT_WIDTH = 1000

MAX_PAGE_NAMED = 200
"""Maximum number of single faults on the page."""

WEAKEST, STRONGEST = 1, 5
"""Ends of the scale of strength."""


Plotted = dict[str, Any]
"""A plot for the template: title, caption, rows of label, words and dots, and ticks.

A tick is a text with its place in percent of the width; the vertical line is at 50.
"""


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
    views = []
    for (question, first, second), rows in report.by_pair().items():
        view = {"question": question, "first": first, "second": second, "rows": rows}
        views.append({**view, "shares": _shares(rows), "strengths": _strengths(rows)})
    return views


def _shares(rows: Sequence[Comparison]) -> Plotted:
    """Plot the share of the first method, 0 to 100 %."""
    first, second = rows[0].first, rows[0].second
    drawn = []
    for one in rows:
        around = one.clustering.interval or one.interval
        dots = [_dot("first", one.share, around, 0, 1)]
        drawn.append(_row(one.character, _percents(one.share, around), dots))
    return {
        "title": f"Choices for {first}",
        "caption": f"Values to the right of the line favour {first}, those to the left {second}. "
        f"Bars are 95{NBSP}% intervals by raters.",
        "rows": drawn,
        "ticks": [(f"{part}{NBSP}%", float(part)) for part in (0, 25, 50, 75, 100)],
    }


def _strengths(rows: Sequence[Comparison]) -> Plotted:
    """Plot the mean strengths of the preferences for both methods."""
    drawn = []
    for one in rows:
        both = (("first", one.strength_of_first, 6), ("second", one.strength_of_second, 14))
        words = " / ".join(f"{mean.mean:.2f}" if mean else "–" for _, mean, _ in both)
        dots = [
            _dot(class_, mean.mean, mean.interval, WEAKEST, STRONGEST) | {"height": height}
            for class_, mean, height in both
            if mean
        ]
        drawn.append(_row(one.character, words, dots))
    scale = range(WEAKEST, STRONGEST + 1)
    return {
        "title": "Mean strength",
        "caption": f"Strength of the preferences for {rows[0].first} (filled) and for "
        f"{rows[0].second} (open), from 1 (weak) to 5 (strong).",
        "rows": drawn,
        "ticks": [(str(n), 100 * _part(n, WEAKEST, STRONGEST)) for n in scale],
    }


def _strength_plot(ranking: Ranking) -> Plotted | None:
    """Plot the strengths of several methods; None if there are none."""
    if not ranking.methods:
        return None
    ends = [one.interval or Interval(one.strength, one.strength) for one in ranking.methods]
    most = max(0.5, *(abs(end) for interval in ends for end in interval))
    rows = []
    for one in ranking.methods:
        dots = [_dot("first", one.strength, one.interval, -most, most)]
        rows.append(_row(one.method, f"{one.strength:+.2f}", dots))
    return {
        "title": f"{ranking.question.capitalize()}, {ranking.character or EVERYBODY}",
        "caption": "",
        "rows": rows,
        "ticks": [(f"{-most:.2g}", 0.0), ("0", 50.0), (f"{most:+.2g}", 100.0)],
    }


def _row(label: str, words: str, dots: list[Plotted]) -> Plotted:
    return {"label": label or EVERYBODY, "words": words, "dots": dots}


def _dot(class_: str, at: float, interval: Interval | None, low: float, high: float) -> Plotted:
    """Return a value with its interval (start and length), in units of a plot's width.

    The height of its middle is 0 to 20 from the top.
    """
    ends = None
    if interval is not None:
        left, right = (min(max(_part(end, low, high), 0), 1) for end in interval)
        ends = (round(PLOT_WIDTH * left, 1), round(PLOT_WIDTH * (right - left), 1))
    place = round(PLOT_WIDTH * _part(at, low, high), 1)
    return {"class_": class_, "at": place, "interval": ends, "height": 10}


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
