"""Hairs of a face as thin triangles that follow its points: lashes and brows.

Each point of a strand is a mean of two points of the face plus an offset, so all shapes carry over.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.heads.painting import BROW_REACH, brow_way

BROW_HAIRS_PER_MEGABYTE, MAX_BROW_HAIRS = 350, 1400
"""Hairs of both brows: as many as a smaller head has room for, and the most."""

HAIR_SIZE = (0.034, 0.42)
"""Width at the root and length of a hair of a brow, in centimetres."""

LASH_WIDTH = 0.13
"""Width of a lash at its root, as a share of the way to the next of its strip."""


class Strands(NamedTuple):
    """S points of strands, and their triangles."""

    first: Ints
    second: Ints
    share: Floats
    """(S, 1) share of the second point; the rest is that of the first."""
    offset: Floats
    """(S, 3) from there."""
    triangles: Ints

    def on(self, values: Floats) -> Floats:
        """Carry (V, 3) displacements of the face over to the strands."""
        return values[self.first] * (1 - self.share) + values[self.second] * self.share


def lashes(places: Floats, rows: int, strips: Sequence[int]) -> Strands:
    """Split strips of lashes into strands by (V, 2) texture coordinates; other points have nan.

    Each strip has `rows` rows of one height, the roots highest; strips lie below each other, and
    those with the numbers `strips` are used, each a little beside the one before.
    """
    on = np.flatnonzero(np.isfinite(places[:, 0]))
    side = np.floor(2 * places[on, 0])
    level = places[on, 1].round(2)
    found: list[tuple[int, int, float]] = []
    triangles: list[tuple[int, int, int]] = []
    for half in np.unique(side):
        levels = np.unique(level[side == half])[::-1]
        lines = [on[(side == half) & (level == one)] for one in levels]
        lines = [line[np.argsort(places[line, 0])] for line in lines]
        for shift, strip in zip(np.arange(0, 1, 1 / len(strips)), strips, strict=True):
            root, middle, tip = (lines[rows * strip + row] for row in (0, rows // 2, rows - 1))
            for one, following in zip(range(len(root)), range(1, len(root)), strict=False):
                start = len(found)
                found += [
                    (row[one], row[following], shift + LASH_WIDTH * across)
                    for row, across in (
                        (root, 0), (root, 1), (middle, 0.9), (middle, 0.1), (tip, 0.5)
                    )
                ]  # fmt: skip
                triangles += [
                    (start, start + 1, start + 2),
                    (start, start + 2, start + 3),
                    (start + 3, start + 2, start + 4),
                ]
    first, second, share = (np.array(row) for row in zip(*found, strict=True))
    return Strands(first, second, share[:, None], np.zeros((len(first), 3)), np.array(triangles))


def brows(points: Floats, normals: Floats, recipe: Json, megabytes: float) -> Strands:
    """Lay hairs on the brows: upright at the nose, flat towards the temple."""
    far, along = brow_way(points, recipe)
    near = np.flatnonzero((far < BROW_REACH) & (normals[:, 2] > 0))
    count = min(int(megabytes * BROW_HAIRS_PER_MEGABYTE), MAX_BROW_HAIRS)
    # A fixed seed, so that the same head has the same brows.
    draw = np.random.default_rng(0)
    thick = 1 - far[near] / BROW_REACH
    chosen = draw.choice(near, count, p=thick / thick.sum())
    width, length = HAIR_SIZE
    side = np.sign(points[chosen, 0])[:, None]
    out = normals[chosen]
    lean = (np.clip(1 - along[chosen], 0, 1) * 1.2 + 0.25 + 0.12 * draw.standard_normal(count))[
        :, None
    ]
    way = np.concatenate([side * np.sin(lean), np.cos(lean) - 0.25, 0 * lean], 1)
    way -= out * np.sum(way * out, axis=1, keepdims=True)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    across = np.cross(way, out)
    jitter = 0.1 * draw.standard_normal((count, 3))
    jitter -= out * np.sum(jitter * out, axis=1, keepdims=True)
    root = jitter + 0.05 * out
    tall = length * (0.6 + 0.5 * draw.random((count, 1)))
    corners = [root - across * width / 2, root + across * width / 2, root + way * tall + 0.1 * out]
    follows = np.repeat(chosen, 3)
    offset = np.stack(corners, 1).reshape(-1, 3)
    triangles = np.arange(len(follows)).reshape(-1, 3)
    return Strands(follows, follows, np.zeros((len(follows), 1)), offset, triangles)
