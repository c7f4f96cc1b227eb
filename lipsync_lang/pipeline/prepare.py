"""Prepare: values that depend on settings and frame rate, but not on the line.

Conventions: P poses, C contacts; half-widths are seconds, reaches and lengths whole frames unless
said otherwise; `step` is the weight by which a pose may change from frame to frame.

Kernels
    Poses that a constraint ties together keep it through the softening only with the same kernel.
    So each group has the narrowest half-width of its poses, g; what a pose wants beyond, L, it
    gets before it is held and constrained, by a kernel of sqrt(L^2 - g^2): variances add up.
Contacts
    A kernel takes from a floor f at the ends of its plateau, where it sees the flanks. These fall
    by `step` a frame at most, so that a plateau held for w frames more on each side loses at most
    ``loss(w) = sum over j of k_j min(F, step max(0, distance from the plateau - w))``. The floor
    is raised by that, as far as there is room, and then held for the least w that leaves no more
    than `GIVEN` to lose. w need not be whole: held at F + w step, the flanks that the speed limit
    puts to the plateau pass F where they should. Ceilings are the same upside down; one that a
    constraint with a floor of its contact implies is left to the constraint, which is exact.
Constraints
    A threshold of 1 or more is convex. One below is so if its higher pose never passes it, which
    is seen to, unless a contact needs more of that pose: then the constraints come once more
    after the softening, exact but with their corners. So beside a floor of the lower pose the
    higher one has a ceiling, at what their threshold leaves.

The paper has none of this.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import ceil, floor, inf
from typing import NamedTuple, Self

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.pipeline.anticipate import falling
from lipsync_lang.pipeline.constrain import Cap
from lipsync_lang.pipeline.hold import SHORTEST, Plateau, bounds
from lipsync_lang.pipeline.limit import ramps
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.soften import Blur, kernel, reach_of
from lipsync_lang.pipeline.tables import Contact, Tables

GIVEN = 0.02
"""Weight that a contact may lose if no room is left to give it back."""

ROUNDING = 1e-9
"""Tolerance for sums of weights: in floats 1 - 0.9 is not exactly 0.1."""

RIGGED = 0.02
"""Seconds: half-width of the kernel that rounds the channels of a rig off once more."""


class Reach(NamedTuple):
    """Frames on each side on which a stage depends; infinite if unbounded."""

    back: float
    """Frames."""
    ahead: float
    """Frames."""


@dataclass(frozen=True, eq=False, repr=False)
class StageValues:
    """Values that a performance derives from its tables, motion and frame rate."""

    step: float
    wide: tuple[Blur, ...]
    """Kernels before the constraints."""
    shared: tuple[Blur, ...]
    """Kernels after them, the same for all poses of a group."""
    ramps: Floats
    """(P, n) maximum distance of each pose from rest by frames from an end."""
    early: Ints
    """(R,) poses with anticipation."""
    left: Floats
    """(R, n) remaining share of these poses by frames ahead."""
    blocked: Floats
    """(R, P) share by which each pose prevents their anticipation."""
    opposed: Bools
    """(R, N) True for phonemes that prevent their anticipation."""
    levels: tuple[Floats, ...]
    """(2, P, 1) minimum and maximum weight in each contact while it is held."""
    contested: Ints
    """(K,) poses that some contacts hold up, and others keep down."""
    longer: float
    """Maximum number of frames by which a plateau is extended, on each side."""
    tops: Floats
    """(P,) greatest weight that leaves room for what a pose outranks, and keeps pairs convex."""
    topped: bool
    """True if any pose has less than 1."""
    convex: bool
    """True if the softening keeps every constraint by itself."""
    lead: int
    """Frames from rest to the first held frame of a contact; 0 without a floor."""
    reach: dict[str, Reach]
    """Frames on which each stage depends, by its name."""

    def __getstate__(self) -> dict[str, object]:
        """Return the fields, without the copy of the kernel: only its own process can use it."""
        return {name: value for name, value in vars(self).items() if not name.startswith("_")}

    @property
    def halo(self) -> float:
        """Frames on either side on which a frame depends in all stages together."""
        looks = self.reach.values()
        return max(sum(r.back for r in looks), sum(r.ahead for r in looks))


MAX_PREPARED = 64
"""Maximum number of cached motions and frame rates; a studio tries many."""


def prepare(tables: Tables, motion: Motion, fps: float) -> StageValues:
    """Derive the values of a motion at a frame rate; the tables cache them.

    Parameters
    ----------
    tables : with the thresholds that the motion asks for
    fps : frames per second
    """
    known = tables.prepared
    # one look-up, since the hash of a motion takes all of its fields
    found: StageValues | None = known.get((motion, fps))
    if found is None:
        if len(known) >= MAX_PREPARED:
            known.clear()
        found = known[motion, fps] = _prepared(tables, motion, fps)
    return found


def _prepared(tables: Tables, motion: Motion, fps: float) -> StageValues:
    step = motion.speed_limit / fps
    # poses shown one at a time are 0 or 1, and must stay so
    half = np.zeros_like(tables.softness) if motion.hold else tables.softness * motion.softness
    narrow, extra = _shared(tables, half)
    soft = bool(half.any())
    keeping = _HoldLevels.of(narrow, step, fps)
    room, convex = _room(tables)
    contacts = tables.contacts if motion.contacts == "hold" else ()
    raised = tuple(keeping.levels(c.floor, c.raised, room) for c in contacts)
    ones = np.ones(len(half))
    under = [keeping.levels(1 - c.ceiling, _unimplied(tables, c), ones) for c in contacts]
    lowered = tuple(
        (*(Plateau(p, 1 - weight) for p, weight in levels), *_excluded(tables, c, high, keeping))
        for c, levels, high in zip(contacts, under, raised, strict=True)
    )
    enveloped = motion.limit == "before" and not motion.hold
    both = {p for levels in lowered for p, _ in levels if tables.held[p]}
    # what a level wants beyond the range of its pose lengthens the plateau by so many frames
    above = [weight - room[pose] for levels in raised for pose, weight in levels]
    below = [-weight for levels in lowered for _, weight in levels]
    longer = float(max((0.0, *above, *below))) / step
    late = np.array([reach_of(width, fps) for width in narrow.tolist()])
    channel = reach_of(RIGGED * motion.softness, fps) if soft else 0
    leads = (max(int(late[p]), channel) + ceil(w / step - 1e-9) for c in raised for p, w in c)
    frames = tables.anticipate * motion.anticipate * fps
    # within one frame there is no earlier frame to raise
    early = np.flatnonzero(frames > 1)
    left = falling(frames[early])
    # a shown drawing is whole
    tops = ones if motion.hold else _tops(tables, raised, room, soft=soft)
    return StageValues(
        step=step,
        wide=_blurs(extra, fps),
        shared=_blurs(narrow, fps),
        ramps=ramps(step, late),
        early=early,
        left=left,
        blocked=tables.blockers[early],
        opposed=np.ascontiguousarray(tables.opposed[:, early].T),
        levels=tuple(bounds(*sides, len(half)) for sides in zip(raised, lowered, strict=True)),
        contested=np.array(sorted(both) if enveloped else (), np.intp),
        longer=longer,
        tops=tops,
        topped=bool((tops < 1).any()),
        convex=convex or not soft,
        lead=max(leads, default=0),
        reach=_reaches(motion, fps, left.shape[1] - 1, longer, (extra, narrow)),
    )


def channel_kernel(motion: Motion, fps: float) -> Floats | None:
    """Return the kernel for the channels of a rig; None leaves their corners."""
    half = 0.0 if motion.hold else RIGGED * motion.softness
    return kernel(half, fps) if half > 0 else None


def _shared(tables: Tables, half: Floats) -> tuple[Floats, Floats]:
    """Return each pose's half-width after the constraints, and the one before them: (P,) each."""
    group = np.arange(len(half))
    for one, other in [(cap.low, cap.high) for cap in tables.caps] + list(tables.at_most):
        # union of the groups of both poses, by relabelling: there are few poses
        group[group == group[one]] = group[other]
    narrow = np.array([half[group == mine].min() for mine in group])
    return narrow, np.sqrt(np.maximum(half**2 - narrow**2, 0))


