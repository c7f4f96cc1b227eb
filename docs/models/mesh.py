"""Small tools for character heads made by a script: shapes, morph targets, binary glTF.

A character is a list of `Part`s. Each part is a triangle mesh with one material and any number of
named morph targets; `write_glb` writes them as one glTF mesh. Lengths in the file are metres, y
points up and the face looks along +z; a part may be built in other units and `transformed` last.
Triangles run anticlockwise seen from outside.
"""

# ruff: noqa: INP001 - beside a script, not in a package

from __future__ import annotations

import json
import struct
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import ArrayLike, NDArray

    Points = NDArray[np.float64]
    Faces = NDArray[np.int64]
    Shape = tuple[Points, Faces]

# numbers the glTF standard gives to types
UINT8, UINT16, FLOAT32 = 5121, 5123, 5126
ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
LARGEST_INDEX = 65534  # 65535 would restart the primitive

STILL = 8e-5  # metres: less movement than this is none
SAME_NORMAL = 0.02  # and so is a turn of about a degree


@dataclass
class Part:
    """A triangle mesh of one material, with a displacement of its vertices per morph target."""

    name: str
    positions: Points  # (V, 3)
    triangles: Faces  # (F, 3)
    color: tuple[float, float, float, float] = (0.8, 0.8, 0.8, 1.0)  # linear RGBA
    roughness: float = 0.7
    targets: dict[str, Points] = field(default_factory=dict)  # (V, 3) each; missing: unmoved
    colors: Points | None = None  # (V, 3) linear, multiply `color`
    normals: Points | None = None  # (V, 3); None: smooth over this part
    target_normals: dict[str, Points] | None = None  # of the moved vertices, not differences
    double_sided: bool = False


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


