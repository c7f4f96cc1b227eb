"""CSV: one row per bigram, for spreadsheets."""

import csv
from typing import TYPE_CHECKING, TextIO

if TYPE_CHECKING:
    from lipsync_lang.coverage.forms.registry import Asked
    from lipsync_lang.coverage.report import Coverage

HEAD = (
    "language", "character", "bigram", "count", "percent", "running", "silence", "layer", "status",
    "authored", "example", "places", "column",
)  # fmt: skip


def write(coverage: "Coverage", out: TextIO, asked: "Asked") -> None:
    """Write a row for each bigram that occurs; those with silence come last."""
    del asked  # it is always whole
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(HEAD)
    for report in coverage.reports:
        for silence, bigrams in (("no", report.bigrams), ("yes", report.silence)):
            for one in bigrams:
                rows.writerow(
                    (
                        report.language, report.character, one.bigram, one.count, one.percent,
                        one.running, silence, one.layer, one.status,
                        "yes" if one.authored else "no", one.example, " ".join(one.places),
                        report.column,
                    )
                )  # fmt: skip
