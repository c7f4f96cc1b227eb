"""Small tools for character heads made by a script: shapes, morph targets, binary glTF.

A character is a list of `Part`s, which `merged` joins and `write_head` writes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from lipsync_lang.plugins.heads.parts import (  # for the scripts too
    STILL,
    Part,
    srgb,
    take,
    transformed,
    with_normals,
    write_glb,
)

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from numpy.typing import ArrayLike, NDArray

    Points = NDArray[np.float64]
    Faces = NDArray[np.int64]
    Shape = tuple[Points, Faces]

__all__ = ["Part", "merged", "srgb", "take", "transformed", "with_normals"]

COPYRIGHT = "The lipsync_lang authors, Apache-2.0"

# --- numbers


def smoothstep(low: float, high: float, x: ArrayLike) -> Points:
    """0 below `low`, 1 above `high`, an S curve between. With low > high it falls instead."""
    t = np.clip((np.asarray(x, float) - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def bump(x: ArrayLike, centre: float, width: float) -> Points:
    """A bell of height 1 at `centre` that reaches 0 at `width` on both sides."""
    return smoothstep(width, 0.0, np.abs(np.asarray(x, float) - centre))


def catmull_rom(points: ArrayLike, count: int) -> Points:
    """`count` points on a smooth curve through `points` (N, D), evenly spread over its knots."""
    p = np.asarray(points, float)
    p = p.reshape(len(p), -1)
    p = np.concatenate([2 * p[:1] - p[1:2], p, 2 * p[-1:] - p[-2:-1]])
    at = np.linspace(0.0, len(p) - 3.0, count)
    i = np.minimum(at.astype(int), len(p) - 4)
    t = (at - i)[:, None]
    a, b, c, d = p[i], p[i + 1], p[i + 2], p[i + 3]
    return 0.5 * (
        2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3
    )


def rotation(axis: ArrayLike, radians: float) -> Points:
    """The matrix (3, 3) that turns a column vector about `axis` by the right-hand rule."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(radians) * cross + (1 - np.cos(radians)) * (cross @ cross)


# --- shapes: each returns positions (V, 3) and triangles (F, 3)


def grid_faces(rows: int, columns: int, *, wrap: bool = False) -> Faces:
    """The triangles of a grid of vertices numbered row by row; `wrap` joins last column to first.

    They face the side from which columns run to the right and rows run up.
    """
    across = columns if wrap else columns - 1
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(across), indexing="ij")
    a, b = (i * columns + j).ravel(), (i * columns + (j + 1) % columns).ravel()
    c, d = a + columns, b + columns
    return np.stack([a, b, d, a, d, c], 1).reshape(-1, 3)


def patch(points: Points, *, wrap: bool = False) -> Shape:
    """A sheet over a grid of points (R, C, 3)."""
    rows, columns = points.shape[:2]
    return points.reshape(-1, 3), grid_faces(rows, columns, wrap=wrap)


def loft(rings: Points, *, cap_start: bool = True, cap_end: bool = True) -> Shape:
    """A skin over closed rings (R, S, 3), each running anticlockwise seen from the end.

    Each cap is a fan to the middle of its ring.
    """
    rows, columns = rings.shape[:2]
    positions, triangles = patch(rings, wrap=True)
    j = np.arange(columns)
    nxt = (j + 1) % columns
    if cap_start:
        fan = np.stack([nxt, j, np.full(columns, len(positions))], 1)
        triangles = np.concatenate([triangles, fan])
        positions = np.concatenate([positions, rings[:1].mean(1)])
    if cap_end:
        last = (rows - 1) * columns
        fan = np.stack([last + j, last + nxt, np.full(columns, len(positions))], 1)
        triangles = np.concatenate([triangles, fan])
        positions = np.concatenate([positions, rings[-1:].mean(1)])
    return positions, triangles


def superellipse(segments: int, exponent: float = 2.0) -> Points:
    """A closed outline (S, 2) of radius 1: 2 is a circle, above it squarer, below it pointed."""
    t = np.arange(segments) * 2 * np.pi / segments
    xy = np.stack([np.cos(t), np.sin(t)], 1)
    return np.sign(xy) * np.abs(xy) ** (2.0 / exponent)


