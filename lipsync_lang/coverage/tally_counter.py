"""Counts of names in a corpus, such as unreadable words."""

from lipsync_lang.coverage.report import Tally

MAX_TALLY_NAMES = 10_000
"""Maximum number of distinct names; later ones are dropped."""


class TallyCounter:
    """Count and first place of each name."""

    def __init__(self) -> None:
        self._counts: dict[str, int] = {}
        self._places: dict[str, str] = {}

    def add(self, what: str, place: str) -> None:
        """Count an occurrence."""
        if what in self._counts:
            self._counts[what] += 1
        elif len(self._counts) < MAX_TALLY_NAMES:
            self._counts[what] = 1
            self._places[what] = place

    def tallies(self) -> tuple[Tally, ...]:
        """Return the counts, most frequent first."""
        order = sorted(self._counts, key=lambda what: (-self._counts[what], what))
        return tuple(
            Tally(what=what, count=self._counts[what], place=self._places[what]) for what in order
        )
