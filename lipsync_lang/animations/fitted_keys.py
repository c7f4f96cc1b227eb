"""Fitting of piecewise cubic curves with few keys, for curve editors.

Conventions: (T, C) is frames by columns, and the columns share their keys. Keys have the values of
their frames. Slopes are chosen by least squares; from each key, the longest span within the bounds
of all frames leads to the next key. Where both neighbouring spans allow it, a key has one slope on
both sides. `rigs.splines` has the formula of the curves.
"""

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.faces.rigs.splines import Spline, hermite

CONTACT_TOLERANCE = 1e-3
"""Shortfall of a pose from the floor of its contact that nobody sees."""

SLOPE_SHARES = (0.5, 0.25, 0.75, 0.0, 1.0)
"""Shares of the later slope of a key in the one slope that is tried for both sides."""

NEGATIVE_TOLERANCE = 1e-3
"""Undershoot below a column's least value that nobody sees."""


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
        even = (self.values[last] - self.values[first]) / length
        if last - first == 1:
            return np.array([even, even])
        p, m, q, n = self._weights(first, last)
        sides = np.column_stack((m, n)) * length
        ends = np.outer(p, self.values[first]) + np.outer(q, self.values[last])
        rest = self.values[first + 1 : last] - ends
        # one inner frame leaves a slope open: the straight line decides
        straight = np.array([even, even])
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
