"""What a performance is: times, poses, weights, and the way back to what made them."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any, Literal, Self, get_args

import numpy as np
import numpy.typing as npt

from lipsync_lang.errors import LipsyncError, refuse_other
from lipsync_lang.rigs.channel import Channel
from lipsync_lang.schedules.schedule import Schedule

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lipsync_lang.animations.explanation import Explanation
    from lipsync_lang.animations.keys import Curve

Frames = Literal["pandas", "polars"]
"""Libraries of data frames, the preferred one first."""


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

    def keyframes(self, tolerance: float) -> "list[Curve]":
        """Return the keyframes of every column: as few as keep to a tolerance.

        Parameters
        ----------
        tolerance : what suits the format; the animation's own comes before it
        """
        from lipsync_lang.animations.keys import curves

        error = tolerance if self.tolerance is None else self.tolerance
        return curves(self.poses, self.timeline, self.weights, error)

    def __repr__(self) -> str:
        """Say in one line what it is of."""
        span = f", {self.times[0]:.2f} to {self.times[-1]:.2f} s" if len(self) else ""
        return (
            f"<Animation {self.title!r}: {len(self)} frames of {len(self.poses)} poses "
            f"at {self.fps:g} fps{span}>"
        )

    def _repr_html_(self) -> str:
        """Show notebooks the curves."""
        from lipsync_lang.animations.notebook import curves_html

        return curves_html(self)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.times)

    def __bool__(self) -> bool:
        """Be true without frames, too: an animation is there."""
        return True

    def __iter__(self) -> "Iterator[tuple[str, npt.NDArray[np.float64]]]":
        """Yield each pose with its (T,) curve; `dict(animation)` maps one to the other."""
        return zip(self.poses, self.weights.T, strict=True)

    def __contains__(self, pose: object) -> bool:
        """Tell whether there is a pose of that name."""
        return pose in self.poses

    def __array__(
        self,
        dtype: npt.DTypeLike | None = None,
        copy: bool | None = None,  # noqa: FBT001 as numpy calls it
    ) -> npt.NDArray[Any]:
        """Return the (T, P) weights for `numpy.asarray`."""
        if copy:
            return np.array(self.weights, dtype)
        return np.asarray(self.weights, dtype)

    def to_frame(self, library: Frames | None = None) -> Any:
        """Return a data frame: a row for each frame, `time_s` and a column for each pose.

        Parameters
        ----------
        library : what makes the frame; None for pandas where it is installed, else polars

        Raises
        ------
        LipsyncError
            The library is not installed.

        Examples
        --------
        >>> performer = ll.resolve("english", "facefx")
        >>> animation = performer.perform(ll.Schedule(("M", "AA"), [0, 0.1, 0.3]))
        >>> animation.to_frame().columns[:3].tolist()
        ['time_s', 'open', 'W']
        """
        if library is not None:
            refuse_other("library", library, Frames)
        wanted = get_args(Frames) if library is None else (library,)
        for name in wanted:
            try:
                module = import_module(name)
            except ImportError:
                continue
            return module.DataFrame({"time_s": self.times, **dict(self)})
        raise LipsyncError(
            f"{' and '.join(wanted)} {'are' if library is None else 'is'} not installed; "
            f"install {' or '.join(wanted)}: pip install {wanted[0]}"
        )

    def __getitem__(self, pose: str) -> npt.NDArray[np.float64]:
        """Return the (T,) curve of one pose."""
        from lipsync_lang.errors import did_you_mean, spelled

        name = spelled(pose, self.poses)
        if name not in self.poses:
            raise LipsyncError(f"no pose '{pose}' here; {did_you_mean(pose, self.poses)}")
        return self.weights[:, self.poses.index(name)]

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
