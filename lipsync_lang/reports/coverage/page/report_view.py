"""View of a report, with the names and figures for the templates."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from lipsync_lang.base.presentation.wording import gathered, percent
from lipsync_lang.reports.coverage.page import charts
from lipsync_lang.reports.coverage.page.states import STATE_CODES, StateRow, States
from lipsync_lang.reports.coverage.report import labelled

MAX_PLACES = 3
"""Maximum number of places of a bigram in its row."""


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
        shares = (percent(share) for _, share in self.stack)
        return ", ".join(map(" ".join, zip(shares, names, strict=True))) or "no bigrams"

    @cached_property
    def needed(self) -> dict[str, int]:
        """The number of bigrams that cover each share of all occurrences, smallest share first."""
        needed: Mapping[str, int] = self.document["needed"]
        return {share: needed[share] for share in sorted(needed, key=float)}

    @property
    def hours_of_next(self) -> float:
        """Hours to draw the bigrams that come next."""
        return len(self.document["next_hour"]["bigrams"]) * self.minutes / 60

    def distribution(self) -> charts.Chart:
        """Chart the share of each bigram."""
        codes = "".join(map(self.states.status_code, self.rows))
        return charts.distribution(self.rows, codes, self.needed)

    def running(self) -> charts.Chart:
        """Chart the running total."""
        return charts.running(self.rows, self.needed)

    def heat_map(self) -> tuple[list[str], list[list[charts.Cell | None]]]:
        """Return the axis and the cells of the map."""
        return charts.heat_map(self.rows, list(self.document["phonemes"]))

    def other_scripts(self, *, counted: bool) -> list[Mapping[str, Any]]:
        """Return the counted or the uncounted words in other scripts."""
        words = self.document.get("other_scripts", ())
        return [word for word in words if word["counted"] == counted]

    def place(self, place: str) -> str:
        """Return a place without the common folder of all files."""
        return place.removeprefix(self.folder)

    def places(self, row: StateRow) -> str:
        """Return the first places of a bigram, grouped by file."""
        return gathered(map(self.place, row["places"][:MAX_PLACES]))
