"""Drawable parts of a glTF file: arrays, textures, nodes, and the materials of surfaces."""

import warnings
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.extras import install_line
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.accessors import Accessors, Array
from lipsync_lang.faces.rigs.model import Model

Texels = npt.NDArray[np.uint8]

MAX_TEXTURE_PIXELS = 2048
"""Maximum pixels of a texture's longer side; a picture would not show more detail."""

MAX_PIXELS = 2**26
"""Maximum pixels of an image, 8192 by 8192; without it a small file could unpack to any size."""

IMAGE_FORMATS = ("PNG", "JPEG", "WEBP")
"""Image formats of glTF and its extensions; Pillow's other decoders stay disabled for safety."""


class Gltf:
    """A glTF document with its binary data."""

    def __init__(self, model: Model, path: Path) -> None:
        self.path, self.document = path, model.document
        self.arrays = Accessors(model, path)

    def image(self, number: int) -> bytes | None:
        """Read a texture's image file; None if it is outside the model."""
        row = self.document["textures"][number]
        kinds = (row, *row.get("extensions", {}).values())
        sources = [kind["source"] for kind in kinds if "source" in kind]
        image = self.document["images"][sources[0]] if sources else {}
        if "bufferView" not in image:
            return None
        return self.arrays.view(image["bufferView"])

    def order(self) -> dict[int, int | None]:
        """List the visible nodes with their parents, parents first."""
        nodes, scenes = self.document.get("nodes", []), self.document.get("scenes", [])
        children = set(chain.from_iterable(node.get("children", ()) for node in nodes))
        roots = [number for number in range(len(nodes)) if number not in children]
        if scenes:
            roots = scenes[self.document.get("scene", 0)].get("nodes", [])
        found: dict[int, int | None] = {}
        waiting: list[tuple[int, int | None]] = [(root, None) for root in roots]
        while waiting:
            number, parent = waiting.pop()
            # A damaged file may name a node twice, or as its own child.
            if number not in found:
                found[number] = parent
                waiting += [(child, number) for child in nodes[number].get("children", ())]
        return found

    def local(self, number: int, **moved: Floats) -> Floats:
        """Compute the (4, 4) matrix of a node relative to its parent, with animated values."""
        node = self.document["nodes"][number]
        if "matrix" in node:
            return np.reshape(np.array(node["matrix"], float), (4, 4))
        rest = {"translation": (0, 0, 0), "rotation": (0, 0, 0, 1), "scale": (1, 1, 1)}
        own = {name: np.array(node.get(name, value), float) for name, value in rest.items()}
        own |= moved
        v, s = own["rotation"][:3], own["rotation"][3]
        # Rodrigues' formula of a quaternion, transposed: points are rows here.
        axes = (2 * s * s - 1) * np.eye(3) + 2 * np.outer(v, v) - 2 * s * np.cross(np.eye(3), v)
        matrix = np.eye(4)
        matrix[:3, :3] = own["scale"][:, None] * axes
        matrix[3, :3] = own["translation"]
        return matrix


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
    try:
        from PIL import Image
    except ImportError:
        raise OutputError(f"pictures need Pillow: {install_line('video')}") from None
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


def material(gltf: Gltf, row: Json) -> Material:
    """Read a material; glTF's defaults fill missing properties."""
    surface = row.get("pbrMetallicRoughness", {})
    mode = row.get("alphaMode", "OPAQUE")
    texture = surface.get("baseColorTexture")
    extensions = (texture or {}).get("extensions", {})
    placed = extensions.get("KHR_texture_transform", {})  # undoes what quantising did, as a rule
    cutoff = {"OPAQUE": 0.0, "MASK": float(row.get("alphaCutoff", 0.5))}.get(mode, 0.5)
    return Material(
        np.array(surface.get("baseColorFactor", [1.0] * 4), float),
        gltf.image(texture["index"]) if texture else None,
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
