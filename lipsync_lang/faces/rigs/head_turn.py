"""Turns of the head as engines take them, whatever their bone and the axes of their model.

Axes are those of a face: x to its left, y up, z to the front, right-handed as in glTF. A pose set
states which way its model looks, and the axes of its poses are converted (`Channel.head_axis`).
"""

from collections.abc import Sequence
from functools import reduce

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.transforms import product, turns

HEAD_ANGLES = ("HeadYaw", "HeadPitch", "HeadRoll")
"""Turns in radians: to its left, bent forward, and tilted to its right."""


class HeadTurn:
    """Composes the columns that turn the head, in their order, as a GLB does.

    Parameters
    ----------
    axes : (A, 3) axis of each of these columns
    columns : their numbers
    """

    def __init__(self, axes: Floats, columns: tuple[int, ...]) -> None:
        self.axes, self.columns = axes, columns

    @classmethod
    def of(cls, channels: Sequence[Channel]) -> "HeadTurn":
        """Return the turns among the channels of an animation or a stream."""
        found = {n: one.head_axis for n, one in enumerate(channels) if one.head_axis is not None}
        return cls(np.array([*found.values()], float).reshape(-1, 3), tuple(found))

    def __call__(self, weights: Floats) -> Floats:
        """Return the turns of (T, P) weights as quaternions x, y, z, w: (T, 4)."""
        moves = zip(self.axes, weights[:, [*self.columns]].T, strict=True)
        rest = np.tile([0.0, 0.0, 0.0, 1.0], (len(weights), 1))
        return reduce(product, (turns(axis, degrees) for axis, degrees in moves), rest)


def head_angles(turned: Floats) -> Floats:
    """Convert quaternions (T, 4) to `HEAD_ANGLES`: (T, 3).

    They turn about the vertical, then about the turned x, then about the turned z.
    """
    x, y, z, w = turned.T
    yaw = np.arctan2(2 * (w * y + x * z), 1 - 2 * (x * x + y * y))
    pitch = np.arcsin((2 * (w * x - y * z)).clip(-1, 1))
    roll = np.arctan2(2 * (w * z + x * y), 1 - 2 * (x * x + z * z))
    return np.column_stack([yaw, pitch, roll])
