"""Timings as a table of comma-separated values, for spreadsheets, and as Audacity's label track.

A label that begins like a formula gets an apostrophe there, which the reader of tables removes.
"""

import csv
from io import StringIO

from lipsync_lang.base.files.quoting import spreadsheet_text
from lipsync_lang.schedules.schedule import Schedule
from lipsync_lang.schedules.tiers import CONFIDENCE_TIER, TIME_DIGITS, tiers_of


def table_text(schedule: Schedule) -> str:
    """Return a schedule as a CSV table: begin, end, label and type of each word and phone."""
    out = StringIO()
    tiers = tiers_of(schedule)
    sure = tiers.pop(CONFIDENCE_TIER, [])
    # a confidence begins with its word, so the start finds it
    rated = {start: label for label, start, _ in sure}
    rows = csv.writer(out, lineterminator="\n")
    rows.writerow(["Begin", "End", "Label", "Type", *(["Confidence"] if sure else [])])
    for kind, spans in tiers.items():
        for label, start, end in spans:
            rate = rated.get(start, "") if kind == "words" else ""
            rows.writerow([start, end, spreadsheet_text(label), kind, *([rate] if sure else [])])
    return out.getvalue()


def label_track_text(schedule: Schedule) -> str:
    """Return the phonemes of a schedule as a label track for Audacity; its words are left out."""
    spans = tiers_of(schedule)["phones"]
    return "".join(
        f"{start:.{TIME_DIGITS}f}\t{end:.{TIME_DIGITS}f}\t{label}\n" for label, start, end in spans
    )
