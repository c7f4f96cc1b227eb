"""The page: a coverage document as one HTML file for a producer.

The page contains the first report, which is readable without a script; the parts of other reports
are in `<template>` elements. A part that several reports share, such as a language's ranking for
every character, is written once. Characters differ in the states of bigrams, which the script
inserts. A state is one character, its index in a list: `0`, `1` ... `9`, `a`, `b` ...

The templates take a report as its view, with all names and figures. Charts are numbers for them:
SVG paths stretched to the available width, x in ranks, y in thousandths from the top. Text is
separate HTML, so that it keeps its size on a telephone.

The page loads no other files; its content security policy forbids it.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import groupby
from math import ceil, floor, log10
from string import ascii_lowercase, digits
from typing import Any, NamedTuple, Self

from markupsafe import Markup

from lipsync_lang.base.errors import count
from lipsync_lang.base.presentation.pages import CHART_HEIGHT, PageEnvironment
from lipsync_lang.base.presentation.wording import (
    NBSP,
    folder,
    gathered,
    hours,
    listed,
    percentage_text,
    ranked_text,
)
from lipsync_lang.reports.coverage.report import AUTHORED, BORROWED_LAYER, labelled

MAX_PLACES = 3
"""Maximum number of places of a bigram in its row."""

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

SHADES, GAMMA = 9, 0.4
"""Number of shades of the map, and the exponent that separates rare bigrams."""

MAX_TICKS = 5
LATE_SHARE = 0.78
"""Share of the width from which a mark's label is on its left."""

WHOLE_SHARE = "100"
HANGING_HEIGHTS, STANDING_HEIGHTS = (0.7, 0.5, 0.3), (0.08, 0.26, 0.44)
"""End heights of the labels of marks, from the first mark on; 0 is the top."""

StateRow = Mapping[str, Any]
"""A bigram of a report in the document."""

GAP_STATUS = "gap"
"""Status of bigrams without curves, which is empty in the document."""

BORROWED_STATUS = "borrowed"
"""Status of curves that a person drew for a similar sound."""

STATUSES = {
    "approved": "approved by a person",
    "edited": "drawn by a person",
    BORROWED_STATUS: "drawn by a person for a similar sound",
    "fitted": "fitted to captures, not yet checked",
    "drafted": "drafted by the program, not yet checked",
    GAP_STATUS: "no curves at all",
}
LAYER_MEANINGS = {
    "character": "the character's own",
    "language": "of the language",
    "shared": "shared by all languages",
    BORROWED_LAYER: "borrowed from a similar sound",
    "draft": "drafted from the targets",
    GAP_STATUS: "no curves at all",
}
"""Layers in the order of legends; further names of a document follow."""

STATE_CODES = digits + ascii_lowercase


@dataclass(frozen=True)
class States:
    """The statuses and layers of a document's bigrams."""

    statuses: tuple[str, ...]
    layers: tuple[str, ...]
    seen: frozenset[str]
    """Statuses and layers that occur in the document."""

    @classmethod
    def of(cls, rows: Iterable[StateRow]) -> Self:
        """Collect the states of some bigrams."""
        pairs = [(status(row), str(row["layer"])) for row in rows]
        statuses = dict.fromkeys((*STATUSES, *(status for status, _ in pairs)))
        layers = dict.fromkeys((*LAYER_MEANINGS, *(layer for _, layer in pairs)))
        seen = frozenset(name for pair in pairs for name in pair)
        return cls(tuple(statuses), tuple(layers), seen)

    def status_code(self, row: StateRow) -> str:
        """Return the status of a bigram as a character."""
        return STATE_CODES[self.statuses.index(status(row))]

    def layer_code(self, row: StateRow) -> str:
        """Return the layer of a bigram as a character."""
        return STATE_CODES[self.layers.index(row["layer"])]

    def codes(self, rows: Iterable[StateRow]) -> str:
        """Return the statuses of all bigrams, a space, and their layers, as characters."""
        pairs = [(self.status_code(row), self.layer_code(row)) for row in rows]
        return " ".join("".join(pair[half] for pair in pairs) for half in (0, 1))

    def legend(self, names: Iterable[str]) -> list[tuple[str, str]]:
        """Return the codes and names of the statuses, or of the layers, that occur."""
        coded = zip(STATE_CODES, names, strict=False)
        return [(code, name) for code, name in coded if name in self.seen]

    def shares(self, rows: Iterable[StateRow]) -> dict[str, tuple[int, int]]:
        """Count the bigrams of each status, and their occurrences."""
        shares = dict.fromkeys(self.statuses, (0, 0))
        for row in rows:
            bigrams, heard = shares[status(row)]
            shares[status(row)] = (bigrams + 1, heard + row["count"])
        return shares


