"""Model of a page: geometry, shapes, bones and surfaces, as `gl_face.js` draws them.

The scene is that of the pictures (`render.model`), so that a page shows the face of a video. It is
read from a sweep, which moves one channel after the other, and does not depend on the line.

Conventions: V points, C channels (columns of the animation); matrices act on rows.
"""

from collections.abc import Hashable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import ModelError, OutputError
from lipsync_lang.base.grouping import grouped
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.model import movable_nodes
from lipsync_lang.faces.rigs.placing import NODE_REST, local
from lipsync_lang.render.model import light
from lipsync_lang.render.model.camera import FIELD_DEGREES, Camera, close_up, framed
from lipsync_lang.render.model.picture import BEHIND
from lipsync_lang.render.model.scene import Primitive, Scene
from lipsync_lang.render.staging import staged, sweep
from lipsync_lang.studio.array_pack import ArrayPack

SHORT = 32767
"""Number of steps of a coordinate on each side of the middle of its mesh."""

MIN_MOVEMENT_SHARE = 1e-5
"""Minimum movement of a point in a shape, as a share of the size of the mesh."""

SMALL_MODEL = 2**16
"""Maximum number of points for point numbers of two bytes."""

CLEAR = 1e-3
"""Minimum visible opacity of a material."""

MAX_IMAGE_BYTES = 4 * 2**20
"""Size limit in bytes of a texture; larger ones make a page too slow to send."""

BEYOND = {
    "normalTexture": "normal maps",
    "occlusionTexture": "occlusion maps",
    "emissiveTexture": "glowing textures",
}
"""Properties of a material that are not drawn."""


def face_data(animation: Animation, pack: ArrayPack) -> Json:
    """Return the model of an animation as JSON data, with its arrays in a pack.

    `unshown` lists the parts of the model that the page cannot show; it is the only field if the
    model cannot be drawn.
    """
    if animation.model is None:
        return {"unshown": []}
    scene = page_scene(animation)
    if isinstance(scene, str):  # nobody's folders are sent
        return {"unshown": [scene.replace(str(animation.model), animation.model.name)]}
    try:
        with np.errstate(over="raise", invalid="raise"):
            return _face(animation, scene, pack)
    except FloatingPointError:
        return {"unshown": [f"{animation.model.name}: a point moves too far to be drawn"]}


def packed_face(animation: Animation) -> tuple[Json, ArrayPack]:
    """Return the model of an animation, and a new pack that begins with its arrays.

    The pages of a report share both until the scene is another.
    """
    key = animation.columns, page_scene(animation) if animation.model else None
    if key not in _PACKED:
        _PACKED.clear()
        pack = ArrayPack()
        _PACKED[key] = face_data(animation, pack), pack
    face, pack = _PACKED[key]
    return face, pack.copy()


_PACKED: dict[Hashable, tuple[Json, ArrayPack]] = {}


def page_scene(animation: Animation) -> Scene | str:
    """Return the scene of a page, or the reason why its model cannot be drawn.

    The pages of a report, and the warnings about a page, share the scene of their model.
    """
    model, swept = animation.model, sweep(animation)
    # bones turn as far as in the line, so that two lines may differ in their sweeps
    key = (model, _changed(model), swept.columns, swept.weights.tobytes())
    if key not in _SCENES:
        while len(_SCENES) >= MOST_SCENES:
            _SCENES.pop(next(iter(_SCENES)))
        try:
            with np.errstate(over="raise", invalid="raise"):
                _SCENES[key] = staged(swept)
        except (ModelError, OutputError) as error:
            _SCENES[key] = str(error)
        except FloatingPointError:
            _SCENES[key] = f"{model}: a point moves too far to be drawn"
    return _SCENES[key]


def _changed(model: Path | None) -> int:
    """Return the time at which a file was changed; 0 if it cannot be read."""
    with suppress(OSError):
        return 0 if model is None else model.stat().st_mtime_ns
    return 0


_SCENES: dict[Hashable, Scene | str] = {}
"""The latest scenes, by their model, its columns and how far they move."""

MOST_SCENES = 4
"""Number of scenes that are kept, which take some megabytes each."""


def _face(animation: Animation, scene: Scene, pack: ArrayPack) -> Json:
    # The page draws each material as one run of triangles.
    order = np.argsort(scene.material, kind="stable")
    normals = np.nan_to_num(light.unit(scene.directions(scene.normals)))
    textured = any(material.image is not None for material in scene.materials)
    kind = "u2" if scene.count <= SMALL_MODEL else "u4"
    nodes = {part.node for part in scene.parts}
    grids = {node: Grid.of([one for one in scene.parts if one.node == node]) for node in nodes}
    return {
        "unshown": list(_unshown(scene)),
        "count": scene.count,
        "camera": _camera(framed(scene)),
        "close": _camera(close_up(scene)),
        "light": {
            "lamps": [
                [*(np.array(one.way) / np.linalg.norm(one.way)).tolist(), *one.colour, one.wrap,
                 one.shine] for one in light.LAMPS
            ],
            "sky": light.SKY.tolist(),
            "ground": light.GROUND.tolist(),
            "sharpest": light.SHARPEST,
            "least": light.LEAST_LIGHT,
            "around": light.AROUND,
            "cells": light.CELLS,
            "bias": light.BIAS,
            "behind": BEHIND,
        },
        "nodes": _nodes(scene, animation),
        "parts": [_part(scene, part, pack, kind, grids[part.node]) for part in scene.parts],
        "triangles": pack.add(scene.triangles[order], kind),
        "groups": pack.add(light.groups(scene), kind),
        "normals": pack.add(normals, "i1", 127),
        "colours": pack.add(scene.colours, "u2", 65535),
        "places": pack.add(scene.places, "f4") if textured else None,
        "moving": pack.add(scene.moving, "u1"),
        "materials": list(_materials(scene, pack)),
    }  # fmt: skip


