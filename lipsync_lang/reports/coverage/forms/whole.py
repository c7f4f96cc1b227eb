"""Forms that hold a whole report: JSON, a page, CSV for spreadsheets, JUnit XML for build servers.

The schema of the JSON document is `docs/reference/coverage.schema.json`. The page is one HTML file
with its style and script inside.
"""

import csv
import json
from dataclasses import replace
from typing import TextIO

from lipsync_lang.base.files.quoting import spreadsheet_text
from lipsync_lang.base.presentation.junit import JunitCase, JunitSuite, junit_text
from lipsync_lang.base.presentation.wording import percentage_text
from lipsync_lang.reports.coverage.forms import FORMS, FormOptions
from lipsync_lang.reports.coverage.forms.text import headline
from lipsync_lang.reports.coverage.report import Coverage, CoverageReport, TotalFigures
from lipsync_lang.reports.coverage.total import piece_of

CSV_HEAD = (
    "language", "character", "bigram", "count", "percent", "running", "silence", "layer", "status",
    "authored", "example", "places", "column", "poseset", "rank_for_all", "percent_for_all",
    "serves", "hours",
)  # fmt: skip


@FORMS.register("json")
def write_json(coverage: Coverage, out: TextIO, _: FormOptions) -> None:
    """Write the document."""
    # Standard output of Windows may hold no IPA, which JSON can escape.
    holds_all = (getattr(out, "encoding", None) or "utf-8").lower().startswith("utf")
    json.dump(coverage.to_dict(), out, ensure_ascii=not holds_all, indent=2)
    out.write("\n")


@FORMS.register("html")
def write_page(coverage: Coverage, out: TextIO, _: FormOptions) -> None:
    """Write the page."""
    from lipsync_lang.reports.coverage.page import page

    out.write(page(coverage.to_dict()))


@FORMS.register("csv")
def write_csv(coverage: Coverage, out: TextIO, _: FormOptions) -> None:
    """Write a row for each bigram that occurs; bigrams with silence come last.

    `rank_for_all` is the place in the ranking of all reports. A bigram that serves several reports
    has the same rank in each, and its hours in the first row alone: the sum of `hours` is the
    total. Words and file names come from the corpus, so text like a formula is quoted.
    """
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(CSV_HEAD)
    total = coverage.total
    ranks = {} if total is None else {one.piece: n for n, one in enumerate(total.ranking, 1)}
    counted: set[int] = set()
    for report in coverage.reports:
        for silence, bigrams in (("no", report.bigrams), ("yes", report.silence)):
            for one in bigrams:
                rank = ranks.get(piece_of(report, one), 0) if silence == "no" else 0
                cells: tuple[object, ...] = ("", "", "", "")
                if rank and total is not None and not one.authored:
                    item = total.ranking[rank - 1]
                    hours = 0 if rank in counted else round(coverage.minutes / 60, 4)
                    counted.add(rank)
                    cells = (rank, item.percent, " ".join(item.languages), hours)
                row = (
                    report.language, report.character, one.bigram, one.count, one.percent,
                    one.running, silence, one.layer, one.status, "yes" if one.authored else "no",
                    one.example, " ".join(one.places), report.column, report.poseset, *cells,
                )  # fmt: skip
                # Python's writer does not quote a carriage return, and readers end a row at it.
                rows.writerow(
                    spreadsheet_text(cell).replace("\r\n", "\n").replace("\r", "\n")
                    if isinstance(cell, str)
                    else cell
                    for cell in row
                )


@FORMS.register("junit")
def write_junit(coverage: Coverage, out: TextIO, options: FormOptions) -> None:
    """Write a suite for each report, and one of the total if there are several; a case per bigram.

    The first case of a suite fails if less than the demanded share is authored. Bigrams that are
    not authored are skipped, not failed. Each suite has its figures as properties.
    """
    suites = [_suite(report, options.fail_under) for report in coverage.reports]
    if coverage.total is not None and len(suites) > 1:
        name = "all reports together"
        summary = f"{percentage_text(coverage.total.authored.percent)} of the speech is authored"
        output = f"{headline(coverage.total)}\n{summary}"
        cases = [JunitCase(name, "authored")]
        suites.insert(0, JunitSuite(name, cases, _properties(coverage.total), output))
    out.write(junit_text(suites, "coverage") + "\n")


def _properties(figures: CoverageReport | TotalFigures) -> dict[str, object]:
    """Return the figures of a report, or of the total."""
    return {
        "authored_percent": figures.authored.percent,
        "authored_bigrams": figures.authored.bigrams,
        "left_bigrams": figures.left.bigrams,
        "left_hours": figures.left.hours,
        "next_hour_percent": figures.next_hour.percent,
        "next_hour_bigrams": " ".join(figures.next_hour.bigrams),
    }


def _suite(report: CoverageReport, fail_under: float | None) -> JunitSuite:
    name = f"{report.label} on {report.character}"
    share = report.authored.percent
    whole = JunitCase(name, "authored")
    if fail_under is not None and share < fail_under:
        exact = f"{share:g} % are authored, under {fail_under:g} %"
        whole = JunitCase(name, "authored", "failure", exact)
    cases = [whole]
    for one in report.bigrams:
        origin = f"{one.layer}, {one.status or 'unanswered'}; {one.count} times"
        reason = f"{origin}: {', '.join(one.places)}"
        case = JunitCase(name, one.bigram)
        cases.append(case if one.authored else replace(case, outcome="skipped", message=reason))
    found = [(one, "not read") for one in report.unread]
    found += [(one, "no map for") for one in report.unmapped]
    for word in report.other_scripts:
        found.append((word, f"in another script{'' if word.counted else ', not counted'}"))
    lines = [f"{percentage_text(share)} of {report.occurrences} occurrences are authored"]
    lines += [f"{one.place}: {problem}: {one.what} ({one.count} times)" for one, problem in found]
    return JunitSuite(name, cases, _properties(report), "\n".join(lines))