def status(row: StateRow) -> str:
    """Return the status of a bigram: `borrowed` and `gap` are distinguished."""
    if row["layer"] == BORROWED_LAYER and row["status"] in AUTHORED:
        return BORROWED_STATUS
    return str(row["status"] or GAP_STATUS)


PAGE_ENVIRONMENT = PageEnvironment(__package__, "templates")
PAGE_ENVIRONMENT.globals |= {
    "percent": partial(percentage_text, space=NBSP),
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


class Mark(NamedTuple):
    """A line at the rank where a share of all occurrences is reached."""

    class_: str
    style: str
    share: str
    rank: int


@dataclass(frozen=True)
class Chart:
    """A chart over the ranks of a report's bigrams."""

    title: str
    description: str
    width: int
    shapes: Sequence[tuple[str, str]]
    """Class and SVG path of each."""
    ticks: Sequence[tuple[str, str]]
    """Text and CSS position of each, as of `ranks`."""
    marks: Sequence[Mark]
    ranks: Sequence[tuple[str, str]]


class Cell(NamedTuple):
    """A bigram on the map."""

    number: int
    shade: int
    row: StateRow


def _step(most: float) -> float:
    """Return the smallest step of 1, 2, 5 or 10 times a power of ten with few ticks."""
    rough = most / MAX_TICKS
    size: float = 10.0 ** floor(log10(rough))
    return next(size * times for times in (1, 2, 5, 10) if size * times >= rough)


def _tick(percent: float, height: float) -> tuple[str, str]:
    return f"{percent:g}{NBSP}%", _placed(bottom=height)


def _marks(
    needed: Mapping[str, int], width: int, heights: Sequence[float], *, standing: bool
) -> list[Mark]:
    """Mark the ranks at which shares of all occurrences are reached; labels avoid other marks."""
    shares = [share for share in needed if share != WHOLE_SHARE]
    marks = []
    for share, height in zip(shares, heights, strict=False) if width else ():
        left = needed[share] / width
        end = {"top": height} if standing else {"bottom": 1 - height}
        classes = f"mark{' stands' if standing else ''}{' late' if left > LATE_SHARE else ''}"
        marks.append(Mark(classes, _placed(left=left, **end), share, needed[share]))
    return marks


def _ranks(width: int) -> list[tuple[str, str]]:
    step = max(1, round(_step(width))) if width else 1
    round_ones = (rank for rank in range(step, width, step) if 1 < rank < width - step / 2)
    ranks = dict.fromkeys((1, *round_ones, width)) if width else ()
    return [(f"{rank:,}", _placed(left=(rank - 0.5) / width)) for rank in ranks]


def _placed(**sides: float) -> str:
    return ";".join(f"{side}:{100 * share:.2f}%" for side, share in sides.items())


@dataclass(frozen=True, eq=False)
class ReportView:
    """A report of the document, as JSON data, ready for the templates.

    Two reports may hold the same figures, so the page tells views apart by identity.
    """

    document: Mapping[str, Any]
    states: States
    """States of all reports."""
    minutes: float
    """Minutes of work for a bigram."""
    folder: str
    """Common folder of all files, which places omit."""
    painted: bool = False
    """True to show the states of single bigrams; the script adds them to other reports."""

    @cached_property
    def name(self) -> str:
        """The language and the character."""
        return f"{self.title} on {self.document['character']}"

    @cached_property
    def language(self) -> str:
        """The language's title, or its name."""
        return str(self.document.get("language_title") or self.document["language"])

    @cached_property
    def title(self) -> str:
        """The language, with its column if it has several."""
        return labelled(self.language, self.document.get("column", ""))

    @cached_property
    def rows(self) -> Sequence[StateRow]:
        """The bigrams, most frequent first."""
        return self.document["bigrams"]

    @cached_property
    def shares(self) -> dict[str, tuple[int, int]]:
        """Bigrams and occurrences of each status."""
        return self.states.shares(self.rows)

    @cached_property
    def stack(self) -> list[tuple[str, float]]:
        """Code and percentage of each status that occurs."""
        whole = sum(heard for _, heard in self.shares.values()) or 1
        # There are more codes than statuses.
        shares = zip(STATE_CODES, self.shares.values(), strict=False)
        return [(code, 100 * heard / whole) for code, (_, heard) in shares if heard]

    @property
    def stack_description(self) -> str:
        """The shares of the statuses in words."""
        names = (name for name, (_, heard) in self.shares.items() if heard)
        shares = (percentage_text(share, NBSP) for _, share in self.stack)
        return ", ".join(map(" ".join, zip(shares, names, strict=True))) or "no bigrams"

    @cached_property
    def needed(self) -> dict[str, int]:
        """The number of bigrams that cover each share of all occurrences, smallest share first."""
        needed: Mapping[str, int] = self.document["needed"]
        return {share: needed[share] for share in sorted(needed, key=float)}

    def distribution(self) -> Chart:
        """Chart the share of each bigram, by rank, in the colour of its status (figure 2)."""
        rows, codes = self.rows, list(map(self.states.status_code, self.rows))
        most = max((row["percent"] for row in rows), default=0) or 1
        step = _step(most)
        top = ceil(round(most / step, 6)) * step
        outlines = dict.fromkeys(sorted(set(codes)), "")
        rank = 0
        for code, group in groupby(zip(rows, codes, strict=True), key=lambda pair: pair[1]):
            heights = [
                CHART_HEIGHT - round(row["percent"] * CHART_HEIGHT / top) for row, _ in group
            ]
            steps = "".join(f"V{height}h1" for height in heights)  # adjacent bars share a piece
            outlines[code] += f"M{rank} {CHART_HEIGHT}{steps}V{CHART_HEIGHT}z"
            # One path for each status, because thousands of bars as elements are slow in browsers
            rank += len(heights)
        return Chart(
            "Distribution",
            "Occurrences of each bigram, most frequent first, coloured by status.",
            len(rows),
            [(f"s{code}", outline) for code, outline in outlines.items()],
            [_tick(n * step, n * step / top) for n in range(round(top / step) + 1)],
            _marks(self.needed, len(rows), STANDING_HEIGHTS, standing=True),
            _ranks(len(rows)),
        )

    def running(self) -> Chart:
        """Chart the running share of all occurrences, by rank."""
        heights = (CHART_HEIGHT - round(row["running"] * CHART_HEIGHT / 100) for row in self.rows)
        start = f"M0 {CHART_HEIGHT}{''.join(f'V{height}h1' for height in heights)}"
        return Chart(
            "Running total",
            "Share of all occurrences that the most frequent bigrams make up together.",
            len(self.rows),
            [("under", f"{start}V{CHART_HEIGHT}z"), ("line", start)],
            [_tick(percent, percent / 100) for percent in (0, 25, 50, 75, 100)],
            _marks(self.needed, len(self.rows), HANGING_HEIGHTS, standing=False),
            _ranks(len(self.rows)),
        )

    def heat_map(self) -> tuple[list[str], list[list[Cell | None]]]:
        """Return the axis of the map, and its cells: first phonemes down, second ones across."""
        numbered = {row["bigram"]: (number, row) for number, row in enumerate(self.rows)}
        named = {half for name in numbered for half in name.partition("-")[::2]}
        axis = [phoneme for phoneme in self.document["phonemes"] if phoneme in named]
        axis += sorted(named - set(axis))
        most = max((row["count"] for row in self.rows), default=0) or 1
        cells = {
            bigram: Cell(number, ceil(SHADES * (row["count"] / most) ** GAMMA), row)
            for bigram, (number, row) in numbered.items()
        }
        return axis, [[cells.get(f"{first}-{second}") for second in axis] for first in axis]

    def place(self, place: str) -> str:
        """Return a place without the common folder of all files."""
        return place.removeprefix(self.folder)

    def places(self, row: StateRow) -> str:
        """Return the first places of a bigram, grouped by file."""
        return gathered(map(self.place, row["places"][:MAX_PLACES]))


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
    return f"{count(shared['bigrams'], 'bigram', space=NBSP)} with {', '.join(shared['phonemes'])}"


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
