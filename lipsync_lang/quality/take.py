"""An animation and its phonemes, as arrays that every measure reads.

Conventions: curves are (C, T); a column is a pose or a channel of a rig. Times are in seconds and
rise. The n phonemes are those of the track, silence first and last, with n + 1 bounds.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lipsync_lang.errors import LipsyncError
from lipsync_lang.pipeline.arrays import Bools, Floats, Ints
from lipsync_lang.pipeline.constrain import Cap

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.pipeline.motion import Motion
    from lipsync_lang.pipeline.track import Track
    from lipsync_lang.resolver.compiled import Compiled

FLOOR_SHARE = 0.9
"""Share of a floor that makes a visible contact."""

CEILING_TOLERANCE = 0.05
"""Share of a column's range by which nobody sees that a ceiling is exceeded."""


OPENS_SHARE = 0.4
"""Phonemes that open the mouth by this share of the widest one should be seen to open it."""

BLOCK_SHARE = 0.25
"""Phonemes that show this share of a pose's highest, or of an opponent's, keep it from looking
ahead."""


class Touch(NamedTuple):
    """A contact as bounds of columns; infinite bounds demand nothing."""

    name: str
    phonemes: Bools
    """(N,) True for common phonemes that demand the contact."""
    low: Floats
    """(C,) lower bound of each column."""
    high: Floats
    """(C,) upper bound of each column."""

    @property
    def raised(self) -> bool:
        """True if the contact raises a column; a face at rest makes all other contacts."""
        return bool(np.isfinite(self.low).any())


class Roles(NamedTuple):
    """The pose set's facts about its poses and phonemes, for measures of motion."""

    opening: Bools
    """(C,) True for the columns that loudness opens (`intensity`); none is unknown."""
    ahead: Floats
    """(C,) seconds by which a column looks ahead (`anticipate`)."""
    opens: Bools
    """(N,) True for common phonemes that open the mouth wide when said alone."""
    begins: Floats
    """(N, C) peak of each column in the first half of a phoneme said alone, of its highest."""
    blocks: Bools
    """(N, C) True for phonemes that keep a column from looking ahead."""


@dataclass(frozen=True, eq=False)
class Face:
    """The columns of an animation, with their ranges, contacts and constraints."""

    names: tuple[str, ...]
    touches: tuple[Touch, ...]
    caps: tuple[Cap, ...]
    at_most: tuple[tuple[int, int], ...]
    low: Floats
    high: Floats
    """(C,) the range of each column; infinite for bones."""
    span: Floats
    """(C,) width of each range."""
    measures: dict[str, Floats]
    """By name, (C,) gains."""
    roles: Roles | None = None
    """None for the channels of a rig."""


def face_of(animation: "Animation", performer: "Performer") -> Face:
    """Return the face of an animation: a performer's poses, or its rig's channels.

    Raises
    ------
    LipsyncError
        The columns are neither.
    """
    compiled = performer.compiled
    if animation.poses == performer.poses:
        return _posed(performer)
    if compiled.rig is not None:
        names = tuple(one["name"] for one in compiled.rig["channels"])
        if animation.poses == names:
            return _rigged(performer, names)
    raise LipsyncError(
        f"the animation has other columns than {performer.character} has poses; read its file for "
        f"this character (quality.fitting.read_for), or name the character it was made for"
    )


def _posed(performer: "Performer") -> Face:
    compiled = performer.compiled
    tables, count = compiled.tables, len(performer.poses)
    touches = [
        Touch(
            name,
            contact.phonemes,
            np.where(contact.floor > 0, contact.floor, -np.inf),
            np.where(contact.ceiling < 1, contact.ceiling, np.inf),
        )
        for name, contact in zip(compiled.contact_names, tables.contacts, strict=True)
    ]
    measures = {
        name: np.array([gains.get(pose, 0.0) for pose in performer.poses])
        for name, gains in compiled.measures.items()
    }
    unit = np.ones(count)
    zero = np.zeros(count)
    return Face(
        performer.poses,
        tuple(touches),
        tables.caps,
        tables.at_most,
        zero,
        unit,
        unit,
        measures,
        _roles(compiled),
    )