def _camera(camera: Camera) -> Json:
    fields = {name: np.asarray(value).tolist() for name, value in vars(camera).items()}
    return fields | {"field": FIELD_DEGREES}


def _nodes(scene: Scene, animation: Animation) -> list[Json]:
    """Return the visible nodes, parents first: positions at rest, and channels of bones."""
    rank = {number: place for place, number in enumerate(scene.order)}
    moves = grouped(
        (one.node, {"channel": column, "turn": one.rotation, "shift": one.translation})
        for column, one in enumerate(animation.columns)
    )
    rows, movable = [], movable_nodes(scene.document)
    for number, parent in scene.order.items():
        node = scene.document["nodes"][number]
        own = moves.get(movable.get(number, ""))
        shown: Json = {"matrix": local(scene.document["nodes"][number]).ravel().tolist()}
        if own:
            shown = {"moves": own} | {key: node.get(key, it) for key, it in NODE_REST.items()}
        rows.append({"parent": -1 if parent is None else rank[parent]} | shown)
    return rows


class Grid(NamedTuple):
    """Steps to which the points of a mesh are rounded, the same for all of its primitives.

    A point that two primitives share stays one point, so that no hole shows between them.
    """

    middle: Floats
    reach: float
    far: dict[int, float]
    """Longest movement in each shape, by the number of the shape."""

    @classmethod
    def of(cls, parts: Sequence[Primitive]) -> Self:
        """Return the grid of the primitives of a mesh."""
        low = np.min([part.base.min(axis=0) for part in parts], axis=0)
        high = np.max([part.base.max(axis=0) for part in parts], axis=0)
        far: dict[int, float] = {}
        for part in parts:
            for row, target in zip(part.deltas, part.active, strict=True):
                # The largest step decides the scale that all primitives share: see `Grid`.
                far[int(target)] = max(far.get(int(target), 0.0), float(np.abs(row).max()))
        return cls((low + high) / 2, float((high - low).max()) or 1.0, far)


def _part(scene: Scene, part: Primitive, pack: ArrayPack, kind: str, grid: Grid) -> Json:
    """Return a primitive: its points at rest, and the points that each shape moves."""
    rank = {number: place for place, number in enumerate(scene.order)}
    middle, reach, _ = grid
    skin = None
    if part.skin is not None:
        skin = {
            "bones": [rank.get(node, -1) for node in part.skin.nodes.tolist()],
            "inverse": pack.add(part.skin.inverse, "f4"),
            "sets": part.skin.bones.shape[1],
            "joints": pack.add(part.skin.bones, "u2"),
            "shares": pack.add(part.skin.shares, "u2", 65535),
        }
    whole = pack.add(part.base - middle, "i2", SHORT / reach)  # arrays are numbered in this order
    shapes = []  # that channels move, or that are visible at rest
    rest, moved = part.weights.values[0], part.weights.values[1:] - part.weights.values[0]
    for row, target in zip(part.deltas, part.active, strict=True):
        points = np.flatnonzero(np.abs(row).max(axis=1) > MIN_MOVEMENT_SHARE * reach)
        if len(points):
            far = grid.far[int(target)]
            shape = {
                "channels": np.flatnonzero(moved[:, target]).tolist(),
                "rest": float(rest[target]),
                "scale": far / SHORT,
                "points": pack.add(points, kind),
                "deltas": pack.add(row[points], "i2", SHORT / far),
            }
            shapes.append(shape)
    return {
        "node": rank[part.node],
        "first": part.points.start,
        "count": len(part.base),
        "middle": middle.tolist(),
        "scale": reach / SHORT,
        "points": whole,
        "shapes": shapes,
        "skin": skin,
    }


def _materials(scene: Scene, pack: ArrayPack) -> Iterator[Json]:
    """Yield the materials in use, each with its run of triangles."""
    counts = np.bincount(scene.material, minlength=len(scene.materials)).tolist()
    first = 0
    for one, count in zip(scene.materials, counts, strict=True):
        if count:
            yield {
                "first": first,
                "count": count,
                "cutoff": one.cutoff / max(float(one.colour[3]), CLEAR),
                "double": one.double,
                "gloss": one.gloss,
                "lit": one.lit,
                "image": None
                if one.image is None or len(one.image) > MAX_IMAGE_BYTES
                else pack.add(np.frombuffer(one.image, np.uint8), "u1"),
            }
        first += count


def _unshown(scene: Scene) -> Iterator[str]:
    """Yield a remark on parts of a model that the page leaves out."""
    rows = [row for row in scene.document.get("materials", ()) if isinstance(row, dict)]
    lost = [what for key, what in BEYOND.items() if any(key in row for row in rows)]
    if any("metallicRoughnessTexture" in row.get("pbrMetallicRoughness", {}) for row in rows):
        lost.append("roughness and metal maps")
    if any(row.get("alphaMode") == "BLEND" for row in rows):
        lost.append("transparency (surfaces are drawn solid)")
    if any(len(one.image or b"") > MAX_IMAGE_BYTES for one in scene.materials):
        lost.append(f"textures of more than {MAX_IMAGE_BYTES >> 20} MB")
    missing = any(
        one.image is None and "baseColorTexture" in row.get("pbrMetallicRoughness", {})
        for one, row in zip(scene.materials, rows, strict=False)
    )
    if missing:
        lost.append("textures in separate files")
    if lost:
        yield f"parts of the model that are not shown: {', '.join(lost)}"
