"""Make a talking head from a face model: painted, with tongue, lashes and brows, and thinned."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from io import BytesIO
from itertools import pairwise
from pathlib import Path

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints
from lipsync_lang.base.errors import LipsyncError, ModelError, OutputError, did_you_mean
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.heads.face_model import FaceModel
from lipsync_lang.faces.heads.obj_files import obj_mesh
from lipsync_lang.faces.heads.painting import lip_share, painted, ramp
from lipsync_lang.faces.heads.strands import Strands, brows, lashes
from lipsync_lang.faces.heads.thinning import Web, thin
from lipsync_lang.faces.rigs.parts import (
    Part,
    smooth_normals,
    srgb,
    take,
    transformed,
    with_normals,
    write_glb,
)

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
    shapes = {**model.shapes(), **_tongue_shapes(model)}
    rest = sum(weight * shapes[name] for name, weight in recipe["rest"].items())
    points = neutral.points + shift + rest
    surface = _surfaces(model)
    on = {
        name: _marked(neutral.triangles[surface == number], len(points))
        for number, name in enumerate(recipe["surfaces"])
    }
    points[on["teeth"], 0] -= recipe["teeth_nearer"] * np.sign(points[on["teeth"], 0])
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