def tube(  # noqa: PLR0913 - a shape has many measures
    path: ArrayLike,
    radii: ArrayLike,
    segments: int = 12,
    *,
    exponent: float = 2.0,
    side: ArrayLike = (1.0, 0.0, 0.0),
    caps: bool = True,
) -> Shape:
    """A tube along `path` (R, 3), with `radii` (R,) or (R, 2): towards `side`, and across it.

    `side` is one direction, or one for each point of the path.
    """
    path = np.asarray(path, float)
    radii = np.asarray(radii, float)
    radii = np.stack([radii, radii], 1) if radii.ndim == 1 else radii
    ahead = np.gradient(path, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    over = np.cross(ahead, np.broadcast_to(np.asarray(side, float), path.shape))
    over /= np.linalg.norm(over, axis=1, keepdims=True)
    right = np.cross(over, ahead)
    outline = superellipse(segments, exponent)
    rings = (
        path[:, None]
        + right[:, None] * (outline[None, :, :1] * radii[:, None, :1])
        + over[:, None] * (outline[None, :, 1:] * radii[:, None, 1:])
    )
    return loft(rings, cap_start=caps, cap_end=caps)


def ellipsoid(
    centre: ArrayLike, radii: ArrayLike, rings: int = 12, segments: int = 16, *, exponent: float = 2
) -> Shape:
    """An ellipsoid with poles along z, `exponent` as in `superellipse` for its outline there."""
    angle = np.pi * np.arange(1, rings) / rings
    outline = superellipse(segments, exponent)
    points = np.empty((rings - 1, segments, 3))
    points[..., :2] = outline[None] * np.sin(angle)[:, None, None]
    points[..., 2] = -np.cos(angle)[:, None]
    positions, triangles = loft(points)
    positions[-2:] = [[0, 0, -1], [0, 0, 1]]
    return positions * np.asarray(radii, float) + np.asarray(centre, float), triangles


def revolved(profile: ArrayLike, segments: int = 24, *, exponent: float = 2.0) -> Shape:
    """A surface turned about the y axis: `profile` (R, 2) holds radius and height, upwards.

    A radius of 0 at either end closes the surface there.
    """
    profile = np.asarray(profile, float)
    closed_start, closed_end = (abs(profile[end, 0]) < STILL for end in (0, -1))
    body = profile[int(closed_start) : len(profile) - int(closed_end)]
    outline = superellipse(segments, exponent)
    rings = np.empty((len(body), segments, 3))
    rings[..., 0] = body[:, :1] * outline[:, 0]
    rings[..., 2] = -body[:, :1] * outline[:, 1]
    rings[..., 1] = body[:, 1:]
    positions, triangles = loft(rings, cap_start=bool(closed_start), cap_end=bool(closed_end))
    if closed_start:
        positions[len(body) * segments, 1] = profile[0, 1]
    if closed_end:
        positions[-1, 1] = profile[-1, 1]
    return positions, triangles


# --- work on parts


def merged(parts: Sequence[Part], name: str) -> Part:
    """Join parts, each shaded by itself, with the material of the first."""
    parts = [with_normals(part) for part in parts]
    starts = np.cumsum([0] + [len(part.positions) for part in parts])
    targets = list(dict.fromkeys(key for part in parts for key in part.targets))
    colors = [np.ones((len(p.positions), 3)) if p.colors is None else p.colors for p in parts]
    return replace(
        parts[0],
        name=name,
        positions=np.concatenate([part.positions for part in parts]),
        triangles=np.concatenate(
            [part.triangles + start for part, start in zip(parts, starts, strict=False)]
        ),
        targets={
            key: np.concatenate([p.targets.get(key, np.zeros_like(p.positions)) for p in parts])
            for key in targets
        },
        colors=np.concatenate(colors) if any(p.colors is not None for p in parts) else None,
        normals=np.concatenate([part.normals for part in parts]),
        target_normals={
            key: np.concatenate([p.target_normals.get(key, p.normals) for p in parts])
            for key in targets
        },
    )


def mirrored(part: Part, name: str) -> Part:
    """The same part on the other side of the plane x = 0."""
    flip = np.array([-1.0, 1.0, 1.0])
    turned = transformed(part, turn=np.diag(flip))
    return replace(turned, name=name, triangles=part.triangles[:, ::-1].copy())


def write_head(path: Path, parts: Sequence[Part], targets: Sequence[str], name: str) -> None:
    """Write the parts of a head of this project as one file, the same bytes each time."""
    origin = {"generator": "docs/models/mesh.py", "copyright": COPYRIGHT}
    with path.open("wb") as out:
        write_glb(out, parts, targets, {"name": name}, origin)
