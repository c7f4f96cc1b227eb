"""Things met in a corpus, told apart and counted."""

from lipsync_lang.coverage.report import Tally

KINDS = 10_000
"""Different things that are told apart; in a corpus with more, the rest is not named."""


class Kinds:
    """Things met, how often, and where first."""

    def __init__(self) -> None:
        self._counts: dict[str, int] = {}
        self._places: dict[str, str] = {}

    def add(self, what: str, place: str) -> None:
        """Count one."""
        if what in self._counts:
            self._counts[what] += 1
        elif len(self._counts) < KINDS:
            self._counts[what] = 1
            self._places[what] = place

    def tallies(self) -> tuple[Tally, ...]:
        """Return them, most frequent first."""
        order = sorted(self._counts, key=lambda what: (-self._counts[what], what))
        return tuple(
            Tally(what=what, count=self._counts[what], place=self._places[what]) for what in order
        )
