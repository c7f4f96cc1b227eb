"""Animated scene: the triangles of a model and the positions of their corners over time.

The input is a GLB with an animation, as written for `animations.glb`. Poses and rigs play no part
here: a picture shows exactly the motion in the file. Times are seconds; points are (V, 3).
"""

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.extras import needing
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.accessors import Accessors, Array
from lipsync_lang.faces.rigs.container import fail
from lipsync_lang.faces.rigs.model import Model, read_model
from lipsync_lang.faces.rigs.placing import local, parents
from lipsync_lang.faces.rigs.tracks import drives

Texels = npt.NDArray[np.uint8]

MAX_TEXTURE_PIXELS = 2048
"""Maximum pixels of a texture's longer side; a picture would not show more detail."""

MAX_PIXELS = 2**26
"""Maximum pixels of an image, 8192 by 8192; without it a small file could unpack to any size."""

IMAGE_FORMATS = ("PNG", "JPEG", "WEBP")
"""Image formats of glTF and its extensions; Pillow's other decoders stay disabled for safety."""

TRIANGLES, STRIP, FAN = 4, 5, 6
"""Primitive modes with surfaces."""

MIN_MOVEMENT = 3e-4
"""Fraction of a mesh's size; smaller movements count as still."""

LOOKS = {"NORMAL": {3}, "COLOR_0": {3, 4}, "TEXCOORD_0": {2}}
"""Vertex attributes for appearance, with their numbers of components."""

MOMENTS = 24
"""Number of times sampled to find moving points."""


def texture_image(document: Json, arrays: Accessors, number: int) -> bytes | None:
    """Read a texture's image file; None if it is outside the model."""
    row = document["textures"][number]
    kinds = (row, *row.get("extensions", {}).values())
    sources = [kind["source"] for kind in kinds if "source" in kind]
    image = document["images"][sources[0]] if sources else {}
    return arrays.view(image["bufferView"]) if "bufferView" in image else None


def decoded(data: bytes) -> Texels | None:
    """Decode an image file to (H, W, 4); None if it is unreadable or too large."""
    image = pillow()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # a picture of too many pixels is a warning at first
            picture = image.open(BytesIO(data), formats=IMAGE_FORMATS)
            if picture.width * picture.height > MAX_PIXELS:
                return None
            picture = picture.convert("RGBA")
    except Exception:  # noqa: BLE001 each of Pillow's formats has errors of its own
        return None
    picture.thumbnail((MAX_TEXTURE_PIXELS, MAX_TEXTURE_PIXELS))
    return np.asarray(picture)


def pillow() -> Any:
    """Import Pillow; the error message says how to install it."""
    with needing(OutputError, "pictures need Pillow:", "video"):
        from PIL import Image
    return Image


@dataclass(frozen=True, eq=False)
class Material:
    """Appearance of a surface.

    `colour` is (4,) linear red, green, blue and alpha. The surface is absent below alpha `cutoff`,
    visible from behind if `double`, and ignores light unless `lit`; gloss is in [0, 1]. The place
    of the texture, (2,) each, is its coordinates times scale, plus offset.
    """

    colour: Floats
    image: bytes | None
    cutoff: float
    double: bool
    gloss: float
    lit: bool
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)

    @cached_property
    def texture(self) -> Texels | None:
        """(H, W, 4) sRGB; None without an image that can be read."""
        return None if self.image is None else decoded(self.image)

    def texels(self, u: Array, v: Array) -> Texels:
        """Sample the texture at texture coordinates, (n, 4); the texture repeats."""
        if self.texture is None:
            return np.full((len(u), 4), 255, np.uint8)
        height, width = self.texture.shape[:2]
        column = np.floor(u * width).astype(np.intp) % width
        row = np.floor(v * height).astype(np.intp) % height
        return self.texture[row, column]


def material(document: Json, arrays: Accessors, row: Json) -> Material:
    """Read a material; glTF's defaults fill missing properties."""
    surface = row.get("pbrMetallicRoughness", {})
    mode = row.get("alphaMode", "OPAQUE")
    texture = surface.get("baseColorTexture")
    extensions = (texture or {}).get("extensions", {})
    placed = extensions.get("KHR_texture_transform", {})  # undoes what quantising did, as a rule
    cutoff = {"OPAQUE": 0.0, "MASK": float(row.get("alphaCutoff", 0.5))}.get(mode, 0.5)
    return Material(
        np.array(surface.get("baseColorFactor", [1.0] * 4), float),
        texture_image(document, arrays, texture["index"]) if texture else None,
        cutoff,
        bool(row.get("doubleSided")),
        1.0 - surface.get("roughnessFactor", 1.0),
        "KHR_materials_unlit" not in row.get("extensions", {}),
        _pair(placed.get("scale", (1, 1))),
        _pair(placed.get("offset", (0, 0))),
    )


