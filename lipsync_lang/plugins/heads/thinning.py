"""Thin a mesh: points are merged into neighbours where that changes its look least.

A kept point stays where it is, so its shapes and its colour hold exactly. The cost of merging v
into u is the distance of u from the planes around v, squared, times their areas, over some poses::

    cost(v, u) = sum over poses and planes n of v: area (n . (u - v))^2

as in quadric error metrics without memory (Lindstrom and Turk 1998). Points on the border of a
surface stay. Each round merges points that lie apart, so the arrays change at once.
"""

from dataclasses import dataclass, replace

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats, Ints

LENGTH_WEIGHT = 0.003
"""Weight of the length of an edge, so that flat parts thin evenly."""

TINTED = 0.6
"""Weight of a change of colour."""

CHEAPEST = 0.6
"""Share of the points that may go in one round."""

UPRIGHT = 0.25
"""Smallest cosine between the normals of a triangle before and after."""


@dataclass(frozen=True, eq=False)
class Web:
    """A mesh of V points and F triangles that can be thinned."""

    poses: Floats
    """(K, V, 3) positions in the poses that count."""
    triangles: Ints
    """(F, 3) point numbers."""
    surface: Ints
    """(F,) number of the surface of each triangle."""
    colors: Floats
    """(V, 3)"""
    worth: Floats
    """(V,) factor of the cost of each point."""

    @property
    def count(self) -> int:
        """Number of points that a triangle uses."""
        return len(np.unique(self.triangles))


def thin(web: Web, goal: int) -> Web:
    """Merge points until at most `goal` are left, or none can go."""
    barred = np.zeros(web.poses.shape[1], bool)
    while (left := web.count) > goal:
        tried, gone, target = _merges(web, barred, left - goal)
        if not len(tried):
            break
        barred[np.setdiff1d(tried, gone)] = True  # otherwise they hold up their neighbours
        into = np.arange(web.poses.shape[1])
        into[gone] = target
        triangles = into[web.triangles]
        a, b, c = triangles.T
        whole = (a != b) & (b != c) & (c != a)
        web = replace(web, triangles=triangles[whole], surface=web.surface[whole])
    return web


def _merges(web: Web, barred: Bools, most: int) -> tuple[Ints, Ints, Ints]:
    """Choose points to try in one round, those that can go, and the neighbour of each."""
    edges, pinned = _edges(web)
    source, end = np.concatenate([edges, edges[:, ::-1]]).T
    cost = _costs(web, source, end)
    cost[(pinned | barred)[source]] = np.inf
    # The last key of `lexsort` counts first: the edges of a source, the cheapest first.
    order = np.lexsort((cost, source))
    source, end, cost = source[order], end[order], cost[order]
    first = np.flatnonzero(np.diff(source, prepend=-1))
    count = web.poses.shape[1]
    least, best = np.full(count, np.inf), np.zeros(count, np.intp)
    least[source[first]], best[source[first]] = cost[first], end[first]
    finite = least[np.isfinite(least)]
    if not len(finite):
        return best[:0], best[:0], best[:0]
    least[least > np.quantile(finite, CHEAPEST)] = np.inf
    least += np.arange(count) * 1e-15  # no two alike
    around = least
    for _ in range(2):  # points two edges away stay, so merges do not meet
        wider = around.copy()
        np.minimum.at(wider, edges[:, 0], around[edges[:, 1]])
        np.minimum.at(wider, edges[:, 1], around[edges[:, 0]])
        around = wider
    gone = np.flatnonzero((least <= around) & np.isfinite(least))
    tried = gone[np.argsort(least[gone])][:most]
    gone = tried[_joined_twice(edges, tried, best[tried], count)]
    gone = gone[_upright(web, gone, best[gone])]
    return tried, gone, best[gone]


