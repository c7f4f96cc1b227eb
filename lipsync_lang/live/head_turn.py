"""Turns of the head as engines take them.

Axes are those of a face: x to its left, y up, z to the front, right-handed as in glTF. The face of
a model may look the other way, as in VRM 0; the pose set states it, and its axes are converted.
"""

from functools import reduce
from math import asin, atan2
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lipsync_lang.arrays import Floats
from lipsync_lang.rigs.transforms import product, turns

if TYPE_CHECKING:
    from lipsync_lang.performing.performer import Performer

HEAD_REGION = "head"
"""Region whose poses turn the head."""

HALF_TURN = (-1.0, 1.0, -1.0)
"""Signs of axes seen from the other side."""

NO_TURN = np.array([[0.0, 0.0, 0.0, 1.0]])
"""No turn, as a quaternion."""


class HeadAngles(NamedTuple):
    """Turns in radians: about the vertical, then about the turned x, then about the turned z."""

    yaw: float
    """To its left."""
    pitch: float
    """Bent forward."""
    roll: float
    """Tilted to its right."""


class HeadTurn:
    """Composes the poses that turn the head, in their order, as a GLB does.

    Parameters
    ----------
    axes : (A, 3) axis of each of these poses
    columns : their columns in a frame
    """

    def __init__(self, axes: Floats, columns: tuple[int, ...]) -> None:
        self.axes, self.columns = axes, columns

    @classmethod
    def of(cls, performer: "Performer", first: int) -> "HeadTurn":
        """Return the turns of a performer's gestures, whose columns begin at `first`."""
        made = performer.compiled.gestures
        found = {
            column: pose["channel"]["rotation"]
            for column, pose in enumerate(made["poses"], first)
            if pose["region"] == HEAD_REGION and pose["channel"]["rotation"] is not None
        }
        axes = np.array([*found.values()], float).reshape(-1, 3)
        return cls(axes if made["front"] == "z" else axes * HALF_TURN, tuple(found))

    def __call__(self, weights: Floats) -> Floats:
        """Return the turn of a frame's (P,) weights as a quaternion x, y, z, w: (4,)."""
        moves = zip(self.axes, weights[[*self.columns]], strict=True)
        turned = reduce(product, (turns(axis, np.array([by])) for axis, by in moves), NO_TURN)
        out: Floats = turned[0]
        return out


def head_angles(turn: Floats) -> HeadAngles:
    """Convert a quaternion (4,) to angles."""
    x, y, z, w = turn.tolist()
    return HeadAngles(
        atan2(2 * (w * y + x * z), 1 - 2 * (x * x + y * y)),
        asin(min(max(2 * (w * x - y * z), -1.0), 1.0)),
        atan2(2 * (w * z + x * y), 1 - 2 * (x * x + z * z)),
    )
