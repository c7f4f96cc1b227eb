"""Two ways to say one thing, side by side: which sound of one is which of the other.

What a pronunciation says and what a voice was heard to say differ by a sound here and there. The
alignment is the cheapest by dynamic programming: the same common phoneme costs nothing, another
of its kind (vowel for vowel) `NEAR`, any other `FAR`, one that only one of the two has `ALONE`.
Pauses, which only the voice knows for sure, cost `PAUSE`, and are never taken for a sound.

It is searched in a band along the diagonal, so that its cost grows linearly with length.
"""

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

NEAR, FAR, ALONE, PAUSE = 0.8, 1.9, 1.0, 0.2
BAND_SOUNDS = 200
"""Sounds that the two may drift apart."""

TINY = 1e-9
_BOTH, _SAID, _HEARD = range(3)


def align(
    said: Sequence[str], heard: Sequence[str], kinds: Mapping[str, str], silence: str
) -> npt.NDArray[np.intp]:
    """Find for each sound that is heard the one that is said.

    Parameters
    ----------
    said, heard : (n,) and (m,) common phonemes, `silence` among them
    kinds : of each common phoneme; sounds of one kind are near
    silence : the phoneme of pauses

    Returns
    -------
    (m,) indices into `said`, never falling; -1 for a sound that nothing says
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
    """Return the last move of the cheapest way to each place of the band, by row.

    That is (n + 1, band), the column of each row's first place (n + 1,), and m.
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
    """Walk the cheapest way back from its end."""
    found = np.full(m, -1, np.intp)
    i, j = len(lows) - 1, m
    while i or j:
        move = moves[i, j - lows[i]] if i else _HEARD
        i, j = i - (move != _HEARD), j - (move != _SAID)
        if move == _BOTH:
            found[j] = i
    return found


def _costs(names: Sequence[str], kinds: Mapping[str, str], silence: str) -> npt.NDArray[np.float64]:
    """Return what it costs to take one phoneme for another: (p, p)."""
    kind = [kinds.get(name, name) for name in names]
    cost = np.array([[NEAR if a == b else FAR for b in kind] for a in kind])
    np.fill_diagonal(cost, 0)
    at = names.index(silence)
    cost[at, :] = cost[:, at] = np.inf
    cost[at, at] = 0
    return cost
