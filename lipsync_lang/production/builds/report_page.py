"""Report of a build as a self-contained HTML page, styled like the coverage page.

The page holds counts of all lines, and the worst lines in full: thousands of lines more make it no
larger. Charts are SVG with a name in words; rows are sorted and filtered by a script of its own.
"""

import os
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, TextIO
from urllib.parse import quote

from lipsync_lang.base.arrays import Ints
from lipsync_lang.base.files.quoting import shell_command
from lipsync_lang.base.presentation.pages import CHART_HEIGHT, PageEnvironment
from lipsync_lang.base.presentation.percentages import percent, percentage_text
from lipsync_lang.base.presentation.wording import NBSP, count
from lipsync_lang.production.builds.build_tally import (
    BINS,
    BuildHeading,
    BuildTally,
    FigureTally,
    share_of_limit,
)
from lipsync_lang.production.builds.planned_line import BuiltLine, JudgedFigure, PlannedLine
from lipsync_lang.production.builds.report_files import MakePages

LEAST_BAR = 60
"""Minimum height of a bar with lines, out of `CHART_HEIGHT`: one line of 20,000 is visible."""

MAX_TIMES = 3
"""Maximum number of places of a figure in a row."""

MAX_ROW_TEXT_CHARS = 160
"""Maximum length of a line's text in a row."""


class Bars(NamedTuple):
    """A histogram for the template, stretched to the available width."""

    title: str
    words: str
    """The chart in a sentence."""
    within: str
    """SVG path of the bars within the limit."""
    over: str
    """SVG path of the bars beyond it."""
    limit: float | None
    """Position of the limit as a share of the width."""
    labels: tuple[tuple[str, float], ...]
    """Text below the chart, and its position as a share of the width."""
    told: str = ""
    """Text of every bar for screen readers, if `words` have less information."""


@dataclass(frozen=True)
class WorstRow:
    """Line among the worst, ready for the template."""

    built: BuiltLine
    page: Path | None
    folder: Path

    @property
    def line(self) -> PlannedLine:
        """The plan of the line."""
        return self.built.line

    @property
    def link(self) -> str:
        """Address of the line's page, from the report; empty without one."""
        if self.page is None:
            return ""
        try:
            return quote(Path(os.path.relpath(self.page, self.folder)).as_posix())
        except ValueError:  # another drive of Windows
            return self.page.absolute().as_uri()

    @property
    def command(self) -> str:
        """Command that writes the line's page."""
        line = self.line
        parts = ["lipsync-lang", "run", "-l", line.language, "-c", line.character]
        parts += [] if line.timings is None else ["--schedule", str(line.timings)]
        parts += [] if line.audio is None else ["--audio", str(line.audio)]
        parts += ["-o", f"{line.name}.html"]
        if line.timings is None and line.text:
            parts += ["--", line.text]
        return shell_command(parts)

    @property
    def text(self) -> str:
        """The line's text, shortened."""
        text = self.line.text
        return text if len(text) <= MAX_ROW_TEXT_CHARS else f"{text[: MAX_ROW_TEXT_CHARS - 1]}…"

    @property
    def confidence(self) -> str:
        """Confidence of the alignment in percent."""
        known = self.built.confidence
        return "–" if known is None else f"{100 * known:.0f}{NBSP}%"

    @cached_property
    def shown(self) -> list[tuple[str, JudgedFigure]]:
        """The figures over their limits with a state; else the one that is nearest to its own."""
        over = [("s4", one) for one in self.built.failed]
        over += [
            ("s1", f) for f in self.built.figures if not f.passed and f not in self.built.failed
        ]
        ordered = sorted(over, key=lambda pair: -share_of_limit(pair[1]))
        if ordered or self.built.outcome == "failed":
            return ordered
        limited = [f for f in self.built.figures if share_of_limit(f) > 0]
        return [("s0", max(limited, key=share_of_limit))] if limited else []

    @property
    def names(self) -> list[str]:
        """The figures over their limits."""
        return [figure.name for state, figure in self.shown if state != "s0"]


