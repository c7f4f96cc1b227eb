"""Plain methods on the same targets, so that ours is compared with something."""

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.packs.library import Library
from lipsync_lang.performer import Performer
from lipsync_lang.pipeline.arrays import Floats
from lipsync_lang.schedules.schedule import Schedule


def keyframes(
    performer: Performer, schedule: Schedule, fps: float = 60, library: Library | None = None
) -> Animation:
    """Animate by one key per phoneme at its centre, straight lines between them.

    What most viseme tables do. A phoneme that moves has a key for each of its targets, evenly
    spread over its time. The targets are those the pose set's bigrams are drafted from.

    Returns
    -------
    An animation over the same frames as the performer's own
    """
    targets = (library or Library()).poseset(performer.compiled.poseset).model.targets
    ids, bounds, _ = performer.common_phonemes(schedule)
    times, keys = [], []
    for number, start, end in zip(ids, bounds, bounds[1:], strict=False):
        steps = targets.get(performer.compiled.phonemes[number], ())
        rows = [[step.weights.get(pose, 0.0) for pose in performer.poses] for step in steps]
        rows = rows or [[0.0] * len(performer.poses)]
        for step, row in enumerate(rows):
            times.append(start + (end - start) * (step + 0.5) / len(rows))
            keys.append(row)
    frames = performer.performance(schedule, fps).frames.times()
    weights = np.column_stack(
        [np.interp(frames, times, column) for column in zip(*keys, strict=True)]
    )
    return Animation(frames, performer.poses, weights, fps, schedule)


def read_out(animation: Animation, gains: dict[str, float]) -> Floats:
    """Return what a measure of a pose set shows over an animation: (T,) sum of gain x pose."""
    shown: Floats = np.sum([gain * animation[pose] for pose, gain in gains.items()], axis=0)
    return shown
