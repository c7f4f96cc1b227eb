"""Curves of a measure of a pose set, for benchmarks of motion."""

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Floats


def read_out(animation: Animation, gains: dict[str, float]) -> Floats:
    """Return a pose set's measure over an animation: (T,), the sum of gain x pose."""
    return np.sum([gain * animation[pose] for pose, gain in gains.items()], axis=0)
