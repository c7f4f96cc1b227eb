"""Readers of captures: lines of signals with their phonemes, from files.

An unreadable file is set aside with the reason, and the other files are still read.
"""

from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lipsync_lang.animations.animation_readers import Recording, read_animation
from lipsync_lang.animations.readers.live_link import fits
from lipsync_lang.arrays import Floats
from lipsync_lang.capture.capture_files import CaptureFiles, find_captures
from lipsync_lang.capture.capture_timings import CaptureTimings, readable
from lipsync_lang.capture.captured_line import CapturedLine, resampled
from lipsync_lang.capture.fit_file import SetAside
from lipsync_lang.capture.sensors import SensorSignals, load_readout, read_sensors
from lipsync_lang.errors import AnimationError, LipsyncError
from lipsync_lang.quality.fitting import even_times, placed_columns, some_names
from lipsync_lang.schedules.timing_file import HEAD_BYTES

if TYPE_CHECKING:
    from lipsync_lang.packs.models import ReadOut
    from lipsync_lang.performing.performer import Performer
    from lipsync_lang.schedules.schedule import Schedule

FPS_TOLERANCE = 0.01
"""Maximum relative difference of the stated frame rate from that of the times."""


class Captures(NamedTuple):
    """Captured lines, and the captures that are not used."""

    lines: tuple[CapturedLine, ...]
    set_aside: tuple[SetAside, ...]


def read_captures(  # noqa: PLR0913 facts that files may lack
    performer: "Performer",
    paths: str | Path | Iterable[str | Path],
    *,
    readout: str | Path | None = None,
    speaker: str | None = None,
    aligner: str | None = None,
    notation: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Captures:
    """Read captures with their phonemes, as signals of a performer's face.

    Parameters
    ----------
    performer : defines poses, rig channels, measures and the language of the timings
    paths : files and folders; `find_captures` says which files belong to a capture
    readout : read-out of sensor tables; by default `readout.yaml` in their folder or above
    speaker : pattern of paths with the speaker, such as `{speaker}_*`
    aligner : aligner for captures with text and sound; by default the language's
    notation : notation of the timings; None for that of the read-out or the language
    progress : called with the numbers of captures read and of all captures

    Raises
    ------
    LipsyncError
        A path is missing, or the read-out is unsound. A fault of one capture sets that one aside.
    """
    found = find_captures(paths, speaker=speaker)
    stated = None if readout is None else load_readout(Path(readout))
    load = cache(load_readout)
    timed = CaptureTimings(performer, aligner, notation)
    lines, aside = [], list(found.set_aside)
    spoken = timed.aligned([one for one in found.files if one.timings is None])
    for number, files in enumerate(found.files, 1):
        try:
            own = load(files.readout) if stated is None and files.readout else stated
            lines.append(_line(performer, files, own, timed, spoken.get(files.name)))
        except (LipsyncError, OSError) as error:
            aside.append(SetAside(line=files.name, why=str(error)))
        if progress is not None:
            progress(number, len(found.files))
    return Captures(tuple(lines), tuple(aside))


class _Moving(NamedTuple):
    """The motion of a capture, without its phonemes."""

    times: Floats
    signals: tuple[str, ...]
    values: Floats
    gains: Floats
    free: bool = False
    rigged: bool = False
    remarks: tuple[str, ...] = ()
    schedule: "Schedule | None" = None


def _line(
    performer: "Performer",
    files: CaptureFiles,
    readout: "ReadOut | None",
    timed: CaptureTimings,
    spoken: "Schedule | LipsyncError | None",
) -> CapturedLine:
    """Read one capture."""
    motion = _motion(performer, files, readout)
    fps = (len(motion.times) - 1) / float(motion.times[-1] - motion.times[0])
    if files.fps is not None and abs(fps / files.fps - 1) > FPS_TOLERANCE:
        raise AnimationError(
            f"{files.capture}: its times have {fps:.4g} frames per second, but the list states "
            f"{files.fps:g}; correct the wrong one"
        )
    schedule = timed.schedule(files, readout, spoken or motion.schedule)
    schedule, more = readable(performer, schedule)
    return CapturedLine(
        files.name,
        schedule,
        motion.times + files.start,
        motion.signals,
        motion.values,
        motion.gains,
        motion.free,
        motion.rigged,
        files.speaker,
        (*motion.remarks, *schedule.remarks, *more),
    )


def _motion(performer: "Performer", files: CaptureFiles, readout: "ReadOut | None") -> _Moving:
    """Read the motion of sensors if a read-out has the columns, or else of poses or channels."""
    may_be_sensors = files.capture.suffix.lower() == ".csv"
    if may_be_sensors:  # unless it is a take of Live Link Face
        with files.capture.open("rb") as stream:
            may_be_sensors = not fits(stream.read(HEAD_BYTES))
    if readout is not None and may_be_sensors:
        sensed = read_sensors(files.capture, readout)
        if sensed is not None:
            return _measured(performer, files.capture, sensed)
    try:
        return _weighted(performer, read_animation(files.capture))
    except AnimationError as error:
        if readout is not None or not may_be_sensors:
            raise
        raise AnimationError(f"{error} (for a table of sensors, give a read-out)") from None


def _measured(performer: "Performer", path: Path, sensed: SensorSignals) -> _Moving:
    """Return the measures of sensors that the pose set has."""
    known = performer.compiled.measures
    used = [at for at, name in enumerate(sensed.measures) if name in known]
    if not used:
        raise AnimationError(
            f"{path}: its read-out has {some_names(sensed.measures)}, but the measures of "
            f"{performer.character} are {some_names(known) or 'none'}; use these in the read-out"
        )
    signals = tuple(sensed.measures[at] for at in used)
    gains = np.array([[known[s].get(pose, 0.0) for pose in performer.poses] for s in signals])
    times, _ = even_times(str(path), sensed.times)
    values = sensed.values[:, used]
    if times is not sensed.times:
        values = resampled(times, sensed.times, values)
    other = [name for name in sensed.measures if name not in known]
    remarks = list(sensed.remarks)
    if other:
        remarks.append(
            f"{path}: {performer.character} has no measure {some_names(other)}; these are left out"
        )
    return _Moving(times, signals, values, gains, free=True, remarks=tuple(remarks))


def _weighted(performer: "Performer", recording: Recording) -> _Moving:
    """Return the recorded poses or rig channels of an animation."""
    found = placed_columns(recording, performer)
    names = [found.face[number].name for number in found.numbers.tolist()]
    gains = found.gains[found.numbers]
    remarks = found.remarks
    if found.missing:
        told = f"has no column for {some_names(found.missing)}; these are not fitted"
        remarks += (f"{recording.source}: {told}",)
    deaf = ~gains.any(axis=1)
    if deaf.all():
        raise AnimationError(f"{recording.source}: no pose moves any of {some_names(names)}")
    kept = np.flatnonzero(~deaf)
    signals = tuple(names[at] for at in kept)
    return _Moving(
        found.times,
        signals,
        found.values[:, kept],
        gains[kept],
        rigged=found.face != performer.channels,
        remarks=remarks,
        schedule=recording.schedule,
    )
