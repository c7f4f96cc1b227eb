"""Turning nodes: quaternions are (T, 4) arrays of x, y, z, w, as glTF has them.

A matrix is (4, 4), and its rows are glTF's columns: where the three axes go, then the origin.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


class Parts(NamedTuple):
    """What a matrix is made of: it scales, then turns, then moves."""

    translation: Floats
    rotation: Floats
    scale: Floats


def turns(axis: Floats, degrees: Floats) -> Floats:
    """Return quaternions that turn about an axis, which has some length."""
    half = np.radians(degrees) / 2
    return np.column_stack([np.outer(np.sin(half), axis / np.linalg.norm(axis)), np.cos(half)])


def product(first: Floats, then: Floats) -> Floats:
    """Return the quaternions that turn by `then` about the axes as `first` has turned them."""
    (u, s), (v, t) = ((q[:, :3], q[:, 3:]) for q in (first, then))
    dot = np.sum(u * v, axis=1, keepdims=True)
    return np.hstack([s * v + t * u + np.cross(u, v), s * t - dot])


def parts(matrix: Floats) -> Parts | None:
    """Part a matrix; None where it shears or flattens, which no parts can."""
    axes = matrix[:3, :3]
    scale = np.linalg.norm(axes, axis=1)
    scale[0] *= np.sign(np.linalg.det(axes))
    if not scale.all():
        return None
    axes = axes / scale[:, None]
    if not np.allclose(axes @ axes.T, np.eye(3), atol=1e-4):
        return None
    return Parts(matrix[3, :3], quaternion(axes), scale)


def quaternion(axes: Floats) -> Floats:
    """Return the (4,) quaternion of a rotation; the (3, 3) rows are where the axes go.

    It is the eigenvector of the largest eigenvalue (Bar-Itzhack, 2000), which no angle troubles.
    """
    x, y, z = axes
    table = [
        [x[0] - y[1] - z[2], x[1] + y[0], x[2] + z[0], y[2] - z[1]],
        [x[1] + y[0], y[1] - x[0] - z[2], y[2] + z[1], z[0] - x[2]],
        [x[2] + z[0], y[2] + z[1], z[2] - x[0] - y[1], x[1] - y[0]],
        [y[2] - z[1], z[0] - x[2], x[1] - y[0], x[0] + y[1] + z[2]],
    ]
    found: Floats = np.linalg.eigh(np.array(table)).eigenvectors[:, -1]
    return found
