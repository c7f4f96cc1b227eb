"""What a performance is: times, poses, weights, and the way back to what made them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import numpy.typing as npt

from lipsync_lang.errors import LipsyncError
from lipsync_lang.rigs.channel import Channel
from lipsync_lang.schedules.schedule import Schedule

if TYPE_CHECKING:
    from lipsync_lang.animations.explanation import Explanation
    from lipsync_lang.animations.keys import Curve


@dataclass(frozen=True, eq=False)
class Animation:
    """Pose weights at every frame.

    Parameters
    ----------
    times : (T,) seconds; below zero where the mouth moves before the sound
    poses : P names
    weights : (T, P) in [0, 1]; what a rig drives may have a range of its own
    fps : frames per second
    schedule : what was spoken
    performer : what performed it; explains any frame
    asked : how it was to be performed: the line's name, styles and dials
    channels : what each column drives on a model; empty where nothing is known of it
    model : the model file that the character or its pose set names
    offset : seconds at which the sound begins on the timeline of the files that are written
    tolerance : how far keyframes may stray from the curves, in formats that have keyframes; None
        for what suits the format
    neutral : what the face at rest is called, where it has a name
    contacts : the poses that must be seen wherever they are reached
    """

    times: npt.NDArray[np.float64]
    poses: tuple[str, ...]
    weights: npt.NDArray[np.float64]
    fps: float
    schedule: Schedule
    performer: Any = None
    asked: Mapping[str, Any] = field(default_factory=dict)
    channels: tuple[Channel, ...] = ()
    model: Path | None = None
    offset: float = 0.0
    tolerance: float | None = None
    neutral: str | None = None
    contacts: tuple[str, ...] = ()

    @property
    def title(self) -> str:
        """What it is called in files: its words, or the file they came from."""
        source = Path(self.schedule.source)
        words = " ".join(word.text for word in self.schedule.words)
        return shorten(words, 60, placeholder=" ...") or (
            source.stem if source.suffix else "lipsync"
        )

    @property
    def columns(self) -> tuple[Channel, ...]:
        """What each column drives: shapes of its own name, where nothing else is known."""
        return self.channels or tuple(map(Channel, self.poses))

    @property
    def begins(self) -> float:
        """Seconds at which the sound begins in files whose time cannot be below zero.

        The `offset`, or later where the mouth moves before that.
        """
        return max(self.offset, -float(self.times[0]))

    @property
    def timeline(self) -> npt.NDArray[np.float64]:
        """(T,) seconds from the start of such files."""
        return np.maximum(self.times + self.begins, 0.0)

    def keys(self, tolerance: float) -> "list[Curve]":
        """Return the keyframes of every column: as few as keep to a tolerance.

        Parameters
        ----------
        tolerance : what suits the format; the animation's own comes before it
        """
        from lipsync_lang.animations.keys import curves

        error = tolerance if self.tolerance is None else self.tolerance
        return curves(self.poses, self.timeline, self.weights, error)

    def __getitem__(self, pose: str) -> npt.NDArray[np.float64]:
        """Return the (T,) curve of one pose."""
        if pose not in self.poses:
            from lipsync_lang.errors import did_you_mean

            raise LipsyncError(f"no pose '{pose}' here; {did_you_mean(pose, self.poses)}")
        return self.weights[:, self.poses.index(pose)]

    def cut(self) -> Self:
        """Return the frames within the schedule only: no lead-in or tail, so no promise of rest."""
        half = 0.5 / self.fps
        inside = (self.times > self.schedule.start - half) & (self.times < self.schedule.end + half)
        return replace(self, times=self.times[inside], weights=self.weights[inside])

    def save(self, path: str | Path, writer: str | None = None) -> None:
        """Write to a file.

        Parameters
        ----------
        path : the file; its suffix names the format (``lipsync-lang formats`` lists them). ``-`` is
            standard output
        writer : the name of the format, where the suffix is another's
        """
        from lipsync_lang.animations.animation_writers import save
        from lipsync_lang.files import argument_path

        save(self, argument_path(path), writer)

    def explain(self, seconds: float) -> "Explanation":
        """Say why each pose stands where it stands at a time."""
        if self.performer is None:
            raise LipsyncError(
                "this animation was not performed here; nothing is known of its making"
            )
        explanation: Explanation = self.performer.explain(self, seconds)
        return explanation
