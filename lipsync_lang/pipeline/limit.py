"""Limit speed: no pose moves faster than l_max (paper 3.2.3, figure 10).

Two envelopes share the promise. The lower one, the largest curve below that is slow enough, only
takes away, so it keeps every constraint. The upper one, the smallest above, keeps what must be
seen: a contact's flanks widen and its peak stays.
"""

import numpy as np

from lipsync_lang.pipeline.arrays import Bools, Floats, Ints


def ramps(step: float, late: Ints) -> Floats:
    """Return how far from rest poses may be 0, 1, 2, ... frames from an end: (P, n).

    Parameters
    ----------
    step : weight by which a pose may change from frame to frame
    late : (P,) frames for which a pose rests first, so that a kernel may reach over them
    """
    count = int(1 / step) + 1 + int(late.max(initial=0))
    out: Floats = np.maximum(np.arange(count) - late[:, None], 0) * step
    return out


def rest_at_ends(curves: Floats, ramp: Floats, *, head: bool, tail: bool) -> Floats:
    """Keep (P, T) curves within reach of rest at the first and last frame of an animation.

    Parameters
    ----------
    ramp : (P, n) as from `ramps`
    head, tail : whether these frames include the animation's first, its last
    """
    out = curves.copy()
    count = min(curves.shape[1], ramp.shape[1])
    if head:
        np.minimum(out[:, :count], ramp[:, :count], out=out[:, :count])
    if tail:
        np.minimum(out[:, -count:], ramp[:, count - 1 :: -1], out=out[:, -count:])
    return out


def envelope(curves: Floats, step: float, upper: Bools) -> Floats:
    """Return slow curves: the smallest above where `upper`, (P,), the largest below elsewhere.

    The one is the other upside down.
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
    out += 2 * slope
    back: Floats = np.minimum.accumulate(out[:, ::-1], axis=1)[:, ::-1] - slope
    # rounding must not leave the curve's own range
    np.maximum(back, np.minimum.reduce(curves, axis=1, keepdims=True), out=back)
    return np.minimum(back, curves, out=back)
