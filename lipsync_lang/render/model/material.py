"""Surface materials: colour, texture, alpha cutoff and gloss."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lipsync_lang.arrays import Floats
from lipsync_lang.json_object import Json
from lipsync_lang.render.model.gltf import Gltf, Texels, decoded
from lipsync_lang.rigs.accessors import Array


@dataclass(frozen=True, eq=False)
class Material:
    """Appearance of a surface.

    Parameters
    ----------
    colour : (4,) linear red, green, blue and alpha
    image : file of the texture, or None
    cutoff : alpha below which the surface is absent
    double : true for surfaces visible from behind
    gloss : in [0, 1]
    lit : false for surfaces that ignore light
    scale, offset : (2,) place of the texture: coordinates times scale, plus offset
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
        found: Texels = self.texture[row, column]
        return found


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