def _pair(values: Array) -> tuple[float, float]:
    first, second = map(float, values)
    return first, second


class KeyTrack(NamedTuple):
    """Keyframes with linear interpolation."""

    times: Floats
    values: Floats

    def at(self, seconds: float) -> Floats:
        """Interpolate the values at a time."""
        after = int(np.clip(np.searchsorted(self.times, seconds), 1, len(self.times) - 1))
        low, high = self.times[after - 1 : after + 1]
        share = np.clip((seconds - low) / (high - low), 0.0, 1.0)
        return (1 - share) * self.values[after - 1] + share * self.values[after]


@dataclass(frozen=True, eq=False)
class Skin:
    """Skinning data: (J,) nodes, (J, 4, 4) inverse bind matrices, (N, S) bones, (N, S) weights."""

    nodes: Ints
    inverse: Floats
    bones: Ints
    shares: Floats


@dataclass(frozen=True, eq=False)
class Primitive:
    """A primitive of a node; `points` are the places of its N points in the scene."""

    node: int
    points: slice
    base: Floats
    """(N, 3) positions at rest."""
    deltas: Floats
    """(K, N, 3) offsets of the morph targets in use."""
    active: Ints
    """(K,) numbers of these morph targets."""
    weights: KeyTrack
    skin: Skin | None