def _blurs(half: Floats, fps: float) -> tuple[Blur, ...]:
    """Return one blur for each half-width above 0."""
    # a set, since the first call of `np.unique` imports `numpy.ma` for 10 ms
    widths = sorted(set(half[half > 0].tolist()))
    return tuple(Blur(np.flatnonzero(half == width), kernel(width, fps)) for width in widths)


def _room(tables: Tables) -> tuple[Floats, bool]:
    """Return the limit for raising each floor, (P,), and True if all pairs can be convex."""
    floors, room, convex = tables.floors, np.ones(len(tables.floors)), True
    for cap in tables.caps:
        low, high, threshold = cap
        # what two floors leave of their threshold is divided evenly between them
        shared = max(threshold - floors[low] - floors[high], 0)
        if floors[low] > 0 and not _exclusive(tables, cap):
            for pose in (low, high):
                room[pose] = min(room[pose], max(floors[pose] + shared / 2, floors[pose]))
        elif floors[low] > 0:
            room[low] = min(room[low], max(threshold, floors[low]))
        if threshold < 1:
            convex &= bool(threshold >= floors[high])
            room[high] = min(room[high], max(threshold, floors[high]))
    return room, convex


def _unimplied(tables: Tables, contact: Contact) -> list[int]:
    """Return the poses whose ceiling does not follow from a constraint with a floor."""
    kept = {
        cap.low
        for cap in tables.caps
        if contact.floor[cap.high] > 0
        and cap.threshold - contact.floor[cap.high] <= contact.ceiling[cap.low] + ROUNDING
    }
    return [pose for pose in contact.lowered if pose not in kept]


