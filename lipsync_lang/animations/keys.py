"""Curves as keyframes: as few as keep to a stated error, joined by straight lines.

From a key, the longest line is drawn that passes no frame by more than the error and ends on a
frame; there the next key is. What is held stays held: where a value repeats, both ends of the
run are keys, so that a contact or a rest is as long and as deep as it was.
"""

from functools import reduce
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

ERROR = 0.005
"""The most that a curve may stray, of the weight of a pose, where nothing else is asked for."""

ROUNDING = 5e-5
"""What of an error is kept back for the decimals of files, so that they keep to it as well."""


class Curve(NamedTuple):
    """The keyframes of one channel."""

    name: str
    frames: Ints
    """(K,) numbers of frames, rising; the first and the last are keys."""
    times: Floats
    """(K,) seconds, as the animation has them."""
    values: Floats
    """(K,)"""


def keyframes(times: Floats, values: Floats, error: float) -> Ints:
    """Return which of T frames are keys.

    Parameters
    ----------
    times, values : (T,) seconds, rising, and values of one curve
    error : the most that a line between two keys may miss a frame between them by; 0 keeps all
        frames but those on a straight line
    """
    count = len(times)
    error = max(error - ROUNDING, 0.0)
    if count <= 2:  # noqa: PLR2004 both ends
        return np.arange(count)
    held = np.diff(values) == 0
    ends = np.flatnonzero(np.diff(held)) + 1  # where a run of equal values begins or ends
    pinned = np.union1d([0, count - 1], ends)
    keys = [np.array([0])]
    for first, last in pairwise(pinned.tolist()):
        span = slice(first, last + 1)
        keys.append(first + _chain(times[span], values[span], error))
    return np.concatenate(keys)


def _chain(times: Floats, values: Floats, error: float) -> Ints:
    """Return the keys after the first, of frames that do not hold."""
    last = len(times) - 1
    if last == 1 or values[0] == values[1]:  # a step, or a run that holds
        return np.array([last])
    at, level = times.tolist(), values.tolist()
    keys: list[int] = []
    key, reached = 0, 1
    low, high = -np.inf, np.inf
    for frame in range(1, last + 1):
        run = at[frame] - at[key]
        slope = (level[frame] - level[key]) / run
        if not low <= slope <= high:
            key = reached
            keys.append(key)
            low, high = -np.inf, np.inf
            run = at[frame] - at[key]
            slope = (level[frame] - level[key]) / run
        reached = frame
        low, high = max(low, slope - error / run), min(high, slope + error / run)
    return np.array([*keys, last])


def curves(
    names: tuple[str, ...], times: Floats, weights: Floats, error: float = ERROR
) -> list[Curve]:
    """Return the keyframes of every channel of an animation.

    Parameters
    ----------
    names : C channels
    times : (T,) seconds
    weights : (T, C)
    error : see `keyframes`; 0 keeps every frame that is not on a straight line
    """
    found = []
    for number, name in enumerate(names):
        frames = keyframes(times, weights[:, number], error)
        found.append(Curve(name, frames, times[frames], weights[frames, number]))
    return found


def needed(times: Floats, weights: Floats, error: float) -> Ints:
    """Return which of T frames any channel needs, for formats that share their keyframes."""
    ends = np.unique([0, len(times) - 1])
    return reduce(np.union1d, (keyframes(times, column, error) for column in weights.T), ends)
