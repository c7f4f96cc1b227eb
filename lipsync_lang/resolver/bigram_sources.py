"""Sources of a bigram's curves: its file, the layers beneath, and the targets."""

import numpy as np

from lipsync_lang.arrays import Floats
from lipsync_lang.resolver.compiled import Pair
from lipsync_lang.resolver.layers import BigramRow, PairPacks


def stated(shelf: PairPacks, row: BigramRow) -> str | None:
    """Return the key of a row in the file that states it; None for a draft.

    The key is another pair's where a coarser pair, or a substitute, is drawn in its place.
    """
    for file in shelf.drawn:
        if row.place is not None and file.path == row.place.file:
            own = file.rows.get(row.origin.pair)
            if own is not None and own.place == row.place:
                return "-".join(row.origin.pair)
            return next(
                ("-".join(p) for p, one in file.rows.items() if one.place == row.place), None
            )
    return None


def beneath(shelf: PairPacks, row: BigramRow) -> BigramRow | None:
    """Return the row of the same pair without the file that states it; None for a draft."""
    if row.place is None:
        return None
    rest = tuple(file for file in shelf.drawn if file.path != row.place.file)
    return shelf.redrawn(rest).row(row.origin.pair)


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
