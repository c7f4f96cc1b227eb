"""Transforms of nodes, and turns of the head as engines take them.

Quaternions are (T, 4) arrays of x, y, z, w, in glTF's order. Matrices are (4, 4). Their rows are
glTF's columns: the images of the three axes, then the origin. Axes of the head are those of a face:
x to its left, y up, z to the front, right-handed as in glTF. A pose set states which way its model
looks, and the axes of its poses are converted (`Channel.head_axis`).
"""

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.faces.rigs.channel import Channel

HEAD_ANGLES = ("HeadYaw", "HeadPitch", "HeadRoll")
"""Turns in radians: to its left, bent forward, and tilted to its right."""


def turns(axis: Floats, degrees: Floats) -> Floats:
    """Build rotation quaternions about an axis of non-zero length."""
    half = np.radians(degrees) / 2
    return np.column_stack([np.outer(np.sin(half), axis / np.linalg.norm(axis)), np.cos(half)])


def product(first: Floats, then: Floats) -> Floats:
    """Compose rotations: `first`, then `then` about the rotated axes."""
    (u, s), (v, t) = ((q[:, :3], q[:, 3:]) for q in (first, then))
    dot = np.sum(u * v, axis=1, keepdims=True)
    return np.hstack([s * v + t * u + np.cross(u, v), s * t - dot])


def parts(matrix: Floats) -> dict[str, Floats] | None:
    """Decompose a matrix into `translation`, `rotation` and `scale`; None for shear or scale 0."""
    axes = matrix[:3, :3]
    scale = np.linalg.norm(axes, axis=1)
    # A mirror is no rotation, so one scale becomes negative.
    scale[0] *= np.sign(np.linalg.det(axes))
    if not scale.all():
        return None
    axes = axes / scale[:, None]
    # Axes that are not at right angles are sheared.
    if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-4):
        return None
    return {"translation": matrix[3, :3], "rotation": quaternion(axes), "scale": scale}


def quaternion(axes: Floats) -> Floats:
    """Convert a rotation, (3, 3) with the images of the axes as rows, to a (4,) quaternion.

    The result is the eigenvector of the largest eigenvalue (Bar-Itzhack, 2000), a method that is
    stable for all angles.
    """
    x, y, z = axes
    table = [
        [x[0] - y[1] - z[2], x[1] + y[0], x[2] + z[0], y[2] - z[1]],
        [x[1] + y[0], y[1] - x[0] - z[2], y[2] + z[1], z[0] - x[2]],
        [x[2] + z[0], y[2] + z[1], z[2] - x[0] - y[1], x[1] - y[0]],
        [y[2] - z[1], z[0] - x[2], x[1] - y[0], x[0] + y[1] + z[2]],
    ]
    # `eigh` sorts eigenvalues upwards.
    return np.linalg.eigh(np.array(table)).eigenvectors[:, -1]


class HeadTurn(NamedTuple):
    """Composes the columns that turn the head, in their order, as a GLB does."""

    axes: Floats
    """(A, 3) axis of each of these columns."""
    columns: tuple[int, ...]
    """Their numbers."""

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
