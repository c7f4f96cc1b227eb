"""An animation with its phonemes, as arrays for all measures.

Conventions: curves are (C, T); a column is a pose or a channel of a rig. Times are in seconds and
ascend. The n phonemes are those of the track, with silence first and last, and n + 1 bounds.
"""

from dataclasses import dataclass
from functools import cached_property
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from lipsync_lang.arrays import Bools, Floats, Ints
from lipsync_lang.errors import LipsyncError
from lipsync_lang.performing.performed_line import PerformedLine
from lipsync_lang.quality.face_columns import Face, face_of

if TYPE_CHECKING:
    from lipsync_lang.animations.animation import Animation
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.pipeline.motion import Motion
    from lipsync_lang.pipeline.track import Track

CEILING_TOLERANCE = 0.05
"""Maximum invisible excess over a ceiling, as a share of the column's range."""


@dataclass(frozen=True, eq=False)
class MeasuredScene:
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

    @cached_property
    def remembered(self) -> dict[Any, Any]:
        """Cache of values that several measures need, by function."""
        return {}

    @cached_property
    def steps(self) -> Floats:
        """(T - 1,) seconds from frame to frame."""
        return self.times[1:] - self.times[:-1]

    @cached_property
    def frame(self) -> float:
        """Seconds between frames."""
        return median(self.steps.tolist()) if self.steps.size else 1.0

    @cached_property
    def sounds(self) -> Bools:
        """(n,) True for sounds, False for silence."""
        sounds: Bools = self.track.ids != self.silence
        return sounds

    @cached_property
    def owner(self) -> Ints:
        """(T,) index of each frame's phoneme; the outermost silences have no end."""
        at = self.track.bounds.searchsorted(self.times, side="right") - 1
        return np.minimum(np.maximum(at, 0), len(self.track.ids) - 1)

    @cached_property
    def speaking(self) -> Bools:
        """(T,) True for frames in a sound."""
        speaking: Bools = self.sounds[self.owner]
        return speaking

    @cached_property
    def seconds(self) -> float:
        """Total duration of the sounds."""
        return float(self.lengths[self.sounds].sum())

    @cached_property
    def lengths(self) -> Floats:
        """(n,) seconds of each phoneme."""
        return self.track.bounds[1:] - self.track.bounds[:-1]

    @cached_property
    def share(self) -> Floats:
        """(C, T) curves as shares of each column's range."""
        return self.curves / self.face.span[:, None]

    @cached_property
    def changes(self) -> Floats:
        """(C, T - 1) shares from frame to frame."""
        return self.share[:, 1:] - self.share[:, :-1]

    @cached_property
    def speeds(self) -> Floats:
        """(C, T - 1) shares per second from frame to frame."""
        return np.abs(self.changes) / self.steps

    @cached_property
    def cuts(self) -> Ints:
        """(n, 2) first frame of each phoneme and the frame past its last, half a frame wider."""
        half, bounds = self.frame / 2 + 1e-9, self.track.bounds
        cuts = np.empty((len(bounds) - 1, 2), np.intp)
        cuts[:, 0] = self.times.searchsorted(bounds[:-1] - half)
        cuts[:, 1] = self.times.searchsorted(bounds[1:] + half, side="right")
        np.maximum(cuts[:, 0], cuts[:, 1], out=cuts[:, 1])
        return cuts

    def highest(self, values: Floats) -> Floats:
        """Return the maximum of (..., T) values in the frames of each phoneme: (..., n).

        It is NaN for phonemes without frames.
        """
        cuts = self.cuts
        # one column more, since a cut past the end is no index for `reduceat`
        padded = np.concatenate((values, values[..., -1:]), axis=-1)
        highest = np.maximum.reduceat(padded, cuts.ravel(), axis=-1)[..., ::2]
        return np.where(cuts[:, 1] > cuts[:, 0], highest, np.nan)

    @cached_property
    def margins(self) -> Floats:
        """(B, T) margin of each bounded column of a contact, in shares of its range."""
        columns, floor, high, _ = self.face.bounded
        span, curves = self.face.span[columns, None], self.curves[columns]
        below = (high - curves) / span + CEILING_TOLERANCE
        margins: Floats = np.minimum((curves - floor) / span, below) + 1e-9
        return margins

    @cached_property
    def margin(self) -> Floats:
        """(contacts, T) margin of each contact at each frame; negative without contact."""
        if not self.face.touches:
            return np.zeros((0, len(self.times)))
        margin: Floats = np.minimum.reduceat(self.margins, self.face.bounded.starts, axis=0)
        return margin

    @cached_property
    def demanded(self) -> Bools:
        """(contacts, n) True for phonemes that demand a contact."""
        if not self.face.touches:
            return np.zeros((0, len(self.track.ids)), bool)
        demanded: Bools = self.face.demanding[:, self.track.ids] & ~self.track.waived
        return demanded

    @cached_property
    def wanted(self) -> list[int]:
        """Number of phonemes that demand each contact."""
        counts: list[int] = self.demanded.sum(axis=1).tolist()
        return counts


def scene_of(animation: "Animation", performer: "Performer") -> MeasuredScene:
    """Return an animation with its phonemes as arrays.

    Raises
    ------
    LipsyncError
        The animation is of another face, has fewer than two frames, times that do not rise, or
        weights that are not finite.
    """
    face = face_of(animation, performer)
    times, weights = animation.times, animation.weights
    if len(times) < 2:  # noqa: PLR2004 one frame does not move
        raise LipsyncError("the animation has fewer than two frames, which cannot be judged")
    if not np.isfinite(weights).all() or (times[1:] <= times[:-1]).any():
        raise LipsyncError(
            "the animation has times that do not rise, or weights that are not finite numbers"
        )
    performed = PerformedLine.of(animation)
    settings = performed.settings if performed else {}
    track = performer.track(
        animation.schedule, line=settings.get("line"), styles=settings.get("styles")
    )
    labels = animation.schedule.labels
    compiled = performer.compiled
    return MeasuredScene(
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
    )
