"""Reduction of curves to keyframes within a maximum error: straight lines, or cubic curves.

For lines, the algorithm is greedy: from each key, the longest line within the error of all frames
leads to the next key. `fitted_keys` fits cubic curves. Both ends of a run of equal values are
always keys, so contacts and rests keep their exact duration and depth.
"""

from collections.abc import Mapping
from functools import reduce
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from lipsync_lang.animations.fitted_keys import fit
from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.errors import LipsyncError

ERROR = 0.005
"""Default maximum error, in units of pose weight."""

LARGEST_ERROR = 0.5
"""Half of a pose's range; keys of a larger error show nothing of a curve."""

LINES = "lines:"
"""Prefix of an error of straight lines."""

DECIMAL_ROUNDING = 5e-5
"""Margin of the error for decimal rounding in files."""


class KeyedCurve(NamedTuple):
    """Keyframes of one channel."""

    name: str
    frames: Ints
    """(K,) frame numbers, increasing; the first and last frames are keys."""
    times: Floats
    """(K,) seconds, as in the animation."""
    values: Floats
    """(K,) weights."""
    arriving: Floats
    """(K,) slope before each key, per second; 0 before the first."""
    leaving: Floats
    """(K,) slope after each key, per second; 0 after the last."""
    cubic: bool = False
    """True for cubic curves between the keys, False for straight lines."""


def keyframes(times: Floats, values: Floats, error: float) -> Ints:
    """Return the frames that are keys; lines between them are within `error` of all (T,) values."""
    count = len(times)
    error = max(error - DECIMAL_ROUNDING, 0.0)
    if count <= 2:  # noqa: PLR2004 both ends
        return np.arange(count)
    held = np.diff(values) == 0
    ends = np.flatnonzero(np.diff(held)) + 1  # start or end of a run of equal values
    pinned = np.union1d([0, count - 1], ends)
    keys = [np.array([0])]
    for first, last in pairwise(pinned.tolist()):
        span = slice(first, last + 1)
        keys.append(first + _chain(times[span], values[span], error))
    return np.concatenate(keys)


def _chain(times: Floats, values: Floats, error: float) -> Ints:
    """Return the keys of a span without runs, except the first: frame numbers from its start."""
    last = len(times) - 1
    if last == 1 or values[0] == values[1]:  # a step, or a run of equal values
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
        # The slopes that pass all frames since the key within the error.
        low, high = max(low, slope - error / run), min(high, slope + error / run)
    return np.array([*keys, last])


def curves(
    names: tuple[str, ...],
    times: Floats,
    weights: Floats,
    error: float = ERROR,
    floors: Mapping[str, float] | None = None,
) -> list[KeyedCurve]:
    """Return the keyframes of each channel: `weights` (T, C) at `times` (T,) in seconds.

    No frame is farther than `error` from its curve; for cubic curves it is in (0, 0.5]. Curves are
    cubic if there are `floors`, the levels of contacts by name, and straight lines if it is None.
    """
    found = []
    for number, name in enumerate(names):
        if floors is None:
            keys = keyframes(times, weights[:, number], error)
            values = weights[keys, number]
            slopes = np.diff(values) / np.diff(times[keys])
            parts = values, np.append(0, slopes), np.append(slopes, 0)
        else:
            column, floor = weights[:, number : number + 1], np.array([floors.get(name, 0.0)])
            spline = fit(times, column, margin(error), floor)
            keys = spline.frames
            parts = (spline.values[:, 0], spline.arriving[:, 0], spline.leaving[:, 0])
        found.append(KeyedCurve(name, keys, times[keys], *parts, cubic=floors is not None))
    return found


def checked(error: float, *, lines: bool = False) -> float:
    """Return an error of keys, or refuse it: (0, 0.5] is allowed, and 0 for straight lines."""
    if lines and error == 0:
        return error
    if not 0 < error <= LARGEST_ERROR:
        least = "0 or more" if lines else "above 0"
        what = f"the largest error of keys, {least} and at most {LARGEST_ERROR:g}, such as 0.01"
        raise LipsyncError(f"keys={error:g}: give {what}")
    return error


def margin(error: float) -> float:
    """Return the error of cubic keys without the rounding of files; see `checked`."""
    return max(checked(error) - DECIMAL_ROUNDING, error / 2)


def parse_keys(text: str) -> tuple[float, bool]:
    """Parse ``0.01`` or ``lines:0.01``: the error of keys, and True for straight lines."""
    lines = text.startswith(LINES)
    try:
        error = float(text.removeprefix(LINES))
        return checked(error, lines=lines), lines
    except (ValueError, LipsyncError):
        raise LipsyncError(
            f"--keys {text}: give the largest error of keys, above 0 and at most "
            f"{LARGEST_ERROR:g} (--keys 0.01), or that of straight lines, from 0 (--keys {LINES}0)"
        ) from None


def needed(times: Floats, weights: Floats, error: float) -> Ints:
    """Return the keys that all channels share: frame numbers for `weights` (T, C).

    A key of one channel bends the lines of the others. If a line then misses a frame by more than
    `error`, its worst frame becomes a key too.
    """
    ends = np.unique([0, len(times) - 1])
    keys = reduce(np.union1d, (keyframes(times, column, error) for column in weights.T), ends)
    while True:
        lines = [np.interp(times, times[keys], column[keys]) for column in weights.T]
        strays = np.abs(np.array(lines) - weights.T).max(axis=0, initial=0.0)
        far = np.flatnonzero(strays > max(error, 1e-9 * np.abs(weights).max(initial=1.0)))
        if not far.size:
            return keys
        # Of all strays between two keys, the worst alone: it mends most of the others.
        worst = far[np.argsort(-strays[far])]
        _, first = np.unique(np.searchsorted(keys, worst), return_index=True)
        keys = np.union1d(keys, worst[first])
