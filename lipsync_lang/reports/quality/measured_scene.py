"""Lines of one face with their phonemes, as arrays for all measures.

Conventions: curves are (C, T); a column is a pose or a channel of a rig. The T frames and the n
phonemes of L lines follow each other, so that a measure reads all of them at once. Times are in
seconds and ascend within a line; its phonemes have silence first and last.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.performer import PerformedLine, Performer
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.reports.quality.face_columns import Face, face_of

CEILING_TOLERANCE = 0.05
"""Maximum invisible excess over a ceiling, as a share of the column's range."""


def search(
    places: tuple[Ints, Floats], to: tuple[Ints, Floats], side: Literal["left", "right"] = "left"
) -> Ints:
    """Return the result of `searchsorted` within each line, as indices over all lines.

    Parameters
    ----------
    places, to : lines and times; those of `places` ascend
    """
    return _keys(*places).searchsorted(_keys(*to), side)


def _keys(line: Ints, times: Floats) -> "np.ndarray[tuple[int], np.dtype[np.complex128]]":
    # complex numbers are sorted by their real part, then by the imaginary one
    keys = np.empty(len(times), np.complex128)
    keys.real, keys.imag = line, times
    return keys


@dataclass(frozen=True, eq=False)
class MeasuredScene:
    """Lines with their phonemes and their face."""

    times: Floats
    """(T,) seconds, rising within each line."""
    curves: Floats
    """(C, T)"""
    frames: Ints
    """(L + 1,) first frame of each line, and T."""
    face: Face
    ids: Ints
    """(n,) common phonemes."""
    begin: Floats
    end: Floats
    """(n,) seconds of each phoneme."""
    waived: Bools
    """(n,) True where a bigram of the phoneme waives its contacts."""
    phonemes: Ints
    """(L + 1,) first phoneme of each line, and n."""
    labels: tuple[str, ...]
    """(n,) names of the phonemes for messages."""
    silence: int
    motion: Motion
    rules: dict[str, dict[str, Any]]

    @cached_property
    def remembered(self) -> dict[Any, Any]:
        """Cache of values that several measures need, by function."""
        return {}

    @cached_property
    def spans(self) -> list[slice]:
        """The frames of each line."""
        first = self.frames.tolist()
        return list(map(slice, first, first[1:]))

    @cached_property
    def frame_line(self) -> Ints:
        """(T,) line of each frame."""
        return np.arange(len(self.spans)).repeat(self.frames[1:] - self.frames[:-1])

    @cached_property
    def line(self) -> Ints:
        """(n,) line of each phoneme."""
        return np.arange(len(self.spans)).repeat(self.phonemes[1:] - self.phonemes[:-1])

    @cached_property
    def seams(self) -> Ints:
        """(L - 1,) last frame of each line but the last."""
        return self.frames[1:-1] - 1

    @cached_property
    def steps(self) -> Floats:
        """(T - 1,) seconds from frame to frame; 1 between lines."""
        steps: Floats = self.times[1:] - self.times[:-1]
        steps[self.seams] = 1
        return steps

    @cached_property
    def frame(self) -> Floats:
        """(L,) median seconds between the frames of each line."""
        out = []
        for span in self.spans:
            count = span.stop - span.start - 1
            middle = ((count - 1) // 2, count // 2)
            own = np.sort(self.steps[span.start : span.start + count])
            out.append((own.item(middle[0]) + own.item(middle[1])) / 2)
        return np.array(out)

    @cached_property
    def sounds(self) -> Bools:
        """(n,) True for sounds, False for silence."""
        return self.ids != self.silence

    @cached_property
    def owner(self) -> Ints:
        """(T,) index of each frame's phoneme; the outermost silences have no end."""
        return np.maximum(self.passed(self.line, self.begin) - 1, self.phonemes[self.frame_line])

    @cached_property
    def _frame_keys(self) -> Any:
        return _keys(self.frame_line, self.times)

    def frame_at(self, line: Ints, times: Floats, side: Literal["left", "right"] = "left") -> Ints:
        """Return the first frame at or after times of lines, or after them for the right side."""
        return self._frame_keys.searchsorted(_keys(line, times), side)

    def passed(self, line: Ints, times: Floats, side: Literal["left", "right"] = "left") -> Ints:
        """Return how many times of lines each frame has reached, or passed: (T,)."""
        # the few times are sought among the many frames, which takes a fifth of the reverse
        first = self.frame_at(line, times, side)
        return np.bincount(first, minlength=len(self.times) + 1)[:-1].cumsum()

    @cached_property
    def speaking(self) -> Bools:
        """(T,) True for frames in a sound."""
        return self.sounds[self.owner]

    @cached_property
    def spoken(self) -> list[bool]:
        """True for lines with frames in a sound."""
        return np.logical_or.reduceat(self.speaking, self.frames[:-1]).tolist()

    @cached_property
    def seconds(self) -> list[float]:
        """Total duration of the sounds of each line."""
        own = np.where(self.sounds, self.lengths, 0.0)
        return np.add.reduceat(own, self.phonemes[:-1]).tolist()

    @cached_property
    def lengths(self) -> Floats:
        """(n,) seconds of each phoneme."""
        return self.end - self.begin

    @cached_property
    def share(self) -> Floats:
        """(C, T) curves as shares of each column's range."""
        return self.curves / self.face.span[:, None]

    @cached_property
    def changes(self) -> Floats:
        """(C, T - 1) shares from frame to frame; 0 between lines."""
        changes: Floats = self.share[:, 1:] - self.share[:, :-1]
        changes[:, self.seams] = 0
        return changes

    @cached_property
    def speeds(self) -> Floats:
        """(C, T - 1) shares per second from frame to frame; 0 between lines."""
        return np.abs(self.changes) / self.steps

    def top(self, values: Floats) -> Floats:
        """Return the maximum of (..., T) or (..., T - 1) values in each line: (..., L)."""
        return np.maximum.reduceat(values, self.frames[:-1], axis=-1)

    def counts(self, marked: Bools) -> Ints:
        """Return the number of True of (..., n) marks in each line: (L, ...)."""
        counts: Ints = np.add.reduceat(marked, self.phonemes[:-1], axis=-1, dtype=np.intp)
        return counts.T

    def frames_of(self, marked: Bools) -> list[slice]:
        """Return the part of each line in the values of marked frames, (T,) marks."""
        cuts = marked.nonzero()[0].searchsorted(self.frames).tolist()
        return list(map(slice, cuts, cuts[1:]))

    def split(self, numbers: Ints) -> list[slice]:
        """Return the part of each line in ascending indices of phonemes."""
        cuts = numbers.searchsorted(self.phonemes).tolist()
        return list(map(slice, cuts, cuts[1:]))

    @cached_property
    def cuts(self) -> Ints:
        """(n, 2) first frame of each phoneme and the frame past its last, half a frame wider."""
        half = self.frame[self.line] / 2 + 1e-9
        first = self.frame_at(self.line, self.begin - half)
        past = self.frame_at(self.line, self.end + half, "right")
        return np.column_stack((first, np.maximum(first, past)))

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
        return np.minimum((curves - floor) / span, below) + 1e-9

    @cached_property
    def margin(self) -> Floats:
        """(contacts, T) margin of each contact at each frame; negative without contact."""
        if not self.face.touches:
            return np.zeros((0, len(self.times)))
        parts = map(self.face.bounded.part, range(len(self.face.touches)))
        return np.stack([self.margins[part].min(axis=0) for part in parts])

    @cached_property
    def demanded(self) -> Bools:
        """(contacts, n) True for phonemes that demand a contact."""
        if not self.face.touches:
            return np.zeros((0, len(self.ids)), bool)
        return self.face.demanding[:, self.ids] & ~self.waived


def scene_of(animations: Sequence[Animation], performer: Performer) -> MeasuredScene:
    """Return animations of one face with their phonemes as arrays.

    Raises LipsyncError if an animation is of another face, has fewer than two frames, times that do
    not rise, or weights that are not finite.
    """
    (face,) = {face_of(animation, performer) for animation in animations}
    compiled, tracks, labels, judged = performer.compiled, [], [], []
    rest = compiled.phonemes[compiled.tables.silence]
    for animation in animations:
        times = animation.times
        if len(times) < 2:  # noqa: PLR2004 one frame does not move
            raise LipsyncError("the animation has fewer than two frames, which cannot be judged")
        judged.append(animation.weights[:, : len(face.names)])
        if not np.isfinite(judged[-1]).all() or (times[1:] <= times[:-1]).any():
            raise LipsyncError(
                "the animation has times that do not rise, or weights that are not finite numbers"
            )
        performed = PerformedLine.of(animation)
        settings = performed.settings if performed else {}
        line, styles = settings.get("line"), settings.get("styles")
        track = performer.track(animation.schedule, line=line, styles=styles)
        tracks.append(track)
        own = animation.schedule.labels
        # A track has silences of its own at both ends, which no label of the schedule has made.
        labels += [own[at] if at >= 0 else rest for at in track.source.tolist()]
    return MeasuredScene(
        np.concatenate([animation.times for animation in animations]),
        np.ascontiguousarray(np.concatenate(judged).T),
        np.cumsum([0, *(len(animation.times) for animation in animations)]),
        face,
        np.concatenate([track.ids for track in tracks]),
        np.concatenate([track.bounds[:-1] for track in tracks]),
        np.concatenate([track.bounds[1:] for track in tracks]),
        np.concatenate([track.waived for track in tracks]),
        np.cumsum([0, *(len(track.ids) for track in tracks)]),
        tuple(labels),
        compiled.tables.silence,
        performer.motion,
        compiled.checks["rules"],
    )
