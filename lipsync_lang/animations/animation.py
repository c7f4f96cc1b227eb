"""Animation: the result of a performance, as an array of pose weights over time (seconds)."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from io import BytesIO
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, Self, get_args

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.errors import LipsyncError, did_you_mean, refuse_other, spelled
from lipsync_lang.base.extras import package_line
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.schedules.schedule import Schedule

if TYPE_CHECKING:
    from lipsync_lang.animations.explanation import Explanation
    from lipsync_lang.animations.keys import KeyedCurve

FrameLibrary = Literal["pandas", "polars"]
"""Supported data frame libraries, in order of preference."""


class AnimationSource(Protocol):
    """The maker of an animation, which can explain it."""

    def explain(self, animation: "Animation", seconds: float) -> "Explanation":
        """Explain the weight of each pose at a time in seconds."""


@dataclass(frozen=True, eq=False)
class ExportSettings:
    """Settings of output files, for all formats that can follow them.

    Raises LipsyncError if `key_error` is out of range.

    Parameters
    ----------
    offset : start of the sound on the timeline of the file, in seconds
    key_error : maximum error of keyframes, in formats with keyframes; None for the default of the
        format, which has straight lines between them
    key_lines : True for straight lines within `key_error`, False for cubic curves in formats that
        have tangents
    against : other animations of the line by name, for formats that compare
    face : file beside the output that holds the model's data for all lines; empty for each its own
    pose_names : True if columns have the names of poses, where the model has shapes of other names
    frame_rate : frames per second that somebody has asked for, in formats that count the frames of
        another program; None for that program's own if the animation has the usual rate
    """

    offset: float = 0.0
    key_error: float | None = None
    key_lines: bool = False
    against: Mapping[str, "Animation"] = field(default_factory=dict)
    face: str = ""
    pose_names: bool = False
    frame_rate: float | None = None

    def __post_init__(self) -> None:
        """Refuse an error of keys that is out of range."""
        if self.key_error is not None:
            from lipsync_lang.animations.keys import checked

            checked(self.key_error, lines=self.key_lines)


USUAL_EXPORT = ExportSettings()
"""Settings of files if nobody asks for others."""


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
    source : the maker of the animation, for `explain`; None for curves of another program
    channels : the model channel of each column; empty if unknown
    model : the model file of the character or its pose set
    neutral : the name of the neutral pose, if any
    contacts : poses that must stay visible at every contact, with the levels that contacts hold
    export : settings of output files
    """

    times: npt.NDArray[np.float64]
    poses: tuple[str, ...]
    weights: npt.NDArray[np.float64]
    fps: float
    schedule: Schedule
    source: AnimationSource | None = None
    channels: tuple[Channel, ...] = ()
    model: Path | None = None
    neutral: str | None = None
    contacts: Mapping[str, float] = field(default_factory=dict)
    export: ExportSettings = USUAL_EXPORT

    @classmethod
    def filled(cls, **fields: Any) -> Self:
        """Make an animation by its fields, without setting each one alone, which takes longer."""
        made = cls.__new__(cls)
        vars(made).update(fields)
        return made

    @property
    def title(self) -> str:
        """Title in output files: the words of the schedule, or the name of its source file."""
        source = Path(self.schedule.source)
        words = " ".join(word.text for word in self.schedule.words)
        named = source.stem if source.suffix else "lipsync"
        return shorten(words, 60, placeholder="…") or named

    @property
    def columns(self) -> tuple[Channel, ...]:
        """Channel of each column; by default, a shape with the name of the pose."""
        return self.channels or tuple(map(Channel, self.poses))

    @property
    def offset(self) -> float:
        """Start of the sound on the timeline of output files, in seconds."""
        return self.export.offset

    @property
    def begins(self) -> float:
        """Start of the sound in seconds, in formats without negative time.

        The `offset`, or the length of the movement before the sound if that is longer.
        """
        return max(self.offset, -float(self.times[0]))

    @property
    def timeline(self) -> npt.NDArray[np.float64]:
        """(T,) seconds from the start of a file without negative time."""
        # Rounding may leave the first frame a little below 0.
        return np.maximum(self.times + self.begins, 0.0)

    def keyframes(self, suits: float, *, lines: bool = False) -> "list[KeyedCurve]":
        """Return a minimal set of keyframes for each column within an error.

        `suits` is the default error of the format; `ExportSettings.key_error` takes precedence.
        With `lines`, they are of straight lines in any case, for formats without tangents.
        """
        from lipsync_lang.animations.keys import curves

        error = self.export.key_error
        straight = error is None or lines or self.export.key_lines
        within, floors = suits if error is None else error, None if straight else self.contacts
        return curves(self.poses, self.timeline, self.weights, within, floors)

    def thinned(self) -> Self:
        """Return only the frames that straight lines within `key_error` need; all of them without.

        For formats whose curves share their times and have no tangents.
        """
        from lipsync_lang.animations.keys import needed

        if self.export.key_error is None:
            return self
        kept = needed(self.times, self.weights, self.export.key_error)
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
        return curves_html(self)

    def show(self, height: int = 760) -> "PageFrame":
        """Return the page of the animation for a notebook, which plays it in place.

        The `height` is that of the frame in pixels.

        Examples
        --------
        >>> performer = ll.resolve("english", "facefx")
        >>> animation = performer.perform(ll.Schedule(("M", "AA"), [0, 0.1, 0.3]))
        >>> frame = animation.show()
        >>> frame._repr_html_().startswith("<iframe")
        True
        """
        from lipsync_lang.animations.animation_writers import WRITERS

        page = BytesIO()
        WRITERS["html"].write(self, page)
        return PageFrame(page.getvalue().decode("utf-8"), height)

    def __len__(self) -> int:
        """Return the number of frames."""
        return len(self.times)

    def __bool__(self) -> bool:
        """Return True, even for an animation without frames."""
        return True

    def __iter__(self) -> Iterator[tuple[str, npt.NDArray[np.float64]]]:
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
        return np.array(self.weights, dtype) if copy else np.asarray(self.weights, dtype)

    def to_frame(self, library: FrameLibrary | None = None) -> Any:
        """Return a data frame: one row per frame, with `time_s` and a column per pose.

        By default, the `library` is pandas if installed, else polars. Raises LipsyncError if it is
        not installed.

        Examples
        --------
        >>> performer = ll.resolve("english", "facefx")
        >>> animation = performer.perform(ll.Schedule(("M", "AA"), [0, 0.1, 0.3]))
        >>> animation.to_frame().columns[:3].tolist()
        ['time_s', 'open', 'W']
        """
        if library is not None:
            refuse_other("library", library, FrameLibrary)
        wanted = get_args(FrameLibrary) if library is None else (library,)
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
        name = spelled(pose, self.poses)
        if name not in self.poses:
            raise LipsyncError(f"unknown pose '{pose}'; {did_you_mean(pose, self.poses)}")
        return self.weights[:, self.poses.index(name)]

    def cut(self) -> Self:
        """Return only the frames within the schedule, without lead-in and tail."""
        half = 0.5 / self.fps  # tolerance: half a frame at both ends
        inside = (self.times > self.schedule.start - half) & (self.times < self.schedule.end + half)
        return replace(self, times=self.times[inside], weights=self.weights[inside])

    def without_gestures(self) -> Self:
        """Return the animation without the columns of gestures; itself if it has none."""
        kept = [n for n, channel in enumerate(self.channels) if not channel.gesture]
        if len(kept) == len(self.channels):
            return self
        return replace(
            self,
            poses=tuple(self.poses[n] for n in kept),
            weights=np.ascontiguousarray(self.weights[:, kept]),
            channels=tuple(self.channels[n] for n in kept),
        )

    def save(
        self,
        path: str | Path,
        writer: str | None = None,
        *,
        keys: float | None = None,
        lines: bool = False,
    ) -> None:
        """Write to a file.

        Raises LipsyncError if the format is unknown, the file cannot be written, or `keys` is out
        of range.

        Parameters
        ----------
        path : the output file; its suffix selects the format (``lipsync-lang formats`` lists them).
            ``-`` is standard output
        writer : format name, to override the suffix
        keys : maximum error of keyframes; by default, that of the `export` settings
        lines : straight lines within `keys`, also in formats with tangents; 0 drops only frames on
            a straight line
        """
        from lipsync_lang.animations.animation_writers import save
        from lipsync_lang.base.files import argument_path

        shown = self
        if keys is not None:
            shown = replace(self, export=replace(self.export, key_error=keys, key_lines=lines))
        save(shown, argument_path(path), writer)

    def explain(self, seconds: float) -> "Explanation":
        """Explain the weight of each pose at a time in seconds."""
        if self.source is None:
            raise LipsyncError("this animation was read from a file, so it cannot be explained")
        return self.source.explain(self, seconds)


