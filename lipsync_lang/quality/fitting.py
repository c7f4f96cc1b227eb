"""Animations of other programs, as poses or rig channels of a performer, for `check` to read."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.readers.animation_readers import Recording, read_animation
from lipsync_lang.errors import AnimationError
from lipsync_lang.pipeline.arrays import Floats
from lipsync_lang.rigs.driver import Driver
from lipsync_lang.rigs.shape_matching import placed

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.rigs.channel import Channel
    from lipsync_lang.schedules.schedule import Schedule

UNEVEN_FRAMES = 0.02
"""Share of a frame by which intervals may differ; more uneven frames are resampled."""

MAX_FPS = 240.0
"""Files with more keys per second are resampled at this rate."""

MAX_FRAMES = 1_000_000
"""Frames at an even rate: more than an hour at the greatest one."""

MAX_FRAMES_EACH = 100
"""The same for each frame of the file; a longer pause is no recording of a line."""

PERCENT_ABOVE = 5.0
"""Weights above this are percentages, not shares of 1."""

MAX_NAMES = 8
"""Names that a remark lists."""

Read = tuple[Animation, tuple[str, ...]]
"""An animation, and remarks on doubtful points."""


def read_for(
    performer: "Performer",
    path: str | Path,
    schedule: "Schedule | None" = None,
    *,
    channels: bool = False,
) -> Read:
    """Read an animation file as the poses of a performer, or as the channels of its rig.

    Columns are found by name in any spelling, like the shapes of a model. Poses without a column
    stay at rest, and a remark names them.

    Parameters
    ----------
    path : CSV, a take of Live Link Face, a GLB with an animation, or our JSON
    schedule : the spoken line; by default the file's own
    channels : read rig channels; by default poses, or channels if the file has only these

    Raises
    ------
    AnimationError
        The file cannot be read, has no column of the face, or holds no schedule and none is given.
    """
    recording = read_animation(path)
    spoken = schedule or recording.schedule
    if spoken is None:
        raise AnimationError(
            f"{recording.source}: does not tell what was said; give a TEXT, or timed phonemes "
            "(`schedule`)"
        )
    return fit(recording, performer, spoken, channels=channels)


def fit(
    recording: Recording, performer: "Performer", schedule: "Schedule", *, channels: bool = False
) -> Read:
    """Return a recording as an animation of a face; see `read_for`."""
    faces = _faces(performer)
    if channels:
        faces = faces[1:]
    if not faces:
        raise AnimationError(f"{performer.character} has no rig; leave out `channels`")
    shapes = [placed(face, recording.names) for face in faces]
    best = max(range(len(faces)), key=lambda n: (len(shapes[n].shapes), -n))
    face, found = faces[best], shapes[best].shapes
    if not found:
        raise AnimationError(
            f"{recording.source}: has nothing of {performer.character}: it has "
            f"{_some(recording.names)}; wanted are {_some(c.name for c in face)}. Name a character "
            "of the pose set that it was made for"
        )
    values = np.zeros((len(recording.times), len(face)))
    for number, columns in found.items():
        own = recording.values[:, [recording.names.index(name) for name in columns]]
        values[:, number] = own.max(axis=1)
    remarks = [*recording.remarks, *(f"{recording.source}: {d}" for d in shapes[best].doubts)]
    if values.max() > PERCENT_ABOVE:
        values = values / 100
        remarks.append(f"{recording.source}: its weights run to 100, and are taken as percent")
    times, fps = _even(recording.source, recording.times)
    if times is not recording.times:
        values = np.column_stack([np.interp(times, recording.times, one) for one in values.T])
    names = tuple(channel.name for channel in face)
    animation = Animation(times, names, values, fps, schedule, channels=face)
    missing = [channel.name for number, channel in enumerate(face) if number not in found]
    if missing:
        remarks.append(f"{recording.source} has nothing for {_some(missing)}; they stay at rest")
    return animation, tuple(remarks)


def _faces(performer: "Performer") -> "list[tuple[Channel, ...]]":
    """Return the poses of a performer, and the channels of its rig if it has one."""
    compiled = performer.compiled
    faces = [performer.channels]
    if compiled.rig is not None:
        driver = Driver.from_plain(compiled.rig, performer.poses, compiled.tables.floors)
        faces.append(driver.channels)
    return faces


def _even(source: str, times: Floats) -> tuple[Floats, float]:
    """Return evenly spaced times, and frames per second."""
    step = float(np.median(np.diff(times)))
    fps = min(1 / step, MAX_FPS)
    fps = round(fps) if fps >= 1 and abs(fps - round(fps)) < UNEVEN_FRAMES else fps
    apart = np.abs(np.diff(times) * fps - 1)
    if apart.max() <= UNEVEN_FRAMES:
        return times, fps
    count = int(np.floor((times[-1] - times[0]) * fps + 1e-6)) + 1
    if count > min(MAX_FRAMES, MAX_FRAMES_EACH * len(times)):
        raise AnimationError(
            f"{source}: has {len(times)} frames over {times[-1] - times[0]:g} s, too unevenly "
            "to judge; export it at an even rate"
        )
    return times[0] + np.arange(count) / fps, fps


def _some(names: "Iterable[str]") -> str:
    known = list(names)
    return ", ".join(known[:MAX_NAMES]) + (", ..." if len(known) > MAX_NAMES else "")
