"""The place of the page where one report at a time is shown, and the store of all others."""

from collections.abc import Callable, Mapping, Sequence
from itertools import groupby

from lipsync_lang.coverage.page.markup import Child, Markup, join, tags
from lipsync_lang.coverage.page.report_view import ReportView
from lipsync_lang.coverage.page.states import CODES, LAYERS, STATUSES, Row, States

COLUMNS = {
    "rank": "number",
    "bigram": "text",
    "heard": "number",
    "%": "number",
    "% so far": "number",
    "status": "text",
    "from": "text",
    "as in": "text",
    "heard at": "text",
}
"""Columns of rankings, and what they are sorted as."""


class Chosen:
    """The first report, filled in, and the parts that others put in its place."""

    def __init__(self, reports: Sequence[ReportView], states: States) -> None:
        self.reports = reports
        self.states = states
        self.first = reports[0].parts(painted=True)
        self.numbers: dict[Markup, int] = {}
        """Every different part, and the key it is stored by."""
        self.keys = [self._keys(one) for one in reports]

    def _keys(self, report: ReportView) -> dict[str, int]:
        parts = report.parts(painted=False)
        return {
            name: self.numbers.setdefault(part, len(self.numbers)) for name, part in parts.items()
        }

    def html(self) -> Markup:
        """Return the first report and the store."""
        return join(
            self._picker(),
            tags.section(self._slot("summary"), id="report", tabindex="-1"),
            _section("Draw next", self._slot("next")),
            _section(
                "Where the work is",
                tags.div(self._slot("distribution"), self._slot("running"), class_="beside"),
            ),
            _section("Which sound follows which", self._map()),
            _section("Every bigram", self._tools(), self._table("ranked", "Every bigram")),
            _section(
                "With silence",
                tags.p("From a pause into a sound, and from a sound into a pause: ranked apart."),
                self._table("silence", "Bigrams with silence"),
            ),
            _section("Not understood", self._slot("unread")),
            _section(
                "Lines to see it with",
                tags.p(
                    "A short list of lines that together hold all that nobody has drawn yet, each "
                    "with the bigrams that no line before it has. Animate them to see what is left."
                ),
                scroll(self._slot("sentences"), "Lines to see it with", class_="scroll tall"),
            ),
            _section("Never heard", self._slot("unused")),
            self._store(),
        )  # fmt: skip

    def _slot(self, name: str, element: Callable[..., Markup] = tags.div) -> Markup:
        return element(self.first[name], data_part=name, data_key=self.keys[0][name])

    def _store(self) -> Markup:
        shown = set(self.keys[0].values())
        return join(
            tags.template(part, data_key=number)
            for part, number in self.numbers.items()
            if number not in shown
        )

    def _picker(self) -> Markup:
        """Let one of the reports be chosen: needs the script, which takes `hidden` away."""
        numbered = [
            (one.language, tags.option(one.name, value=number, **self._data(number)))
            for number, one in enumerate(self.reports)
        ]
        groups = (
            tags.optgroup((option for _, option in group), label=language)
            for language, group in groupby(numbered, key=lambda pair: pair[0])
        )
        name = self.reports[0].name
        parts = " ".join(self.first)
        select = tags.select(groups, id="picker", autocomplete="off", data_parts=parts)
        return join(
            tags.nav(
                tags.label("Report ", select),
                class_="picker",
                data_statuses=" ".join(self.states.statuses),
                data_layers=" ".join(self.states.layers),
                hidden=True,
            ),
            tags.noscript(tags.p(f"Below is {name}; with scripts on, any other can be chosen."))
            if self.reports[1:]
            else (),
        )

    def _data(self, number: int) -> dict[str, str]:
        report = self.reports[number]
        return {
            "data_keys": " ".join(map(str, self.keys[number].values())),
            "data_ranked": self._codes(report.rows),
            "data_silence": self._codes(report.silence),
        }

    def _codes(self, rows: Sequence[Row]) -> str:
        """Write the statuses of all bigrams, then their layers."""
        states = self.states
        statuses, layers = map(states.status_code, rows), map(states.layer_code, rows)
        return f"{''.join(statuses)} {''.join(layers)}"

    def _map(self) -> Markup:
        colours = ("status", "layer")
        switch = tags.fieldset(
            tags.legend("Colour by"),
            (
                tags.label(
                    tags.input(
                        type="radio",
                        name="colour",
                        value=one,
                        checked=not number,
                        autocomplete="off",
                    ),
                    one,
                )
                for number, one in enumerate(colours)
            ),
            class_="switch",
            hidden=True,
        )
        keys = (
            self._key(self.states.statuses, STATUSES, "s", "by-status"),
            self._key(self.states.layers, LAYERS, "l", "by-layer"),
        )
        return tags.div(
            tags.div(
                tags.p("Rows: the first sound; columns: the second. The stronger, the more heard."),
                switch,
                keys,
                scroll(self._slot("map"), "The first sound by the second"),
            ),
            tags.div(tags.h3("Sounds heard"), self._slot("phonemes")),
            class_="mapped",
            id="map",
            data_colour=colours[0],
        )  # fmt: skip

    def _key(
        self, names: Sequence[str], meanings: Mapping[str, str], letter: str, class_: str
    ) -> Markup:
        """Explain the colours of the map."""
        entries = (
            tags.li(name, class_=f"swatch {letter}{CODES[code]}", title=meanings.get(name))
            for code, name in enumerate(names)
            if name in self.states.seen
        )
        return tags.ul(entries, class_=f"key {class_}")

    def _tools(self) -> Markup:
        """Search and filter the ranking: needs the script."""
        filters = (
            tags.button(name, type="button", aria_pressed="true", class_=f"chip s{CODES[code]}")
            for code, name in enumerate(self.states.statuses)
            if name in self.states.seen
        )
        return tags.div(
            tags.label("Search ", tags.input(type="search", id="search", autocomplete="off")),
            tags.div(filters, class_="filters", role="group", aria_label="Show statuses"),
            tags.output(id="found"),
            class_="tools",
            hidden=True,
        )

    def _table(self, part: str, label: str) -> Markup:
        head = (tags.th(name, data_sort=kind, scope="col") for name, kind in COLUMNS.items())
        table = tags.table(
            tags.thead(tags.tr(head)), self._slot(part, tags.tbody), class_="ranking", id=part
        )
        return scroll(table, label, class_="scroll tall")


def scroll(content: Markup, label: str, class_: str = "scroll") -> Markup:
    """Put what may be too large into a box that scrolls, by keyboard too."""
    return tags.div(content, class_=class_, role="region", aria_label=label, tabindex=0)


def _section(title: str, *content: Child) -> Markup:
    return tags.section(tags.h2(title), *content)
