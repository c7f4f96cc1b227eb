"""One shape at a time, for programs that swap drawings and do not blend.

Of all ways to show one pose after the other, each for at least `HOLD`, the one is taken whose
shown poses weigh most. So a shape that would only flicker makes room for its neighbours. The
middle of a contact counts more than all that it can displace, so that lips which meet are seen to
meet. An animation whose poses are shown wholly or not at all has been held already, and is taken as
it is; where it has two contacts on one frame, the first pose is shown.
"""

from collections.abc import Iterator
from itertools import pairwise
from math import ceil, floor
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.fixed import shape_columns
from lipsync_lang.errors import OutputError

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

HOLD = 0.1
"""Seconds for which a shape is shown at least; a shorter one is a flicker."""

REST = 0.25
"""What the face at rest weighs: a pose below it does not stand out."""

NEAR = 1e-6
"""Frames; closer times are the same."""


class HeldShape(NamedTuple):
    """What is shown from one time to another, in seconds of the file's timeline."""

    name: str
    start: float
    end: float


def held(animation: Animation, rest: str) -> list[HeldShape]:
    """Return what is shown from 0 to the end of the sound.

    The shapes follow each other without a gap, and no two neighbours are alike. What moves before
    the timeline begins or after the sound has ended is cut.

    Parameters
    ----------
    rest : what the face at rest is called, if the animation has no name for it
    """
    end = animation.offset + sound(animation)
    if end <= 0:
        raise OutputError(
            f"`offset={animation.offset:g}`: the sound is over {-end:g} s before the file's "
            "timeline begins; give a later offset"
        )
    begin, weights = _frames(animation, end)
    shown = strongest(weights, _contacts(animation), _least(animation))
    names = (*animation.poses, animation.neutral or rest)
    starts = [0, *(np.flatnonzero(np.diff(shown)) + 1).tolist()]
    times = [0.0, *(begin + start / animation.fps for start in starts[1:]), end]
    return [
        HeldShape(names[shown[start]], *span)
        for start, span in zip(starts, pairwise(times), strict=True)
    ]


def sound(animation: Animation) -> float:
    """Return how many seconds are spoken: those of the sound, or of the schedule without one."""
    schedule = animation.schedule
    return schedule.end if schedule.audio is None else schedule.audio.seconds


def strongest(weights: Floats, contacts: list[int], frames: int) -> Ints:
    """Return which pose is shown at each frame; P is the face at rest.

    Parameters
    ----------
    weights : (T, P)
    contacts : columns that must be seen
    frames : how many a pose is shown for at least

    Returns
    -------
    (T,), whose runs have `frames` frames or more, but for a whole that has less
    """
    count, poses = weights.shape
    least = min(frames, count)
    score = np.column_stack([weights, np.full(count, REST)])
    best = score.argmax(axis=1)
    for low, high in _runs(best):
        if best[low] in contacts:
            score[(low + high) // 2, best[low]] += 4.0 * least
    total = np.vstack([np.zeros(poses + 1), np.cumsum(score, axis=0)])
    # (t, p): the most that the first t frames weigh, if the last run shows p; where that begins
    worth = np.full((count + 1, poses + 1), -np.inf)
    began = np.zeros((count + 1, poses + 1), np.int64)
    lead, since = np.full(poses + 1, -np.inf), np.zeros(poses + 1, np.int64)
    for stop in range(least, count + 1):
        start = stop - least
        gain = _best_other(worth[start], start) - total[start]
        since[gain > lead] = start
        np.maximum(lead, gain, out=lead)
        worth[stop], began[stop] = lead + total[stop], since
    shown = np.zeros(count, np.int64)
    stop = count
    while stop:
        pose = int(worth[stop].argmax())
        start = int(began[stop, pose])
        shown[start:stop] = pose
        worth[start, pose] = -np.inf  # what comes before is another
        stop = start
    return shown


def _best_other(worth: Floats, start: int) -> Floats:
    """Return the best score of any other pose so far, for each pose."""
    if start == 0:
        return np.zeros(len(worth))
    second, first = np.argsort(worth, kind="stable")[-2:]
    others = np.full(len(worth), worth[first])
    others[first] = worth[second]
    return others


def _runs(values: Ints) -> Iterator[tuple[int, int]]:
    """Yield where each run of equal values begins and stops."""
    return pairwise([0, *(np.flatnonzero(np.diff(values)) + 1).tolist(), len(values)])


def _frames(animation: Animation, end: float) -> tuple[float, Floats]:
    """Return when the weights between 0 and the end begin, and those; at rest where none are known.

    Of long rests there are only some frames: the others change nothing of what is shown.
    """
    fps = animation.fps
    room = 2 * _least(animation)
    times = animation.times + animation.offset
    inside = (times > (NEAR - 1) / fps) & (times < end - NEAR / fps)
    shapes = np.isin(np.arange(len(animation.poses)), shape_columns(animation))
    weights = animation.weights[inside] * shapes
    if not inside.any():
        return 0.0, np.zeros((1, len(animation.poses)))
    first, last = times[inside][[0, -1]]
    before = min(room, max(0, floor(first * fps + NEAR)))
    after = min(room, max(0, ceil((end - last) * fps - NEAR) - 1))
    return first - before / fps, np.pad(weights, ((before, after), (0, 0)))


def _contacts(animation: Animation) -> list[int]:
    return [animation.poses.index(pose) for pose in animation.contacts]


def _least(animation: Animation) -> int:
    """Return how many frames a shape is shown for at least."""
    drawn = np.isin(animation.weights, (0.0, 1.0)).all()
    return 1 if drawn else ceil(HOLD * animation.fps - NEAR)
