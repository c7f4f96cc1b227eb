"""Forms that hold a whole report, whatever the options: JSON, a page, and CSV for spreadsheets.

The schema of the JSON document is `docs/reference/coverage.schema.json`. The page is one HTML file
with its style and script inside.
"""

import csv
import json
from typing import TextIO

from lipsync_lang.base.files.quoting import spreadsheet_text
from lipsync_lang.reports.coverage.forms import FORMS, FormOptions
from lipsync_lang.reports.coverage.report import Coverage
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
