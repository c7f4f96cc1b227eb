"""The stages in order, from a track to weights, in blocks so that the cost is linear.

Conventions: (P, T) is poses by frames; `begin` and `stop` count the animation's frames. By default
the speed limit comes before the constraints; the paper has it after them. The paper's own stages
are stitch, smooth, constrain and limit.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.pipeline import kernel_plan
from lipsync_lang.pipeline.anticipate import anticipate
from lipsync_lang.pipeline.bend import Bend, bend
from lipsync_lang.pipeline.constrain import constrain
from lipsync_lang.pipeline.hold import SHORTEST, demands, held_frames, hold
from lipsync_lang.pipeline.levels import Blend, Dial, scale, shares
from lipsync_lang.pipeline.limit import envelope, lower_envelope, rest_at_ends
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.overlay import Overlay, lay_over
from lipsync_lang.pipeline.prepare import StageValues, prepare
from lipsync_lang.pipeline.smooth import chord, closing, closing_within
from lipsync_lang.pipeline.soften import soften
from lipsync_lang.pipeline.switch import FREE, NONE, switch
from lipsync_lang.pipeline.tables import RESOLUTION, Tables
from lipsync_lang.pipeline.track import Track
from lipsync_lang.pipeline.warp import FramePlace, locate, positions, stitch, warp

CURVE_RATE = 600.0
"""Frames per second of curves that do not depend on the output's rate.

24, 25, 30, 50, 60, 100 and 120 divide it, so that their frames are read and not interpolated.
"""

BLOCK = 8192
"""Number of frames of a block, whose arrays fit into the processor's cache."""


class Stage(NamedTuple):
    """The curves after one stage."""

    name: str
    curves: Floats
    """(P, T)"""


class FinalFrames(NamedTuple):
    """Frames that nothing fed later changes."""

    times: Floats
    """(k,) seconds."""
    weights: Floats
    """(k, P) in [0, 1]."""


@dataclass(frozen=True)
class Frames:
    """Output frames: frame k lies at ``start + (first + k) / fps`` seconds."""

    start: float
    first: int
    count: int
    fps: float

    def times(self, begin: int = 0, stop: int | None = None) -> Floats:
        """Return the seconds of frames `begin` to `stop`."""
        stop = self.count if stop is None else stop
        return self.start + np.arange(self.first + begin, self.first + stop) / self.fps