class Scene:
    """Visible geometry of a model: V points, F triangles.

    Raises ModelError if the file is damaged, has nothing to draw, or is compressed without an
    installed decoder. The last animation of a GLB is played; messages call the file `name`.
    """

    def __init__(self, path: Path, name: Path) -> None:
        self._model = read_model(path, bones=True)
        self.document, self._arrays = self._model.document, Accessors(self._model, name)
        self.parts: list[Primitive] = []
        self._rows: list[tuple[Ints, Floats, Floats, Floats, Ints]] = []
        try:
            with np.errstate(over="raise", invalid="raise", divide="raise"):
                self._read()
                for moment in (0.0, self.seconds):
                    if not np.isfinite(self.points(moment)).all():
                        raise ValueError("a point moves too far to be drawn")  # noqa: TRY301
                matrices = self._matrices(0.0)
                for number, part in enumerate(self.parts):
                    if part.skin is None and np.linalg.det(matrices[part.node]) < 0:
                        # A mirrored node reverses the winding order of its triangles.
                        own = self._rows[number]
                        self._rows[number] = (own[0][:, ::-1], *own[1:])
        except (AttributeError, LookupError, TypeError, ValueError, ArithmeticError) as error:
            fail(name, f"its meshes cannot be read ({str(error)[:60]})")
        if not self.parts:
            fail(name, "shows no surfaces", "export the model itself, with its meshes")
        triangles, normals, colours, places, materials = zip(*self._rows, strict=True)
        self.triangles: Ints = np.concatenate(triangles)
        """(F, 3) point numbers."""
        self.normals: Floats = np.concatenate(normals)
        """(V, 3) at rest; nan if the file has none."""
        self.colours: Floats = np.concatenate(colours)
        """(V, 4) linear red, green, blue and alpha."""
        self.places: Floats = np.concatenate(places)
        """(V, 2) texture coordinates."""
        self.material: Ints = np.concatenate(materials)
        """(F,) material numbers."""

    def _read(self) -> None:
        document, arrays = self.document, self._arrays
        animation = document["animations"][-1]
        self.sound: float = animation.get("extras", {}).get("audio_start", 0.0)
        """Start of the sound in seconds."""
        self._tracks = dict(_tracks(self._model, arrays, animation))
        self.seconds = max(float(track.times[-1]) for track in self._tracks.values())
        """Duration in seconds."""
        self.order = parents(document)
        """Visible nodes with their parents, parents first."""
        rows = [*document.get("materials", ()), {}]
        self.materials = [material(document, arrays, row) for row in rows]
        for number in self.order:
            node = document["nodes"][number]
            if "mesh" in node:
                mesh = document["meshes"][node["mesh"]]
                for primitive in mesh["primitives"]:
                    self._add(number, node, mesh, primitive)

    def _add(self, number: int, node: Json, mesh: Json, primitive: Json) -> None:
        """Add a primitive of a node."""
        arrays, attributes = self._arrays, primitive["attributes"]
        mode = primitive.get("mode", TRIANGLES)
        if mode not in {TRIANGLES, STRIP, FAN} or "POSITION" not in attributes:
            return
        arrays.unpack(primitive)
        base = arrays[attributes["POSITION"]].astype(float)
        count, first = len(base), self.count
        if base.shape[1] != 3:  # noqa: PLR2004 of space
            raise ValueError("POSITION must have three values per point")
        corners = np.arange(count)
        if "indices" in primitive:
            corners = arrays[primitive["indices"]][:, 0].astype(np.intp)
        triangles = _triangles(corners, mode)
        _check_below(triangles, count, "a triangle refers to a point that does not exist")
        shapes = len(primitive.get("targets", ()))
        rest = node.get("weights", mesh.get("weights", [0.0] * shapes))
        still = KeyTrack(np.array([0.0, 1.0]), np.tile(np.array(rest, float), (2, 1)))
        weights = self._tracks.get((number, "weights"), still)
        weights = weights._replace(values=weights.values.reshape(len(weights.times), shapes))
        active = np.flatnonzero(np.abs(weights.values).max(axis=0, initial=0.0) > 0)
        targets = [primitive["targets"][target] for target in active]
        arrays.spend(3 * count * len(active))
        deltas = np.zeros((len(active), count, 3))
        for row, target in zip(deltas, targets, strict=True):
            if "POSITION" in target:
                row[:] = arrays[target["POSITION"]]
        if not (np.isfinite(base).all() and np.isfinite(deltas).all()):
            raise ValueError("a point has a position that is not a finite number")
        points = slice(first, first + count)
        skin = self._skin(node, attributes)
        self.parts.append(Primitive(number, points, base, deltas, active, weights, skin))
        which = primitive.get("material", len(self.materials) - 1)
        normals, colours, places = self._looks(attributes, count, self.materials[which])
        own = np.full(len(triangles), which, np.intp)
        self._rows.append((triangles + first, normals, colours, places, own))

    @property
    def count(self) -> int:
        """Number of points."""
        return self.parts[-1].points.stop if self.parts else 0

    def _skin(self, node: Json, attributes: Json) -> Skin | None:
        if "skin" not in node or "JOINTS_0" not in attributes:
            return None
        skin = self.document["skins"][node["skin"]]
        inverse = np.tile(np.eye(4), (len(skin["joints"]), 1, 1))
        if "inverseBindMatrices" in skin:
            inverse = self._arrays[skin["inverseBindMatrices"]].reshape(-1, 4, 4)
        sets = [one for one in range(8) if f"JOINTS_{one}" in attributes]
        bones = np.hstack([self._arrays[attributes[f"JOINTS_{one}"]] for one in sets])
        shares = np.hstack([self._arrays[attributes[f"WEIGHTS_{one}"]] for one in sets])
        _check_below(bones, len(skin["joints"]), "a point is bound to a bone that does not exist")
        total = shares.sum(axis=1, keepdims=True)
        # Exporters round the shares, and some write sums that are far from 1.
        shares = shares / np.where(total > 0, total, 1.0)
        return Skin(np.array(skin["joints"]), inverse, bones.astype(np.intp), shares)

    def _looks(
        self, attributes: Json, count: int, material: Material
    ) -> tuple[Floats, Floats, Floats]:
        """Read the normals, colours and texture coordinates of points."""
        arrays = {n: self._arrays[attributes[n]] for n in LOOKS if n in attributes}
        for name, values in arrays.items():
            if values.shape[0] != count or values.shape[1] not in LOOKS[name]:
                raise ValueError(f"{name} does not match the points of its mesh")
        normals = arrays.get("NORMAL", np.full((count, 3), np.nan)).astype(float)
        colours = np.ones((count, 4))
        if "COLOR_0" in arrays:
            given = arrays["COLOR_0"]
            colours[:, : given.shape[1]] = given
        places = arrays.get("TEXCOORD_0", np.zeros((count, 2))).astype(float)
        return normals, colours * material.colour, places * material.scale + material.offset

    def points(self, seconds: float) -> Floats:
        """Compute the positions of all points at a time: (V, 3)."""
        matrices = self._matrices(seconds)
        found = np.empty((self.count, 3))
        for part in self.parts:
            points = part.base
            if len(part.active):
                weights = part.weights.at(seconds)[part.active]
                points = points + np.tensordot(weights, part.deltas, 1)
            found[part.points] = _moved(points, part, matrices)
        return found

    def directions(self, own: Floats) -> Floats:
        """Transform (V, 3) directions at points by the initial state of the model."""
        matrices = self._matrices(0.0)
        return np.vstack([_moved(own[part.points], part, matrices, 0.0) for part in self.parts])

    def _matrices(self, seconds: float) -> dict[int, Floats]:
        """Compute the world matrix of every visible node."""
        found: dict[int, Floats] = {}
        for number, parent in self.order.items():
            paths = ("translation", "rotation")
            tracks = {path: self._tracks.get((number, path)) for path in paths}
            moved = {path: track.at(seconds) for path, track in tracks.items() if track}
            if "rotation" in moved:
                # Between two keys, a mean of quaternions is shorter than 1.
                moved["rotation"] /= np.linalg.norm(moved["rotation"])
            own = local(self.document["nodes"][number], **moved)
            found[number] = own if parent is None else own @ found[parent]
        return found

    @cached_property
    def rest(self) -> Floats:
        """(V, 3) initial positions of the points."""
        return self.points(0.0)

    @cached_property
    def shown_by(self) -> Ints:
        """(V,) node of each point."""
        return np.repeat([p.node for p in self.parts], [len(p.base) for p in self.parts])

    @cached_property
    def moving(self) -> Bools:
        """(V,) mask of points that can move."""
        driven = {node for node, path in self._tracks if path != "weights"}
        for number, parent in self.order.items():
            if parent in driven:
                driven.add(number)
        found = np.zeros(self.count, bool)
        for part in self.parts:
            bases = [one.base for one in self.parts if one.node == part.node]
            size = np.ptp(np.vstack(bases), axis=0).max(initial=0.0)
            movers = {part.node} if part.skin is None else set(part.skin.nodes.tolist())
            most = np.abs(part.weights.values).max(axis=0)[part.active]
            reach = np.tensordot(most, np.linalg.norm(part.deltas, axis=2), 1)
            shaped = reach > MIN_MOVEMENT * size
            found[part.points] = shaped | bool(driven & movers)
        return found

    @cached_property
    def moments(self) -> list[Floats]:
        """(V, 3) positions at `MOMENTS` times from start to end."""
        return [self.points(float(time)) for time in np.linspace(0.0, self.seconds, MOMENTS)]

    @cached_property
    def moves(self) -> Floats:
        """(V,) maximum distance of each point from rest, estimated at a few times."""
        far = np.max([np.abs(points - self.rest).max(axis=1) for points in self.moments], axis=0)
        return far if far.any() else far + 1.0

    @property
    def widest(self) -> Floats:
        """(V, 3) positions at the time of the largest total movement."""
        return max(self.moments, key=lambda points: np.abs(points - self.rest).sum())


