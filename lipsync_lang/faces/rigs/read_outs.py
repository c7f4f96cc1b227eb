"""Read-outs of shapes, measured on the mesh of a model: how each shape moves the mouth.

Lengths are in widths of the closed mouth, so models of any scale compare: a human mouth is about
5 cm wide. The face looks along +z, and y is up, as glTF requires. No name is read: the mouth is
where points that lie close together come apart most, in the shape that lowers the most of the mesh.
If few shapes part them there, these are lids, for example, and other shapes are tried.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.errors import ModelError, shortlist
from lipsync_lang.faces.rigs.accessors import Accessors
from lipsync_lang.faces.rigs.model import Model
from lipsync_lang.faces.rigs.placing import placed

NEAR_SHARE = 0.05
"""Largest distance between the lips at rest, as a fraction of the width of the moving part."""

PARTED_SHARE = 0.15
"""Smallest opening of a pair of lip points, as a fraction of the largest one."""

TRIED_SHAPES = 12
"""Number of shapes that are tried as the opening of the mouth."""

USED_SHARE = 0.15
"""Smallest share of all moving shapes that part the points of a mouth beyond doubt."""

LEAST_MOUTH = 0.05
"""Smallest aperture of the widest shape of a mouth that opens, in widths of the mouth."""

FRONT_SHARE = 0.4
"""Least depth of moving points on a face that looks to the front, as a share from the back."""

STILL_SHARE = 1e-5
"""Largest way of a point that nobody sees, as a fraction of the size of its mesh."""

MAX_MEASURED_POINTS = 100_000
"""Largest model whose mouth is looked for in a choice of pose sets: pairs of points cost memory."""

CORNER_SLOPE = 2.0
"""Steepest way of the lips to the back beside the corners, over that to the side."""

SKIN_STRETCH = 2.0
"""Largest stretch of skin by an open mouth, over its length: points of both lips part farther."""

CHIN_BOX = (0.0, -0.7, 0.0), (0.15, 0.25, 0.5)
"""Middle of the chin from that of the lips, and half its size, in widths of the mouth."""

TONGUE_BOX = (0.0, 0.0, -0.66), (0.3, 0.4, 0.54)
"""The same of the tongue, which lies behind the lips."""

LIP_BOX = 0.05, 0.15, 0.135
"""Half the size of the part of a lip behind its front; the teeth lie deeper."""


@dataclass(frozen=True)
class ShapeReadOut:
    """Movement of the mouth by one shape at full weight, in widths of the mouth."""

    aperture: float
    """Gap between the inner edges of the lips in the middle, less that at rest."""
    width: float
    """Distance between the corners, less that at rest."""
    protrusion: float
    """Way of the lips to the front."""
    corners: float
    """Way of the corners upwards."""
    jaw: float
    """Way of the chin downwards."""
    tongue_out: float
    """Farthest way of a point of the tongue to the front, past that of jaw and lips."""
    tongue_up: float
    """Farthest way of a point of the tongue upwards, past that of the lips."""
    aside: float
    """Mean place of the points that it moves, left of the middle; far-moving points count more."""


SOUND_MEASURES = ("aperture", "width", "protrusion", "jaw")
"""Measures that packs state of the mouths of sounds."""


@dataclass(frozen=True, eq=False)
class MouthPoints:
    """Point numbers of a mouth: pairs of lip points from the right corner to the left, and others.

    They are the fronts of the lips; the middle pair touches at rest, as lips that purse part their
    fronts. `width` is the distance between the corners at rest, in units of the model.
    """

    lips: Ints
    """(2, n) of the upper lip and the lower one."""
    chin: Ints
    tongue: Ints
    width: float
    aside: Floats
    """(V,) places of the points to the left of the middle, in units of the model."""

    def measure(self, moved: Floats) -> ShapeReadOut:
        """Measure a shape by its (V, 3) offsets at full weight."""
        above, below = moved[self.lips]
        middle = len(above) // 2
        lips = (above[middle] + below[middle]) / 2
        right, left = (above[end] + below[end] for end in (0, -1))
        chin = moved[self.chin].mean(axis=0)
        ways = np.abs(moved).sum(axis=1)
        inside = moved[self.tongue] if len(self.tongue) else np.zeros((1, 3))
        found = (
            above[middle, 1] - below[middle, 1],
            (left[0] - right[0]) / 2,
            lips[2],
            (left[1] + right[1]) / 4,
            -chin[1],
            max(0.0, inside[:, 2].max() - max(0.0, chin[2], lips[2])),
            max(0.0, inside[:, 1].max() - max(0.0, *above[:, 1], *below[:, 1])),
            self.aside @ ways / (ways.sum() or 1.0),
        )
        return ShapeReadOut(*(float(value / self.width) for value in found))


def read_outs(model: Model) -> Mapping[str, ShapeReadOut]:
    """Measure each shape of a model at full weight, by its name.

    Raises ModelError if the file is damaged, or no shape of it opens a mouth.

    Examples
    --------
    >>> read_outs(read_model(Path("head.glb")))["jawOpen"].aperture  # doctest: +SKIP
    0.62
    """
    rest, shapes = moved_points(model)
    mouth = find_mouth(rest, shapes, model.path)
    return {name: mouth.measure(moved) for name, moved in shapes.items()}


def moved_points(model: Model) -> tuple[Floats, dict[str, Floats]]:
    """Read the (V, 3) points of all meshes with shapes, and the (V, 3) offsets of each shape.

    They stand as the model shows them. A face that looks to the back, as in VRM 0, is turned round.
    """
    arrays = Accessors(model)
    blocks: list[Floats] = []
    moved: dict[str, list[Floats]] = {name: [] for name in model.shape_names}
    for mesh in model.meshes:
        for primitive in model.document["meshes"][mesh.number]["primitives"]:
            arrays.unpack(primitive)
            turn = placed(model, arrays, mesh.number, primitive)
            points = arrays[primitive["attributes"]["POSITION"]]
            blocks.append(points @ turn[:3, :3] + turn[3, :3])
            if (count := sum(map(len, blocks))) > MAX_MEASURED_POINTS:
                raise ModelError(f"{model.path}: {count:,} points are too many to find a mouth in")
            targets = dict(zip(mesh.shapes, primitive["targets"], strict=True))
            for name, own in moved.items():
                at = targets.get(name, {}).get("POSITION")
                own.append(np.zeros_like(blocks[-1]) if at is None else arrays[at] @ turn[:3, :3])
    rest = np.concatenate(blocks)
    shapes = {name: np.concatenate(own) for name, own in moved.items()}
    if bad := [name for name, own in shapes.items() if not np.isfinite(own).all()]:
        raise ModelError(f"{model.path}: an offset of {shortlist(bad)} is not a finite number")
    ways = sum(np.abs(own).sum(axis=1) for own in shapes.values())
    back, front = rest[:, 2].min(), rest[:, 2].max()
    if np.sum(ways) and np.average(rest[:, 2], weights=ways) < back + FRONT_SHARE * (front - back):
        around = np.array([-1.0, 1.0, -1.0])
        return rest * around, {name: own * around for name, own in shapes.items()}
    return rest, shapes


def find_mouth(rest: Floats, shapes: Mapping[str, Floats], path: Path) -> MouthPoints:
    """Find the mouth among (V, 3) points, where a shape that lowers many of them parts them.

    Of several shapes, that which parts them widest wins, and it counts somewhat how many others
    part the same points.
    """
    moving = [moved for moved in shapes.values() if moved.any()]
    moving.sort(key=lambda moved: np.minimum(moved[:, 1], 0.0).sum())
    best, middle = 0.0, rest[:, 0].mean()
    for opened in moving[:TRIED_SHAPES]:
        pairs = _lip_pairs(rest, opened)
        across = rest[pairs, 0].mean(axis=0)
        # A frown on one side parts points of one cheek.
        if not across.size or not across.min() < middle < across.max():
            continue
        parted = np.array([np.abs(np.diff(moved[pairs, 1], axis=0)).max() for moved in moving])
        share = float(np.mean(parted > PARTED_SHARE * parted.max()))
        # A wide hole: lids part less, and hardly any other shape parts those.
        gap = float(-np.diff(opened[pairs, 1], axis=0).min())
        worth = share**0.25 * gap * float(np.ptp(across))
        if worth > best:
            best, found, wide = worth, pairs, opened[:, 1]
            # The search for pairs takes most of the time, and a jaw nearly always comes first.
            if share >= USED_SHARE:
                break
    if not best:
        raise ModelError(f"{path}: no shape opens a mouth")
    line = rest[found].mean(axis=0)
    width, middle = float(np.ptp(line[:, 0])), len(line) // 2
    off = (rest - line[middle]) / width
    found[:, middle] = _touching(rest, wide, found[:, middle], width)
    chin, tongue = (
        np.flatnonzero((np.abs(off - center) < half).all(axis=1))
        for center, half in (CHIN_BOX, TONGUE_BOX)
    )
    return MouthPoints(found, chin if len(chin) else found[1], tongue, width, off[:, 0] * width)


def _touching(rest: Floats, opened: Floats, fronts: Ints, width: float) -> Ints:
    """Return the points of both lips that touch at rest, behind a pair of their fronts."""
    off = (rest - rest[fronts, None]) / width
    behind = (np.abs(off) < LIP_BOX).all(axis=2) & (off[..., 2] <= 0)
    upper, lower = np.abs(opened - opened[fronts, None])
    above, below = map(np.flatnonzero, behind & [upper < lower, lower < upper])
    away = np.linalg.norm(rest[above, None] - rest[below], axis=2)
    first, second = np.unravel_index(away.argmin(), away.shape)
    return np.array([above[first], below[second]])


def _lip_pairs(rest: Floats, opened: Floats) -> Ints:
    """Pair points of both lips, (2, n), from the right corner to the left.

    They are the frontmost of each column, between the corners.
    """
    moving = np.flatnonzero(np.abs(opened).max(axis=1) > 0)
    size = float(np.ptp(rest[moving, 0]))
    if not size:
        return np.empty((2, 0), np.intp)
    near, middle = NEAR_SHARE * size, median(rest[moving, 0].tolist())
    columns = np.round((rest[:, 0] - middle) / near).astype(int)
    found, most = [], 0.0
    # a set, since the first call of `np.unique` imports `numpy.ma` for 10 ms
    for column in sorted(set(columns[moving].tolist())):
        here = np.flatnonzero(columns == column)
        here = here[rest[here, 1].argsort()]
        heights, numbers = rest[here, 1], np.arange(len(here))
        # each point with those a little above it: a square of all points takes ten times as long
        counts = heights.searchsorted(heights + 1.01 * near) - numbers - 1
        steps = np.arange(counts.sum()) - (counts.cumsum() - counts).repeat(counts)
        pair = here[np.stack((numbers.repeat(counts), numbers.repeat(counts) + 1 + steps))]
        parted = opened[pair[0], 1] - opened[pair[1], 1]
        # what is too little here is so in the end
        seen = np.flatnonzero(np.abs(parted) > PARTED_SHARE * most)
        seen = seen[np.linalg.norm(rest[pair[0, seen]] - rest[pair[1, seen]], axis=1) <= near]
        most = max(most, np.abs(parted[seen]).max(initial=0.0))
        found.append((np.where(parted > 0, pair, pair[::-1])[:, seen], np.abs(parted[seen])))
    both = np.concatenate([pair[:, parted > PARTED_SHARE * most] for pair, parted in found], axis=1)
    if not both.size:
        return both
    both = both[:, np.lexsort((*both[::-1], -rest[both, 2].sum(axis=0), columns[both[0]]))]
    fronts = both[:, np.unique(columns[both[0]], return_index=True)[1]]
    apart, seen = (rest[pairs[0], 1] >= rest[pairs[1], 1] for pairs in (both, fronts))
    if apart.any() and 2 * seen.sum() <= seen.size:
        # A shape that curls a lip brings points of it together: the one that rises lies below.
        both = both[:, apart]
        fronts = both[:, np.unique(columns[both[0]], return_index=True)[1]]
    right, left = _corners(rest, opened, both)
    across = rest[np.column_stack((right, fronts, left)), 0].sum(axis=0)
    between = (across > across[0]) & (across < across[-1])
    return np.column_stack((right, fronts[:, between[1:-1]], left))


def _corners(rest: Floats, opened: Floats, pairs: Ints) -> tuple[Ints, Ints]:
    """Return the pairs of lip points at the right corner and the left one, as seen from the front.

    Behind the corners, points of the mouth's inside part as well, farther aside but much deeper.
    Beside them, the skin stretches.
    """
    parted = opened[pairs[0], 1] - opened[pairs[1], 1]
    lips = parted > SKIN_STRETCH * np.linalg.norm(rest[pairs[0]] - rest[pairs[1]], axis=1)
    if lips.any():
        pairs = pairs[:, lips]
    aside, _, depth = rest[pairs].sum(axis=0).T
    right, left = (pairs[:, (side + depth / CORNER_SLOPE).argmax()] for side in (-aside, aside))
    return right, left


@lru_cache(maxsize=8)
def still_by_mesh(model: Model) -> Mapping[str, frozenset[str]]:
    """Return the shapes that move no point of a mesh, by its name; empty if unreadable."""
    found = {}
    try:
        arrays = Accessors(model)
        for mesh in model.meshes:
            parts = model.document["meshes"][mesh.number]["primitives"]
            moving = (_moving(arrays, one, mesh.shapes) for one in parts)
            found[mesh.name] = frozenset(mesh.shapes).difference(*moving)
    except (ModelError, KeyError, TypeError):
        return {}
    return found


def still_shapes(model: Model) -> frozenset[str]:
    """Return the shapes that move no point of any mesh; none if the points cannot be read."""
    still = still_by_mesh(model)
    parts = (set(mesh.shapes) - still.get(mesh.name, frozenset()) for mesh in model.meshes)
    return frozenset(model.shape_names).difference(*parts)


def _moving(arrays: Accessors, primitive: Mapping[str, Any], names: Sequence[str]) -> Iterator[str]:
    """Yield the shapes that move a point of a part of a mesh."""
    pairs = zip(names, primitive["targets"], strict=True)
    offsets = {name: target["POSITION"] for name, target in pairs if "POSITION" in target}
    if offsets:
        points = arrays[primitive["attributes"]["POSITION"]].astype(float)
        least = STILL_SHARE * np.ptp(points, axis=0).max()
        yield from (name for name, at in offsets.items() if np.abs(arrays[at]).max() > least)


@lru_cache(maxsize=8)
def measured(model: Model) -> Mapping[str, ShapeReadOut]:
    """Measure each shape; empty without a mouth, for a damaged model, and for a large one."""
    try:
        return read_outs(model)
    except (ModelError, LookupError, TypeError, ValueError):
        return {}


def unmeasured(model: Model) -> str:
    """Return why `measured` is empty; empty if it is not."""
    try:
        return "" if measured(model) else str(read_outs(model))
    except (ModelError, LookupError, TypeError, ValueError) as error:
        return str(error).removeprefix(f"{model.path}: ")
