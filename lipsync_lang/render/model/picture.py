"""Pictures of a model: (size, size, 3) sRGB.

Each pixel is the mean of `FINE` by `FINE` samples. Still geometry is drawn once. The cost of a
frame is therefore that of the moving triangles: in speech, those around the mouth. While a head
nods, they are all; between two nods, those around the mouth again.
"""

from collections.abc import Iterator
from functools import partial, reduce
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Bools, Floats, Ints, Singles
from lipsync_lang.pipeline import kernel
from lipsync_lang.render.model.camera import Camera, framed
from lipsync_lang.render.model.light import LINEAR_LIGHT, SHADES, Normals, encoded, lit, openness
from lipsync_lang.render.model.raster import (
    MIN_AREA,
    DepthKeys,
    Samples,
    Window,
    area,
    fill,
    planes,
    shown,
)
from lipsync_lang.render.model.scene import Material, Scene

Pixels = npt.NDArray[np.uint8]

FINE = 2

COVERED, SHADED = 1 << 18, 1 << 14
"""Samples per batch, for coverage and for shading."""

OVERHEAD = 64.0
"""Fixed cost of a triangle, in samples."""

ABOVE, BELOW = (0.72, 0.74, 0.77), (0.36, 0.38, 0.42)
"""Background light at the top and the bottom."""

BEHIND = 0.4
"""Brightness of the inside of a double-sided surface."""


class Faces(NamedTuple):
    """Screen positions and appearance of the n visible triangles of a frame."""

    names: Ints
    corners: Floats
    """(n, 3, 2) samples."""
    depth: Floats
    """(n, 3) 1 / distance."""
    looks: Singles
    """(3, k, n) planes: diffuse light (3), specular light, texture coordinates (3)."""


class Ground(NamedTuple):
    """Geometry that stands still, drawn once, and the triangles to draw over it."""

    triangles: Ints
    keys: DepthKeys
    light: Singles
    pixels: Pixels