def _roles(compiled: "Compiled") -> Roles:
    """Read roles off the bank: each phoneme is looked at in its own part of silence-phoneme."""
    tables, stated = compiled.tables, compiled.intensity or {"regions": ()}
    own = [pose for region in stated["regions"] for pose in compiled.regions.get(region, ())]
    opening = np.isin(np.arange(len(compiled.poses)), own)
    rows = tables.pairs[tables.silence]
    curves = tables.curves[rows].astype(float)
    start = tables.boundary[rows][:, None]
    at = np.linspace(0, 1, curves.shape[1])[None]
    said = at >= start
    early = said & (at <= (1 + start) / 2)
    widest = (curves[:, :, opening].sum(axis=2) * said).max(axis=1)
    begins = (curves * early[:, :, None]).max(axis=1) / tables.highest
    shown = (curves * said[:, :, None]).max(axis=1)
    blocks = tables.opposed | (shown @ tables.blockers > BLOCK_SHARE) | (begins > BLOCK_SHARE)
    for contact in tables.contacts:
        blocks |= contact.phonemes[:, None] & (contact.ceiling < 1)
    opens = widest > OPENS_SHARE * widest.max(initial=0.0)
    return Roles(opening, tables.anticipate, opens, begins, blocks)


def _rigged(performer: "Performer", names: tuple[str, ...]) -> Face:
    """Return the face of a rig's channels; gains carry the bounds of contacts over to channels."""
    from lipsync_lang.rigs.driver import Driver

    compiled = performer.compiled
    rig = Driver.from_plain(compiled.rig or {}, performer.poses, compiled.tables.floors).rig
    yielding = np.isin(np.arange(len(names)), [channel for channel, _ in rig.at_most])
    free = _bounds(rig, np.zeros(len(performer.poses)), np.ones(len(performer.poses)))
    touches = []
    for name, contact in zip(compiled.contact_names, compiled.tables.contacts, strict=True):
        low, high = _bounds(rig, contact.floor, contact.ceiling)
        asks = (low > free[0] + 1e-9) & ~yielding
        touches.append(
            Touch(
                name,
                contact.phonemes,
                np.where(asks, low, -np.inf),
                np.where(high < free[1] - 1e-9, high, np.inf),
            )
        )
    span = np.where(rig.span > 0, rig.span, 1.0)
    return Face(names, tuple(touches), (), rig.at_most, rig.low, rig.high, span, {})


def _bounds(rig: Any, floor: Floats, ceiling: Floats) -> tuple[Floats, Floats]:
    """Return lower and upper bound of every channel while poses keep to floors and ceilings."""
    up, down = np.maximum(rig.gains, 0), np.minimum(rig.gains, 0)
    low = np.clip(up @ floor + down @ ceiling, rig.low, rig.high)
    high = np.clip(up @ ceiling + down @ floor, rig.low, rig.high)
    return low, high


