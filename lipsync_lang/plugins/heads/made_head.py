"""Make a talking head from a face model: painted, with tongue, lashes and brows, and thinned.

Lashes and brows are strands: thin triangles that follow the points of the face. Each point of a
strand is a mean of two points of the face plus an offset, so all shapes carry over.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from io import BytesIO
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from lipsync_lang import LipsyncError, ModelError, OutputError
from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.base.json_object import Json
from lipsync_lang.plugins.heads.face_model import FaceModel
from lipsync_lang.plugins.heads.obj_files import obj_mesh
from lipsync_lang.plugins.heads.painting import BROW_REACH, brow_way, lip_share, painted, ramp
from lipsync_lang.plugins.heads.parts import (
    Part,
    smooth_normals,
    srgb,
    take,
    transformed,
    with_normals,
    write_glb,
)
from lipsync_lang.plugins.heads.thinning import Web, thin

BROW_HAIRS_PER_MEGABYTE, MAX_BROW_HAIRS = 350, 1400
"""Hairs of both brows: as many as a smaller head has room for, and the most."""

HAIR_SIZE = (0.034, 0.42)
"""Width at the root and length of a hair of a brow, in centimetres."""

LASH_WIDTH = 0.13
"""Width of a lash at its root, as a share of the way to the next of its strip."""

MEGABYTE = 10**6

POINTS_PER_MEGABYTE = 2850
"""Points of the first try; a further try has as many as would fit the size."""

LEAST_POINTS = 2500
"""Fewest points of a head; with fewer the lips break up."""

MAX_HAIR_POINTS = 20000
"""Maximum number of points of hair."""

SPARSE = 7
"""Each so many points of the face are asked for the one nearest to a hair."""

WHITE = (1.0, 1.0, 1.0, 1.0)

CORNEA_SHARE = 1.06
"""Radius, in those of the iris, of the part of the eyeball in front of it that is left out."""


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


@dataclass(frozen=True)
class HeadWish:
    """Request for a head: its person, hair, colours and size."""

    identities: Mapping[int, float] = field(default_factory=dict)
    """Identities by number, in standard deviations."""
    seed: int | None = None
    """Draws a person; None for the neutral one."""
    hair: Path | None = None
    """An OBJ file of hair, in the lengths of the model and in its place."""
    colors: Mapping[str, str] = field(default_factory=dict)
    """Web colours by name of a surface or of a paint."""
    megabytes: float = 4.0
    """Largest size of the file."""


@dataclass(frozen=True, eq=False)
class MadeHead:
    """A finished head: its GLB, its V points in all parts and the names of its shapes."""

    content: bytes
    points: int
    shapes: tuple[str, ...]


def make_head(model: FaceModel, wish: HeadWish) -> MadeHead:
    """Make a head; a LipsyncError if a file or a colour is wrong, or the size too small."""
    model = FaceModel(model.folder, _colored(model.recipe, wish.colors))
    recipe, neutral = model.recipe, model.neutral
    shift = model.identity(wish.identities, wish.seed)
    shapes = model.shapes()
    for name, moved in _tongue_shapes(model).items():
        shapes[name] = shapes.get(name, 0) + moved
    points = neutral.points + shift
    points += _shut(points, shapes, recipe["rest"])
    surface = _surfaces(model)
    on = {
        name: _marked(neutral.triangles[surface == number], len(points))
        for number, name in enumerate(recipe["surfaces"])
    }
    points[on["teeth"], 0] -= recipe["teeth_nearer"] * np.sign(points[on["teeth"], 0])
    _set_teeth(points, shapes, on, recipe)
    pupils = np.array([[rim[0], *pair] for rim in recipe["rims"] for pair in pairwise(rim[1:])])
    seen = surface >= 0
    triangles = np.concatenate([neutral.triangles[seen], pupils])
    irises = np.full(len(pupils), list(recipe["surfaces"]).index("irises"))
    surface = np.concatenate([surface[seen], irises])
    colors = painted(neutral.points, on, recipe)
    body = Part("head", points, triangles, WHITE, targets=shapes, colors=colors)
    # Thinning watches an open mouth as well, where other points matter than at rest.
    poses = np.stack([points, points + sum(shapes[name] for name in recipe["watched"])])
    web = Web(poses, triangles, surface, colors, _worth(model, on))
    rows, strips = recipe["lash_rows"], recipe["lash_strips"]
    extra = [_hairs("lashes", lashes(_lash_places(model), rows, strips), body, recipe)]
    normals = smooth_normals(neutral.points, triangles[surface == 0])
    hairs = brows(neutral.points, normals, recipe, wish.megabytes)
    extra.append(_hairs("brows", hairs, body, recipe))
    if wish.hair is not None:
        extra.append(_worn(wish.hair, neutral.points, shift, recipe))
    return _fitted(body, web, extra, model, wish.megabytes)


def _shut(points: Floats, shapes: Mapping[str, Floats], rest: Json) -> Floats:
    """Return the offsets (V, 3) that shut the lips of a person: these differ in how they rest."""
    upper, lower, closed = rest["upper"], rest["lower"], shapes[rest["by"]]
    gap = points[upper, 1].min() - points[lower, 1].max() + rest["overlap"]
    return closed * gap / (closed[lower, 1].max() - closed[upper, 1].max())


def _set_teeth(
    points: Floats, shapes: Mapping[str, Floats], on: Mapping[str, Bools], recipe: Json
) -> None:
    """Move both rows of teeth up or down: people differ in what their lips show of them."""
    row, lip = recipe["teeth"], points[recipe["rest"]["upper"], 1].min()
    lower = shapes[row["lower_moved_by"]].any(axis=1)
    front = on["teeth"] & (np.abs(points[:, 0]) < row["aside"])
    front &= points[:, 2] > np.median(points[on["teeth"], 2])
    rows = on["teeth"] | on["gums"]
    points[rows & ~lower, 1] += lip - row["upper"] - points[front & ~lower, 1].min()
    points[rows & lower, 1] += lip - row["lower"] - points[front & lower, 1].max()


def _colored(recipe: Json, colors: Mapping[str, str]) -> Json:
    """Return the recipe with other colours; a LipsyncError for an unknown name or no colour."""
    painted_parts = {**recipe["surfaces"], "lips": recipe["lips"]}
    known = [*painted_parts, *recipe["colors"]]
    surfaces, others = dict(painted_parts), dict(recipe["colors"])
    for name, color in colors.items():
        if name not in known:
            raise LipsyncError(f"no part '{name}' to paint: {did_you_mean(name, known)}")
        if not re.fullmatch("#[0-9a-fA-F]{6}", color):
            raise LipsyncError(f"colour of {name}: '{color}' is no colour; write it like #d8a284")
        if name in surfaces:
            surfaces[name] = {**surfaces[name], "color": color}
        else:
            others[name] = color
    lips = surfaces.pop("lips")
    return {**recipe, "surfaces": surfaces, "lips": lips, "colors": others}


def _surfaces(model: FaceModel) -> Ints:
    """Number the surface of each triangle; -1 for those that are left out."""
    recipe, neutral = model.recipe, model.neutral
    found = np.full(len(neutral.triangles), -1)
    for number, row in enumerate(recipe["surfaces"].values()):
        for first, last in row["faces"]:
            found[(neutral.faces >= first) & (neutral.faces <= last)] = number
    eye, places = recipe["eye"], neutral.points[neutral.triangles]
    off = np.stack([np.abs(places[..., 0]), places[..., 1]], -1) - np.array(eye["center"])
    out = np.linalg.norm(off, axis=-1) / eye["radius"]
    names = list(recipe["surfaces"])
    front = places[..., 2].min(axis=1) > eye["front"]
    found[(found == names.index("eyes")) & (out.max(axis=1) < CORNEA_SHARE) & front] = -1
    hidden = (out.min(axis=1) > CORNEA_SHARE) | ~front
    found[(found == names.index("irises")) & hidden] = -1
    return found


def _marked(triangles: Ints, count: int) -> Bools:
    found = np.zeros(count, bool)
    found[triangles] = True
    return found


def _worth(model: FaceModel, on: Mapping[str, Bools]) -> Floats:
    """Return how much each point counts: less in the mouth and at the back of the head."""
    recipe, points = model.recipe, model.neutral.points
    worth = np.zeros(len(points))
    for name, row in recipe["surfaces"].items():
        worth[on[name]] = np.maximum(worth[on[name]], row["keep"])
    return worth * (0.15 + 0.85 * ramp(recipe["back"] - 5, recipe["back"], points[:, 2]))


def _tongue_shapes(model: FaceModel) -> dict[str, Floats]:
    """Make shapes of the tongue: its front moves, flattens and narrows, more towards the tip."""
    recipe, points = model.recipe, model.neutral.points
    surface = list(recipe["surfaces"]).index("tongue")
    tongue = np.flatnonzero(
        _marked(model.neutral.triangles[_surfaces(model) == surface], len(points))
    )
    found = {}
    for name, row in recipe["tongue"].items():
        x, y, z = points[tongue].T
        share = ramp(row["from"], row["to"], z)
        move = share[:, None] * np.array(row["move"])
        move[:, 0] -= x * row["narrow"] * share
        move[:, 1] += (recipe["tongue_middle"] - y) * row["flat"] * share + row["drop"] * share**3
        found[name] = np.zeros_like(points)
        found[name][tongue] = move
    return found


def _lash_places(model: FaceModel) -> Floats:
    """Return the texture coordinates of the strips of lashes, nan elsewhere."""
    neutral = model.neutral
    places = np.full_like(neutral.places, np.nan)
    for first, last in model.recipe["lashes"]:
        points = np.unique(neutral.triangles[(neutral.faces >= first) & (neutral.faces <= last)])
        places[points] = neutral.places[points]
    return places


def _hairs(name: str, strands: Strands, body: Part, recipe: Json) -> Part:
    """Make a part of strands, lit as the face below them."""
    positions = strands.on(body.positions) + strands.offset
    targets = {key: strands.on(shift) for key, shift in body.targets.items()}
    normals = smooth_normals(body.positions, body.triangles)[strands.first]
    color = srgb(recipe["colors"][name])
    return Part(
        name, positions, strands.triangles, color, 1.0, targets,
        normals=normals, target_normals={}, double_sided=True,
    )  # fmt: skip


def _worn(path: Path, face: Floats, shift: Floats, recipe: Json) -> Part:
    """Read hair, which follows the identity of the face below it."""
    mesh = obj_mesh(path)
    used, triangles = np.unique(mesh.triangles, return_inverse=True)
    positions = mesh.points[used]
    if len(used) > MAX_HAIR_POINTS:
        raise ModelError(
            f"{path}: has {len(used):,} points, more than {MAX_HAIR_POINTS:,}; thin it"
        )
    # In blocks: all distances at once would take gigabytes.
    near = np.concatenate(
        [
            np.argmin(((block[:, None] - face[None, ::SPARSE]) ** 2).sum(axis=2), axis=1)
            for block in np.array_split(positions, len(positions) // 200 + 1)
        ]
    )
    color = srgb(recipe["colors"]["hair"])
    moved = positions + shift[::SPARSE][near]
    return Part("hair", moved, triangles.reshape(-1, 3), color, 0.6, double_sided=True)


def _fitted(body: Part, web: Web, extra: list[Part], model: FaceModel, limit: float) -> MadeHead:
    """Thin the head until its file is small enough."""
    goal = int(limit * POINTS_PER_MEGABYTE)
    while True:
        web = thin(web, goal)
        parts = [*_split(replace(body, triangles=web.triangles), web.surface, model), *extra]
        made = _written(parts, model)
        if len(made.content) <= limit * MEGABYTE:
            return made
        # At least 3 % fewer each time, so that the loop ends.
        left, goal = goal, int(web.count * min(0.97, limit * MEGABYTE / len(made.content)))
        if goal < LEAST_POINTS or web.count > left:
            raise OutputError(
                f"a head of {limit:g} MB would have {goal:,} points, too few for lips; allow more"
            )


def _split(body: Part, surface: Ints, model: FaceModel) -> list[Part]:
    """Split the thinned body by material."""
    recipe = model.recipe
    body = with_normals(body)
    lips = lip_share(model.neutral.points, recipe)[body.triangles].min(axis=1) > 0.5  # noqa: PLR2004 more lip than skin
    parts = []
    for number, (name, row) in enumerate(recipe["surfaces"].items()):
        here = surface == number
        if number == 0:
            glossy = here & lips
            parts.append(take(body, glossy, "lips", roughness=1 - recipe["lips"]["gloss"]))
            here &= ~lips
        parts.append(take(body, here, name, roughness=1 - row["gloss"]))
    return parts


def _written(parts: list[Part], model: FaceModel) -> MadeHead:
    """Write the parts in metres, about the joint of the neck."""
    recipe = model.recipe
    pivot, scale = np.array(recipe["node"]["translation"], float), recipe["scale"]
    node = {**recipe["node"], "translation": [float(one) for one in pivot * scale]}
    shapes = tuple(sorted(parts[0].targets))
    origin = {
        "generator": "lipsync-lang heads",
        "copyright": recipe["credit"],
        "extras": {"license": model.licence},
    }
    out = BytesIO()
    moved = [transformed(part, scale=scale, move=-pivot * scale) for part in parts]
    write_glb(out, moved, shapes, node, origin)
    return MadeHead(out.getvalue(), sum(len(part.positions) for part in parts), shapes)
