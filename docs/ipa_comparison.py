"""Comparison of languages: the mappings of each IPA symbol, and the reasons for differences.

The usual mapping of a symbol is that of most packs. A pack with another mapping gives a reason: in
its own `reasons`, in a decision that languages share, or because it maps the symbol as its letters.
"""

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from typing import NamedTuple

from lipsync_lang.packs import models
from lipsync_lang.packs.finding import IPA
from lipsync_lang.packs.library import Library

MAX_PIECES = 4
"""Maximum number of letters of a symbol in a search for the parts of its mapping."""

CommonSequence = tuple[str, ...]
"""The common phonemes of a symbol, in sequence; empty if it is silent."""


class UnusualMapping(NamedTuple):
    """An unusual mapping of a symbol, with the packs that share it."""

    to: CommonSequence
    reason: str
    """The reason; empty if none is stated."""
    languages: tuple[str, ...]


class SymbolMappings(NamedTuple):
    """A symbol of the IPA with its mappings in all languages."""

    symbol: str
    usual: CommonSequence
    languages: tuple[str, ...]
    """Names of the packs with this mapping."""
    unusual: tuple[UnusualMapping, ...]


def compare(library: Library) -> list[SymbolMappings]:
    """Compare the mappings of all languages found, the most widespread symbols first.

    A pack with a private tag is another mapping of a language, and is left out.
    """
    packs = [library.language(found.name).model for found in library.names("language")]
    own = [pack for pack in packs if "-x-" not in pack.tag]
    return compare_models(own, library.ipa().model.decided)


def compare_models(
    packs: Iterable[models.Language], decided: Sequence[models.Decision] = ()
) -> list[SymbolMappings]:
    """Compare the mappings of languages; `decided` are decisions that languages share."""
    tables = {
        pack.name: {label: tuple(sounds.to) for label, sounds in pack.notations[IPA].items()}
        for pack in packs
        if IPA in pack.notations
    }
    own = {pack.name: pack.reasons for pack in packs}
    shared = {(label, one.to): one.why for one in decided for label in one.labels}
    mapped: dict[str, dict[CommonSequence, list[str]]] = {}
    for name, table in tables.items():
        for label, to in table.items():
            mapped.setdefault(label, {}).setdefault(to, []).append(name)
    numbers = {label: sum(map(len, found.values())) for label, found in mapped.items()}
    order = sorted(mapped, key=lambda label: (-numbers[label], label))
    return [_row(label, mapped[label], tables, own, shared) for label in order]


def _row(
    label: str,
    found: Mapping[CommonSequence, Sequence[str]],
    tables: Mapping[str, Mapping[str, CommonSequence]],
    own: Mapping[str, Mapping[str, str]],
    shared: Mapping[tuple[str, CommonSequence], str],
) -> SymbolMappings:
    reasons = {
        name: own[name].get(label) or shared.get((label, to)) or _as_letters(label, tables[name])
        for to, names in found.items()
        for name in names
    }

    def rank(to: CommonSequence) -> tuple[int, int]:
        """Return the number of packs with a mapping, and of those without a reason."""
        return len(found[to]), sum(not reasons[name] for name in found[to])

    usual = max(found, key=rank)
    groups = Counter((to, reasons[name]) for to, names in found.items() for name in names)
    unusual = [
        UnusualMapping(to, why, tuple(name for name in found[to] if reasons[name] == why))
        for (to, why), _ in groups.most_common()
        if to != usual
    ]
    return SymbolMappings(label, usual, tuple(found[usual]), tuple(unusual))


def _as_letters(label: str, table: Mapping[str, CommonSequence]) -> str:
    """Return a phrase on the labels that explain a mapping; empty if none do.

    These are a shorter label with the same mapping, or letters with this mapping in sequence.
    """
    shorter = (label[:end] for end in range(len(label) - 1, 0, -1))
    one = next((part for part in shorter if table.get(part) == table[label]), "")
    if one:
        return f"as {one}"
    wanted = _sequence(table[label])

    def cut(rest: str, parts: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
        """Yield the divisions into other labels that together have the mapping."""
        if not rest:
            if _sequence([name for part in parts for name in table[part]]) == wanted:
                yield parts
            return
        for end in range(len(rest), 0, -1):
            if rest[:end] in table and rest[:end] != label and len(parts) < MAX_PIECES:
                yield from cut(rest[end:], (*parts, rest[:end]))

    return next((f"as {' and '.join(parts)}" for parts in cut(label, ()) if len(parts) > 1), "")


def _sequence(names: Iterable[str]) -> list[str]:
    """Return common phonemes in sequence; a repeated one is one long sound."""
    return [name for name, _ in groupby(names)]
