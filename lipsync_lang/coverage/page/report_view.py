"""One report in parts: each is a piece of the page that another report may put its own in place of.

Parts that name bigrams one by one leave their states out; the script puts them in from the codes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from lipsync_lang.coverage.page import charts
from lipsync_lang.coverage.page.markup import Child, Markup, join, tags
from lipsync_lang.coverage.page.states import CODES, STATUSES, Row, States, status
from lipsync_lang.coverage.page.wording import NBSP, count, gathered, hours, percent
from lipsync_lang.coverage.report import labelled

PLACES = 3  # of a bigram, named in its row


@dataclass(frozen=True)
class ReportView:
    """A report of the document, and what the page says of it."""

    document: Mapping[str, Any]
    states: States
    minutes: float
    folder: str
    """What places begin with; the page leaves it out."""

    @cached_property
    def name(self) -> str:
        """What it is about: a language on a character."""
        return f"{self.title} on {self.document['character']}"

    @cached_property
    def language(self) -> str:
        """The language as people call it."""
        return str(self.document.get("language_title") or self.document["language"])

    @cached_property
    def title(self) -> str:
        """The language, and of several of its columns which."""
        return labelled(self.language, self.document.get("column", ""))

    @cached_property
    def rows(self) -> Sequence[Row]:
        """The bigrams, the most heard first."""
        return self.document["bigrams"]  # type: ignore[no-any-return]

    @cached_property
    def silence(self) -> Sequence[Row]:
        """The bigrams with silence."""
        return self.document["silence"]  # type: ignore[no-any-return]

    @cached_property
    def stack(self) -> Markup:
        """How much of what is heard is in which status."""
        shares = self.states.shares(self.rows)
        parts = [(heard, CODES[code]) for code, (_, heard) in enumerate(shares.values())]
        return charts.stack(parts, charts.described(shares))

    def parts(self, *, painted: bool) -> dict[str, Markup]:
        """Return the parts of the page that this report fills, with or without states."""
        needed = self.document["needed"]
        codes = "".join(map(self.states.status_code, self.rows))
        states = self.states if painted else None
        return {
            "summary": self._summary(),
            "next": self._next(),
            "distribution": charts.distribution(self.rows, codes, needed),
            "running": charts.running(self.rows, needed),
            "map": charts.heat_map(self.rows, list(self.document["phonemes"]), states),
            "ranked": join(self._ranked(self.rows, states)),
            "silence": join(self._ranked(self.silence, states)),
            "phonemes": charts.bars(self.document["phonemes"]),
            "unused": self._unused(),
            "sentences": self._sentences(),
            "unread": self._unread(),
        }

    def _summary(self) -> Markup:
        document = self.document
        drawn, left, needed = document["authored"], document["left"], document["needed"]
        said = join(
            f"{count(document['lines'], 'line')} and {count(document['words'], 'word')} hold "
            f"{count(document['occurrences'], 'bigram')}, {len(self.rows):,} of them different.",
            f" The pose set is {document['poseset']}." if document["poseset"] else "",
        )
        facts = [
            (
                percent(drawn["percent"]),
                "drawn by a person",
                count(drawn["bigrams"], "bigram"),
            ),
            (hours(left["hours"]), "of drawing left", count(left["bigrams"], "bigram")),
            *(
                (f"{needed[share]:,}", f"bigrams for {share}{NBSP}%", "of what is heard")
                for share in sorted(needed, key=float)
            ),
        ]
        return join(
            tags.h2(self.name),
            tags.p(said),
            tags.dl(
                (
                    tags.div(tags.dt(what), tags.dd(tags.b(fact), tags.span(more)))
                    for fact, what, more in facts
                ),
                class_="facts",
            ),
            self._legend(),
        )  # fmt: skip

    def _legend(self) -> Markup:
        shares = self.states.shares(self.rows)
        entries = [
            tags.li(
                tags.b(name, class_=f"chip s{CODES[code]}"), f" {count(bigrams, 'bigram')}",
                tags.span(STATUSES.get(name, "")),
            )
            for code, (name, (bigrams, _)) in enumerate(shares.items())
            if name in self.states.seen
        ]  # fmt: skip
        return join(self.stack, tags.ul(entries, class_="legend"))

    def advice(self, **link: int) -> Markup:
        """Say what to draw next, in a sentence whose report's name may be a link."""
        name = tags.span(self.name, **link) if link else self.name
        following = self.document["next_hour"]
        bigrams = following["bigrams"]
        if bigrams:
            time = hours(len(bigrams) * self.minutes / 60)
            them = f"these {len(bigrams)} bigrams" if len(bigrams) > 1 else "this bigram"
            return join(
                f"Draw {them} next: ", "they are " if len(bigrams) > 1 else "it is ",
                tags.strong(percent(following["percent"])),
                " of all that is heard in ", name, f", and about {time} of work.",
            )  # fmt: skip
        if not self.document["occurrences"]:
            return join(f"Nothing was heard in {self.name}: the corpus holds no line of it.")
        return join(f"Nothing is left to draw for {self.name}.")

    def _next(self) -> Markup:
        return join(tags.p(self.advice()), bigrams(self.document["next_hour"]["bigrams"]))

    def _unused(self) -> Markup:
        unused = self.document["unused"]
        if not unused:
            return tags.p("Every bigram of the language is heard.")
        said = f"{count(len(unused), 'bigram')} that nobody says here; they can wait."
        return join(tags.p(said), tags.p(" ".join(unused), class_="names"))

    def _sentences(self) -> Markup:
        sentences = self.document["sentences"]
        if not sentences:
            return tags.p("No line is needed: there is nothing left that lines could show.")
        return tags.ol(
            (
                tags.li(
                    tags.q(one["text"], dir="auto"), tags.small(self._place(one["place"])),
                    bigrams(one["bigrams"]),
                )
                for one in sentences
            ),
            class_="sentences",
        )  # fmt: skip

    def _unread(self) -> Markup:
        others = self.document.get("other_scripts", ())
        return tags.div(
            self._unknown("Words that could not be read", self.document["unread"]),
            self._unknown("Symbols without a mouth", self.document["unmapped"]),
            self._unknown(
                "Other scripts, not counted", [one for one in others if not one["counted"]]
            ),
            self._unknown("Other scripts, read", [one for one in others if one["counted"]]),
            class_="beside",
        )

    def _ranked(self, rows: Sequence[Row], states: States | None) -> list[Markup]:
        """List bigrams; without states, their cells are there all the same."""
        if not rows:
            return [tags.tr(tags.td("None are heard.", colspan=9))]
        return [
            tags.tr(
                tags.td(rank),
                tags.th(row["bigram"]),
                tags.td(f"{row['count']:,}"),
                tags.td(f"{row['percent']:.2f}"),
                tags.td(f"{row['running']:.2f}"),
                tags.td(tags.b(status(row)), class_=f"s{states.status_code(row)}")
                if states
                else tags.td(tags.b()),
                tags.td(row["layer"] if states else ""),
                tags.td(row["example"]),
                tags.td(gathered(map(self._place, row["places"][:PLACES]))),
            )
            for rank, row in enumerate(rows, 1)
        ]

    def _unknown(self, title: str, found: Sequence[Mapping[str, Any]]) -> Markup:
        """List what could not be read, the most frequent first."""
        rows: Child = (
            tags.tr(
                tags.th(one["what"], dir="auto"),
                tags.td(f"{one['count']:,}"),
                tags.td(self._place(one["place"])),
            )
            for one in found
        )
        table = tags.table(
            tags.thead(tags.tr(tags.th("what"), tags.th("times"), tags.th("first at"))),
            tags.tbody(rows),
            class_="list",
        )
        return tags.section(tags.h3(title), table if found else tags.p("None."))

    def _place(self, place: str) -> str:
        return place.removeprefix(self.folder)


def bigrams(names: Sequence[str]) -> Markup:
    """List bigrams, each in a frame of its own."""
    return tags.ul((tags.li(name) for name in names), class_="bigrams") if names else Markup()
