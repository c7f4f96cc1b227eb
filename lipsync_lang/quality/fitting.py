"""Bring an animation of any program onto the face of a performer, so that it can be judged."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.readers.animation_readers import Recording, read_animation
from lipsync_lang.errors import AnimationError
from lipsync_lang.pipeline.arrays import Floats
from lipsync_lang.rigs.driver import Driver
from lipsync_lang.rigs.names import placed

if TYPE_CHECKING:
    from collections.abc import Iterable

    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.rigs.channel import Channel
    from lipsync_lang.schedules.schedule import Schedule

UNEVEN = 0.02
"""Share of a frame by which frames may be apart unevenly before they are laid out anew."""

MOST_RATE = 240.0
"""Frames per second; a file with more keys is read at so many."""

PERCENT = 5.0
"""Weights past this are no shares of 1."""

FEW = 8
"""As many names as a remark lists."""

Read = tuple[Animation, tuple[str, ...]]
"""An animation, and what is doubtful about it."""


def read_for(
    performer: "Performer",
    path: str | Path,
    schedule: "Schedule | None" = None,
    *,
    channels: bool = False,
) -> Read:
    """Read an animation file as the poses of a performer, or as the channels of its rig.

    Columns are found by name, however they are spelled, as the shapes of a model are. What has no
    column stays at rest, and is told.

    Parameters
    ----------
    path : CSV, a take of Live Link Face, a GLB with an animation, or our JSON
    schedule : what was said; what the file says was, unless given
    channels : whether to read channels; else poses, or channels where only these are found

    Raises
    ------
    AnimationError
        The file cannot be read, has nothing of the face, or nobody knows what was said.
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
    """Lay a recording on a face; see `read_for`."""
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
    if values.max() > PERCENT:
        values = values / 100
        remarks.append(f"{recording.source}: its weights run to 100, and are taken as percent")
    times, fps = _even(recording.times)
    if times is not recording.times:
        values = np.column_stack([np.interp(times, recording.times, one) for one in values.T])
    names = tuple(channel.name for channel in face)
    animation = Animation(times, names, values, fps, schedule, channels=face)
    missing = [channel.name for number, channel in enumerate(face) if number not in found]
    if missing:
        remarks.append(f"{recording.source} has nothing for {_some(missing)}; they stay at rest")
    return animation, tuple(remarks)


def _faces(performer: "Performer") -> "list[tuple[Channel, ...]]":
    """Return the poses of a performer, and the channels of its rig where it has one."""
    compiled = performer.compiled
    faces = [performer.channels]
    if compiled.rig is not None:
        driver = Driver.from_plain(compiled.rig, performer.poses, compiled.tables.floors)
        faces.append(driver.channels)
    return faces


def _even(times: Floats) -> tuple[Floats, float]:
    """Return times that are evenly apart, and how many there are in a second."""
    step = float(np.median(np.diff(times)))
    fps = min(1 / step, MOST_RATE)
    fps = round(fps) if abs(fps - round(fps)) < UNEVEN else fps
    apart = np.abs(np.diff(times) * fps - 1)
    if apart.max() <= UNEVEN:
        return times, fps
    count = int(np.floor((times[-1] - times[0]) * fps + 1e-6)) + 1
    return times[0] + np.arange(count) / fps, fps


def _some(names: "Iterable[str]") -> str:
    known = list(names)
    return ", ".join(known[:FEW]) + (", ..." if len(known) > FEW else "")