WIDTH, HEIGHT = 720, 160
"""Size of the drawing in pixels."""

MOST_POINTS = 720
"""Maximum number of points per curve, to limit the size of long animations."""

MOST_CURVES = 60
"""Maximum number of curves; those with the most movement are drawn."""


class PageFrame(NamedTuple):
    """A page in a frame of a notebook, `height` pixels high; it cannot reach the notebook."""

    page: str
    height: int

    def __repr__(self) -> str:
        """Say how the page is shown elsewhere."""
        size = f"{len(self.page) / 1e6:.1f} MB"
        return f"<PageFrame of {size}; save('line.html') writes it to a file>"

    def _repr_html_(self) -> str:
        """Show the page in notebooks."""
        from html import escape

        return (
            f'<iframe sandbox="allow-scripts" width="100%" height="{self.height:d}" '
            f'style="border: 0" srcdoc="{escape(self.page)}"></iframe>'
        )


def curves_html(animation: "Animation") -> str:
    """Draw the curves over seconds in different colours, with a legend below.

    The vertical range is 0 to 1, or the range of the values if a rig exceeds it.
    """
    from html import escape

    head = escape(repr(animation))
    if not len(animation):
        return f"<p>{head}</p>"
    moving = np.ptp(animation.weights, axis=0)
    shown = [int(i) for i in np.argsort(-moving, kind="stable")[:MOST_CURVES] if moving[i] > 0]
    low, high = min(0.0, animation.weights.min()), max(1.0, animation.weights.max())
    picked = np.unique(np.linspace(0, len(animation) - 1, MOST_POINTS).round().astype(int))
    times = animation.times[picked] - animation.times[0]
    across = times / max(times[-1], 1e-9) * WIDTH
    lines, legend = [], []
    for number, pose in enumerate(sorted(shown)):
        colour = f"hsl({360 * number / len(shown):.0f},65%,45%)"
        heights = HEIGHT * (high - animation.weights[picked, pose]) / (high - low)
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across, heights, strict=True))
        name = escape(animation.poses[pose])
        lines.append(
            f'<polyline stroke="{colour}" points="{points}"><title>{name}</title></polyline>'
        )
        legend.append(f'<span style="color:{colour}">{name}</span>')
    return (
        f"<div><p>{head}</p>"
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" height="{HEIGHT}" fill="none" '
        f'stroke-width="1.5">{"".join(lines)}</svg><p>{" ".join(legend)}</p></div>'
    )
