"""Routes of the coverage view: the project's script, and the bigrams that it still needs."""

from pathlib import Path

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.json_object import Json
from lipsync_lang.reports.coverage.report import BigramNeed, CoverageReport, Tally
from lipsync_lang.resolver.layers import DRAFTED, FITTED
from lipsync_lang.studio.routes.requests import StudioRequest, sent_file
from lipsync_lang.studio.script_count import script_of, scripts_in
from lipsync_lang.studio.workshop import Workshop
from lipsync_lang.text.lines.line_readers import by_suffix

MINUTES = 5.0
"""Default minutes to author a bigram, as in `coverage`."""

MAX_MINUTES = 600.0
"""Maximum number of minutes to author a bigram."""

MAX_PLANNED = 300
"""Maximum number of bigrams in the plan."""

MAX_TALLIES = 30
"""Maximum number of words listed as unread or unmapped."""

MAX_SENTENCES = 60
"""Maximum number of lines that together contain the bigrams left to draw."""


def coverage(workshop: Workshop, request: StudioRequest) -> Json:
    """Return the script, the state of its count, and the bigrams left to draw."""
    script = script_of(workshop)
    script.update(workshop)
    report = script.report(workshop, _minutes(request))
    return {
        "script": {"name": script.name, "sent": script.sent, "column": script.column or ""},
        "offered": scripts_in(workshop.project),
        "suffixes": sorted(by_suffix()),
        "report": None if report is None else _report_data(report),
    } | script.progress


def choose(workshop: Workshop, request: StudioRequest) -> Json:
    """Use a file of the project as the script; an empty name stands for no script."""
    name, column = request.text("name"), request.body.get("column")
    if column is not None and not isinstance(column, str):
        raise LipsyncError("`column` must be the name or the number of a column")
    if name:
        script_of(workshop).choose(workshop, name, column or None)
    else:
        script_of(workshop).clear()
    return coverage(workshop, request)


def receive(workshop: Workshop, request: StudioRequest) -> Json:
    """Use a sent file as the script."""
    script = script_of(workshop)
    script.receive(lambda folder: sent_file(request, folder), request.query.get("column") or None)
    return coverage(workshop, request)


def sentences(workshop: Workshop, request: StudioRequest) -> Json:
    """Return a short list of lines that together show every bigram that is not authored."""
    report = script_of(workshop).report(workshop, _minutes(request), sentences=True)
    if report is None:
        raise LipsyncError("no script is counted; choose a script first")
    found = [
        {"text": one.text, "place": Path(one.place).name, "bigrams": list(one.bigrams)}
        for one in report.sentences
    ]
    return {"sentences": found[:MAX_SENTENCES], "count": len(found)}


def _minutes(request: StudioRequest) -> float:
    try:
        minutes = float(request.query.get("minutes", MINUTES))
    except ValueError:
        minutes = 0.0
    if not 0 < minutes <= MAX_MINUTES:
        raise LipsyncError("minutes for a bigram: give a number above 0 and up to 600")
    return minutes


def _report_data(report: CoverageReport) -> Json:
    """Return a report as JSON data for the view."""
    missing = [row for row in report.bigrams if not row.authored]
    status: dict[str, list[int]] = {}
    for row in report.bigrams:
        # Trigrams may author a bigram whose own curve is a draft; it keeps the status of its curve.
        shown = row.authored or row.status == FITTED
        own = row.status if shown else DRAFTED if row.status else "gap"
        kinds = status.setdefault(own, [0, 0])
        kinds[0] += 1
        kinds[1] += row.count
    soon = report.next_hour
    alike: Json = report.model_dump(
        include={"lines", "words", "occurrences", "authored", "left", "needed"}
    )
    return alike | {
        "kinds": len(report.bigrams),
        "status": status,
        "next_hour": {"bigrams": len(soon.bigrams), "percent": soon.percent},
        "plan": [_need(row) for row in missing[:MAX_PLANNED]],
        "silence": [_need(row) for row in report.silence if not row.authored][:MAX_PLANNED],
        "unread": _tallies(report.unread),
        "unmapped": _tallies(report.unmapped),
        "other_scripts": _tallies(report.other_scripts),
        "entries": _tallies(report.entries),
    }


def _need(row: BigramNeed) -> Json:
    fields: Json = row.model_dump(exclude={"running", "in_trigrams", "stated"})
    return fields | {"places": [Path(place).name for place in row.places]}


def _tallies(found: tuple[Tally, ...]) -> list[Json]:
    return [one.model_dump() | {"place": Path(one.place).name} for one in found[:MAX_TALLIES]]
