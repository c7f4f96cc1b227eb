"""Reduction of curves to keyframes within a maximum error: straight lines, or cubic curves.

For lines, the algorithm is greedy: from each key, the longest line within the error of all frames
leads to the next key. Both ends of a run of equal values are always keys, so contacts and rests
keep their exact duration and depth.

Cubic curves have few keys, for curve editors; `rigs.tracks` has their formula. Keys have the
values of their frames. Slopes are chosen by least squares; from each key, the longest span within
the bounds of all frames leads to the next key. Where both neighbouring spans allow it, a key has
one slope on both sides.

Conventions: (T, C) is frames by columns. The columns of a fit share their keys.
"""

from collections.abc import Mapping
from functools import reduce
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.faces.rigs.tracks import Spline, hermite

ERROR = 0.005
"""Default maximum error, in units of pose weight."""

LARGEST_ERROR = 0.5
"""Half of a pose's range; keys of a larger error show nothing of a curve."""

LINES = "lines:"
"""Prefix of an error of straight lines."""

DECIMAL_ROUNDING = 5e-5
"""Margin of the error for decimal rounding in files."""

CONTACT_TOLERANCE = 1e-3
"""Shortfall of a pose from the floor of its contact that nobody sees."""

SLOPE_SHARES = (0.5, 0.25, 0.75, 0.0, 1.0)
"""Shares of the later slope of a key in the one slope that is tried for both sides."""

NEGATIVE_TOLERANCE = 1e-3
"""Undershoot below a column's least value that nobody sees."""


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


def fit(times: Floats, values: Floats, error: float, floors: Floats | None = None) -> Spline:
    """Fit cubic curves to frames: `values` (T, C) at rising `times` (T,) in seconds.

    No frame is farther than `error` from its curve. Runs of equal values, such as closed lips and
    rest, are exact. Frames above `floors` (C,), the levels of contacts, stay above, within 0.001.
    """
    count = len(times)
    if count == 1:
        none = np.zeros_like(values)
        return Spline(np.zeros(1, np.int64), values, none, none)
    low = np.maximum(values - error, np.minimum(values.min(axis=0), 0.0) - NEGATIVE_TOLERANCE)
    if floors is not None:
        held = (floors > 0) & (values >= floors - CONTACT_TOLERANCE)
        low = np.where(held, np.maximum(low, floors - CONTACT_TOLERANCE), low)
    spans = _CurveSpans(times, values, low, values + error)
    still = spans.still
    keys, slopes = [0], []
    # runs and what is between them take turns
    for stop in (*(np.flatnonzero(np.diff(still)) + 1).tolist(), count - 1):
        while keys[-1] < stop:
            at = keys[-1]
            run = stop, np.zeros((2, values.shape[1]))
            end, found = run if still[at] else spans.longest(at, stop)
            keys.append(end)
            slopes.append(found)
    table = np.array(slopes)
    _join(spans, keys, table)
    none = np.zeros((1, values.shape[1]))
    arriving, leaving = np.concatenate((none, table[:, 1])), np.concatenate((table[:, 0], none))
    frames = np.array(keys, np.int64)
    return Spline(frames, values[frames], arriving, leaving)


class _CurveSpans:
    """Frames with the lowest and highest value of a curve at each: (T, C)."""

    def __init__(self, times: Floats, values: Floats, low: Floats, high: Floats) -> None:
        self.times, self.values = times, values
        self.low, self.high = low, high
        self.still = (np.diff(values, axis=0) == 0).all(axis=1)
        """(T - 1,) True from frames that the next one equals."""

    def longest(self, first: int, last: int) -> tuple[int, Floats]:
        """Return the end and the slopes (2, C) of the longest span found within the bounds.

        The search doubles the span until it leaves the bounds, then bisects.
        """
        good, bad = first + 1, last + 1
        best = self.slopes(first, good)
        # Each try costs as much as its span, so doubling keeps their sum linear.
        reach = 2
        while good < last:
            end = min(first + reach, last)
            found = self.slopes(first, end)
            if not self.fits(first, end, found):
                bad = end
                break
            good, best, reach = end, found, reach * 2
        while bad - good > 1:
            middle = (good + bad) // 2
            found = self.slopes(first, middle)
            if self.fits(first, middle, found):
                good, best = middle, found
            else:
                bad = middle
        return good, best

    def slopes(self, first: int, last: int) -> Floats:
        """Return the slopes at both ends of a span that fit its frames best: (2, C)."""
        length = self.times[last] - self.times[first]
        straight = np.tile((self.values[last] - self.values[first]) / length, (2, 1))
        if last - first == 1:
            return straight
        p, m, q, n = self._weights(first, last)
        sides = np.column_stack((m, n)) * length
        ends = np.outer(p, self.values[first]) + np.outer(q, self.values[last])
        rest = self.values[first + 1 : last] - ends
        # one inner frame leaves a slope open: the straight line decides
        return straight + np.linalg.lstsq(sides, rest - sides @ straight, rcond=None)[0]

    def fits(self, first: int, last: int, slopes: Floats) -> bool:
        """Return True if the curve of a span is within the bounds of its inner frames."""
        inner = slice(first + 1, last)
        p, m, q, n = self._weights(first, last)
        length = self.times[last] - self.times[first]
        shown = np.outer(p, self.values[first]) + np.outer(q, self.values[last])
        shown += np.column_stack((m, n)) @ slopes * length
        return bool(((shown >= self.low[inner]) & (shown <= self.high[inner])).all())

    def _weights(self, first: int, last: int) -> tuple[Floats, Floats, Floats, Floats]:
        inner = self.times[first + 1 : last] - self.times[first]
        return hermite(inner / (self.times[last] - self.times[first]))


def _join(spans: _CurveSpans, keys: list[int], table: Floats) -> None:
    """Smooth `table`, (K - 1, 2, C) slopes: a key gets one slope if both its spans allow it."""
    for number in range(1, len(keys) - 1):
        before, after = table[number - 1].copy(), table[number].copy()
        first, key, last = keys[number - 1 : number + 2]
        # a run stays flat
        runs = [spans.still[key - 1], spans.still[key]]
        for share in [float(runs[1])] if any(runs) else SLOPE_SHARES:
            joint = table[number - 1, 1] * (1 - share) + table[number, 0] * share
            before[1] = after[0] = joint
            if spans.fits(first, key, before) and spans.fits(key, last, after):
                table[number - 1], table[number] = before, after
                break
