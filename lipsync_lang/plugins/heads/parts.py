"""Heads made by a program: triangle meshes with shapes, moved and written as binary glTF.

Lengths in the file are metres, y points up and the face looks along +z; a part may be built in
other units and `transformed` last. Triangles run anticlockwise seen from outside. All parts are one
mesh in floats, so a point that two parts share is the same point in both.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.container import write_container

UINT8, UINT16, FLOAT32 = 5121, 5123, 5126
"""Component types of glTF."""

ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
"""Targets of buffer views."""

LARGEST_INDEX = 65534
"""Maximum number of points of a part; index 65535 would restart the primitive."""

STILL = 8e-5
"""Largest movement in metres that counts as none."""

SAME_NORMAL = 0.02
"""Largest change of a normal that counts as none, about a degree."""


@dataclass
class Part:
    """A triangle mesh of one material, with a displacement of its V points per shape."""

    name: str
    positions: Floats
    """(V, 3)"""
    triangles: Ints
    """(F, 3) point numbers."""
    color: tuple[float, float, float, float] = (0.8, 0.8, 0.8, 1.0)
    """Linear red, green, blue and alpha."""
    roughness: float = 0.7
    targets: dict[str, Floats] = field(default_factory=dict)
    """(V, 3) displacements by shape; a missing shape leaves the part unmoved."""
    colors: Floats | None = None
    """(V, 3) linear, multiplied with `color`."""
    normals: Floats | None = None
    """(V, 3); None: smooth over this part."""
    target_normals: dict[str, Floats] | None = None
    """(V, 3) normals of the moved points by shape, not differences."""
    double_sided: bool = False


# Colours and normals


def srgb(code: str) -> tuple[float, float, float, float]:
    """Convert a web colour such as "#e0a080" to linear red, green, blue and alpha."""
    value = np.array([int(code[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4)  # noqa: PLR2004 - the sRGB standard
    red, green, blue = (round(float(c), 5) for c in linear)
    return red, green, blue, 1.0


def smooth_normals(positions: Floats, triangles: Ints) -> Floats:
    """Compute a unit normal per point, (V, 3): the mean of its triangles' by their area."""
    a, b, c = (positions[triangles[:, i]] for i in range(3))
    # The length of a cross product is twice the area, so large triangles count more.
    face = np.cross(b - a, c - a)
    corners, count = triangles.T.ravel(), len(positions)
    tripled = np.concatenate([face] * 3)
    # `bincount` adds all corners of a point; `+=` with indices would keep the last.
    normals = np.stack([np.bincount(corners, tripled[:, i], count) for i in range(3)], 1)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(length > 0, normals / np.where(length > 0, length, 1), [0.0, 0.0, 1.0])


def with_normals(part: Part) -> Part:
    """Return the part with its normals, at rest and at each shape in full."""
    if part.normals is not None and part.target_normals is not None:
        return part
    moved = {
        name: smooth_normals(part.positions + shift, part.triangles)
        for name, shift in part.targets.items()
    }
    rest = smooth_normals(part.positions, part.triangles)
    return replace(part, normals=rest, target_normals=moved)


# Taking apart and moving


def take(part: Part, faces: Bools, name: str, **changes: Any) -> Part:
    """Return the marked triangles as a part of their own, shaded as if still joined to the rest."""
    part = with_normals(part)
    # The inverse is one row in numpy 1, and has other shapes in numpy 2.
    used, triangles = np.unique(part.triangles[faces], return_inverse=True)
    return replace(
        part,
        name=name,
        positions=part.positions[used],
        triangles=triangles.reshape(-1, 3),
        targets={key: value[used] for key, value in part.targets.items()},
        colors=None if part.colors is None else part.colors[used],
        normals=None if part.normals is None else part.normals[used],
        target_normals={key: value[used] for key, value in (part.target_normals or {}).items()},
        **changes,
    )


