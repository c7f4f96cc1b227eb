"""Sources of a bigram's curves: the pack that states it, the layers beneath it, and the targets."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.pipeline.arrays import Floats
from lipsync_lang.resolver.compiled import Pair
from lipsync_lang.resolver.layers import BigramRow, PairPacks

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Pack
    from lipsync_lang.packs.models import BigramCurves


def stated(shelf: PairPacks, row: BigramRow) -> "tuple[str, BigramCurves] | None":
    """Return the key and the fields of a row in the pack that states it; None for a draft."""
    packs: tuple[Pack[Any], ...] = (shelf.character, *shelf.own_banks, *shelf.banks)
    for pack in packs:
        if row.place is None or pack.path != row.place.file:
            continue
        bigrams = pack.model.bigrams
        own = "-".join(row.origin.pair)
        for key in (own, *bigrams):
            if key in bigrams and pack.where(("bigrams", key), key=True) == row.place:
                return key, bigrams[key]
    return None


def beneath(shelf: PairPacks, row: BigramRow) -> BigramRow | None:
    """Return the row of the same pair without the pack that states it; None for a draft."""
    if row.place is None:
        return None
    file, character = row.place.file, shelf.character
    if character.path == file:
        model = character.model.model_copy(update={"bigrams": {}})
        character = replace(character, model=model)
    rest = replace(
        shelf,
        character=character,
        banks=tuple(bank for bank in shelf.banks if bank.path != file),
        own_banks=tuple(bank for bank in shelf.own_banks if bank.path != file),
    )
    return rest.row(row.origin.pair)


def target_curves(shelf: PairPacks, pair: Pair, boundary: float) -> dict[int, Floats]:
    """Return curves that reach the targets of both phonemes in the middle of each.

    Parameters
    ----------
    boundary : normalised time at which the first phoneme ends

    Returns
    -------
    (n, 2) control points by pose number, for poses that move; 0 at either end. Empty if one of
    the phonemes has no target.
    """
    if pair[0] not in shelf.targets or pair[1] not in shelf.targets:
        return {}
    first, second = (shelf.targets[phoneme][0].weights for phoneme in pair)
    times = [*_middles(len(first), 0, boundary), *_middles(len(second), boundary, 1)]
    weights = np.concatenate((first, second))
    ends = np.zeros((1, weights.shape[1]))
    values = np.concatenate((ends, weights, ends))
    at = np.array([0, *times, 1])
    return {
        int(pose): np.column_stack((at, values[:, pose]))
        for pose in np.flatnonzero(weights.any(axis=0))
    }


def _middles(parts: int, start: float, end: float) -> list[float]:
    """Return the middles of equal parts of a span."""
    return [start + (end - start) * (part + 0.5) / parts for part in range(parts)]
