"""Alignment of two sequences of common phonemes: an expected pronunciation and the heard one.

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

COST_TOLERANCE = 1e-9
_BOTH, _SAID, _HEARD = range(3)
MOVES_IN_BYTE = 4
"""Moves that share a byte, two bits each: a long text has a hundred million of them."""

SHIFTS = np.arange(0, 2 * MOVES_IN_BYTE, 2, dtype=np.uint8)
PACKED_ROWS = 256
"""Rows of moves that are packed together, which is quicker."""


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
    kind = [kinds.get(name, name) for name in names]
    cost = np.array([[NEAR if a == b else FAR for b in kind] for a in kind])
    np.fill_diagonal(cost, 0)
    at = names[silence]
    cost[at, :] = cost[:, at] = np.inf  # a pause is never paired with a sound
    cost[at, at] = 0
    alone = np.full(len(names), ALONE)
    alone[at] = PAUSE
    rows = np.array([names[name] for name in said], np.intp)
    columns = np.array([names[name] for name in heard], np.intp)
    moves, lows = _moves(rows, columns, cost, alone)
    # Follow the cheapest path back from its end, and collect the pairs.
    found = [-1] * len(heard)
    # Single places are read faster from a view of bytes than from an array.
    table, width, starts = moves.data.cast("B"), moves.shape[1], lows.tolist()
    i, j = len(said), len(heard)
    while i or j:
        place, part = divmod(j - starts[i], MOVES_IN_BYTE)
        move = table[(i - 1) * width + place] >> 2 * part & 3 if i else _HEARD
        i, j = i - (move != _HEARD), j - (move != _SAID)
        if move == _BOTH:
            found[j] = i
    return np.array(found, np.intp)


def _moves(
    rows: npt.NDArray[np.intp],
    columns: npt.NDArray[np.intp],
    cost: npt.NDArray[np.float64],
    alone: npt.NDArray[np.float64],
) -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.intp]]:
    """Fill the table of the dynamic programme, one row at a time.

    Moves along a row are vectorised. With ``gap[j]`` the cost of the first j heard sounds without
    partners, the row is ``gap + running minimum of (best - gap)``.

    Returns
    -------
    (n, band / 4) last moves of the cheapest paths, (n + 1,) first column of each row
    """
    n, m = len(rows), len(columns)
    width = BAND_SOUNDS + abs(n - m) + m // max(n, 1)
    middles = np.arange(n + 1) * m // max(n, 1)
    lows, highs = np.maximum(middles - width, 0), np.minimum(middles + width, m)
    moves = np.empty((n, int((highs - lows).max()) // MOVES_IN_BYTE + 1), np.uint8)
    block = np.zeros((min(n, PACKED_ROWS), moves.shape[1] * MOVES_IN_BYTE), np.uint8)
    gaps = np.concatenate([[0.0], np.cumsum(alone[columns])])
    pairs = np.concatenate([np.full((len(cost), 1), np.inf), cost[:, columns]], axis=1)
    line = np.full(m + 2, np.inf)  # one place before column 0; infinite outside of the band
    line[1 : highs[0] + 2] = gaps[: highs[0] + 1]
    steps = zip(rows.tolist(), lows.tolist(), lows[1:].tolist(), highs[1:].tolist(), strict=False)
    for i, (row, was, low, high) in enumerate(steps, start=1):
        if low == was:
            line[low] = np.inf  # left by a row whose band began further left
        up = line[low + 1 : high + 2] + alone[row]
        both = line[low : high + 1] + pairs[row, low : high + 1]
        best = np.minimum(up, both)
        gap = gaps[low : high + 1]
        now = best - gap
        np.minimum.accumulate(now, out=now)
        now += gap
        line[low + 1 : high + 2] = now
        move = block[(i - 1) % len(block), : high - low + 1]
        move[:] = np.where(up < both, _SAID, _BOTH)
        # `gap` is taken off and added again, which rounds: equal costs are no longer equal.
        move[now < best - COST_TOLERANCE] = _HEARD
        if i % len(block) == 0 or i == n:
            first = (i - 1) // len(block) * len(block)
            parts = block[: i - first].reshape(i - first, -1, MOVES_IN_BYTE)
            moves[first:i] = np.bitwise_or.reduce(parts << SHIFTS, axis=2)
    return moves, lows
