"""Readers of animations of other programs, as poses or rig channels of a performer, for `check`."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_readers import Recording, read_animation
from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.errors import AnimationError, shortlist
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.shape_matching import placed
from lipsync_lang.performing.performer import Performer
from lipsync_lang.schedules.schedule import Schedule

UNEVEN_FRAMES = 0.02
"""Maximum difference of intervals as a share of a frame; more uneven frames are resampled."""

MAX_FPS = 240.0
"""Maximum number of keys per second; files with more are resampled."""

MAX_RESAMPLED_FRAMES = 1_000_000
"""Maximum number of resampled frames: more than an hour at the highest rate."""

MAX_FRAMES_EACH = 100
"""Maximum number of resampled frames per frame of the file; a longer pause is not within a line."""

PERCENT_ABOVE = 5.0
"""Weights above this are percentages, not fractions."""

AnimationWithRemarks = tuple[Animation, tuple[str, ...]]
"""An animation with remarks on doubtful points."""


def read_for(
    performer: Performer,
    path: str | Path,
    schedule: Schedule | None = None,
    *,
    channels: bool = False,
) -> AnimationWithRemarks:
    """Read an animation file as the poses of a performer, or as the channels of its rig.

    Columns are found by name in any spelling, like shapes of a model. Poses without a column stay
    at rest, and a remark names them. Raises AnimationError if the file cannot be read, has no
    column of the face, or holds no schedule and none is given.

    Parameters
    ----------
    path : CSV, a take of Live Link Face, a GLB with an animation, or our JSON
    schedule : the spoken line; by default the file's own
    channels : read rig channels; by default poses, or channels if the file has only these
    """
    recording = read_animation(path)
    spoken = schedule or recording.schedule
    if spoken is None:
        raise AnimationError(
            f"{recording.source}: has no spoken text; give a TEXT, or timed phonemes (`schedule`)"
        )
    return fit(recording, performer, spoken, channels=channels)


def fit(
    recording: Recording, performer: Performer, schedule: Schedule, *, channels: bool = False
) -> AnimationWithRemarks:
    """Return a recording as an animation of a face; see `read_for`."""
    found = placed_columns(recording, performer, channels=channels)
    values = np.zeros((len(found.times), len(found.face)))
    values[:, found.numbers] = found.values
    names = tuple(channel.name for channel in found.face)
    animation = Animation(found.times, names, values, found.fps, schedule, channels=found.face)
    if not found.missing:
        return animation, found.remarks
    told = f"{recording.source} has no column for {shortlist(found.missing)}"
    return animation, (*found.remarks, f"{told}; these stay at rest")


@dataclass(frozen=True, eq=False)
class PlacedColumns:
    """Columns of a recording that are poses or rig channels of a performer, at an even rate.

    Conventions: C poses or channels of the face, N of them found, P poses, T frames.
    """

    face: tuple[Channel, ...]
    numbers: Ints
    """(N,) ascending indices in `face` of the columns found."""
    times: Floats
    """(T,) seconds."""
    fps: float
    values: Floats
    """(T, N) weights."""
    gains: Floats
    """(C, P) weight of each pose in each column of the face."""
    remarks: tuple[str, ...]

    @property
    def missing(self) -> list[str]:
        """Names of the face without a column."""
        found = set(self.numbers.tolist())
        return [one.name for number, one in enumerate(self.face) if number not in found]


def placed_columns(
    recording: Recording, performer: Performer, *, channels: bool = False
) -> PlacedColumns:
    """Find the columns of a recording that are poses of a performer, or channels of its rig.

    Raises AnimationError if no column belongs to the face, or the frames are too uneven.

    Parameters
    ----------
    channels : read rig channels; by default poses, or channels if more of them are found
    """
    faces = [(performer.channels, np.eye(len(performer.poses)))]
    if (driver := performer.driver) is not None:
        faces.append((driver.channels, driver.rig.gains))
    if channels:
        faces = faces[1:]
    if not faces:
        raise AnimationError(f"{performer.character} has no rig; leave out `channels`")
    shapes = [placed(face, recording.names) for face, _ in faces]
    # Of equal counts the poses win, which come first.
    best = max(range(len(faces)), key=lambda n: (len(shapes[n].shapes), -n))
    (face, gains), found = faces[best], shapes[best].shapes
    if not found:
        raise AnimationError(
            f"{recording.source}: has nothing of {performer.character}: it has "
            f"{shortlist(recording.names)}; wanted are {shortlist(c.name for c in face)}. Name a "
            "character of the pose set that it was made for"
        )
    numbers = sorted(found)
    columns = {name: at for at, name in enumerate(recording.names)}
    values = np.column_stack(
        [recording.values[:, [columns[n] for n in found[one]]].max(axis=1) for one in numbers]
    )
    remarks = [*recording.remarks, *(f"{recording.source}: {d}" for d in shapes[best].doubts)]
    if values.max() > PERCENT_ABOVE:
        values = values / 100
        remarks.append(f"{recording.source}: its weights are up to 100 and are read as percentages")
    times, fps = even_times(recording.source, recording.times)
    # By identity: `even_times` returns the same array if nothing is to be resampled.
    if times is not recording.times:
        values = np.column_stack([np.interp(times, recording.times, one) for one in values.T])
    return PlacedColumns(face, np.array(numbers), times, fps, values, gains, tuple(remarks))


def on_model(animation: "Animation", performer: Performer) -> "Animation":
    """Return an animation of a performer's poses, or of its rig's channels, on its model."""
    if animation.poses != performer.poses:
        return replace(animation, model=performer.model)
    placed = replace(animation, channels=performer.channels, model=performer.model)
    return performer.rigged(placed)


def even_times(source: str, times: Floats) -> tuple[Floats, float]:
    """Return evenly spaced times, and their frames per second."""
    step = float(np.median(np.diff(times)))
    fps = min(1 / step, MAX_FPS)
    # Times with few digits make 30 frames per second 29.99 or 30.01.
    fps = round(fps) if fps >= 1 and abs(fps - round(fps)) < UNEVEN_FRAMES else fps
    apart = np.abs(np.diff(times) * fps - 1)
    if apart.max() <= UNEVEN_FRAMES:
        return times, fps
    count = int(np.floor((times[-1] - times[0]) * fps + 1e-6)) + 1
    if count > min(MAX_RESAMPLED_FRAMES, MAX_FRAMES_EACH * len(times)):
        raise AnimationError(
            f"{source}: has {len(times)} frames over {times[-1] - times[0]:g} s, too uneven "
            "to judge; export it at an even rate"
        )
    return times[0] + np.arange(count) / fps, fps
