"""Reports of a project's build, with a page for each of its worst lines."""

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files import atomic
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.production.builds.build_run import BuildOutcome
from lipsync_lang.production.builds.build_tally import (
    BuildHeading,
    BuildTally,
    CountedLine,
    share_of_limit,
)
from lipsync_lang.production.builds.planned_line import BuiltLine
from lipsync_lang.production.builds.project_build import ProjectBuild
from lipsync_lang.production.builds.records import Key
from lipsync_lang.production.builds.report_files import write_report

MAX_PAGES = 20
"""Number of worst lines with a page of their own."""

PAGE = "html"
"""Writer of pages, and suffix of the report that links to them."""


def report(
    project: ProjectBuild,
    outcome: BuildOutcome,
    refused: Sequence[BuiltLine],
    paths: Sequence[Path],
    most: int,
) -> tuple[BuildTally, list[BuiltLine]]:
    """Write the reports of a build; return counts of all lines, and the worst past a limit.

    Lines are `refused` if the packs of their pair have faults.
    """
    lines = [*outcome.lines(), *map(CountedLine.of, refused)]
    tally = BuildTally(lines)
    if paths:
        named = "name" in project.project.model_fields_set
        heading = BuildHeading(
            project.project.name if named else project.folder.name,
            sum(one.outcome == "built" for one in outcome.built.values()),
            len(outcome.plan.steps) - len(outcome.plan.stale),
            tuple(outcome.kept),
            outcome.seconds,
        )
        linking = next((path for path in paths if path.suffix.lower() == f".{PAGE}"), None)
        pages = partial(_pages, project, outcome, linking) if linking else None
        write_report(paths, lines, heading, tally, pages=pages)
    return tally, [one for one in tally.worst if one.failed or one.unsure][:most]


def pages_folder(report: Path) -> Path:
    """Return the folder of the pages that a report links to."""
    return report.with_name(f"{report.stem}-lines")


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
