"""Animation: the result of a performance, as an array of pose weights over time (seconds)."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any, Literal, Self, get_args

import numpy as np
import numpy.typing as npt

from lipsync_lang.errors import LipsyncError, refuse_other
from lipsync_lang.extras import package_line
from lipsync_lang.rigs.channel import Channel
from lipsync_lang.schedules.schedule import Schedule

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lipsync_lang.animations.explanation import Explanation
    from lipsync_lang.animations.keys import Curve
    from lipsync_lang.animations.notebook import PageFrame

Frames = Literal["pandas", "polars"]
"""Supported data frame libraries, in order of preference."""


@dataclass(frozen=True, eq=False)
class Animation:
    """Pose weights at every frame.

    Parameters
    ----------
    times : (T,) seconds; negative for movement before the sound
    poses : P pose names
    weights : (T, P) in [0, 1]; rig channels may have other ranges
    fps : frames per second
    schedule : the performed schedule
    performer : the performer that made the animation; needed by `explain`
    asked : performance options: line name, styles and dials
    channels : the model channel of each column; empty if unknown
    model : the model file of the character or its pose set
    offset : start of the sound on the timeline of output files, in seconds
    key_error : maximum error of keyframes, in formats with keyframes; None for the default of the
        format, which has straight lines between them
    key_lines : True for straight lines within `key_error`, False for cubic curves in formats that
        have tangents
    neutral : the name of the neutral pose, if any
    contacts : poses that must stay visible at every contact, with the levels that contacts hold
    against : other animations of the line by name, for formats that compare
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
    key_error: float | None = None
    key_lines: bool = False
    neutral: str | None = None
    contacts: Mapping[str, float] = field(default_factory=dict)
    against: Mapping[str, "Animation"] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """Title in output files: the words of the schedule, or the name of its source file."""
        source = Path(self.schedule.source)
        words = " ".join(word.text for word in self.schedule.words)
        return shorten(words, 60, placeholder=" ...") or (
            source.stem if source.suffix else "lipsync"
        )

    @property
    def columns(self) -> tuple[Channel, ...]:
        """Channel of each column; by default, a shape with the name of the pose."""
        return self.channels or tuple(map(Channel, self.poses))

    @property
    def begins(self) -> float:
        """Start of the sound in seconds, in formats without negative time.

        The `offset`, or the length of the movement before the sound if that is longer.
        """
        return max(self.offset, -float(self.times[0]))

    @property
    def timeline(self) -> npt.NDArray[np.float64]:
        """(T,) seconds from the start of a file without negative time."""
        return np.maximum(self.times + self.begins, 0.0)

    def keyframes(self, suits: float, *, lines: bool = False) -> "list[Curve]":
        """Return a minimal set of keyframes for each column within an error.

        Parameters
        ----------
        suits : default error of the format; the animation's own `key_error` takes precedence
        lines : straight lines in any case, for formats without tangents

        Raises
        ------
        LipsyncError
            `key_error` is out of range.
        """
        from lipsync_lang.animations.keys import checked, cubic_curves, curves

        if self.key_error is None:
            return curves(self.poses, self.timeline, self.weights, suits)
        error = checked(self.key_error, lines=self.key_lines)
        if lines or self.key_lines:
            return curves(self.poses, self.timeline, self.weights, error)
        return cubic_curves(self.poses, self.timeline, self.weights, error, self.contacts)

    def thinned(self) -> Self:
        """Return only the frames that straight lines within `key_error` need; all of them without.

        For formats whose curves share their times and have no tangents.

        Raises
        ------
        LipsyncError
            `key_error` is out of range.
        """
        from lipsync_lang.animations.keys import checked, needed

        if self.key_error is None:
            return self
        kept = needed(self.times, self.weights, checked(self.key_error, lines=self.key_lines))
        return replace(self, times=self.times[kept], weights=self.weights[kept])

    def __repr__(self) -> str:
        """Summarise the animation in one line."""
        span = f", {self.times[0]:.2f} to {self.times[-1]:.2f} s" if len(self) else ""
        return (
            f"<Animation {self.title!r}: {len(self)} frames of {len(self.poses)} poses "
            f"at {self.fps:g} fps{span}>"
        )

    def _repr_html_(self) -> str:
        """Draw the curves for notebooks."""
        from lipsync_lang.animations.notebook import curves_html

        return curves_html(self)

    def show(self, height: int = 760) -> "PageFrame":
        """Return the page of the animation for a notebook, which plays it in place.

        Parameters
        ----------
        height : of the frame in pixels

        Examples
        --------
        >>> performer = ll.resolve("english", "facefx")
        >>> animation = performer.perform(ll.Schedule(("M", "AA"), [0, 0.1, 0.3]))
        >>> frame = animation.show()
        >>> frame._repr_html_().startswith("<iframe")
        True
        """
        from lipsync_lang.animations.notebook import page_frame

        return page_frame(self, height)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.times)

    def __bool__(self) -> bool:
        """Return True, even for an animation without frames."""
        return True

    def __iter__(self) -> "Iterator[tuple[str, npt.NDArray[np.float64]]]":
        """Yield pairs of pose name and (T,) curve; `dict(animation)` is a mapping of them."""
        return zip(self.poses, self.weights.T, strict=True)

    def __contains__(self, pose: object) -> bool:
        """Test for a pose by name."""
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
        """Return a data frame: one row per frame, with `time_s` and a column per pose.

        Parameters
        ----------
        library : the data frame library; None for pandas if installed, else polars

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
            f"install {' or '.join(wanted)}: {package_line(wanted[0])}"
        )

    def __getitem__(self, pose: str) -> npt.NDArray[np.float64]:
        """Return the (T,) curve of one pose."""
        from lipsync_lang.errors import did_you_mean, spelled

        name = spelled(pose, self.poses)
        if name not in self.poses:
            raise LipsyncError(f"unknown pose '{pose}'; {did_you_mean(pose, self.poses)}")
        return self.weights[:, self.poses.index(name)]

    def cut(self) -> Self:
        """Return only the frames within the schedule, without lead-in and tail."""
        half = 0.5 / self.fps  # tolerance: half a frame at both ends
        inside = (self.times > self.schedule.start - half) & (self.times < self.schedule.end + half)
        return replace(self, times=self.times[inside], weights=self.weights[inside])

    def save(
        self,
        path: str | Path,
        writer: str | None = None,
        *,
        keys: float | None = None,
        lines: bool = False,
    ) -> None:
        """Write to a file.

        Parameters
        ----------
        path : the output file; its suffix selects the format (``lipsync-lang formats`` lists them).
            ``-`` is standard output
        writer : format name, to override the suffix
        keys : maximum error of keyframes; by default, the animation's own `key_error`
        lines : straight lines within `keys`, also in formats with tangents; 0 drops only frames on
            a straight line

        Raises
        ------
        LipsyncError
            The format is unknown, the file cannot be written, or `keys` is out of range.
        """
        from lipsync_lang.animations.animation_writers import save
        from lipsync_lang.animations.keys import checked
        from lipsync_lang.files import argument_path

        shown = self
        if keys is not None:
            shown = replace(self, key_error=checked(keys, lines=lines), key_lines=lines)
        save(shown, argument_path(path), writer)

    def explain(self, seconds: float) -> "Explanation":
        """Explain the weight of each pose at a time in seconds."""
        if self.performer is None:
            raise LipsyncError("this animation was read from a file, so it cannot be explained")
        explanation: Explanation = self.performer.explain(self, seconds)
        return explanation
