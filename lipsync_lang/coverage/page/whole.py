"""The page around the reports: what to do next, all pairs side by side, and what scripts need."""

from base64 import b64encode
from collections.abc import Mapping, Sequence
from hashlib import sha256
from importlib.resources import files
from string import Template
from typing import Any

from lipsync_lang.coverage.page.chosen import Chosen, scroll
from lipsync_lang.coverage.page.markup import Markup, join, tags
from lipsync_lang.coverage.page.report_view import ReportView, bigrams
from lipsync_lang.coverage.page.states import States
from lipsync_lang.coverage.page.wording import count, folder, hours, listed, percent

TITLE = "What to draw next"
NAMED = 5  # languages in a row, before the rest is counted


def page(document: Mapping[str, Any]) -> str:
    """Return a coverage document as one HTML page that needs nothing else.

    Parameters
    ----------
    document : in the form "lipsync-lang coverage 1"
    """
    rows = [
        row for one in document["reports"] for key in ("bigrams", "silence") for row in one[key]
    ]
    states = States.of(rows)
    root = folder(document["corpus"]["files"])
    reports = [ReportView(one, states, document["minutes"], root) for one in document["reports"]]
    body = join(
        tags.main(
            _top(document, reports),
            _matrix(document, reports) if reports else (),
            Chosen(reports, states).html() if reports else (),
        ),
        _foot(document),
    )
    script = _file("script.js")
    digest = b64encode(sha256(script.encode()).digest()).decode()
    return Template(_file("shell.html")).substitute(
        title=TITLE, style=_file("style.css"), body=body, script=script, digest=f"sha256-{digest}"
    )


def _file(name: str) -> str:
    return (files(__package__) / name).read_text("utf-8")


def _top(document: Mapping[str, Any], reports: Sequence[ReportView]) -> Markup:
    """Say in plain words what to do next: for the pair where an hour is heard the most."""
    corpus = document["corpus"]
    read = f"{count(corpus['lines'], 'line')}, {count(corpus['words'], 'word')}"
    root = folder(corpus["files"])
    names = listed([name.removeprefix(root) for name in corpus["files"]])
    eyebrow = tags.p(f"Lip-sync coverage · {names} · {read}", class_="eyebrow")
    if not reports:
        said = "There is no language here that could be counted. Name a language and a character."
        return tags.header(eyebrow, tags.h1(TITLE), tags.p(said, class_="lead"))
    first = max(reports, key=_gain)
    return tags.header(
        eyebrow,
        tags.h1(TITLE),
        tags.p(first.advice(data_report=reports.index(first)), class_="lead"),
        bigrams(first.document["next_hour"]["bigrams"]),
        tags.p(_shared(document, reports)) if document["shared"] else (),
    )


def _gain(report: ReportView) -> float:
    following = report.document["next_hour"]
    return float(following["percent"] * report.document["occurrences"])


def _shared(document: Mapping[str, Any], reports: Sequence[ReportView]) -> str:
    """Say which languages add nothing to draw, and what the others add."""
    titles = {one.document["language"]: one.language for one in reports}
    groups: dict[str, list[str]] = {}
    for one in sorted(document["shared"], key=lambda one: bool(one["bigrams"])):
        groups.setdefault(_addition(one), []).append(titles.get(one["language"], one["language"]))
    said = (
        f"{listed(names, NAMED)} {'add' if len(names) > 1 else 'adds'} {addition}"
        for addition, names in groups.items()
    )
    return f"What languages share is drawn once: {'; '.join(said)}."


def _matrix(document: Mapping[str, Any], reports: Sequence[ReportView]) -> Markup:
    """Set languages beside characters, with what is drawn, what is left, and what is added."""
    adds = {one["language"]: one for one in document["shared"]}
    characters = dict.fromkeys(one.document["character"] for one in reports)
    head = tags.tr(tags.td(), (tags.th(name) for name in characters), tags.th("adds"))
    rows = (
        tags.tr(
            tags.th(title),
            (cells.get(character, tags.td("–")) for character in characters),
            tags.td(_addition(adds.get(name)), class_="adds"),
        )
        for name, title, cells in _rows(reports)
    )
    table = tags.table(tags.thead(head), tags.tbody(rows), class_="matrix")
    return tags.section(
        tags.h2("Every language on every character"),
        tags.p(
            "The share of what is heard that a person has drawn, and the hours left at "
            f"{document['minutes']:g} minutes a bigram."
        ),
        scroll(table, "Languages by characters"),
        id="matrix",
    )  # fmt: skip


def _rows(reports: Sequence[ReportView]) -> list[tuple[str, str, dict[str, Markup]]]:
    """Return name and title of languages with a cell for each character; none hides another."""
    rows: list[tuple[str, str, dict[str, Markup]]] = []
    for number, one in enumerate(reports):
        language, character = one.document["language"], one.document["character"]
        for name, title, cells in rows:
            if (name, title) == (language, one.title) and character not in cells:
                cells[character] = _cell(number, one)
                break
        else:
            rows.append((language, one.title, {character: _cell(number, one)}))
    return rows


def _foot(document: Mapping[str, Any]) -> Markup:
    """Say what the words and numbers of the page mean."""
    return tags.footer(
        tags.p(
            "A bigram is two sounds on end, as the mouth makes them: what one curve animates. "
            "Drawn by a person means edited or approved; a draft is the program's own. "
            f"Hours count {document['minutes']:g} minutes a bigram."
        )
    )


def _cell(number: int, report: ReportView) -> Markup:
    drawn, left = report.document["authored"], report.document["left"]
    return tags.td(
        tags.b(percent(drawn["percent"])),
        tags.span(f"{hours(left['hours'])} left" if left["bigrams"] else "done"),
        report.stack,
        data_report=number,
    )


def _addition(shared: Mapping[str, Any] | None) -> str:
    if shared is None:
        return "–"
    if not shared["bigrams"]:
        return "nothing"
    return f"{count(shared['bigrams'], 'bigram')} with {', '.join(shared['phonemes'])}"