def write_page(
    heading: BuildHeading, folder: Path, pages: MakePages | None, out: TextIO, tally: BuildTally
) -> None:
    """Write the page of a build, with links from its folder to the pages of lines."""
    worst = tally.worst
    linked = pages(worst) if pages is not None else {}
    rows = [WorstRow(one, linked.get(one.line.key), folder) for one in worst]
    figures = sorted(tally.figures.values(), key=lambda one: (-one.over, one.name))
    values = {
        "heading": heading,
        "tally": tally,
        "rows": rows,
        "figures": figures,
        "charts": [figure_bars(one) for one in figures],
        "confidence": confidence_bars(tally.confidence, tally.aligned),
        "languages": sorted({language for language, _ in tally.pairs}),
        "characters": sorted({character for _, character in tally.pairs}),
        "names": sorted({name for row in rows for name in row.names}),
        "contacts": [one for one in figures if one.name.startswith("contacts")],
    }
    out.write(REPORT_ENVIRONMENT.page("report.html", values, "report.css", "report.js"))


def figure_bars(figure: FigureTally) -> Bars:
    """Draw the distances of the lines from a limit."""
    unit = figure.unit
    words = (
        f"{count(figure.judged - figure.over, 'line')} within the limit, {figure.over:,} over; "
        f"the worst {_number(figure.worst)} {unit}".rstrip()
    )
    known = figure.limit
    ends: tuple[tuple[str, float], ...] = (("0", 0.0), ("limit", 0.5), ("twice", 1.0))
    if known == 0:
        ends = (("0", 0.5 / BINS), ("more", 0.5), ("1", 1.0))
    elif known is not None:
        ends = (("0", 0.0), (_number(known), 0.5), (_number(2 * known), 1.0))
    within, over = _paths(figure.bars, figure.within)
    return Bars(figure.name, words, within, over, figure.within / BINS, ends)


def confidence_bars(counts: Ints, aligned: int) -> Bars:
    """Draw the confidence of all aligned lines."""
    parts = [
        f"{number:,} at {100 * n // BINS} to {100 * (n + 1) // BINS}{NBSP}%"
        for n, number in enumerate(counts.tolist())
        if number
    ]
    half = counts[: BINS // 2].sum()
    words = f"{count(aligned, 'line')} aligned with recordings, {half:,} of them below 50{NBSP}%"
    path, _ = _paths(counts, BINS)
    ends = (("0", 0.0), (f"50{NBSP}%", 0.5), (f"100{NBSP}%", 1.0))
    return Bars("Confidence", words, path, "", None, ends, f"{words}: {', '.join(parts)}")


def _paths(counts: Ints, within: int) -> tuple[str, str]:
    """Return the SVG paths of the bars within a limit and beyond it; a bar is 10 wide."""
    most = counts.max() or 1
    pieces: tuple[list[str], list[str]] = ([], [])
    for number, lines in enumerate(counts.tolist()):
        if lines:
            height = max(LEAST_BAR, round(CHART_HEIGHT * lines / most))
            piece = f"M{10 * number + 1} {CHART_HEIGHT}v-{height}h8v{height}z"
            pieces[number >= within].append(piece)
    return "".join(pieces[0]), "".join(pieces[1])


def _number(value: float) -> str:
    """Write a figure with three digits, thousands in full: `0.0514`, `13`, `22,700`."""
    return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.3g}"  # noqa: PLR2004


REPORT_ENVIRONMENT = PageEnvironment(__package__, "report_templates")
REPORT_ENVIRONMENT.filters["figure"] = _number
REPORT_ENVIRONMENT.filters["share"] = lambda part, whole: percentage_text(
    percent(part, whole), NBSP
)
REPORT_ENVIRONMENT.globals |= {"HEIGHT": CHART_HEIGHT, "WIDTH": 10 * BINS, "MAX_TIMES": MAX_TIMES}