def _moved(
    points: Floats, part: Primitive, matrices: dict[int, Floats], shift: float = 1.0
) -> Floats:
    """Transform points by node or bones; without shift, by the rotation only."""
    if part.skin is None:
        matrix = matrices[part.node]
        return points @ matrix[:3, :3] + shift * matrix[3, :3]
    skin = part.skin
    still = np.eye(4)
    bones = skin.inverse @ np.array([matrices.get(int(node), still) for node in skin.nodes])
    found = np.zeros_like(points)
    for bone, share in zip(skin.bones.T, skin.shares.T, strict=True):
        own = bones[bone]
        turned = np.einsum("ni,nij->nj", points, own[:, :3, :3])
        found += share[:, None] * (turned + shift * own[:, 3, :3])
    return found


def _check_below(numbers: Array, count: int, otherwise: str) -> None:
    if numbers.size and numbers.max() >= count:
        raise ValueError(otherwise)


def _tracks(
    model: Model, arrays: Accessors, animation: Json
) -> Iterator[tuple[tuple[int, str], KeyTrack]]:
    """Yield the animated properties of nodes with their values."""
    for drive in drives(model, arrays, animation):
        times, values = drive.times, drive.values
        if len(times) == 1:
            times, values = times + np.array([0.0, 1.0]), np.vstack([values, values])
        yield (drive.node, drive.path), KeyTrack(times, values)


def _triangles(corners: Ints, mode: int) -> Ints:
    if mode == TRIANGLES:
        return corners[: len(corners) // 3 * 3].reshape(-1, 3)
    if mode == FAN:
        first = np.full(max(0, len(corners) - 2), corners[0])
        return np.column_stack([first, corners[1:-1], corners[2:]])
    found = np.column_stack([corners[:-2], corners[1:-1], corners[2:]])
    # Every other triangle of a strip is wound the other way round.
    found[1::2, :2] = found[1::2, 1::-1]
    return found
