"""Drive: channels of a model as sums of gain times pose, with the same guarantees as poses.

Not in the paper, whose curves go to the model as they are. Poses have kept their promises already:
between 0 and 1, at most `step` a frame, contacts held, at rest at both ends. A channel is

    clip(gains @ poses, low, high), slow enough, and then never above the channel it yields to

and each promise holds on it once more:

Bounds
    Clipping sets them. An envelope stays within the range of its curve, and the last stage goes
    down no farther than `low`.
Speed
    The `span` of a channel is how far it can go: its range, or the sum of its gains' sizes where
    nothing bounds it. It passes ``step * span`` a frame as little as a pose passes `step`. Poses
    being slow, only a channel whose gains add up to more than its span can be too fast at all.
Contacts
    A channel that contact poses raise is slowed by the upper envelope: it is never below its sum,
    so where a contact holds it has the share of the contact's floors, ``clip(gains @ floor)``,
    unless another pose's gain takes from it. One that they lower is slowed by the lower envelope.
    Where they do both, the stronger wins. All others are slowed towards rest, from either side, as
    poses are: what a ceiling keeps down stays down.
Rest
    Clipping comes first, so all channels rest where all poses do. An envelope could leave rest
    before the first frame; the curve is kept within reach of it, as that of a pose is. A channel
    gets anywhere within ``1 / step`` frames, like a pose, so contacts lose nothing farther inside.
Never above another
    ``c = max(low, min(c, other))``, once `other` is final. A minimum of two slow curves is slow if
    both keep to the speed of the slower. Where `other` may move faster than `c` (more units a
    frame), the lower envelope follows: it takes away only, so `c` stays below `other`. A contact
    then keeps what `other` leaves of it, and for a faster `other` what it leaves from near by. That
    is meant: a shape that closes the lips over an open jaw has nothing to close when the jaw is.
    Only where a faster `other` drops below the rest of `c` may `c` start and end below rest.
Smooth
    Clipping and yielding put corners back into what poses had without. So a kernel rounds channels
    off once more. It keeps bounds and speed, and no channel accelerates faster than twice its
    speed over the kernel's half-width. It keeps a channel below the one it yields to where that
    does not go below its own `low`; elsewhere it is lowered once more, with its corner. Channels
    rest for as long as the kernel reaches. A contact loses at most what `prepare` gives to a pose.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.pipeline.limit import lower_envelope, upper_envelope

RESTING = 1e-4
"""Weight below which a pose counts as at rest."""


@dataclass(frozen=True, eq=False)
class Rig:
    """The gains and the bounds of each channel."""

    gains: Floats
    """(C, P) channel units per weight of each pose."""
    low: Floats
    """(C,) least value; minus infinity if unbounded."""
    high: Floats
    """(C,) greatest value; infinite if unbounded."""
    at_most: tuple[tuple[int, int], ...]
    """(channel, other): channel never above other, in an order in which each other is final."""
    contact: Ints
    """(C,) 1 if contact poses raise the channel, -1 if they lower it, otherwise 0."""

    @cached_property
    def span(self) -> Floats:
        """(C,) the range of each channel, in its units."""
        # an unbounded channel has no range; the sum of its gains is as far as poses take it
        bound = np.isfinite(self.low) & np.isfinite(self.high)
        reach: Floats = np.abs(self.gains).sum(axis=1)
        return np.where(bound, self.high - self.low, reach)

    @cached_property
    def rest(self) -> Floats:
        """(C,) value of each channel while all poses rest."""
        out = np.clip(np.zeros(len(self.low)), self.low, self.high)
        for channel, other in self.at_most:
            out[channel] = max(self.low[channel], min(out[channel], out[other]))
        return out


def sides(gains: Floats, floors: Floats) -> Ints:
    """Return 1 for channels that contact poses raise, -1 for those they lower: (C,).

    Parameters
    ----------
    gains : (C, P)
    floors : (P,) the highest floor of any contact; 0 for poses that none holds up
    """
    share = gains * floors
    strongest = share[np.arange(len(share)), np.abs(share).argmax(axis=1)]
    return np.sign(strongest).astype(np.intp)


def drive(weights: Floats, rig: Rig, step: float, kernel: Floats | None = None) -> Floats:
    """Drive the channels of a rig with poses, (T, C); the module lists their guarantees.

    Parameters
    ----------
    weights : (T, P) of a whole animation, in [0, 1], at most `step` apart from frame to frame
    step : weight by which a pose may change from frame to frame
    kernel : (2 J + 1,) rounds channels off, as from `soften.kernel`; None leaves corners
    """
    low, high = rig.low[:, None], rig.high[:, None]
    curves = np.clip(rig.gains @ weights.T, low, high)
    late = 0 if kernel is None else len(kernel) // 2
    ends = bool(weights[0].max() < RESTING), bool(weights[-1].max() < RESTING)
    if late:
        # the kernel reaches over `late` frames, so the channels rest for as many
        rest = np.clip(0.0, rig.low, rig.high)[:, None]
        curves = rest + _near_rest(curves - rest, step * rig.span[:, None], ends, late)
    fast = np.abs(np.diff(curves, axis=1)).max(axis=1, initial=0) > step * rig.span
    if fast.any():
        slow = _slowed(curves[fast], rig, fast, step, ends)
        curves[fast] = np.clip(slow, low[fast], high[fast])  # for rounding's sake
    _yield(curves, rig, rig.at_most, step)
    if kernel is not None:
        # edge values go on outside, and part the rows for one convolution
        longer = np.pad(curves, ((0, 0), (late, late)), mode="edge")
        mean = np.convolve(longer.ravel(), kernel)[late : late + longer.size]
        # the clip is for rounding alone: a mean stays in bounds
        curves = mean.reshape(longer.shape)[:, late : late + curves.shape[1]].clip(low, high)
        deep = [(one, other) for one, other in rig.at_most if rig.low[other] < rig.low[one]]
        _yield(curves, rig, deep, step)
    return np.ascontiguousarray(curves.T)


def _yield(curves: Floats, rig: Rig, pairs: Iterable[tuple[int, int]], step: float) -> None:
    """Lower (C, T) curves, in place, to the curves that limit them."""
    for channel, other in pairs:
        own = np.minimum(curves[channel], curves[other], out=curves[channel])
        np.maximum(own, rig.low[channel], out=own)
        if rig.span[other] > rig.span[channel]:
            own[:] = lower_envelope(own[None], step * rig.span[channel])[0]


def _slowed(curves: Floats, rig: Rig, which: Bools, step: float, ends: tuple[bool, bool]) -> Floats:
    """Slow (C, T) curves of some channels; channels that a contact needs stay up, or down."""
    span, rest = rig.span[which, None], np.clip(0.0, rig.low, rig.high)[which, None]
    unit = np.where(span > 0, span, 1.0)
    curves = _near_rest((curves - rest) / unit, step, ends, 0)
    below, above = lower_envelope(curves, step), upper_envelope(curves, step)
    # the median of below, rest and above: as far from rest as is slow, never beyond the curve
    towards_rest = np.maximum(below, np.minimum(above, 0.0))
    contact = rig.contact[which, None]
    out: Floats = np.where(contact > 0, above, np.where(contact < 0, below, towards_rest))
    out *= unit
    out += rest
    return out


def _near_rest(curves: Floats, step: Floats | float, ends: tuple[bool, bool], late: int) -> Floats:
    """Keep (C, T) curves within reach of 0 at the ends that are at rest, and there for a while."""
    if not any(ends):
        return curves
    reach = np.full(curves.shape[1], np.inf)
    ramp = np.maximum(np.arange(curves.shape[1]) - late, 0)
    if ends[0]:
        reach = ramp
    if ends[1]:
        reach = np.minimum(reach, ramp[::-1])
    return np.clip(curves, -reach * step, reach * step)
