"""The state a bigram is in: whose layer its curves come from, and who has seen them.

A state is written as one character, its place in a list: `0`, `1` ... `9`, `a`, `b` ...
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from string import ascii_lowercase, digits
from typing import Any, Self

Row = Mapping[str, Any]
"""A bigram of a report, as the document has it."""

NONE = "gap"
"""Of bigrams without curves, for which the document leaves the status empty."""

LENT, BORROWED = "like", "borrowed"
"""The layer of curves that are another sound's; nobody drew them for this one."""

STATUSES = {
    "approved": "a person has approved it",
    "edited": "a person has drawn it",
    BORROWED: "drawn by a person for a sound like it",
    "drafted": "drawn by the program, seen by nobody",
    NONE: "no curves at all",
}
LAYERS = {
    "character": "the character's own",
    "language": "of the language",
    "shared": "shared by all languages",
    LENT: "lent by a sound like it",
    "draft": "made from the poses",
    NONE: "no curves at all",
}
"""In the order of legends; the document may name others, which come after them."""

DRAWN = ("approved", "edited")
CODES = digits + ascii_lowercase


@dataclass(frozen=True)
class States:
    """The states that a document's bigrams are in."""

    statuses: tuple[str, ...]
    layers: tuple[str, ...]
    seen: frozenset[str]
    """Those that there are."""

    @classmethod
    def of(cls, rows: Iterable[Row]) -> Self:
        """Collect the states of some bigrams."""
        found = [(status(row), str(row["layer"])) for row in rows]
        statuses = dict.fromkeys((*STATUSES, *(one for one, _ in found)))
        layers = dict.fromkeys((*LAYERS, *(one for _, one in found)))
        return cls(tuple(statuses), tuple(layers), frozenset(one for both in found for one in both))

    def status_code(self, row: Row) -> str:
        """Write the status of a bigram as a character."""
        return CODES[self.statuses.index(status(row))]

    def layer_code(self, row: Row) -> str:
        """Write the layer of a bigram as a character."""
        return CODES[self.layers.index(row["layer"])]

    def shares(self, rows: Iterable[Row]) -> dict[str, tuple[int, int]]:
        """Count the bigrams of each status, and how often they are heard."""
        found = dict.fromkeys(self.statuses, (0, 0))
        for row in rows:
            bigrams, heard = found[status(row)]
            found[status(row)] = (bigrams + 1, heard + row["count"])
        return found


def status(row: Row) -> str:
    """Return the status of a bigram; a gap has a name too, and what is lent is not its own."""
    if row["layer"] == LENT and row["status"] in DRAWN:
        return BORROWED
    return str(row["status"] or NONE)
