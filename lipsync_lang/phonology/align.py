"""Align two sequences of common phonemes: an expected pronunciation and the one heard.

Dynamic programming finds the cheapest alignment. A pair of equal phonemes costs nothing, a pair of
one class (vowel for vowel) `NEAR`, any other pair `FAR`. A phoneme without a partner costs `ALONE`.
A pause without a partner costs `PAUSE`, and a pause is never paired with a sound.

The search stays in a band along the diagonal, so that time and memory grow linearly with length.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

NEAR, FAR, ALONE, PAUSE = 0.8, 1.9, 1.0, 0.2
BAND_SOUNDS = 200
"""Half the width of the band, in sounds."""

TINY = 1e-9
_BOTH, _SAID, _HEARD = range(3)


def align(
    said: Sequence[str], heard: Sequence[str], kinds: Mapping[str, str], silence: str
) -> npt.NDArray[np.intp]:
    """Return the index of the expected sound for each sound heard.

    Parameters
    ----------
    said, heard : (n,) and (m,) common phonemes, with `silence` for pauses
    kinds : the class of each common phoneme
    silence : the phoneme of pauses

    Returns
    -------
    (m,) indices into `said`, never decreasing; -1 for a sound without a partner
    """
    if not said or not heard:
        return np.full(len(heard), -1, np.intp)
    names = {name: number for number, name in enumerate(dict.fromkeys((*said, *heard, silence)))}
    cost = _costs(list(names), kinds, silence)
    alone = np.full(len(names), ALONE)
    alone[names[silence]] = PAUSE
    rows = np.array([names[name] for name in said], np.intp)
    columns = np.array([names[name] for name in heard], np.intp)
    return _back(*_moves(rows, columns, cost, alone))


def _moves(
    rows: npt.NDArray[np.intp],
    columns: npt.NDArray[np.intp],
    cost: npt.NDArray[np.float64],
    alone: npt.NDArray[np.float64],
) -> tuple[npt.NDArray[np.int8], npt.NDArray[np.intp], int]:
    """Fill the table of the dynamic programme, one row at a time.

    Moves along a row are vectorised. With ``gap[j]`` the cost of the first j heard sounds without
    partners, the row is ``gap + running minimum of (best - gap)``.

    Returns
    -------
    (n + 1, band) last moves of the cheapest paths, (n + 1,) first column of each row, and m
    """
    n, m = len(rows), len(columns)
    width = BAND_SOUNDS + abs(n - m) + m // max(n, 1)
    lows = np.array([max(0, i * m // max(n, 1) - width) for i in range(n + 1)], np.intp)
    highs = np.array([min(m, i * m // max(n, 1) + width) for i in range(n + 1)], np.intp)
    moves = np.full((n + 1, int((highs - lows).max()) + 1), _HEARD, np.int8)
    gaps = np.concatenate([[0.0], np.cumsum(alone[columns])])
    before = gaps[: highs[0] + 1]
    for i in range(1, n + 1):
        low, high, was = lows[i], highs[i], lows[i - 1]
        above = np.full(high - low + 2, np.inf)  # columns low - 1 to high of the row before
        first = max(low - 1, was)
        known = before[first - was : high + 1 - was]
        above[first - low + 1 : first - low + 1 + len(known)] = known
        up = above[1:] + alone[rows[i - 1]]
        both = above[:-1] + cost[rows[i - 1], columns[np.arange(low, high + 1) - 1]]
        best = np.minimum(up, both)
        gap = gaps[low : high + 1]
        before = np.minimum.accumulate(best - gap) + gap
        moves[i, : high - low + 1] = np.where(
            before < best - TINY, _HEARD, np.where(both <= up, _BOTH, _SAID)
        )
    return moves, lows, m


def _back(moves: npt.NDArray[np.int8], lows: npt.NDArray[np.intp], m: int) -> npt.NDArray[np.intp]:
    """Follow the cheapest path back from its end, and collect the pairs."""
    found = np.full(m, -1, np.intp)
    i, j = len(lows) - 1, m
    while i or j:
        move = moves[i, j - lows[i]] if i else _HEARD
        i, j = i - (move != _HEARD), j - (move != _SAID)
        if move == _BOTH:
            found[j] = i
    return found


def _costs(names: Sequence[str], kinds: Mapping[str, str], silence: str) -> npt.NDArray[np.float64]:
    """Return the (p, p) costs of pairs of phonemes."""
    kind = [kinds.get(name, name) for name in names]
    cost = np.array([[NEAR if a == b else FAR for b in kind] for a in kind])
    np.fill_diagonal(cost, 0)
    at = names.index(silence)
    cost[at, :] = cost[:, at] = np.inf
    cost[at, at] = 0
    return cost