def _exclusive(tables: Tables, cap: Cap) -> bool:
    """Return True if a pose makes room for the floor of one that it outranks only while it is held.

    Two contact poses exclude each other if their floors pass the threshold.
    """
    low, high = tables.floors[[cap.low, cap.high]]
    return bool(low > 0 and (high == 0 or low + high > cap.threshold + ROUNDING))


def _excluded(
    tables: Tables, contact: Contact, raised: Sequence[Plateau], keeping: "_HoldLevels"
) -> Iterator[Plateau]:
    """Yield ceilings of poses that a contact keeps down for its own floors."""
    levels = dict(raised)
    for cap in tables.caps:
        low, high, threshold = cap
        if low in levels and high not in levels and _exclusive(tables, cap):
            yield Plateau(high, threshold - levels[low])
            if threshold < tables.floors[high]:  # not convex: kept once more after the softening
                under = 1 - threshold + float(contact.floor[low])
                yield Plateau(high, 1 - keeping.level(high, under, 1.0))


def _tops(
    tables: Tables, raised: Sequence[Sequence[Plateau]], room: Floats, *, soft: bool
) -> Floats:
    """Return the greatest weight of each pose: (P,)."""
    held = np.zeros(len(room))
    for pose, weight in (level for levels in raised for level in levels):
        held[pose] = max(held[pose], min(weight, room[pose]))
    tops = np.ones(len(room))
    for cap in tables.caps:
        low, high, threshold = cap
        if held[low] > 0 and not _exclusive(tables, cap):
            tops[high] = min(tops[high], threshold - held[low])
        if soft and threshold < 1:
            tops[high] = min(tops[high], max(threshold, tables.floors[high]))
    return tops


def _reaches(
    motion: Motion, fps: float, ahead: int, longer: float, half: tuple[Floats, Floats]
) -> dict[str, Reach]:
    """Return the reach of each stage; absent stages look at their own frame alone."""
    step = motion.speed_limit / fps
    slope = ceil(1 / step + longer)
    wide, shared = (reach_of(float(h.max(initial=0)), fps) for h in half)
    filled = {"none": 0.0, "closing": max(0, round(motion.window * fps) - 1), "chord": inf}
    smooth = filled[motion.smooth]
    # a bigram stretches over a whole pause, whose end is not known before the next sound
    paused = inf if motion.silence_reach == inf else 0
    looks = {
        "stitch": Reach(paused, paused),
        "smooth": Reach(smooth, smooth),
        "switch": Reach(inf, inf) if motion.hold else Reach(0, 0),
        "anticipate": Reach(0, ahead),
        "ease": Reach(wide, wide),
        "rest": Reach(inf, inf) if motion.ends == "cut" else Reach(slope + shared, slope + shared),
        "limit": Reach(slope, slope),
        "soften": Reach(shared, shared),
    }
    return {name: look for name, look in looks.items() if look != (0, 0)}


class _HoldLevels(NamedTuple):
    """Levels that keep a contact through the softening."""

    kernels: tuple[Floats, ...]
    step: float
    plateau: int
    """Minimum number of frames of a held contact."""

    @classmethod
    def of(cls, half: Floats, step: float, fps: float) -> Self:
        """Take each pose's half-width after the constraints."""
        kernels = tuple(kernel(width, fps) for width in half.tolist())
        return cls(kernels, step, max(1, floor(max(SHORTEST * fps, 1) + 1e-6)))

    def lost(self, pose: int, weight: float, longer: float) -> float:
        """Return the weight lost at the end of a plateau that is extended by `longer` frames."""
        at = np.arange(len(self.kernels[pose])) - len(self.kernels[pose]) // 2
        away = np.where(at < 0, -at, at - (self.plateau - 1)) - longer
        return float(self.kernels[pose] @ np.minimum(self.step * np.maximum(away, 0), weight))

    def level(self, pose: int, wanted: float, room: float) -> float:
        """Return the level at which to hold a pose for a wanted weight."""
        raised = min(max(room, wanted), wanted + self.lost(pose, 1.0, 0))
        allowed = raised - wanted + GIVEN
        low, high = 0.0, float(len(self.kernels[pose]) // 2)
        if self.lost(pose, raised, low) <= allowed:
            return raised
        # bisection: the loss falls as the plateau grows
        while high - low > 1e-3:  # noqa: PLR2004 of a frame
            middle = (low + high) / 2
            enough = self.lost(pose, raised, middle) <= allowed
            low, high = (low, middle) if enough else (middle, high)
        return raised + high * self.step

    def levels(self, wanted: Floats, poses: Sequence[int], room: Floats) -> tuple[Plateau, ...]:
        """Return the plateau of each of some poses."""
        return tuple(Plateau(p, self.level(p, float(wanted[p]), float(room[p]))) for p in poses)
