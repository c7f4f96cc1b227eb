"""JUnit XML for build servers: a suite per report, a case per bigram.

The first case of a suite fails if less than the demanded share is authored. Bigrams that are not
authored are skipped, not failed.
"""

from typing import TYPE_CHECKING, TextIO
from xml.etree import ElementTree as ET

from lipsync_lang.coverage.forms.report_forms import FORMS, Asked
from lipsync_lang.files.xml_text import xml_text

if TYPE_CHECKING:
    from lipsync_lang.coverage.report import Coverage, CoverageReport


@FORMS.register("junit")
def write(coverage: "Coverage", out: TextIO, asked: Asked) -> None:
    """Write the suites."""
    top = ET.Element("testsuites", name="coverage")
    for report in coverage.reports:
        top.append(_suite(report, asked.fail_under))
    ET.indent(top)
    out.write('<?xml version="1.0" encoding="UTF-8"?>\n')
    out.write(ET.tostring(top, encoding="unicode") + "\n")


def _suite(report: "CoverageReport", fail_under: float | None) -> ET.Element:
    name = f"{report.label} on {report.character}"
    failed = fail_under is not None and report.authored.percent < fail_under
    suite = ET.Element(
        "testsuite",
        name=name,
        tests=str(len(report.bigrams) + 1),
        failures=str(int(failed)),
        errors="0",
        skipped=str(report.left.bigrams),
    )
    summary = f"{report.authored.percent:g} % of {report.occurrences} occurrences are authored"
    whole = ET.SubElement(suite, "testcase", classname=name, name="authored")
    if failed:
        ET.SubElement(whole, "failure", message=f"{summary}, under {fail_under:g} %")
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