class Artist:
    """Renderer of a scene.

    `size` is the side of the picture in pixels. By default, the camera frames the scene. It, and
    ambient light, are judged by the scene's own movement; `widest` is another one of the model.
    """

    def __init__(
        self, scene: Scene, size: int, camera: Camera | None = None, widest: Scene | None = None
    ) -> None:
        self._scene, self._fine = scene, size * FINE
        self._camera, self._normals = camera or framed(widest or scene), Normals(scene)
        looks = [(one.double, one.cutoff > 0, one.texture is not None) for one in scene.materials]
        self._double, self._cut, self._textured = np.array(looks)[scene.material].T.copy()
        self._texture = np.where(self._textured, scene.material, -1)
        self._textures = tuple(one.texture for one in scene.materials)
        self._gloss, self._lit = np.zeros(scene.count), np.ones((scene.count, 1), bool)
        for number, material in enumerate(scene.materials):
            own = scene.triangles[scene.material == number]
            self._gloss[own], self._lit[own] = material.gloss, material.lit
        self._open = openness(widest or scene, self._camera)[:, None]
        self._colours = np.hstack([scene.colours[:, :3], np.ones((scene.count, 1))])
        self._usual = self._ground(scene.moving)
        off = sorted(((points != scene.rest).any(axis=1) for points in scene.moments), key=np.sum)
        shaped = np.concatenate([part.deltas.any(axis=(0, 2)) for part in scene.parts])
        # What shapes move, or what moves in the calmer half of the moments: all but a nod.
        self._busy = (shaped | np.any(off[: len(off) // 2], axis=0)) & scene.moving
        same = (self._busy == scene.moving).all()
        self._calm = self._usual if same else self._ground(self._busy)

    def _ground(self, moving: Bools) -> Ground:
        """Draw the background, and before it the triangles that no moving point turns."""
        moved, side = self._normals.around(moving), self._fine
        still = np.setdiff1d(np.arange(len(self._scene.triangles)), moved)
        shade = np.linspace(ABOVE, BELOW, side, dtype=np.float32).T[..., None]
        keys, light = np.zeros((side, side), np.uint64), np.broadcast_to(shade, (3, side, side))
        faces = self._faces(self._scene.rest, still)
        drawn = self._drawn(faces, Window(0, 0, side, side), keys, light)
        return Ground(moved, *drawn)

    def draw(self, seconds: float) -> Pixels:
        """Draw one frame."""
        scene = self._scene
        # Points that count as still stand still, or gaps would open to the still geometry.
        points = np.where(scene.moving[:, None], scene.points(seconds), scene.rest)
        off = (points != scene.rest).any(axis=1)
        ground = self._usual if (off & ~self._busy).any() else self._calm
        faces = self._faces(points, ground.triangles)
        pixels = ground.pixels.copy()
        # The smallest window of whole pixels around the triangles; empty without any.
        low = faces.corners.min(axis=(0, 1), initial=self._fine) // FINE * FINE
        high = -(-faces.corners.max(axis=(0, 1), initial=0) // FINE) * FINE + FINE
        sides = np.concatenate([low, np.maximum(low, high)]).clip(0, self._fine).astype(int)
        window = Window(*sides.tolist())
        left, top, right, bottom = (side // FINE for side in window)
        *_, pixels[top:bottom, left:right] = self._drawn(faces, window, ground.keys, ground.light)
        return pixels

    def _faces(self, points: Floats, names: Ints) -> Faces:
        """Project triangles and keep the visible ones."""
        scene = self._scene
        flat, near = self._camera.see(points, self._fine)
        triangles = scene.triangles[names]
        corners, depth = flat[triangles], near[triangles]
        areas = area(corners)  # negative for front faces, because rows count downwards
        seen = (np.abs(areas) > MIN_AREA) & (depth > 0).all(axis=1)
        seen &= (areas < 0) | self._double[names]
        names, corners, depth = names[seen], corners[seen], depth[seen]
        looks = self._looks(points, names, depth, areas[seen] > 0)
        # Triangles last and in one piece: samples take columns of it, millions of times.
        ways: Singles = planes(corners, looks).transpose(1, 2, 0).astype(np.float32, order="C")
        return Faces(names, corners, depth, ways)

    def _looks(self, points: Floats, names: Ints, depth: Floats, behind: Bools) -> Floats:
        """Compute the (n, 3, k) appearance at the corners of triangles."""
        scene = self._scene
        triangles, normals = scene.triangles[names], self._normals.at(points) @ self._camera.turn
        sides = [lit(normals, self._gloss), BEHIND * lit(-normals, self._gloss)]
        # Surfaces that ignore lamps scatter everything, and reflect nothing.
        sides = [np.where(self._lit, self._open * side, (1, 1, 1, 0)) for side in sides]
        front, back = (self._colours * side for side in sides)
        parts = [np.where(behind[:, None, None], back[triangles], front[triangles])]
        if self._textured.any():
            near = depth[..., None]
            # Texture coordinates over the distance are linear on the picture; samples divide back.
            parts += [scene.places[triangles] * near, near]
        return np.concatenate(parts, axis=2)

    def _drawn(
        self, faces: Faces, window: Window, keys: DepthKeys, light: Singles
    ) -> tuple[DepthKeys, Singles, Pixels]:
        """Composite triangles with the still picture in a window, by depth."""
        rows, columns = slice(window.top, window.bottom), slice(window.left, window.right)
        still, light = keys[rows, columns], light[:, rows, columns].copy()
        keys = still.copy()
        flat, pixels = keys.reshape(-1), light.reshape(3, -1)
        cut = self._cut[faces.names]
        cost = np.abs(area(faces.corners)).clip(0, keys.size) / 2 + OVERHEAD
        for some in (~cut, cut):
            numbers = np.flatnonzero(some)
            # Batches are small enough for the processor cache.
            edges = np.flatnonzero(np.diff(np.cumsum(cost[numbers]) // COVERED)) + 1
            for own in np.split(numbers, edges) if len(numbers) else ():
                seen = partial(self._opaque, faces, own) if some is cut else None
                fill(flat, window, faces.corners[own], faces.depth[own], faces.names[own], seen)
        rank = np.full(len(self._scene.triangles), -1, np.intp)
        rank[faces.names] = np.arange(len(faces.names))
        if kernel.compiled is not None:
            textures = self._texture[faces.names], self._textures, LINEAR_LIGHT
            looks = faces.looks
            kernel.compiled.shade(flat, *window, pixels, rank, *looks.shape[1:], looks, *textures)
            return keys, light, _pixels(light)
        changed = np.flatnonzero(keys != still)
        for place in np.split(changed, range(SHADED, len(changed), SHADED)):
            y, x = np.divmod(place, window.width)
            samples = Samples(x + window.left, y + window.top, rank[shown(flat[place])])
            looks = _at(faces, samples, slice(0, 4))
            for one, _, texels in self._texels(faces, samples):
                looks[:3, one] *= LINEAR_LIGHT[texels[:, :3]].T
            pixels[:, place] = looks[:3] + looks[3]
        return keys, light, _pixels(light)

    def _opaque(self, faces: Faces, own: Ints, samples: Samples) -> Bools:
        """Mask the samples of triangles with alpha above their materials' cutoff."""
        scene = self._scene
        samples = samples._replace(triangle=own[samples.triangle])
        number = scene.material[faces.names[samples.triangle]]
        alpha = np.array([m.colour[3] for m in scene.materials])[number]
        for one, material, texels in self._texels(faces, samples):
            alpha[one] = material.colour[3] * texels[:, 3] / 255
        return alpha >= np.array([m.cutoff for m in scene.materials])[number]

    def _texels(self, faces: Faces, samples: Samples) -> Iterator[tuple[Ints, Material, Pixels]]:
        """Yield each textured material with its samples and their texture values."""
        names = faces.names[samples.triangle]
        textured = np.flatnonzero(self._textured[names])
        numbers = self._scene.material[names[textured]]
        for number in np.unique(numbers):
            material = self._scene.materials[number]
            one = textured[numbers == number]
            picked = Samples(*(values[one] for values in samples))
            u, v, near = _at(faces, picked, slice(4, 7))
            yield one, material, material.texels(u / near, v / near)


def _at(faces: Faces, samples: Samples, part: slice) -> Singles:
    """Evaluate some of the appearance planes at samples: (k, n)."""
    x, y = samples.x.astype(np.float32), samples.y.astype(np.float32)
    first, along, down = faces.looks[:, part].take(samples.triangle, axis=2)
    return first + along * x + down * y


def _pixels(light: Singles) -> Pixels:
    """Average (3, rows, columns) samples to pixels."""
    if kernel.compiled is not None:
        made = np.empty((light.shape[1] // FINE, light.shape[2] // FINE, 3), np.uint8)
        kernel.compiled.average(light, *light.shape[:0:-1], FINE, SHADES, made)
        return made
    parts = [light[:, row::FINE, column::FINE] for row, column in np.ndindex(FINE, FINE)]
    total: Singles = reduce(np.add, parts)
    return encoded(total / FINE**2).transpose(1, 2, 0)
