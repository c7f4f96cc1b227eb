"""Reports of a build: HTML with pages of the worst lines, JUnit XML and JSON, in one pass.

The HTML page holds counts of all lines, and the worst lines in full: thousands of lines more make
it no larger. Charts are SVG with a name in words; rows are sorted and filtered by a script of its
own.
"""

import json
import os
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from io import TextIOWrapper
from pathlib import Path
from shutil import copyfileobj
from tempfile import TemporaryFile
from typing import BinaryIO, NamedTuple, TextIO
from urllib.parse import quote

from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.base.arrays import Ints
from lipsync_lang.base.errors import LipsyncError, OutputError, count
from lipsync_lang.base.files.quoting import shell_command
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.base.files.reading import read_blocks
from lipsync_lang.base.files.writing import atomic, cannot_write
from lipsync_lang.base.presentation.junit import JunitCase, JunitSuite, junit_text
from lipsync_lang.base.presentation.pages import CHART_HEIGHT, PageEnvironment
from lipsync_lang.base.presentation.wording import NBSP, percent, percentage_text
from lipsync_lang.production.builds.build_run import BuildOutcome
from lipsync_lang.production.builds.build_tally import (
    BINS,
    BuildHeading,
    BuildTally,
    CountedLine,
    FigureTally,
    share_of_limit,
)
from lipsync_lang.production.builds.planned_line import BuiltLine, JudgedFigure, PlannedLine
from lipsync_lang.production.builds.project_build import ProjectBuild
from lipsync_lang.production.builds.records import Key
from lipsync_lang.production.builds.unchanged import pages_folder

MAX_PAGES = 20
"""Number of worst lines with a page of their own."""

PAGE = "html"
"""Writer of pages, and suffix of the report that links to them."""

MakePages = Callable[[Sequence[BuiltLine]], Mapping[Key, Path]]
"""Makes pages of lines, and returns them by the line's key."""

BUILD_FORMAT = "lipsync-lang build 1"

LEAST_BAR = 60
"""Minimum height of a bar with lines, out of `CHART_HEIGHT`: one line of 20,000 is visible."""

MAX_TIMES = 3
"""Maximum number of places of a figure in a row."""

MAX_ROW_TEXT_CHARS = 160
"""Maximum length of a line's text in a row."""

REPORT_ENVIRONMENT = PageEnvironment(__package__, "report_templates")

REPORT_ENVIRONMENT.filters["share"] = lambda part, whole: percentage_text(
    percent(part, whole), NBSP
)


def report(
    project: ProjectBuild,
    outcome: BuildOutcome,
    lines: Iterable[CountedLine],
    tally: BuildTally,
    paths: Sequence[Path],
) -> None:
    """Write the reports of a build of some lines, with pages of the worst ones."""
    named = "name" in project.project.model_fields_set
    heading = BuildHeading(
        project.project.name if named else project.folder.name,
        sum(one.verdict != "failed" for one in outcome.built.values()),
        len(outcome.plan.steps) - len(outcome.plan.stale),
        tuple(outcome.kept),
        outcome.seconds,
    )
    linking = next((path for path in paths if path.suffix.lower() == f".{PAGE}"), None)
    pages = partial(_pages, project, outcome, linking) if linking else None
    write_report(paths, lines, heading, tally, pages=pages)


def _pages(
    project: ProjectBuild, outcome: BuildOutcome, report: Path, worst: Sequence[BuiltLine]
) -> dict[Key, Path]:
    """Write the pages of the worst lines beside a report; pages of unchanged lines are kept."""
    folder = pages_folder(report)
    pages: dict[Key, Path] = {}
    for built in worst[:MAX_PAGES]:
        line = built.line
        if built.outcome == "failed" or max(map(share_of_limit, built.figures), default=0) <= 1:
            continue
        path = folder / line.language / line.character / f"{line.name}.{PAGE}"
        refuse_outside(path, project.folder, [report.parent])
        if line.key in outcome.built or not path.exists():
            try:
                pair = project.pairs[line.language, line.character]
                shown = pair.performer.rigged(project.maker.animation(line, pair))
                path.parent.mkdir(parents=True, exist_ok=True)
                with atomic(path) as stream:
                    WRITERS[PAGE].write(shown, stream)
                outcome.remarks |= dict.fromkeys(WRITERS[PAGE].remarks(shown))
            except (LipsyncError, OSError):
                continue  # the report names the line without a page
        pages[line.key] = path
    return pages


def write_report(
    paths: Iterable[Path],
    lines: Iterable[CountedLine],
    heading: BuildHeading,
    tally: BuildTally,
    *,
    pages: MakePages | None = None,
) -> None:
    """Write reports of a build; the folders of the reports are made.

    Raises OutputError if a suffix is none of these, or a file cannot be written.

    Parameters
    ----------
    paths : files to write: `.html`, `.xml` for JUnit, `.json`
    lines : all lines of the project as they stand now; read in full only for forms that name each
    pages : called with the worst lines; returns pages of lines (`-o line.html`) by the line's key
    """
    writers: list[tuple[Path, Callable[[TextIO, BuildTally], None]]] = []
    adders: list[Callable[[BuiltLine], None]] = []
    for path in paths:
        suffix = path.suffix.lower()
        if suffix == ".html":
            writers.append((path, partial(write_page, heading, path.parent, pages)))
        elif suffix in {".xml", ".json"}:
            form = (JunitReport if suffix == ".xml" else JsonReport)(heading)
            writers.append((path, form.write))
            adders.append(form.add)
        else:
            raise OutputError(
                f"{path}: a report cannot be written as '{suffix}'; use .html, .xml or .json"
            )
    # One pass for all forms: a line of an earlier build is read from the record each time.
    for line in lines if adders else ():
        whole = line.whole()
        for add in adders:
            add(whole)
    for path, write in writers:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise cannot_write(path.parent, error) from None
        with TemporaryFile() as made:
            text = TextIOWrapper(made, "utf-8", "backslashreplace", newline="")
            write(text, tally)
            text.detach()
            _put(path, made)


