"""Assembly of the page from its templates: next bigrams, table of all pairs, each report."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from typing import Any

from markupsafe import Markup

from lipsync_lang.base.presentation.pages import CHART_HEIGHT, PageEnvironment
from lipsync_lang.base.presentation.percentages import ranked_text
from lipsync_lang.base.presentation.wording import count, folder, hours, listed, percent
from lipsync_lang.reports.coverage.page.report_view import ReportView
from lipsync_lang.reports.coverage.page.states import LAYER_MEANINGS, STATUSES, States, status

TITLE = "What to draw next"
MOST_ITEMS, MOST_NAMES = 60, 8
"""Maximum number of bigrams in the ranking for all languages, and of names in a list of changes."""

MAX_SENTENCE_LANGUAGES = 5
"""Maximum number of languages in a sentence."""

PARTS = (
    "summary", "next", "distribution", "running", "map", "ranked", "silence", "phonemes",
    "unused", "sentences", "unread",
)  # fmt: skip
"""Macros of `parts.html`; each writes one part of a report."""

PAGE_ENVIRONMENT = PageEnvironment(__package__, "templates")
PAGE_ENVIRONMENT.globals |= {
    "percent": percent,
    "ranked_text": ranked_text,
    "hours": hours,
    "status": status,
    "STATUSES": STATUSES,
    "LAYERS": LAYER_MEANINGS,
    "HEIGHT": CHART_HEIGHT,
    "TITLE": TITLE,
    "MOST_ITEMS": MOST_ITEMS,
    "MOST_NAMES": MOST_NAMES,
}


@dataclass(frozen=True)
class MatrixRow:
    """A language in the table of languages and characters."""

    title: str
    addition: str
    reports: dict[str, ReportView]
    """Cells by character."""


class PartStore:
    """The distinct parts of all reports, with the states of the first report."""

    def __init__(self, reports: Sequence[ReportView], macros: object) -> None:
        self.first = _parts(replace(reports[0], painted=True), macros)
        self._numbers: dict[Markup, int] = {}
        known = self._numbers
        made = (_parts(report, macros).items() for report in reports)
        self.keys = [{name: known.setdefault(p, len(known)) for name, p in own} for own in made]
        """The numbers of the parts of each report."""

    def others(self) -> list[tuple[int, Markup]]:
        """Return number and content of the parts that the first report does not have."""
        shown = set(self.keys[0].values())
        return [(number, part) for part, number in self._numbers.items() if number not in shown]


def page(document: Mapping[str, Any]) -> str:
    """Return a document in the form "lipsync-lang coverage 1" as one self-contained HTML page."""
    corpus, minutes = document["corpus"], document["minutes"]
    root = folder(corpus["files"])
    states = States.of(
        row for one in document["reports"] for key in ("bigrams", "silence") for row in one[key]
    )
    reports = [ReportView(one, states, minutes, root) for one in document["reports"]]

    def gain(report: ReportView) -> float:
        """Return the occurrences that the next hour of drawing covers, times 100."""
        return float(report.document["next_hour"]["percent"] * report.document["occurrences"])

    macros = PAGE_ENVIRONMENT.get_template("parts.html").module
    titles = {one.document["language"]: one.language for one in reports}
    adding: dict[str, list[str]] = {}
    for one in sorted(document["shared"], key=lambda one: bool(one["bigrams"])):
        adding.setdefault(_addition(one), []).append(titles.get(one["language"], one["language"]))
    shared = (
        f"{listed(names, MAX_SENTENCE_LANGUAGES)} {'add' if len(names) > 1 else 'adds'} {addition}"
        for addition, names in adding.items()
    )
    values = {
        "document": document,
        "files": listed([name.removeprefix(root) for name in corpus["files"]]),
        "minutes": f"{minutes:g}",
        "states": states,
        "reports": reports,
        "best": max(reports, key=gain, default=None),
        "shared": "; ".join(shared),
        "characters": list(dict.fromkeys(one.document["character"] for one in reports)),
        "matrix": _matrix(document, reports),
        "options": [
            (name, list(group))
            for name, group in groupby(enumerate(reports), lambda numbered: numbered[1].language)
        ],
        "store": PartStore(reports, macros) if reports else None,
    }
    return PAGE_ENVIRONMENT.page("page.html", values, script="script.js")


def _parts(report: ReportView, macros: object) -> dict[str, Markup]:
    return {name: getattr(macros, name)(report) for name in PARTS}


def _addition(shared: Mapping[str, Any] | None) -> str:
    if shared is None:
        return "–"
    if not shared["bigrams"]:
        return "nothing"
    return f"{count(shared['bigrams'], 'bigram')} with {', '.join(shared['phonemes'])}"


def _matrix(document: Mapping[str, Any], reports: Iterable[ReportView]) -> list[MatrixRow]:
    """Return a row for each language, and another for each further report of a character."""
    additions = {one["language"]: one for one in document["shared"]}
    rows: list[tuple[str, MatrixRow]] = []
    for report in reports:
        language, character = report.document["language"], report.document["character"]
        # A language in several columns has several reports of one character, which share no cell.
        for name, row in rows:
            if (name, row.title) == (language, report.title) and character not in row.reports:
                row.reports[character] = report
                break
        else:
            addition = _addition(additions.get(language))
            rows.append((language, MatrixRow(report.title, addition, {character: report})))
    return [row for _, row in rows]
