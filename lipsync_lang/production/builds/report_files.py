"""Reports of a build: HTML, JUnit XML and JSON, by the suffix of each file, in one pass."""

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from io import TextIOWrapper
from pathlib import Path
from tempfile import TemporaryFile
from typing import TextIO

from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.files.writing import atomic, cannot_write
from lipsync_lang.base.presentation.junit import JunitCase, JunitSuite, junit_text
from lipsync_lang.production.builds.build_tally import BuildHeading, BuildTally, CountedLine
from lipsync_lang.production.builds.planned_line import BuiltLine
from lipsync_lang.production.builds.records import Key

MakePages = Callable[[Sequence[BuiltLine]], Mapping[Key, Path]]
"""Makes pages of lines, and returns them by the line's key."""

BUILD_FORMAT = "lipsync-lang build 1"


def write_report(
    paths: Iterable[Path],
    lines: Iterable[CountedLine],
    heading: BuildHeading,
    tally: BuildTally,
    *,
    pages: MakePages | None = None,
) -> None:
    """Write reports of a build; the folders of the reports are made.

    Parameters
    ----------
    paths : files to write: `.html`, `.xml` for JUnit, `.json`
    lines : all lines of the project as they stand now; read in full only for forms that name each
    pages : called with the worst lines; returns pages of lines (`-o line.html`) by the line's key

    Raises
    ------
    OutputError
        A suffix is none of these, or a file cannot be written.
    """
    writers: list[tuple[Path, Callable[[TextIO, BuildTally], None]]] = []
    adders: list[Callable[[BuiltLine], None]] = []
    for path in paths:
        suffix = path.suffix.lower()
        if suffix == ".html":
            from lipsync_lang.production.builds.report_page import write_page

            writers.append((path, partial(write_page, heading, path.parent, pages)))
        elif suffix in {".xml", ".json"}:
            form = (JunitReport if suffix == ".xml" else JsonReport)(heading)
            writers.append((path, form.write))
            adders.append(form.add)
        else:
            raise OutputError(
                f"{path}: a report cannot be written as '{suffix}'; use .html, .xml or .json"
            )
    for line in lines if adders else ():
        whole = line.whole()
        for add in adders:
            add(whole)
    for path, write in writers:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise cannot_write(path.parent, error) from None
        with atomic(path) as out:
            text = TextIOWrapper(out, "utf-8", "backslashreplace", newline="", write_through=True)
            write(text, tally)
            text.flush()
            text.detach()


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
            "kept": list(heading.kept),
            "seconds": round(heading.seconds, 3),
            "confidence": tally.mean_confidence,
            "units": {name: one.unit for (name, _), one in tally.figures.items()},
        }
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
    """

    def __init__(self, heading: BuildHeading) -> None:
        self._heading = heading
        self._kept = frozenset(heading.kept)
        self._cases: dict[str, list[JunitCase]] = {}

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

    def write(self, out: TextIO, tally: BuildTally) -> None:
        """Write the suites."""
        del tally  # cases are counted as they are written
        suites = [JunitSuite(name, cases) for name, cases in self._cases.items()]
        counts = ("tests", "errors", "failures", "skipped")
        heading = self._heading
        out.write(junit_text(suites, heading.project, counts, heading.seconds) + "\n")
