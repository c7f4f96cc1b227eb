"""Trigrams of a pair: the drawn ones, the phonemes that play them, and their table rows.

Trigrams are never drafted, and no phoneme plays that of its substitute (`like`): where nobody drew
three phonemes, two bigrams show them.
"""

from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.base.arrays import Ints
from lipsync_lang.resolver.compiled import LAYERS, Triple

if TYPE_CHECKING:
    from collections.abc import Mapping

    from lipsync_lang.resolver.layers import Halves, PairPacks


def drawn_trigrams(shelf: "PairPacks") -> "dict[Triple, Halves]":
    """Return the trigrams of all files; earlier layers take precedence, then earlier files."""
    found: dict[Triple, Halves] = {}
    # stable: within a layer the order of the files stays
    for file in sorted(shelf.drawn, key=lambda file: LAYERS.index(file.layer)):
        found = {**file.halves, **found}
    return found


def played_trigrams(shelf: "PairPacks", drawn: "Mapping[Triple, Halves]") -> dict[Triple, Triple]:
    """Return the drawn trigram that each three phonemes of the pair play.

    Of phonemes with shades it is the finest that is drawn, down to that of their parents.
    """
    kin: dict[str, list[str]] = {}
    for name in shelf.numbered:
        for one in {name, shelf.parents.get(name, name)}:
            kin.setdefault(one, []).append(name)
    # by the number of parents; `sorted` is stable, so ties prefer the finer first phoneme
    coarser = sorted(product((0, 1), repeat=3), key=sum)
    names = {name: (name, shelf.parents.get(name, name)) for name in shelf.numbered}
    played = {}
    for triple in drawn:
        for one, two, three in product(*(kin.get(phoneme, ()) for phoneme in triple)):
            found = ((names[one][a], names[two][b], names[three][c]) for a, b, c in coarser)
            played[one, two, three] = next(finest for finest in found if finest in drawn)
    return dict(sorted(played.items()))


def trigram_arrays(
    numbers: "Mapping[str, int]", played: "Mapping[Triple, Triple]", rows: "Mapping[Triple, int]"
) -> tuple[Ints, Ints]:
    """Return ascending codes of three phonemes, and the two rows of each: (K,) and (K, 2).

    `rows` has the number of the first row of each drawn trigram; the second follows it.
    """
    size = len(numbers)
    found = sorted(
        ((numbers[a] * size + numbers[b]) * size + numbers[c], rows[drawn])
        for (a, b, c), drawn in played.items()
    )
    codes = np.array([code for code, _ in found], np.intp)
    firsts = np.array([row for _, row in found], np.intp)
    return codes, firsts[:, None] + np.arange(2)
