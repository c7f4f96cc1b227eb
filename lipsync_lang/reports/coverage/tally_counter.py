"""Counts of names in a corpus, such as unreadable words."""

from collections import Counter

from lipsync_lang.reports.coverage.report import Tally

MAX_TALLY_NAMES = 10_000
"""Maximum number of distinct names; later ones are dropped."""


class TallyCounter:
    """Count and first place of each name."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._places: dict[str, str] = {}

    def add(self, what: str, place: str) -> None:
        """Count an occurrence."""
        if what in self._places or len(self._places) < MAX_TALLY_NAMES:
            self._counts[what] += 1
            self._places.setdefault(what, place)

    def tallies(self) -> tuple[Tally, ...]:
        """Return the counts, most frequent first."""
        order = sorted(self._counts.items(), key=lambda item: (-item[1], item[0]))
        return tuple(Tally(what=what, count=n, place=self._places[what]) for what, n in order)
