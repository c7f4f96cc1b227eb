"""Written forms that an engine would misread, as plain data from packs.

Interjections, abbreviations, Roman numerals, and the words that only look drawn out or stuttered.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self

NumberTables = Mapping[str, Sequence[str] | Mapping[str, str]]
"""By name: words from 1 in a row, or rules that put them together."""


class Interjection(NamedTuple):
    """The labels of an interjection, and its spelling for a voice."""

    labels: tuple[str, ...]
    say: str = ""


class OwnWord(NamedTuple):
    """A word of a pack: its labels, and a spelling to read in its place; one may be empty."""

    labels: tuple[str, ...]
    say: str = ""


@dataclass(frozen=True)
class SpokenForms:
    """The written forms that a language's pack reads in place of its engine: `text` of the pack.

    Spellings of interjections are the shortest, in small letters. Words before a Roman numeral are
    `counted` if it is a cardinal number, and `named` if it is an ordinal one.
    """

    interjections: Mapping[str, Interjection] = field(default_factory=dict)
    abbreviations: Mapping[str, str] = field(default_factory=dict)
    words: Mapping[str, OwnWord] = field(default_factory=dict)
    beginnings: Mapping[str, str] = field(default_factory=dict)
    endings: Mapping[str, Mapping[str, Sequence[str]]] = field(default_factory=dict)
    letters: Mapping[str, str] = field(default_factory=dict)
    repeated: Mapping[str, str] = field(default_factory=dict)
    numbers: NumberTables = field(default_factory=dict)
    counted: tuple[str, ...] = ()
    named: tuple[str, ...] = ()
    ordinals: tuple[str, ...] = ()
    numeral_words: tuple[str, ...] = ()
    doubled: tuple[str, ...] = ()
    hyphenated: tuple[str, ...] = ()
    vowels: str = ""
    censored: tuple[str, ...] = ()
    thousands: str = ""
    decimal: str = ""

    @classmethod
    def from_plain(cls, data: Mapping[str, Any]) -> Self:
        """Rebuild forms from `dataclasses.asdict`, perhaps by way of JSON."""
        known = {
            spelling: Interjection(tuple(labels), say)
            for spelling, (labels, say) in data["interjections"].items()
        }
        words = {w: OwnWord(tuple(labels), say) for w, (labels, say) in data["words"].items()}
        tables = {"interjections": known, "words": words}
        lists = (
            "counted",
            "named",
            "ordinals",
            "numeral_words",
            "doubled",
            "hyphenated",
            "censored",
        )
        return cls(**{**data, **tables} | {name: tuple(data[name]) for name in lists})
