"""Assembly of the page from its templates: next bigrams, table of all pairs, each report."""

import re
from base64 import b64encode
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from hashlib import sha256
from importlib.resources import files
from itertools import groupby
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, PrefixLoader, StrictUndefined
from jinja2.ext import Extension
from markupsafe import Markup

from lipsync_lang.coverage.page import charts, wording
from lipsync_lang.coverage.page.report_view import ReportView
from lipsync_lang.coverage.page.states import LAYERS, STATUSES, States, status
from lipsync_lang.coverage.page.wording import count, folder, listed
from lipsync_lang.coverage.percentages import ranked_text

TITLE = "What to draw next"
MOST_ITEMS, MOST_NAMES = 60, 8
"""Maximum number of bigrams in the ranking for all languages, and of names in a list of changes."""

MAX_LANGUAGES = 5
"""Maximum number of languages in a sentence."""

PARTS = (
    "summary", "next", "distribution", "running", "map", "ranked", "silence", "phonemes",
    "unused", "sentences", "unread",
)  # fmt: skip
"""Macros of `parts.html`; each writes one part of a report."""


class TightLayout(Extension):
    """Pattern of a line break next to a tag or a block, with its indentation."""

    def preprocess(self, source: str, name: str | None, filename: str | None = None) -> str:
        """Remove these line breaks from a template."""
        # Comments keep the breaks, so that Jinja's errors name the right line.
        del name, filename
        return re.sub(r"(?<=[>}])\s*\n\s*|\s*\n\s*(?=[<{])", r"{#\g<0>#}", source)


@dataclass(frozen=True)
class MatrixRow:
    """A language in the table of languages and characters."""

    title: str
    addition: str
    reports: dict[str, ReportView]
    """Cells by character."""


class PartStore:
    """The distinct parts of all reports, with the states of the first report.

    Parameters
    ----------
    reports : at least one
    macros : the module of `parts.html`
    """

    def __init__(self, reports: Sequence[ReportView], macros: object) -> None:
        self.first = _parts(replace(reports[0], painted=True), macros)
        self._numbers: dict[Markup, int] = {}
        self.keys = [
            {
                name: self._numbers.setdefault(part, len(self._numbers))
                for name, part in _parts(report, macros).items()
            }
            for report in reports
        ]
        """The numbers of the parts of each report."""

    def others(self) -> list[tuple[int, Markup]]:
        """Return number and content of the parts that the first report does not have."""
        shown = set(self.keys[0].values())
        return [(number, part) for part, number in self._numbers.items() if number not in shown]


def page(document: Mapping[str, Any]) -> str:
    """Return a coverage document as one self-contained HTML page.

    Parameters
    ----------
    document : in the form "lipsync-lang coverage 1"
    """
    corpus, minutes = document["corpus"], document["minutes"]
    root = folder(corpus["files"])
    states = States.of(
        row for one in document["reports"] for key in ("bigrams", "silence") for row in one[key]
    )
    reports = [ReportView(one, states, minutes, root) for one in document["reports"]]
    environment = _environment()
    macros = environment.get_template("parts.html").module
    script = own_file("script.js")
    digest = b64encode(sha256(script.encode()).digest()).decode()
    return environment.get_template("page.html").render(
        document=document,
        files=listed([name.removeprefix(root) for name in corpus["files"]]),
        minutes=f"{minutes:g}",
        states=states,
        reports=reports,
        best=max(reports, key=_gain, default=None),
        shared=_shared(document, reports),
        characters=list(dict.fromkeys(one.document["character"] for one in reports)),
        matrix=_matrix(document, reports),
        options=[(name, list(group)) for name, group in groupby(enumerate(reports), _language)],
        store=PartStore(reports, macros) if reports else None,
        style=Markup(own_file("style.css")),  # noqa: S704 our own
        script=Markup(script),  # noqa: S704 our own
        digest=Markup(f"sha256-{digest}"),  # noqa: S704 base64
    )


def page_environment(package: str, folder: str) -> Environment:
    """Return an environment for the templates of a package; `coverage/` names those of this one.

    Parameters
    ----------
    folder : the folder of the templates in the package
    """
    shared = PrefixLoader({"coverage": PackageLoader("lipsync_lang.coverage.page")})
    environment = Environment(
        autoescape=True,
        extensions=[TightLayout],
        loader=ChoiceLoader([PackageLoader(package, folder), shared]),
        undefined=StrictUndefined,
    )
    environment.filters["commas"] = "{:,}".format
    environment.globals["count"] = count
    return environment


@cache
def _environment() -> Environment:
    environment = page_environment("lipsync_lang.coverage.page", "templates")
    environment.globals |= {
        "percent": wording.percent,
        "ranked_text": ranked_text,
        "hours": wording.hours,
        "status": status,
        "STATUSES": STATUSES,
        "LAYERS": LAYERS,
        "HEIGHT": charts.HEIGHT,
        "TITLE": TITLE,
        "MOST_ITEMS": MOST_ITEMS,
        "MOST_NAMES": MOST_NAMES,
    }
    return environment


def own_file(name: str) -> str:
    """Return a file of this folder, such as the style, which other reports share."""
    return (files(__package__) / name).read_text("utf-8")


def _parts(report: ReportView, macros: object) -> dict[str, Markup]:
    return {name: getattr(macros, name)(report) for name in PARTS}


def _gain(report: ReportView) -> float:
    """Return the occurrences that the next hour of drawing covers, times 100."""
    following = report.document["next_hour"]
    return float(following["percent"] * report.document["occurrences"])


def _language(numbered: tuple[int, ReportView]) -> str:
    return numbered[1].language


def _shared(document: Mapping[str, Any], reports: Iterable[ReportView]) -> str:
    """Return the languages without additional bigrams, and the additions of the others."""
    titles = {one.document["language"]: one.language for one in reports}
    groups: dict[str, list[str]] = {}
    for one in sorted(document["shared"], key=lambda one: bool(one["bigrams"])):
        groups.setdefault(_addition(one), []).append(titles.get(one["language"], one["language"]))
    return "; ".join(
        f"{listed(names, MAX_LANGUAGES)} {'add' if len(names) > 1 else 'adds'} {addition}"
        for addition, names in groups.items()
    )


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
        for name, row in rows:
            if (name, row.title) == (language, report.title) and character not in row.reports:
                row.reports[character] = report
                break
        else:
            addition = _addition(additions.get(language))
            rows.append((language, MatrixRow(report.title, addition, {character: report})))
    return [row for _, row in rows]