def _edges(web: Web) -> tuple[Ints, Bools]:
    """List the edges, (E, 2), and mark points on the border of a surface, (V,)."""
    corners = web.triangles
    every = np.concatenate([corners[:, [0, 1]], corners[:, [1, 2]], corners[:, [2, 0]]])
    every.sort(axis=1)
    owner = np.tile(web.surface, 3)
    keys = every[:, 0] * web.poses.shape[1] + every[:, 1]  # far quicker than rows
    _, first, which, uses = np.unique(
        keys, return_index=True, return_inverse=True, return_counts=True
    )
    edges = every[first]
    low, high = np.full(len(edges), np.iinfo(np.intp).max), np.full(len(edges), -1)
    np.minimum.at(low, which, owner)
    np.maximum.at(high, which, owner)
    pinned = np.zeros(web.poses.shape[1], bool)
    pinned[edges[(uses != 2) | (low != high)]] = True  # noqa: PLR2004 sides of an edge
    return edges, pinned


def _costs(web: Web, source: Ints, end: Ints) -> Floats:
    """Compute the cost of merging the source of each edge into its end."""
    corners, count = web.triangles, web.poses.shape[1]
    total = np.zeros(len(source))
    for points in web.poses:
        a, b, c = (points[corners[:, i]] for i in range(3))
        normal = np.cross(b - a, c - a)
        area = np.linalg.norm(normal, axis=1)
        # The 3 x 3 forms of planes add up, so a point keeps one for all planes around it.
        plane = np.einsum("fi,fj->fij", normal, normal).reshape(-1, 9)
        plane /= np.maximum(area, 1e-12)[:, None]
        flat, around = corners.ravel(), np.repeat(plane, 3, axis=0)
        sums = np.stack([np.bincount(flat, around[:, i], count) for i in range(9)], 1)
        way = points[end] - points[source]
        total += np.einsum("ei,eij,ej->e", way, sums[source].reshape(-1, 3, 3), way)
        areas = np.bincount(flat, np.repeat(area, 3), count)
        tint = np.sum((web.colors[end] - web.colors[source]) ** 2, axis=1)
        total += areas[source] * (LENGTH_WEIGHT * np.sum(way**2, axis=1) + TINTED * tint)
    return total * web.worth[source]


def _joined_twice(edges: Ints, gone: Ints, target: Ints, count: int) -> Bools:
    """Test for two common neighbours of each pair: with more, the mesh would fold onto itself."""
    both = np.concatenate([edges, edges[:, ::-1]])
    both = both[np.argsort(both[:, 0], kind="stable")]
    starts = np.searchsorted(both[:, 0], np.arange(count + 1))
    near = [set(both[starts[p] : starts[p + 1], 1].tolist()) for p in gone]
    other = [set(both[starts[p] : starts[p + 1], 1].tolist()) for p in target]
    return np.array([len(a & b) == 2 for a, b in zip(near, other, strict=True)], bool)  # noqa: PLR2004 as at any edge


def _upright(web: Web, gone: Ints, target: Ints) -> Bools:
    """Test that no triangle around a merged point turns over, in any pose."""
    into = np.full(web.poses.shape[1], -1)
    into[gone] = target
    moved = np.flatnonzero((into[web.triangles] >= 0).any(axis=1))
    before = web.triangles[moved]
    after = np.where(into[before] >= 0, into[before], before)
    a, b, c = after.T
    whole = (a != b) & (b != c) & (c != a)
    turned = np.zeros(len(moved), bool)
    for points in web.poses:
        old, new = (
            np.cross(
                points[rows[:, 1]] - points[rows[:, 0]], points[rows[:, 2]] - points[rows[:, 0]]
            )
            for rows in (before, after)
        )
        size = np.linalg.norm(old, axis=1) * np.linalg.norm(new, axis=1)
        turned |= np.einsum("fi,fi->f", old, new) < UPRIGHT * size
    wrong = np.zeros(web.poses.shape[1], bool)
    wrong[before[turned & whole]] = True
    return ~wrong[gone]
