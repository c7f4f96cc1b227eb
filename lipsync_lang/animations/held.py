"""Reduction of blended poses to one shape at a time, for programs that swap drawings.

Dynamic programming finds the sequence of poses with the largest total weight, with each pose shown
for at least `HOLD_SECONDS`. This removes flicker. The middle of a contact has a weight above all
poses that it can displace, so that closed lips stay visible. An animation with only weights of 0
and 1 is already held and is used as it is; of two contacts on one frame, the first pose is shown.
"""

from itertools import pairwise
from math import ceil, floor
from typing import NamedTuple

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.fixed import shape_columns
from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.errors import OutputError

HOLD_SECONDS = 0.1
"""Minimum duration of a shape in seconds; shorter shapes flicker."""

REST_WEIGHT = 0.25
"""Weight of the neutral face; weaker poses are not shown."""

NEUTRAL_DRAWING = "rest"
"""Usual name of the neutral drawing."""

FRAME_TOLERANCE = 1e-6
"""Tolerance for equal times, in frames."""


class HeldShape(NamedTuple):
    """A shape and its time span, in seconds of the output timeline."""

    name: str
    start: float
    end: float


def held(animation: Animation, rest: str = NEUTRAL_DRAWING) -> list[HeldShape]:
    """Return the sequence of shapes from 0 to the end of the sound.

    Spans have no gaps, and neighbours differ. Movement before 0 s and after the sound is cut. An
    animation without a neutral shape shows `rest`.
    """
    animation = animation.without_gestures()
    end = animation.offset + sound(animation)
    if end <= 0:
        what = f"the sound ends {-end:g} s before the start of the timeline; give a later offset"
        raise OutputError(f"`offset={animation.offset:g}`: {what}")
    begin, weights = _frames(animation, end)
    contacts = [animation.poses.index(pose) for pose in animation.contacts]
    shown = strongest(weights, contacts, _least(animation))
    names = (*animation.poses, animation.neutral or rest)
    starts = [0, *_changes(shown)]
    times = [0.0, *(begin + start / animation.fps for start in starts[1:]), end]
    spans = zip(starts, pairwise(times), strict=True)
    return [HeldShape(names[shown[start]], *span) for start, span in spans]


def sound(animation: Animation) -> float:
    """Return the duration in seconds of the sound, or of the schedule without audio."""
    schedule = animation.schedule
    return schedule.end if schedule.audio is None else schedule.audio.seconds


def strongest(weights: Floats, contacts: list[int], frames: int) -> Ints:
    """Return the pose shown at each frame of `weights` (T, P): its column, or P if neutral.

    A pose stays for `frames` frames or more, or for all T. The columns `contacts` stay visible.
    """
    count, poses = weights.shape
    least = min(frames, count)
    score = np.column_stack([weights, np.full(count, REST_WEIGHT)])
    best = score.argmax(axis=1)
    for low, high in pairwise([0, *_changes(best), count]):
        if best[low] in contacts:
            # More than all poses that a hold around this frame could displace.
            score[(low + high) // 2, best[low]] += 4.0 * least
    # The sum over any run is the difference of two sums from the start.
    total = np.vstack([np.zeros(poses + 1), np.cumsum(score, axis=0)])
    # (t, p): best total of the first t frames with a last run of p, and the start of that run
    worth = np.full((count + 1, poses + 1), -np.inf)
    began = np.zeros((count + 1, poses + 1), np.int64)
    lead, since = np.full(poses + 1, -np.inf), np.zeros(poses + 1, np.int64)
    for stop in range(least, count + 1):
        start = stop - least
        others = np.zeros(poses + 1)  # best score of any other pose so far
        if start:
            second, first = np.argsort(worth[start], kind="stable")[-2:]
            others[:] = worth[start, first]
            others[first] = worth[start, second]
        gain = others - total[start]
        # Of equal gains, the earlier start stays.
        since[gain > lead] = start
        np.maximum(lead, gain, out=lead)
        worth[stop], began[stop] = lead + total[stop], since
    shown = np.zeros(count, np.int64)
    stop = count
    while stop:
        pose = int(worth[stop].argmax())
        start = int(began[stop, pose])
        shown[start:stop] = pose
        worth[start, pose] = -np.inf  # the pose before a run is a different one
        stop = start
    return shown


def _changes(values: Ints) -> list[int]:
    """Return the indices of values that differ from the one before."""
    return (np.flatnonzero(np.diff(values)) + 1).tolist()


def _frames(animation: Animation, end: float) -> tuple[float, Floats]:
    """Return the first time and the weights between 0 and the end; rest fills unknown frames.

    Long rests are shortened, because extra frames of rest do not change the result.
    """
    fps = animation.fps
    room = 2 * _least(animation)
    times = animation.times + animation.offset
    # A frame is shown until the next one, so the last one before 0 counts, too.
    inside = (times > (FRAME_TOLERANCE - 1) / fps) & (times < end - FRAME_TOLERANCE / fps)
    shapes = np.isin(np.arange(len(animation.poses)), shape_columns(animation))
    weights = animation.weights[inside] * shapes
    if not inside.any():
        return 0.0, np.zeros((1, len(animation.poses)))
    first, last = times[inside][[0, -1]]
    before = min(room, max(0, floor(first * fps + FRAME_TOLERANCE)))
    after = min(room, max(0, ceil((end - last) * fps - FRAME_TOLERANCE) - 1))
    return first - before / fps, np.pad(weights, ((before, after), (0, 0)))


def _least(animation: Animation) -> int:
    """Return the minimum number of frames per shape."""
    drawn = np.isin(animation.weights, (0.0, 1.0)).all()
    return 1 if drawn else ceil(HOLD_SECONDS * animation.fps - FRAME_TOLERANCE)
