"""States of bigrams: the layer of their curves, and the status.

A state is written as one character, which is its index in a list: `0`, `1` ... `9`, `a`, `b` ...
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from string import ascii_lowercase, digits
from typing import Any, Self

from lipsync_lang.reports.coverage.report import AUTHORED, BORROWED_LAYER

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
