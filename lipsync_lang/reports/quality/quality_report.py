"""Reports of one or several animations as text, JSON or JUnit XML."""

import json
from collections.abc import Callable, Mapping

from lipsync_lang.base.presentation.junit import JunitCase, JunitSuite, junit_text
from lipsync_lang.base.presentation.text_table import columns
from lipsync_lang.reports.quality.figures import Figure, Quality, describe

Qualities = Mapping[str, Quality]
"""Results by name; the first is for the judged animation, the others are for comparison."""


def as_text(qualities: Qualities) -> str:
    """Return the first result in full, then a table of all results if there are several."""
    first, *others = qualities.values()
    if not others:
        return str(first)
    names = list(dict.fromkeys(f.name for one in qualities.values() for f in one.figures))
    known = [{figure.name: figure for figure in one.figures} for one in qualities.values()]
    rows = [["", *qualities]]
    rows += [[name, *(_cell(one.get(name)) for one in known)] for name in names]
    return "\n".join([str(first), "", *columns(rows)])


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
    suites = [
        JunitSuite(name, [_case(quality.subject, figure) for figure in quality.figures])
        for name, quality in qualities.items()
    ]
    return junit_text(suites, counts=("tests", "failures", "skipped"))


def _case(subject: str, figure: Figure) -> JunitCase:
    if figure.verdict == "-":
        return JunitCase(subject, figure.name, "skipped", describe(figure))
    if figure.passed:
        return JunitCase(subject, figure.name)
    findings = "\n".join(f"{one.at:.3f} s: {one.what}" for one in figure.findings)
    return JunitCase(subject, figure.name, "failure", describe(figure), findings)


FORMATS: dict[str, Callable[[Qualities], str]] = {
    "text": as_text,
    "json": as_json,
    "junit": as_junit,
}
"""Output formats by name."""