def transformed(
    part: Part,
    *,
    scale: float = 1.0,
    turn: Floats | None = None,
    move: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> Part:
    """Return the part scaled, then turned by a matrix, then moved; its shapes go along."""
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


def _normals(part: Part, target: str = "") -> Floats:
    """Return the normals of a part that has them, at rest or at a shape."""
    found = (part.target_normals or {}).get(target, part.normals)
    return np.zeros_like(part.positions) if found is None else found


# Binary glTF


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
        self.accessors: list[Json] = []
        self.zeros: dict[int, int] = {}

    def put(self, view: str, values: npt.NDArray[Any]) -> Json:
        """Add the values to a view; `finished` turns names of views to numbers."""
        data = self.views[view]
        start = len(data)
        data += values.tobytes()
        # Accessors begin at multiples of 4 bytes.
        data += bytes(-len(data) % 4)
        return {"bufferView": view, "byteOffset": start}

    def add(self, accessor: Json) -> int:
        self.accessors.append(accessor)
        return len(self.accessors) - 1

    def indices(self, triangles: Ints) -> int:
        place = self.put("triangles", triangles.astype("<u2").ravel())
        return self.add(
            {**place, "componentType": UINT16, "count": triangles.size, "type": "SCALAR"}
        )

    def vectors(self, values: Floats, *, bounds: bool = False) -> int:
        singles = values.astype("<f4")
        place = self.put("vertices", singles)
        return self.add({**place, **_vec3(singles, len(singles), bounds=bounds)})

    def tints(self, colors: Floats) -> int:
        rgba = np.full((len(colors), 4), 255, np.uint8)
        rgba[:, :3] = np.round(np.clip(colors, 0, 1) * 255)
        kind = {"componentType": UINT8, "normalized": True, "count": len(rgba), "type": "VEC4"}
        return self.add({**self.put("colors", rgba), **kind})

    def sparse(self, shifts: Floats, rows: Ints, *, bounds: bool) -> int:
        """Add zeros, except for some rows."""
        if not len(rows):
            return self.nothing(len(shifts))
        values = shifts[rows].astype("<f4")
        # The bounds of an accessor count its zeros, too.
        still = np.zeros((int(len(rows) < len(shifts)), 3), "<f4")
        kind = _vec3(np.concatenate([values, still]), len(shifts), bounds=bounds)
        sparse = {
            "count": len(rows),
            "indices": {**self.put("moved", rows.astype("<u2")), "componentType": UINT16},
            "values": self.put("shifts", values),
        }
        return self.add({**kind, "sparse": sparse})

    def nothing(self, count: int) -> int:
        """Add zeros, which need no bytes."""
        if count not in self.zeros:
            self.zeros[count] = self.add(_vec3(np.zeros((1, 3), "<f4"), count, bounds=True))
        return self.zeros[count]

    def finished(self) -> tuple[list[Json], bytes]:
        """Return the buffer views and the bytes."""
        views: list[Json] = []
        numbers, data = {}, b""
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


def _vec3(values: npt.NDArray[Any], count: int, *, bounds: bool) -> Json:
    accessor: Json = {"componentType": FLOAT32, "count": count, "type": "VEC3"}
    if bounds:
        # The shortest decimals that are these numbers in single precision
        accessor["min"] = [float(str(v)) for v in values.min(0)]
        accessor["max"] = [float(str(v)) for v in values.max(0)]
    return accessor


def _primitive(buffer: _Buffer, part: Part, targets: Sequence[str]) -> Json:
    """Add one part, with every shape in the given order."""
    part = with_normals(part)
    if len(part.positions) > LARGEST_INDEX:
        raise ValueError(f"part {part.name!r} has {len(part.positions)} points: too many")
    attributes = {
        "POSITION": buffer.vectors(part.positions, bounds=True),
        "NORMAL": buffer.vectors(_normals(part)),
    }
    if part.colors is not None:
        attributes["COLOR_0"] = buffer.tints(part.colors)
    return {
        "attributes": attributes,
        "indices": buffer.indices(part.triangles),
        "targets": [_target(buffer, part, name) for name in targets],
    }


def _target(buffer: _Buffer, part: Part, name: str) -> dict[str, int]:
    """Add one shape of a part: only the points that move or turn are kept."""
    shift, turn, moved, turned = moved_rows(part, name)
    return {
        "POSITION": buffer.sparse(shift, moved, bounds=True),
        "NORMAL": buffer.sparse(turn, turned, bounds=False),
    }


def moved_rows(part: Part, name: str) -> tuple[Floats, Floats, Ints, Ints]:
    """Return a shape's displacements and changes of normals, and the points that have either."""
    shift = part.targets.get(name, np.zeros_like(part.positions))
    turn = _normals(part, name) - _normals(part)
    moved = np.flatnonzero(np.linalg.norm(shift, axis=1) > STILL)
    # Without movement, normals differ by rounding alone.
    turned = np.flatnonzero((np.linalg.norm(turn, axis=1) > SAME_NORMAL) & bool(len(moved)))
    return shift, turn, moved, turned


def _material(part: Part) -> Json:
    surface = {
        "baseColorFactor": [float(c) for c in part.color],
        "metallicFactor": 0.0,
        "roughnessFactor": float(part.roughness),
    }
    sides = {"doubleSided": True} if part.double_sided else {}
    return {"name": part.name, "pbrMetallicRoughness": surface, **sides}


def write_glb(
    out: BinaryIO,
    parts: Sequence[Part],
    targets: Sequence[str],
    node: Json,
    origin: Mapping[str, Any],
) -> None:
    """Write the parts as one mesh with the named shapes, the same bytes each time.

    Parameters
    ----------
    targets : all shapes, in their order
    node : the node of the mesh: its `name`, and its `translation` if any
    origin : `generator`, `copyright` and `extras` of the file
    """
    unknown = {key for part in parts for key in part.targets} - set(targets)
    if unknown:
        raise ValueError(f"parts move in shapes that are not listed: {', '.join(sorted(unknown))}")
    buffer = _Buffer()
    primitives = [
        {**_primitive(buffer, part, targets), "material": number}
        for number, part in enumerate(parts)
    ]
    views, data = buffer.finished()
    document = {
        "asset": {"version": "2.0", **origin},
        "scene": 0,
        "scenes": [{"name": node["name"], "nodes": [0]}],
        "nodes": [{**node, "mesh": 0}],
        "meshes": [
            {
                "name": node["name"],
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
    text = json.dumps(document, separators=(",", ":")).encode()
    write_container(out, text, [data])
