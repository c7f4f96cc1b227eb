"""JUnit XML for build servers: a suite per report, a case per bigram.

The first case of a suite fails if less than the demanded share is authored. Bigrams that are not
authored are skipped, not failed. If there are several reports, a suite without bigrams comes first:
its properties are the figures of the total. Each suite has its figures as properties.
"""

from typing import TYPE_CHECKING, TextIO
from xml.etree import ElementTree as ET

from lipsync_lang.coverage.forms.report_forms import FORMS, Asked
from lipsync_lang.coverage.forms.total_text import headline
from lipsync_lang.coverage.percentages import percentage_text
from lipsync_lang.files.xml_text import xml_text

if TYPE_CHECKING:
    from lipsync_lang.coverage.report import Coverage, CoverageReport
    from lipsync_lang.coverage.total import Total, TotalFigures

COUNTS = ("tests", "failures", "errors", "skipped")


@FORMS.register("junit")
def write(coverage: "Coverage", out: TextIO, asked: Asked) -> None:
    """Write the suites."""
    top = ET.Element("testsuites", name="coverage")
    if coverage.total is not None and len(coverage.reports) > 1:
        top.append(_total(coverage.total))
    for report in coverage.reports:
        top.append(_suite(report, asked.fail_under))
    for name in COUNTS:
        top.set(name, str(sum(int(suite.get(name, "0")) for suite in top)))
    ET.indent(top)
    out.write('<?xml version="1.0" encoding="UTF-8"?>\n')
    out.write(ET.tostring(top, encoding="unicode") + "\n")


def _total(total: "Total") -> ET.Element:
    name = "all reports together"
    suite = ET.Element("testsuite", name=name, tests="1", failures="0", errors="0", skipped="0")
    _properties(suite, total)
    ET.SubElement(suite, "testcase", classname=name, name="authored")
    summary = f"{percentage_text(total.authored.percent)} of the speech is authored"
    ET.SubElement(suite, "system-out").text = xml_text(f"{headline(total)}\n{summary}")
    return suite


def _properties(suite: ET.Element, figures: "CoverageReport | TotalFigures") -> None:
    """Add the figures of a report, or of the total."""
    values: tuple[tuple[str, object], ...] = (
        ("authored_percent", figures.authored.percent),
        ("authored_bigrams", figures.authored.bigrams),
        ("left_bigrams", figures.left.bigrams),
        ("left_hours", figures.left.hours),
        ("next_hour_percent", figures.next_hour.percent),
        ("next_hour_bigrams", " ".join(figures.next_hour.bigrams)),
    )
    parent = ET.SubElement(suite, "properties")
    for name, value in values:
        ET.SubElement(parent, "property", name=name, value=xml_text(str(value)))


def _suite(report: "CoverageReport", fail_under: float | None) -> ET.Element:
    name = xml_text(f"{report.label} on {report.character}")
    failed = fail_under is not None and report.authored.percent < fail_under
    suite = ET.Element(
        "testsuite",
        name=name,
        tests=str(len(report.bigrams) + 1),
        failures=str(int(failed)),
        errors="0",
        skipped=str(report.left.bigrams),
    )
    _properties(suite, report)
    share = percentage_text(report.authored.percent)
    summary = f"{share} of {report.occurrences} occurrences are authored"
    whole = ET.SubElement(suite, "testcase", classname=name, name="authored")
    if failed:
        exact = f"{report.authored.percent:g} % are authored, under {fail_under:g} %"
        ET.SubElement(whole, "failure", message=exact)
    for one in report.bigrams:
        case = ET.SubElement(suite, "testcase", classname=name, name=one.bigram)
        if not one.authored:
            origin = f"{one.layer}, {one.status or 'unanswered'}; {one.count} times"
            ET.SubElement(case, "skipped", message=xml_text(f"{origin}: {', '.join(one.places)}"))
    unknown = [f"{one.place}: not read: {one.what} ({one.count} times)" for one in report.unread]
    unknown += [
        f"{one.place}: no map for: {one.what} ({one.count} times)" for one in report.unmapped
    ]
    unknown += [
        f"{one.place}: in another script{'' if one.counted else ', not counted'}: {one.what} "
        f"({one.count} times)"
        for one in report.other_scripts
    ]
    ET.SubElement(suite, "system-out").text = xml_text("\n".join([summary, *unknown]))
    return suite
