"""Node transforms. Quaternions are (T, 4) arrays of x, y, z, w, in glTF's order.

Matrices are (4, 4). Their rows are glTF's columns: the images of the three axes, then the origin.
"""

import numpy as np

from lipsync_lang.base.arrays import Floats


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
    scale[0] *= np.sign(np.linalg.det(axes))
    if not scale.all():
        return None
    axes = axes / scale[:, None]
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
    return np.linalg.eigh(np.array(table)).eigenvectors[:, -1]
