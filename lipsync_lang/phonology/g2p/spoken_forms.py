"""Written forms that an engine would misread, as plain data from packs.

Interjections, abbreviations, Roman numerals, and the words that only look drawn out or stuttered.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Self


class Interjection(NamedTuple):
    """The labels of an interjection, and its spelling for a voice."""

    labels: tuple[str, ...]
    say: str = ""


@dataclass(frozen=True)
class SpokenForms:
    """The written forms of a language that its pack reads, instead of its engine.

    Parameters
    ----------
    interjections : by their shortest spelling, in small letters
    abbreviations : expansions of abbreviations and signs
    counted : words before a Roman numeral that is a cardinal number
    named : words before a Roman numeral that is an ordinal number
    ordinals : ordinal numbers from 1
    doubled : words whose double letter stays when the word is drawn out
    hyphenated : words with a hyphen that are not stutters
    vowels : letters of vowels
    """

    interjections: Mapping[str, Interjection] = field(default_factory=dict)
    abbreviations: Mapping[str, str] = field(default_factory=dict)
    counted: tuple[str, ...] = ()
    named: tuple[str, ...] = ()
    ordinals: tuple[str, ...] = ()
    doubled: tuple[str, ...] = ()
    hyphenated: tuple[str, ...] = ()
    vowels: str = ""

    @classmethod
    def from_plain(cls, data: Mapping[str, Any]) -> Self:
        """Rebuild forms from `dataclasses.asdict`, perhaps by way of JSON."""
        known = {
            spelling: Interjection(tuple(labels), say)
            for spelling, (labels, say) in data["interjections"].items()
        }
        lists = ("counted", "named", "ordinals", "doubled", "hyphenated")
        return cls(**{**data, "interjections": known} | {n: tuple(data[n]) for n in lists})
