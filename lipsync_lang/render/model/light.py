"""Lighting: smooth normals and the brightness of surfaces.

All values are linear light; `encoded` converts the result to sRGB for display.
"""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.render.model.camera import Camera
from lipsync_lang.render.model.raster import MIN_AREA, Window, area, depths, fill
from lipsync_lang.render.model.scene import Scene

_SRGB = np.linspace(0, 1, 256)
LINEAR_LIGHT = np.where(_SRGB <= 0.04045, _SRGB / 12.92, ((_SRGB + 0.055) / 1.055) ** 2.4)  # noqa: PLR2004 sRGB
"""(256,) linear light of each 8-bit sRGB value."""

_SHADE_STEPS = 4096
_MIDDLES = (LINEAR_LIGHT[1:] + LINEAR_LIGHT[:-1]) / 2
SHADES = np.searchsorted(_MIDDLES, np.linspace(0, 1, _SHADE_STEPS)).astype("u1")
"""(4096,) 8-bit sRGB value of each step of linear light from 0 to 1."""

GRAIN = 1e-4, 0.05
"""Relative tolerance for merging corners: of positions, by the model's size, and of normals."""


class Lamp(NamedTuple):
    """A directional light."""

    way: tuple[float, float, float]
    """Direction to the lamp: right, up, towards the eye."""
    colour: tuple[float, float, float]
    wrap: float
    """Spread of the light around an edge: 0 for a point source, 1 for a sky."""
    shine: float
    """Brightness of the specular reflection."""


LAMPS = (
    Lamp((-0.55, 0.6, 0.8), (0.66, 0.63, 0.59), 0.15, 0.3),
    Lamp((0.9, 0.1, 0.5), (0.17, 0.19, 0.22), 0.3, 0.0),
    Lamp((0.6, 0.7, -0.8), (0.24, 0.25, 0.27), 0.0, 0.0),
)
"""Key, fill and rim light."""

SKY, GROUND = np.array([0.30, 0.31, 0.33]), np.array([0.15, 0.14, 0.13])
"""Ambient light from above and from below."""

AROUND, CELLS, BIAS = 40, 256, 4
"""Directions of the ambient light; cells per side of each shadow grid; shadow bias in cells."""

LEAST_LIGHT = 0.4
"""Minimum ambient light at any point."""

SHARPEST = 60.0
"""Specular exponent of a perfectly smooth surface."""


class Normals:
    """Normals of a deforming surface.

    The file's normals turn with the surface. Without them, the surface's own smooth normals apply.
    """

    def __init__(self, scene: Scene) -> None:
        self._corners = scene.triangles
        self._group = groups(scene)
        smooth = self._smooth(scene.rest)
        self._change = np.nan_to_num(unit(scene.directions(scene.normals)) - smooth)

    def at(self, points: Floats) -> Floats:
        """Compute the (V, 3) normals at given point positions."""
        return unit(self._smooth(points) + self._change)

    def around(self, moving: Bools) -> Ints:
        """Find the triangles that look different if some of (V,) points move."""
        owners = self._group[self._corners]
        turned: Bools = np.zeros(len(self._group), bool)
        turned[owners[moving[self._corners].any(axis=1)]] = True
        return np.flatnonzero(turned[owners].any(axis=1))

    def _smooth(self, points: Floats) -> Floats:
        """Average the triangle normals around each point, weighted by area."""
        a, b, c = points[self._corners].swapaxes(0, 1)
        faces = np.cross(b - a, c - a)
        owners = self._group[self._corners].T.ravel()
        sums = [np.bincount(owners, np.tile(part, 3), len(points)) for part in faces.T]
        return unit(np.column_stack(sums))[self._group]


def groups(scene: Scene) -> Ints:
    """Map each of (V,) points to the first one equal to it, apart from texture coordinates."""
    given = scene.normals
    bare: Bools = np.isnan(given[:, 0])
    size = float(np.ptp(scene.rest)) or 1.0
    keys = np.hstack([scene.rest / size / GRAIN[0], np.where(bare[:, None], 0, given) / GRAIN[1]])
    # glTF shades points without a normal flat, so none of them is merged with another.
    keys = np.column_stack([keys.round(), np.where(bare, np.arange(len(keys)), -1)])
    _, first, group = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    return first[group.ravel()]


def unit(vectors: Floats) -> Floats:
    """Normalise vectors to length 1; zero vectors stay zero."""
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return vectors / np.where(lengths > 0, lengths, 1.0)


def lit(normals: Floats, gloss: Floats) -> Floats:
    """Compute the light that surfaces scatter and reflect, from (n, 3) normals in eye axes.

    Of (n,) gloss in [0, 1], returns (n, 4): diffuse light, to be multiplied by the surface colour,
    and white specular light.
    """
    light = np.zeros((len(normals), 4))
    light[:, :3] = GROUND + (SKY - GROUND) * (normals[:, 1:2] / 2 + 0.5)
    for lamp in LAMPS:
        way = np.array(lamp.way) / np.linalg.norm(lamp.way)
        facing = ((normals @ way + lamp.wrap) / (1 + lamp.wrap)).clip(0)
        light[:, :3] += facing[:, None] * np.array(lamp.colour)
        if lamp.shine:
            # Blinn's half vector, with the eye far away in front.
            half = unit((way + np.array([0, 0, 1]))[None])[0]
            power = 2 + SHARPEST * gloss**2
            light[:, 3] += lamp.shine * gloss * (normals @ half).clip(0) ** power
    return light


def openness(scene: Scene, camera: Camera) -> Floats:
    """Estimate the (V,) share of ambient light at points, with the mouth wide open.

    Each light direction has a depth grid. The nearest surface in a grid cell shades every point
    more than `BIAS` cells behind it; the bias keeps a surface from shading itself.
    """
    points = (scene.widest - camera.middle) / camera.half
    normals = Normals(scene).at(scene.widest)
    corners, names = scene.triangles, np.arange(len(scene.triangles), dtype=np.intp)
    reached, all_light = np.zeros(len(points)), np.full(len(points), 1e-9)
    # A spiral of golden angles spreads the directions evenly over a sphere.
    height = 1 - (2 * np.arange(AROUND) + 1) / AROUND
    turn, across = np.arange(AROUND) * np.pi * (3 - np.sqrt(5)), np.sqrt(1 - height**2)
    for way in np.column_stack([across * np.cos(turn), height, across * np.sin(turn)]):
        right = unit(np.cross(way, (0.3, 1.0, 0.2))[None])[0]
        flat = (points @ np.column_stack([right, np.cross(way, right)]) + 1) * (CELLS / 2)
        # The rasteriser needs depths above 0; the model lies within a few units of the middle.
        near = points @ way / 8 + 1
        some = np.abs(area(flat[corners])) > MIN_AREA
        keys = np.zeros(CELLS * CELLS, np.uint64)
        window = Window(0, 0, CELLS, CELLS)
        fill(keys, window, flat[corners[some]], near[corners[some]], names[some])
        column, row = flat.round().astype(np.intp).clip(0, CELLS - 1).T
        lightest = depths(keys)[row * CELLS + column] - 2 * BIAS / CELLS / 8
        facing = (normals @ way).clip(0)
        reached += facing * (near >= lightest)
        all_light += facing
    return LEAST_LIGHT + (1 - LEAST_LIGHT) * np.sqrt(reached / all_light)


def encoded(light: npt.NDArray[np.floating]) -> npt.NDArray[np.uint8]:
    """Encode linear light as sRGB."""
    steps = (light * (_SHADE_STEPS - 1)).clip(0, _SHADE_STEPS - 1).astype(np.uint16)
    return SHADES[steps]