def _put(path: Path, made: BinaryIO) -> None:
    """Write a file, unless it has this content already: its folder keeps its time then."""
    size = made.tell()
    made.seek(0)
    with suppress(OSError):
        if path.is_file() and path.stat().st_size == size:
            # A file that a build opens to read is an input of it.
            with path.open("r+b") as old:
                if all(block == made.read(len(block)) for block in read_blocks(old, size)):
                    return
    made.seek(0)
    with atomic(path) as out:
        copyfileobj(made, out)


class JsonReport:
    """The whole report as JSON; lines wait on the disk, since there may be a million."""

    def __init__(self, heading: BuildHeading) -> None:
        self._heading = heading
        self._rows = TemporaryFile("w+", encoding="utf-8", newline="\n")  # noqa: SIM115 ends with us

    def add(self, line: BuiltLine) -> None:
        """Add a line."""
        plan = line.line
        row = {
            "language": plan.language,
            "character": plan.character,
            "line": plan.name,
            "place": plan.place,
            "outcome": line.outcome,
            "message": line.message,
            "seconds": round(line.seconds, 4),
            "confidence": line.confidence,
            "figures": {one.name: {"value": one.value, "limit": one.limit} for one in line.figures},
            "failed": [figure.name for figure in line.failed],
            "left_out": list(line.left_out),
        }
        self._rows.write(f"{json.dumps(row, ensure_ascii=True)}\n")

    def write(self, out: TextIO, tally: BuildTally) -> None:
        """Write counts, then a row per line."""
        heading = self._heading
        head = {
            "format": BUILD_FORMAT,
            "project": heading.project,
            "passed": tally.passed(),
            "lines": tally.lines,
            "built": heading.built,
            "up_to_date": heading.up_to_date,
            "failed": tally.failed,
            "over_limit": tally.over,
            "doubtful": tally.doubtful,
            "lacking": tally.lacking,
            "kept": list(heading.kept),
            "seconds": round(heading.seconds, 3),
            "confidence": tally.mean_confidence,
            "units": {name: one.unit for (name, _), one in tally.figures.items()},
        }
        # The rows are JSON on the disk already, so they are put before the head's closing brace.
        out.write(json.dumps(head, indent=1)[:-2] + ',\n "rows": [')
        self._rows.seek(0)
        out.writelines(
            f"{',' if number else ''}\n  {row.rstrip()}" for number, row in enumerate(self._rows)
        )
        out.write("\n ]\n}\n")
        self._rows.close()


class JunitReport:
    """JUnit XML for build servers: a suite per language and character, a case per line.

    A line that failed is an error, one over a limit a failure.
    A line is skipped if one of its outputs was left alone, because somebody changed it.
    The output of a suite lists the words that recordings lack.
    """

    def __init__(self, heading: BuildHeading) -> None:
        self._heading = heading
        self._kept = frozenset(heading.kept)
        self._cases: dict[str, list[JunitCase]] = {}
        self._left_out: dict[str, list[str]] = defaultdict(list)

    def add(self, line: BuiltLine) -> None:
        """Add the case of a line."""
        suite = f"{line.line.language} on {line.line.character}"
        name, place = line.line.name, line.line.place
        kept = [path for _, path in line.line.outputs if path in self._kept]
        case = JunitCase(suite, name, file=place.rpartition(":")[0])
        if line.outcome == "failed":
            case = replace(case, outcome="error", message=line.message)
        elif line.failed:
            limited, detail = [], place
            for figure in line.failed:
                amount = f"{figure.name} {figure.value:.4g} {figure.unit}".rstrip()
                limited.append(f"{amount}, at most {figure.limit:g}")
                times = ", ".join(f"{at:.3f} s" for at in figure.at)
                detail += f"\n{figure.name}: {': '.join(filter(None, (times, figure.words)))}"
            case = replace(case, outcome="failure", message="; ".join(limited), detail=detail)
        elif kept:
            message = f"kept, because it was changed: {', '.join(kept)}"
            case = replace(case, outcome="skipped", message=message)
        self._cases.setdefault(suite, []).append(case)
        if line.left_out:
            self._left_out[suite].append(f"{place}: {name} lacks {', '.join(line.left_out)}")

    def write(self, out: TextIO, _: BuildTally) -> None:
        """Write the suites; cases are counted as they are written."""
        suites = [
            JunitSuite(name, cases, output="\n".join(self._left_out[name]))
            for name, cases in self._cases.items()
        ]
        counts = ("tests", "errors", "failures", "skipped")
        out.write(junit_text(suites, self._heading.project, counts, self._heading.seconds) + "\n")


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
        over = [("s4" if f.binding else "s1", f) for f in self.built.figures if not f.passed]
        ordered = sorted(over, key=lambda one: (-share_of_limit(one[1]), not one[1].binding))
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
        f"{count(figure.judged - figure.over, 'line', space=NBSP)} within the limit, "
        f"{figure.over:,} over; "
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
    lines = count(aligned, "line", space=NBSP)
    words = f"{lines} aligned with recordings, {half:,} of them below 50{NBSP}%"
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


REPORT_ENVIRONMENT.filters["figure"] = _number
REPORT_ENVIRONMENT.globals |= {"HEIGHT": CHART_HEIGHT, "WIDTH": 10 * BINS, "MAX_TIMES": MAX_TIMES}
