"""CSV: one row per bigram, for spreadsheets.

Words and file names come from the corpus. Spreadsheets would calculate text that begins like a
formula, so an apostrophe stands before such text, as OWASP advises.
"""

import csv
from typing import TYPE_CHECKING, TextIO

from lipsync_lang.coverage.forms.report_forms import FORMS, Asked

if TYPE_CHECKING:
    from lipsync_lang.coverage.report import BigramNeed, Coverage, CoverageReport

HEAD = (
    "language", "character", "bigram", "count", "percent", "running", "silence", "layer", "status",
    "authored", "example", "places", "column",
)  # fmt: skip

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
"""First characters of formulas in any spreadsheet."""


@FORMS.register("csv")
def write(coverage: "Coverage", out: TextIO, asked: Asked) -> None:
    """Write a row for each bigram that occurs; bigrams with silence come last."""
    del asked  # it is always whole
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(HEAD)
    for report in coverage.reports:
        for silence, bigrams in (("no", report.bigrams), ("yes", report.silence)):
            for one in bigrams:
                rows.writerow(map(_cell, _row(report, one, silence)))


def _row(report: "CoverageReport", one: "BigramNeed", silence: str) -> tuple[object, ...]:
    return (
        report.language, report.character, one.bigram, one.count, one.percent, one.running,
        silence, one.layer, one.status, "yes" if one.authored else "no", one.example,
        " ".join(one.places), report.column,
    )  # fmt: skip


def _cell(value: object) -> object:
    """Quote text that a spreadsheet would calculate; numbers stay numbers."""
    starts = isinstance(value, str) and value.startswith(FORMULA_STARTS)
    return f"'{value}" if starts else value
