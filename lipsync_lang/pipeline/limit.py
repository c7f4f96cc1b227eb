"""Limit speed: no pose moves faster than l_max (paper 3.2.3, figure 10).

Conventions: (P, T) is poses by frames; `step` is the largest change of weight per frame.

Two envelopes share the promise. The lower envelope is the
largest slow curve below a curve. Its use keeps every constraint, because it only takes away. The
upper envelope is the smallest slow curve above. Its use keeps contacts: their flanks widen and
their peaks stay.
"""

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints


def ramps(step: float, late: Ints) -> Floats:
    """Return the greatest weight of each pose 0, 1, 2, ... frames from an end: (P, n).

    Parameters
    ----------
    step : weight by which a pose may change from frame to frame
    late : (P,) frames of rest at the end, for a kernel to reach over
    """
    count = int(1 / step) + 1 + int(late.max(initial=0))
    return np.maximum(np.arange(count) - late[:, None], 0) * step


def rest_at_ends(curves: Floats, ramp: Floats, *, head: bool, tail: bool) -> Floats:
    """Keep (P, T) curves within reach of rest at the first and last frame of an animation.

    Parameters
    ----------
    ramp : (P, n) as from `ramps`
    head, tail : True if the frames include the animation's first, its last
    """
    out = curves.copy()
    count = min(curves.shape[1], ramp.shape[1])
    if head:
        np.minimum(out[:, :count], ramp[:, :count], out=out[:, :count])
    if tail:
        np.minimum(out[:, -count:], ramp[:, count - 1 :: -1], out=out[:, -count:])
    return out


def envelope(curves: Floats, step: float, upper: Bools) -> Floats:
    """Return slow curves: the smallest above if `upper`, (P,), otherwise the largest below.

    The upper envelope of a curve is the lower one of its negative, negated.
    """
    sign = np.where(upper, -1.0, 1.0)[:, None]
    return lower_envelope(curves * sign, step) * sign


def upper_envelope(curves: Floats, step: float) -> Floats:
    """Return the smallest curves above (P, T) that change by at most `step` a frame.

    ``u[t] = max over s of c[s] - step |t - s|``
    """
    return -lower_envelope(-curves, step)


def lower_envelope(curves: Floats, step: float) -> Floats:
    """Return the largest curves below (P, T) that change by at most `step` a frame.

    ``u[t] = min over s of c[s] + step |t - s|``, as a running minimum forwards and one backwards.
    """
    slope = np.arange(curves.shape[1]) * step
    out = np.minimum.accumulate(curves - slope, axis=1)
    # turns c - slope into c + slope, for the minimum from the other side
    out += 2 * slope
    back: Floats = np.minimum.accumulate(out[:, ::-1], axis=1)[:, ::-1] - slope
    # adding and taking away the slope rounds: the result must not leave the curve's own range
    np.maximum(back, np.minimum.reduce(curves, axis=1, keepdims=True), out=back)
    return np.minimum(back, curves, out=back)
