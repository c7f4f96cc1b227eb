"""JUnit XML for build servers: suites of cases that passed, failed, were skipped or had errors."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal
from xml.etree import ElementTree as ET

from lipsync_lang.base.files.quoting import xml_text

DECLARATION = '<?xml version="1.0" encoding="UTF-8"?>\n'


@dataclass(frozen=True)
class JunitCase:
    """A case of a suite."""

    classname: str
    """Name of the group that build servers show the case in."""
    name: str
    outcome: Literal["", "error", "failure", "skipped"] = ""
    """Empty if the case passed."""
    message: str = ""
    detail: str = ""
    """More lines of the message."""
    file: str = ""


@dataclass(frozen=True)
class JunitSuite:
    """A named group of cases, with figures and notes about all of them."""

    name: str
    cases: Sequence[JunitCase]
    properties: Mapping[str, object] = field(default_factory=dict)
    output: str = ""


def junit_text(
    suites: Iterable[JunitSuite],
    name: str = "",
    counts: Sequence[str] = ("tests", "failures", "errors", "skipped"),
    seconds: float | None = None,
) -> str:
    """Return suites as XML, with a replacement character for each that XML forbids.

    With a `name`, all suites together get the sums of the counts. `counts` are those of a suite, in
    the order of its attributes, and `seconds` is the time that all suites took.
    """
    top = ET.Element("testsuites", {"name": xml_text(name)} if name else {})
    top.extend(_suite(suite, counts) for suite in suites)
    for count in counts if name else ():
        top.set(count, str(sum(int(suite.get(count, "0")) for suite in top)))
    if seconds is not None:
        top.set("time", f"{seconds:.3f}")
    ET.indent(top)
    return DECLARATION + ET.tostring(top, encoding="unicode")


def _suite(suite: JunitSuite, counts: Sequence[str]) -> ET.Element:
    outcomes = [case.outcome for case in suite.cases]
    numbers = {
        "tests": len(outcomes),
        "failures": outcomes.count("failure"),
        "errors": outcomes.count("error"),
        "skipped": outcomes.count("skipped"),
    }
    element = ET.Element("testsuite", name=xml_text(suite.name))
    for count in counts:
        element.set(count, str(numbers[count]))
    if suite.properties:
        properties = ET.SubElement(element, "properties")
        for name, value in suite.properties.items():
            ET.SubElement(properties, "property", name=name, value=xml_text(str(value)))
    for case in suite.cases:
        known = {"classname": case.classname, "name": case.name, "file": case.file}
        parent = ET.SubElement(
            element, "testcase", {key: xml_text(text) for key, text in known.items() if text}
        )
        if case.outcome:
            reason = ET.SubElement(parent, case.outcome, message=xml_text(case.message))
            reason.text = xml_text(case.detail) or None
    if suite.output:
        ET.SubElement(element, "system-out").text = xml_text(suite.output)
    return element
