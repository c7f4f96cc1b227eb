"""JUnit XML for build servers: a suite per report, a case per bigram.

The first case of a suite fails if less than the demanded share is authored. Bigrams that are not
authored are skipped, not failed. If there are several reports, a suite without bigrams comes first:
its properties are the figures of the total. Each suite has its figures as properties.
"""

from dataclasses import replace
from typing import TYPE_CHECKING, TextIO

from lipsync_lang.base.presentation.junit import JunitCase, JunitSuite, junit_text
from lipsync_lang.base.presentation.wording import percentage_text
from lipsync_lang.reports.coverage.forms import FORMS, FormOptions
from lipsync_lang.reports.coverage.forms.text import headline

if TYPE_CHECKING:
    from lipsync_lang.reports.coverage.report import Coverage, CoverageReport, TotalFigures


@FORMS.register("junit")
def write(coverage: "Coverage", out: TextIO, options: FormOptions) -> None:
    """Write the suites."""
    suites = [_suite(report, options.fail_under) for report in coverage.reports]
    if coverage.total is not None and len(suites) > 1:
        name = "all reports together"
        summary = f"{percentage_text(coverage.total.authored.percent)} of the speech is authored"
        output = f"{headline(coverage.total)}\n{summary}"
        cases = [JunitCase(name, "authored")]
        suites.insert(0, JunitSuite(name, cases, _properties(coverage.total), output))
    out.write(junit_text(suites, "coverage") + "\n")


def _properties(figures: "CoverageReport | TotalFigures") -> dict[str, object]:
    """Return the figures of a report, or of the total."""
    return {
        "authored_percent": figures.authored.percent,
        "authored_bigrams": figures.authored.bigrams,
        "left_bigrams": figures.left.bigrams,
        "left_hours": figures.left.hours,
        "next_hour_percent": figures.next_hour.percent,
        "next_hour_bigrams": " ".join(figures.next_hour.bigrams),
    }


def _suite(report: "CoverageReport", fail_under: float | None) -> JunitSuite:
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