def srgb(code: str) -> tuple[float, float, float, float]:
    """The linear RGBA of a web colour such as "#e0a080"."""
    value = np.array([int(code[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)  # noqa: PLR2004 - the sRGB standard
    red, green, blue = (round(float(c), 5) for c in linear)
    return red, green, blue, 1.0


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


def smooth_normals(positions: Points, triangles: Faces) -> Points:
    """A unit normal per vertex, the mean of its triangles' by their area."""
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    face = np.cross(b - a, c - a)
    normals = np.zeros_like(positions)
    for i in range(3):
        np.add.at(normals, triangles[:, i], face)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(length > 0, normals / np.where(length > 0, length, 1), [0.0, 0.0, 1.0])


def with_normals(part: Part) -> Part:
    """The part with its normals worked out, at rest and at each target in full."""
    if part.normals is not None and part.target_normals is not None:
        return part
    moved = {
        name: smooth_normals(part.positions + shift, part.triangles)
        for name, shift in part.targets.items()
    }
    rest = smooth_normals(part.positions, part.triangles)
    return replace(part, normals=rest, target_normals=moved)


def take(part: Part, faces: NDArray[np.bool_], name: str, **changes: Any) -> Part:
    """The marked triangles as a part of their own, shaded as if still joined to the rest."""
    part = with_normals(part)
    used, triangles = np.unique(part.triangles[faces], return_inverse=True)
    return replace(
        part,
        name=name,
        positions=part.positions[used],
        triangles=triangles.reshape(-1, 3),
        targets={key: value[used] for key, value in part.targets.items()},
        colors=None if part.colors is None else part.colors[used],
        normals=part.normals[used],
        target_normals={key: value[used] for key, value in part.target_normals.items()},
        **changes,
    )


def transformed(
    part: Part,
    *,
    scale: float = 1.0,
    turn: Points | None = None,
    move: ArrayLike = (0.0, 0.0, 0.0),
) -> Part:
    """The part scaled, then turned by a matrix, then moved; its targets go along."""
    matrix = np.eye(3) if turn is None else turn
    return replace(
        part,
        positions=part.positions @ matrix.T * scale + np.asarray(move, float),
        targets={key: value @ matrix.T * scale for key, value in part.targets.items()},
        normals=None if part.normals is None else part.normals @ matrix.T,
        target_normals=None
        if part.target_normals is None
        else {key: value @ matrix.T for key, value in part.target_normals.items()},
    )


def mirrored(part: Part, name: str) -> Part:
    """The same part on the other side of the plane x = 0."""
    flip = np.array([-1.0, 1.0, 1.0])
    turned = transformed(part, turn=np.diag(flip))
    return replace(turned, name=name, triangles=part.triangles[:, ::-1].copy())


def merged(parts: Sequence[Part], name: str) -> Part:
    """Parts of one material as one part, each shaded by itself. The first gives the material."""
    parts = [with_normals(part) for part in parts]
    starts = np.cumsum([0] + [len(part.positions) for part in parts])
    targets = list(dict.fromkeys(key for part in parts for key in part.targets))
    tinted = any(part.colors is not None for part in parts)
    return replace(
        parts[0],
        name=name,
        positions=np.concatenate([part.positions for part in parts]),
        triangles=np.concatenate(
            [part.triangles + start for part, start in zip(parts, starts, strict=False)]
        ),
        targets={key: np.concatenate([_shift(part, key) for part in parts]) for key in targets},
        colors=np.concatenate([_tint(part) for part in parts]) if tinted else None,
        normals=np.concatenate([part.normals for part in parts]),
        target_normals={
            key: np.concatenate([part.target_normals.get(key, part.normals) for part in parts])
            for key in targets
        },
    )


def _shift(part: Part, target: str) -> Points:
    return part.targets.get(target, np.zeros_like(part.positions))


def _tint(part: Part) -> Points:
    return np.ones_like(part.positions) if part.colors is None else part.colors


# --- binary glTF


class _Buffer:
    """The binary chunk: five views that grow side by side, and the accessors into them."""

    LAYOUT: Mapping[str, dict[str, int]] = {
        "triangles": {"target": ELEMENT_ARRAY_BUFFER},
        "vertices": {"target": ARRAY_BUFFER, "byteStride": 12},
        "colors": {"target": ARRAY_BUFFER, "byteStride": 4},
        "moved": {},
        "shifts": {},
    }

    def __init__(self) -> None:
        self.views: dict[str, bytearray] = {name: bytearray() for name in self.LAYOUT}
        self.accessors: list[dict[str, Any]] = []
        self.zeros: dict[int, int] = {}

    def put(self, view: str, values: NDArray[Any]) -> dict[str, Any]:
        """Add the values to a view; where they are. `finished` turns names of views to numbers."""
        data = self.views[view]
        start = len(data)
        data += values.tobytes()
        data += bytes(-len(data) % 4)
        return {"bufferView": view, "byteOffset": start}

    def add(self, accessor: dict[str, Any]) -> int:
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def indices(self, triangles: Faces) -> int:
        place = self.put("triangles", triangles.astype("<u2").ravel())
        return self.add(
            {**place, "componentType": UINT16, "count": triangles.size, "type": "SCALAR"}
        )

    def vectors(self, values: Points, *, bounds: bool = False) -> int:
        values = values.astype("<f4")
        place = self.put("vertices", values)
        return self.add({**place, **_vec3(values, len(values), bounds=bounds)})

    def tints(self, colors: Points) -> int:
        rgba = np.full((len(colors), 4), 255, np.uint8)
        rgba[:, :3] = np.round(np.clip(colors, 0, 1) * 255)
        kind = {"componentType": UINT8, "normalized": True, "count": len(rgba), "type": "VEC4"}
        return self.add({**self.put("colors", rgba), **kind})

    def sparse(self, shifts: Points, rows: Faces, *, bounds: bool) -> int:
        """Zeros, except for some rows."""
        if not len(rows):
            return self.nothing(len(shifts))
        values = shifts[rows].astype("<f4")
        still = np.zeros((int(len(rows) < len(shifts)), 3), "<f4")
        kind = _vec3(np.concatenate([values, still]), len(shifts), bounds=bounds)
        sparse = {
            "count": len(rows),
            "indices": {**self.put("moved", rows.astype("<u2")), "componentType": UINT16},
            "values": self.put("shifts", values),
        }
        return self.add({**kind, "sparse": sparse})

    def nothing(self, count: int) -> int:
        """An accessor of zeros: it needs no bytes."""
        if count not in self.zeros:
            self.zeros[count] = self.add(_vec3(np.zeros((1, 3), "<f4"), count, bounds=True))
        return self.zeros[count]

    def finished(self) -> tuple[list[dict[str, Any]], bytes]:
        """The buffer views and the bytes."""
        views, numbers, data = [], {}, b""
        for name, content in self.views.items():
            if content:
                numbers[name] = len(views)
                size = {"byteOffset": len(data), "byteLength": len(content)}
                views.append({"buffer": 0, **size, **self.LAYOUT[name]})
                data += bytes(content)
        for accessor in self.accessors:
            sparse = accessor.get("sparse", {})
            for place in (accessor, sparse.get("indices", {}), sparse.get("values", {})):
                if "bufferView" in place:
                    place["bufferView"] = numbers[place["bufferView"]]
        return views, data


def _vec3(values: Points, count: int, *, bounds: bool) -> dict[str, Any]:
    accessor: dict[str, Any] = {"componentType": FLOAT32, "count": count, "type": "VEC3"}
    if bounds:
        # the shortest decimals that are these numbers in single precision
        accessor["min"] = [float(str(v)) for v in values.min(0)]
        accessor["max"] = [float(str(v)) for v in values.max(0)]
    return accessor


def _primitive(buffer: _Buffer, part: Part, targets: Sequence[str]) -> dict[str, Any]:
    """One part, with every target in the given order."""
    part = with_normals(part)
    if len(part.positions) > LARGEST_INDEX:
        raise ValueError(f"part {part.name!r} has {len(part.positions)} vertices: too many")
    attributes = {
        "POSITION": buffer.vectors(part.positions, bounds=True),
        "NORMAL": buffer.vectors(part.normals),
    }
    if part.colors is not None:
        attributes["COLOR_0"] = buffer.tints(part.colors)
    return {
        "attributes": attributes,
        "indices": buffer.indices(part.triangles),
        "targets": [_target(buffer, part, name) for name in targets],
    }


def _target(buffer: _Buffer, part: Part, name: str) -> dict[str, int]:
    """One target of a part: only the vertices that move or turn are kept."""
    shift = _shift(part, name)
    turn = part.target_normals.get(name, part.normals) - part.normals
    moved = np.flatnonzero(np.linalg.norm(shift, axis=1) > STILL)
    turned = np.flatnonzero((np.linalg.norm(turn, axis=1) > SAME_NORMAL) & bool(len(moved)))
    return {
        "POSITION": buffer.sparse(shift, moved, bounds=True),
        "NORMAL": buffer.sparse(turn, turned, bounds=False),
    }


def _material(part: Part) -> dict[str, Any]:
    surface = {
        "baseColorFactor": [float(c) for c in part.color],
        "metallicFactor": 0.0,
        "roughnessFactor": float(part.roughness),
    }
    sides = {"doubleSided": True} if part.double_sided else {}
    return {"name": part.name, "pbrMetallicRoughness": surface, **sides}


def write_glb(
    path: Path,
    parts: Sequence[Part],
    targets: Sequence[str],
    name: str,
    copyright: str,  # noqa: A002 - as glTF calls it
) -> None:
    """Write the parts as one glTF mesh with the named morph targets, the same bytes each time."""
    unknown = {key for part in parts for key in part.targets} - set(targets)
    if unknown:
        raise ValueError(f"parts move in targets that are not listed: {', '.join(sorted(unknown))}")
    buffer = _Buffer()
    primitives = [
        {**_primitive(buffer, part, targets), "material": number}
        for number, part in enumerate(parts)
    ]
    views, data = buffer.finished()
    document = {
        "asset": {"version": "2.0", "generator": "docs/models/mesh.py", "copyright": copyright},
        "scene": 0,
        "scenes": [{"name": name, "nodes": [0]}],
        "nodes": [{"name": name, "mesh": 0}],
        "meshes": [
            {
                "name": name,
                "primitives": primitives,
                "weights": [0.0] * len(targets),
                "extras": {"targetNames": list(targets)},
            }
        ],
        "materials": [_material(part) for part in parts],
        "accessors": buffer.accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    path.write_bytes(_container(document, data))


def _container(document: dict[str, Any], data: bytes) -> bytes:
    """The JSON and the binary chunk in one file."""
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + len(data)
    head = struct.pack("<4sII", b"glTF", 2, size)
    return b"".join(
        [
            head,
            struct.pack("<I4s", len(text), b"JSON"),
            text,
            struct.pack("<I4s", len(data), b"BIN\0"),
            data,
        ]
    )