@dataclass(frozen=True, eq=False)
class Take:
    """An animation with its phonemes and its face."""

    times: Floats
    """(T,) seconds, rising."""
    curves: Floats
    """(C, T)"""
    face: Face
    track: "Track"
    labels: tuple[str, ...]
    """(n,) names of the track's phonemes for messages."""
    silence: int
    motion: "Motion"
    rules: dict[str, dict[str, Any]]
    phonemes: tuple[frozenset[str], ...]
    """Names of the common phonemes, by number; a shade also has the name of its parent."""

    @property
    def frame(self) -> float:
        """Seconds between frames."""
        return float(np.median(np.diff(self.times))) if len(self.times) > 1 else 1.0

    @cached_property
    def sounds(self) -> Bools:
        """(n,) True for sounds, False for silence."""
        sounds: Bools = self.track.ids != self.silence
        return sounds

    @cached_property
    def owner(self) -> Ints:
        """(T,) index of each frame's phoneme; the outermost silences have no end."""
        at = np.searchsorted(self.track.bounds, self.times, side="right") - 1
        return np.clip(at, 0, len(self.track.ids) - 1)

    @cached_property
    def speaking(self) -> Bools:
        """(T,) True for frames in a sound."""
        speaking: Bools = self.sounds[self.owner]
        return speaking

    @cached_property
    def seconds(self) -> float:
        """Total duration of the sounds."""
        return float(np.diff(self.track.bounds)[self.sounds].sum())

    @cached_property
    def share(self) -> Floats:
        """(C, T) curves as shares of each column's range."""
        return self.curves / self.face.span[:, None]

    @cached_property
    def speeds(self) -> Floats:
        """(C, T - 1) shares per second from frame to frame."""
        return np.abs(np.diff(self.share, axis=1)) / np.diff(self.times)

    def frames(self, start: Floats, end: Floats) -> tuple[Ints, Ints]:
        """Return the first frame of each span and the frame past its last, half a frame wider."""
        half = self.frame / 2 + 1e-9
        first = np.searchsorted(self.times, start - half, side="left")
        stop = np.searchsorted(self.times, end + half, side="right")
        return first, np.maximum(first, stop)

    def over(self, which: Ints, values: Floats, how: np.ufunc) -> Floats:
        """Reduce (T,) values over the frames of each phoneme; nan for phonemes without frames."""
        first, stop = self.frames(self.track.bounds[which], self.track.bounds[which + 1])
        if not which.size:
            return np.zeros(0)
        padded = np.append(values, values[-1])
        cuts = np.column_stack((first, stop)).ravel()
        reduced: Floats = how.reduceat(padded, np.minimum(cuts, len(values)))[::2]
        return np.where(stop > first, reduced, np.nan)

    def margin(self, touch: Touch) -> Floats:
        """Return the margin by which each frame makes a contact: (T,), below 0 if it does not."""
        margin: Floats = self.margins(touch).min(axis=0, initial=np.inf)
        return margin

    def margins(self, touch: Touch) -> Floats:
        """Return the margin of every column, in shares of its range: (C, T)."""
        asked = np.isfinite(touch.low)
        low = np.where(asked, touch.low, 0.0)
        floor = np.where(asked, low - (1 - FLOOR_SHARE) * np.abs(low), -np.inf)
        span = self.face.span
        above = (self.curves - floor[:, None]) / span[:, None]
        below = (touch.high[:, None] - self.curves) / span[:, None] + CEILING_TOLERANCE
        margins: Floats = np.minimum(above, below) + 1e-9
        return margins

    def demanded(self, touch: Touch) -> Bools:
        """Return True for phonemes that demand a contact: (n,)."""
        return touch.phonemes[self.track.ids] & ~self.track.waived


def scene_of(animation: "Animation", performer: "Performer") -> Take:
    """Return an animation as arrays, with its phonemes.

    Raises
    ------
    LipsyncError
        The animation is of another face, has fewer than two frames, times that do not rise, or
        weights that are not finite.
    """
    face = face_of(animation, performer)
    times, weights = animation.times, animation.weights
    if len(times) < 2:  # noqa: PLR2004 one frame does not move
        raise LipsyncError("the animation has fewer than two frames; there is nothing to judge")
    if not np.isfinite(weights).all() or (np.diff(times) <= 0).any():
        raise LipsyncError("the animation has times that do not rise, or weights that are none")
    asked = animation.asked if animation.performer is not None else {}
    track = performer.performance(animation.schedule, 60, **asked).track
    labels = animation.schedule.labels
    compiled = performer.compiled
    return Take(
        times,
        np.ascontiguousarray(weights.T),
        face,
        track,
        tuple(
            labels[at] if at >= 0 else compiled.phonemes[compiled.tables.silence]
            for at in track.source
        ),
        compiled.tables.silence,
        performer.motion,
        compiled.checks["rules"],
        tuple(frozenset({name, compiled.shades.get(name, name)}) for name in compiled.phonemes),
    )