@dataclass(frozen=True, eq=False, repr=False)
class Performance:
    """State of a track in the stages."""

    tables: Tables
    track: Track
    motion: Motion
    frames: Frames
    prepared: StageValues
    """The settings at this frame rate."""
    overlays: tuple[Overlay, ...]
    blends: tuple[Blend, ...] = ()
    dials: tuple[Dial, ...] = ()
    bends: tuple[Bend, ...] = ()
    others: tuple[Track, ...] = ()
    """Tracks of sounds that are as likely; their mean is played, with the contacts of `track`."""

    @cached_property
    def curves(self) -> "Performance | None":
        """The same line at `CURVE_RATE`, if the motion is the paper's, which knows no frames.

        A maximum between two frames is none of either, and a chord (paper 3.2.1) joins maxima.
        None where frames count: at rest, in held contacts, and for single poses.
        """
        motion = self.motion
        framed = motion.ends == "rest" or motion.contacts == "hold" or motion.hold
        if framed or motion.smooth != "chord" or self.frames.fps == CURVE_RATE:
            return None
        prepared = prepare(self.tables, motion, CURVE_RATE)
        frames = lay_frames(self.track, motion, CURVE_RATE, prepared.lead)
        return replace(self, frames=frames, prepared=prepared)

    @cached_property
    def held(self) -> tuple[tuple[Bools, Bools], ...]:
        """For each contact: (n,) the phonemes that demand it and (T,) the frames that hold it."""
        track, frames = self.track, self.frames
        first = frames.start + frames.first / frames.fps
        wanted = [demands(contact, track) for contact in self.tables.contacts]
        place = track, first, frames.fps, frames.count
        return tuple((one, held_frames(one, *place)) for one in wanted)

    def weights(self) -> Floats:
        """Run every stage, in the compiled kernel if possible: (T, P)."""
        if self.compiled:
            return self._weigh(0, self.frames.count)
        if self.frames.count <= BLOCK or self.far:
            return np.ascontiguousarray(self.last(0, self.frames.count).T)
        out = np.empty((self.frames.count, len(self.tables.priority)))
        halo = self.halo()
        for begin in range(0, self.frames.count, BLOCK):
            stop = min(begin + BLOCK, self.frames.count)
            low, high = max(0, begin - halo), min(self.frames.count, stop + halo)
            curves = self.last(low, high)
            out[begin:stop] = curves[:, begin - low : stop - low].T
        return out

    def with_tables(self, tables: Tables, motion: Motion) -> "Performance":
        """Return the performance of the same track and dials with other neutral curves."""
        prepared = prepare(tables, motion, self.frames.fps)
        return Performance(tables, self.track, motion, self.frames, prepared, (), (), self.dials)

    def places(self) -> tuple[Ints, Floats]:
        """Return the table rows of the two bigrams that cover each frame, and the place in each."""
        return positions(self.tables.neutral, self.track, locate(self.track, self.frames.times()))

    @property
    def compiled(self) -> bool:
        """True if the compiled kernel supports this performance."""
        other = self.overlays or self.blends or self.bends or self.others or self.track.mixed
        return kernel_plan.serves(self.motion) and not other

    def _weigh(self, begin: int, stop: int) -> Floats:
        kept = kernel_plan.keep(self.tables, self.motion, self.prepared, self.frames.fps)
        return kept.weigh(self.track, self.frames, (begin, stop), self.dials)

    @property
    def far(self) -> bool:
        """True if a frame may depend on frames at any distance."""
        return math.isinf(self.prepared.halo)

    def halo(self) -> int:
        """Return the frames on either side of a block that its own frames depend on."""
        return self.frames.count if self.far else math.ceil(self.prepared.halo) + 4

    def stages(self, begin: int, stop: int) -> list[Stage]:
        """Run the stages on frames `begin` to `stop`; return the curves after each, in bounds."""
        beyond = bool(self.prepared.longer)
        return [
            Stage(name, np.clip(curves, 0, 1) if beyond and name == "hold" else curves)
            for name, curves in self._run(begin, stop)
        ]

    def last(self, begin: int, stop: int) -> Floats:
        """Run the stages on frames `begin` to `stop`; return the curves after the last: (P, T)."""
        if self.compiled:
            return self._weigh(begin, stop).T
        for stage in self._run(begin, stop):
            curves = stage.curves
        return curves

    def bigrams(self, place: FramePlace, times: Floats) -> tuple[Floats, Floats]:
        """Read the two bigrams that cover each frame, styles blended in: (T, P) each."""
        neutral = warp(self.tables.neutral, self.track, place)
        if not self.blends:
            return neutral
        styles = [self.tables.styles[blend.style] for blend in self.blends]
        heard = [neutral, *(warp(bank, self.track, place) for bank in styles)]
        parts = shares(self.blends, times)[..., None]
        ending, beginning = (
            np.sum([part * one for part, one in zip(parts, side, strict=True)], axis=0)
            for side in zip(*heard, strict=True)
        )
        return ending, beginning

    def bigram(self, number: int, stride: int = 1) -> tuple[Floats, Floats]:
        """Return one bigram's own curves, styles blended in: (K,) seconds and (K, P).

        Parameters
        ----------
        stride : every so many of the tabulated steps are returned, and where its pace changes
        """
        track, row = self.track, self.track.rows[number]
        banks = [self.tables.neutral, *(self.tables.styles[blend.style] for blend in self.blends)]
        knots, places = track.knots(number, track.boundary(banks[0])[number])
        even = np.linspace(0, 1, RESOLUTION // stride + 1)
        place = np.sort(np.concatenate((even, places[1:-1])))
        times = np.interp(place, places, knots)
        for enter, leave in ((1, 2), (4, 5)):  # a long sound is held at one place for some time
            first, last = (place.searchsorted(places[enter], side) for side in ("left", "right"))
            times[first], times[first + 1 : last] = knots[enter], knots[leave]
        parts = shares(self.blends, times) if self.blends else np.ones((1, len(times)))
        out = np.zeros((len(times), len(self.tables.priority)))
        table = np.linspace(0, 1, RESOLUTION + 1)
        for part, bank in zip(parts, banks, strict=True):
            own = np.interp(times, *track.knots(number, track.boundary(bank)[number]))
            for pose, curve in enumerate(bank.curves[row].T):
                out[:, pose] += part * np.interp(own, table, curve)
        return times, out

    def _run(self, begin: int, stop: int) -> Iterator[Stage]:
        """Run the stages on the frames, or on the line's own curves and read these."""
        if not self.curves:
            yield from self._framed(begin, stop)
            return
        known, times = self.curves.frames.times(), self.frames.times(begin, stop)
        for name, curves in self.curves._framed(0, len(known)):  # noqa: SLF001 of this class
            yield Stage(name, np.array([np.interp(times, known, curve) for curve in curves]))

    def _framed(self, begin: int, stop: int) -> Iterator[Stage]:
        """Run the stages; those before a speed limit may leave the bounds to lengthen contacts."""
        prepared = self.prepared
        for stage in self._shaped(begin, stop):
            yield stage
            curves = stage.curves
        if self.motion.ends == "rest":
            head, tail = begin == 0, stop == self.frames.count
            curves = rest_at_ends(curves, prepared.ramps, head=head, tail=tail)
            yield Stage("rest", curves)
        if prepared.topped:
            curves = np.minimum(curves, prepared.tops[:, None])
        # poses shown one at a time have their contacts already, and a level could show a second one
        if self.motion.contacts == "hold" and not self.motion.hold:
            for (_, frames), (least, most) in zip(self.held, prepared.levels, strict=True):
                curves = hold(curves, least, most, frames[begin:stop])
            # levels beyond the bounds serve a later speed limit alone
            if prepared.longer and self.motion.limit == "after":
                curves = np.clip(curves, 0, 1)
            yield Stage("hold", curves)
        # slowed first, the constraints come out exact; the paper constrains first
        order = ("limit", "constrain") if self.motion.limit == "before" else ("constrain", "limit")
        for name in order:
            curves = self._constrain(curves) if name == "constrain" else self._slowed(curves, begin)
            yield Stage(name, curves)
        if prepared.shared:
            curves = soften(curves, prepared.shared)
            yield Stage("soften", curves if prepared.convex else self._constrain(curves))

    def _slowed(self, curves: Floats, begin: int) -> Floats:
        prepared = self.prepared
        if self.motion.contacts == "free" or self.motion.limit == "after":
            # an upper envelope would break constraints
            return lower_envelope(curves, prepared.step)
        slow = envelope(curves, prepared.step, upper=self.tables.held)
        self._contest(slow, begin)
        return np.clip(slow, 0, prepared.tops[:, None], out=slow) if prepared.longer else slow

    def _contest(self, curves: Floats, begin: int) -> None:
        """Bring contested poses back into their contacts, of which the last one wins.

        An upper envelope keeps floors alone: it widens a high pose over a ceiling beside it.
        """
        step, some = self.prepared.step, self.prepared.contested
        for (_, held), (least, most) in zip(self.held, self.prepared.levels, strict=True):
            here = held[begin : begin + curves.shape[1]]
            if some.size and here.any():
                away = lower_envelope(np.where(here, 0, len(here) * step)[None], step)
                row = np.minimum(curves[some], most[some] + away)
                curves[some] = np.maximum(row, least[some] - away)

    def _shaped(self, begin: int, stop: int) -> Iterator[Stage]:
        """Run the stages before the guarantees: the desired curves."""
        motion, prepared = self.motion, self.prepared
        times = self.frames.times(begin, stop)
        place = locate(self.track, times)
        curves = self._stitched(times)
        yield Stage("stitch", curves)
        if self.overlays:
            curves = lay_over(curves, self.overlays, times)
            yield Stage("overlay", curves)
        if self.dials:
            curves = scale(curves, self.dials, times)
            yield Stage("dial", curves)
        if motion.smooth != "none":
            curves = self._smooth(curves, place)
            yield Stage("smooth", curves)
        if motion.hold:
            if self.bends:
                curves = bend(curves, self.bends, times)
                yield Stage("bend", curves)
            yield Stage("switch", self._switch(curves, begin, stop))
            return
        if prepared.early.size:
            room = np.maximum(1 - prepared.blocked @ curves, 0)
            room[prepared.opposed[:, self.track.ids].take(place.phoneme, axis=1)] = 0
            curves = anticipate(curves, prepared.early, prepared.left, room)
            yield Stage("anticipate", curves)
        if prepared.wide:
            curves = soften(curves, prepared.wide)
            yield Stage("ease", curves)
        if self.bends:
            yield Stage("bend", bend(curves, self.bends, times))

    def _stitched(self, times: Floats) -> Floats:
        """Join the bigrams that cover each frame: (P, T), the mean of the other tracks if any."""
        if self.others:
            alone = [replace(self, track=one, others=()) for one in self.others]
            return np.mean([one._stitched(times) for one in alone], axis=0)  # noqa: SLF001 own class
        place = locate(self.track, times)
        return stitch(*self.bigrams(place, times), place, self.motion.stitch)

    def _smooth(self, curves: Floats, place: FramePlace) -> Floats:
        frames = self.motion.window * self.frames.fps
        if self.motion.smooth == "chord":
            return chord(curves, frames)
        width = max(1, round(frames))
        out = closing(curves, width)
        held = self.tables.held
        if self.motion.contacts == "hold" and held.any():
            demanded = np.zeros((np.count_nonzero(held), len(self.track.ids)), bool)
            for contact, (wanted, _) in zip(self.tables.contacts, self.held, strict=True):
                demanded |= (contact.floor[held] > 0)[:, None] & wanted
            out[held] = closing_within(curves[held], demanded[:, place.phoneme], width)
        return out

    def _switch(self, curves: Floats, begin: int, stop: int) -> Floats:
        """Show one pose at a time; a contact chooses the pose while held."""
        barred = np.zeros(curves.shape, bool)
        forced = np.full(curves.shape[1], FREE)
        if self.motion.contacts == "hold":
            for contact, (_, frames) in zip(self.tables.contacts, self.held, strict=True):
                here = frames[begin:stop]
                barred[np.ix_(contact.ceiling < 1, here)] = True
                forced[here] = int(contact.floor.argmax()) if contact.raised else NONE
        return switch(curves, barred, forced, round(self.motion.hold * self.frames.fps))

    def _constrain(self, curves: Floats) -> Floats:
        return constrain(curves, self.tables.binding, self.tables.at_most)


def lay_frames(track: Track, motion: Motion, fps: float, lead: int) -> Frames:
    """Choose the frames of an animation: the schedule's, a lead-in and a tail.

    The mouth may move up to `motion.added_silence` before the first sound and after the last, and
    earlier only where a contact needs it; silence in the schedule is used first. If `motion.ends`
    is "cut", the frames are the schedule's.

    Parameters
    ----------
    lead : frames from rest to the first held frame of a contact
    """
    if motion.ends == "cut":
        count = math.ceil((track.end - track.start) * fps - 1e-6) + 1
        return Frames(track.start, 0, count, fps)
    opening = float(track.bounds[1]) - track.start if track.source[0] >= 0 else 0.0
    closing_ = track.end - float(track.bounds[-2]) if track.source[-1] >= 0 else 0.0
    length = track.end - track.start
    first = -frames_until(0, -opening, motion.added_silence, lead, fps)
    last = frames_until(length, length - closing_, motion.added_silence, lead, fps)
    return Frames(track.start, first, last - first + 1, fps)


def frames_until(edge: float, sound: float, reach: float, lead: int, fps: float) -> int:
    """Count the frames up to a schedule's edge, or farther if its outermost sound needs them."""
    # 1e-6 of a frame: times of 30 fps are not exact in binary
    reached = math.floor((sound + reach) * fps + 1e-6)
    held = math.floor((sound + max(SHORTEST, 1 / fps) / 2) * fps + 1e-6)
    return max(math.ceil(edge * fps - 1e-6), reached, held + lead if lead else reached)


def perform(  # noqa: PLR0913 the phonemes, and settings of their delivery
    tables: Tables,
    track: Track,
    motion: Motion,
    fps: float,
    *,
    overlays: tuple[Overlay, ...] = (),
    blends: tuple[Blend, ...] = (),
    dials: tuple[Dial, ...] = (),
    bends: tuple[Bend, ...] = (),
    others: tuple[Track, ...] = (),
    frames: Frames | None = None,
) -> Performance:
    """Prepare a track's performance, and choose its frames.

    Parameters
    ----------
    others : tracks whose mean is played, with the contacts of this one
    frames : of the animation; None for all those of the track
    """
    tables = tables.papers if motion.thresholds == "paper" else tables
    prepared = prepare(tables, motion, fps)
    if frames is None:
        frames = lay_frames(track, motion, fps, prepared.lead)
    asked = overlays, blends, dials, bends, others
    return Performance(tables, track, motion, frames, prepared, *asked)
