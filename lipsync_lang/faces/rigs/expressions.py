"""Expressions of a VRM avatar: named mouths and faces, each of several shapes with their weights.

VRM 1.0 keeps them in the extension VRMC_vrm, VRM 0 in VRM (github.com/vrm-c/vrm-specification).
What a player moves are expressions; shapes have whatever names their author gave them.
"""

from collections.abc import Iterator, Sequence
from math import isfinite
from typing import Any, NamedTuple

from lipsync_lang.base.json_object import Json

FULL_PERCENT = 100.0
"""Weight of a whole shape in VRM 0, which counts per cent."""

NO_PRESET = "unknown"
"""Preset of VRM 0 for an expression that has only a name."""


class Bind(NamedTuple):
    """A shape that an expression moves, with its weight at full expression."""

    expression: str
    mesh: int
    target: int
    weight: float


def binds(document: Json) -> Iterator[Bind]:
    """Yield the binds of all expressions of a model; what is malformed moves nothing in players."""
    nodes = _rows(document.get("nodes"))
    for name, stated in _expressions(document).items():
        for bind in _rows(stated.get("morphTargetBinds")):
            node = bind.get("node")
            at = nodes[node] if isinstance(node, int) and 0 <= node < len(nodes) else {}
            yield from _bind(name, at.get("mesh"), bind, 1.0)
    known = _object(_object(document.get("extensions")).get("VRM"))
    for group in _rows(_object(known.get("blendShapeMaster")).get("blendShapeGroups")):
        preset = str(group.get("presetName", NO_PRESET)).lower()
        name = str(group.get("name", "")) if preset == NO_PRESET else preset
        # VRM 0 binds shapes of meshes, VRM 1.0 those of nodes.
        for bind in _rows(group.get("binds")):
            yield from _bind(name, bind.get("mesh"), bind, FULL_PERCENT)


def stating(document: Json, field: str, values: Sequence[object]) -> frozenset[str]:
    """Return the expressions of VRM 1.0 whose field has one of the values."""
    stated = _expressions(document).items()
    return frozenset(name for name, one in stated if one.get(field) in values)


def _expressions(document: Json) -> dict[str, Json]:
    """Return the expressions of VRM 1.0 by name; a preset wins."""
    stated = _object(
        _object(_object(document.get("extensions")).get("VRMC_vrm")).get("expressions")
    )
    kinds = (_object(stated.get(kind)) for kind in ("custom", "preset"))
    return {name: _object(one) for kind in kinds for name, one in kind.items()}


def _bind(name: str, mesh: object, bind: Json, full: float) -> Iterator[Bind]:
    index, weight = bind.get("index"), bind.get("weight", full)
    if isinstance(mesh, int) and isinstance(index, int) and isinstance(weight, (int, float)):
        share = weight / full
        if name and isfinite(share) and share > 0:
            yield Bind(name, mesh, index, min(share, 1.0))


def _object(value: Any) -> Json:
    return value if isinstance(value, dict) else {}


def _rows(value: Any) -> list[Json]:
    return [one for one in value if isinstance(one, dict)] if isinstance(value, list) else []
