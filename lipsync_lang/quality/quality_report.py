"""Reports of one or several animations as text, JSON or JUnit XML."""

import json
from collections.abc import Callable, Mapping
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from lipsync_lang.quality.figures import Figure, Quality, describe

Qualities = Mapping[str, Quality]
"""Results by name; the first is for the judged animation, the others are for comparison."""


def as_text(qualities: Qualities) -> str:
    """Return the first result in full, then a table of all results if there are several."""
    first, *others = qualities.values()
    if not others:
        return str(first)
    return f"{first}\n\n{_columns(qualities)}"


def _columns(qualities: Qualities) -> str:
    names = list(dict.fromkeys(f.name for one in qualities.values() for f in one.figures))
    known = [{figure.name: figure for figure in one.figures} for one in qualities.values()]
    rows = [["", *qualities]]
    rows += [[name, *(_cell(one.get(name)) for one in known)] for name in names]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    lines = ("  ".join(f"{c:<{w}}" for c, w in zip(row, widths, strict=True)) for row in rows)
    return "\n".join(line.rstrip() for line in lines)


def _cell(figure: Figure | None) -> str:
    if figure is None or figure.value is None:
        return "-"
    return f"{figure.value:.3g}{'' if figure.passed else ' FAIL'}"


def as_json(qualities: Qualities) -> str:
    """Return all results by name as JSON."""
    data = {name: quality.to_dict() for name, quality in qualities.items()}
    return json.dumps(data, ensure_ascii=True, indent=2)


def as_junit(qualities: Qualities) -> str:
    """Return a test suite for each result, with a case for each figure."""
    root = Element("testsuites")
    for name, quality in qualities.items():
        figures = quality.figures
        skipped = sum(figure.verdict == "-" for figure in figures)
        counts = {"tests": len(figures), "failures": len(quality.failed), "skipped": skipped}
        told_counts = {key: str(number) for key, number in counts.items()}
        suite = SubElement(root, "testsuite", {"name": name, **told_counts})
        for figure in figures:
            _case(
                SubElement(suite, "testcase", classname=quality.subject, name=figure.name), figure
            )
    indent(root)
    return tostring(root, encoding="unicode", xml_declaration=True)


def _case(case: Element, figure: Figure) -> None:
    if figure.verdict == "-":
        SubElement(case, "skipped", message=describe(figure))
    if not figure.passed:
        failure = SubElement(case, "failure", message=describe(figure))
        failure.text = "\n".join(f"{one.at:.3f} s: {one.what}" for one in figure.findings)


FORMATS: dict[str, Callable[[Qualities], str]] = {
    "text": as_text,
    "json": as_json,
    "junit": as_junit,
}
"""Output formats by name."""
