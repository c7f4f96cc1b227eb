"""Written forms that an engine would misread, as plain data from packs.

Interjections, abbreviations, Roman numerals, and the words that only look drawn out or stuttered.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, NamedTuple, Self

NumberTables = Mapping[str, Sequence[str] | Mapping[str, str]]
"""By name: words from 1 in a row, or rules that put them together."""


class OwnWord(NamedTuple):
    """A word or interjection of a pack: labels, and a spelling for a voice; one may be empty."""

    labels: tuple[str, ...]
    say: str = ""


@dataclass(frozen=True)
class SpokenForms:
    """The written forms that a language's pack reads in place of its engine: `text` of the pack.

    Spellings of interjections are the shortest, in small letters. Words before a Roman numeral are
    `counted` if it is a cardinal number, and `named` if it is an ordinal one.
    """

    interjections: Mapping[str, OwnWord] = field(default_factory=dict)
    abbreviations: Mapping[str, str] = field(default_factory=dict)
    words: Mapping[str, OwnWord] = field(default_factory=dict)
    beginnings: Mapping[str, str] = field(default_factory=dict)
    endings: Mapping[str, Mapping[str, Sequence[str]]] = field(default_factory=dict)
    rank_cases: tuple[tuple[str, str, Mapping[str, str]], ...] = ()
    letters: Mapping[str, str] = field(default_factory=dict)
    repeated: Mapping[str, str] = field(default_factory=dict)
    joins: tuple[str, ...] = ()
    numbers: NumberTables = field(default_factory=dict)
    counted: tuple[str, ...] = ()
    named: tuple[str, ...] = ()
    ordinals: tuple[str, ...] = ()
    numeral_words: Mapping[str, Sequence[str] | None] = field(default_factory=dict)
    numerals_like: Mapping[str, str] = field(default_factory=dict)
    doubled: tuple[str, ...] = ()
    hyphenated: tuple[str, ...] = ()
    vowels: str = ""
    curses: tuple[str, ...] = ()
    censored: Mapping[str, Sequence[str]] = field(default_factory=dict)
    particles: tuple[str, ...] = ()
    thousands: str = ""
    decimal: str = ""

    @classmethod
    def from_plain(cls, data: Mapping[str, Any]) -> Self:
        """Rebuild forms from `dataclasses.asdict`, perhaps by way of JSON."""
        names = [one.name for one in fields(cls) if one.default == ()]
        tables: dict[str, Any] = {
            table: {
                word: OwnWord(tuple(labels), say) for word, (labels, say) in data[table].items()
            }
            for table in ("interjections", "words")
        }
        tables["censored"] = {sign: tuple(row) for sign, row in data["censored"].items()}
        return cls(**{**data, **tables} | {name: tuple(data[name]) for name in names})
