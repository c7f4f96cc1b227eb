"""JUnit XML for build servers: a suite per report, a case per bigram.

The first case of a suite fails if less than the demanded share is authored. Bigrams that are not
authored are skipped, not failed.
"""

import re
from typing import TYPE_CHECKING, TextIO
from xml.etree import ElementTree as ET

from lipsync_lang.coverage.forms.report_forms import FORMS, Asked

if TYPE_CHECKING:
    from lipsync_lang.coverage.report import Coverage, CoverageReport

FORBIDDEN = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML cannot hold."""


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
            ET.SubElement(case, "skipped", message=_xml_text(f"{origin}: {', '.join(one.places)}"))
    unknown = [f"{one.place}: not read: {one.what} ({one.count} times)" for one in report.unread]
    unknown += [
        f"{one.place}: no map for: {one.what} ({one.count} times)" for one in report.unmapped
    ]
    unknown += [
        f"{one.place}: in another script{'' if one.counted else ', not counted'}: {one.what} "
        f"({one.count} times)"
        for one in report.other_scripts
    ]
    ET.SubElement(suite, "system-out").text = _xml_text("\n".join([summary, *unknown]))
    return suite


def _xml_text(text: str) -> str:
    return FORBIDDEN.sub("�", text)
