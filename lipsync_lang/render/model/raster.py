"""Filling triangles: which of them each sample of a picture shows.

Coordinates are samples from the upper left corner, x to the right and y down; a sample lies where
both are whole. Depth is 1 / distance, which is linear across a triangle: the larger is in front.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.intp]
Bools = npt.NDArray[np.bool_]
Keys = npt.NDArray[np.uint64]

LEVEL = 1e-9
"""Samples that an edge rises; with less it crosses no row."""

LEAST = 1e-6
"""Samples of area; a smaller triangle has no place in a picture."""


class Window(NamedTuple):
    """A part of a picture: from its first column and row up to its last ones, without these."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def width(self) -> int:
        """How many columns it has."""
        return self.right - self.left


class Samples(NamedTuple):
    """(n,) samples that triangles cover: columns, rows, triangles."""

    x: Ints
    y: Ints
    triangle: Ints


def planes(corners: Floats, values: Floats) -> Floats:
    """Return how values change across triangles.

    Parameters
    ----------
    corners : (F, 3, 2), of some area
    values : (F, 3, k) at the corners

    Returns
    -------
    (F, 3, k): ``p[0] + p[1] * x + p[2] * y``
    """
    (ax, ay), (bx, by) = ((corners[:, n] - corners[:, 0]).T[..., None] for n in (1, 2))
    a, b = (values[:, n] - values[:, 0] for n in (1, 2))
    area = ax * by - bx * ay
    along, down = (a * by - b * ay) / area, (b * ax - a * bx) / area
    x, y = corners[:, 0].T[..., None]
    return np.stack([values[:, 0] - along * x - down * y, along, down], axis=1)


def area(corners: Floats) -> Floats:
    """Return (F,) twice the areas of triangles; those that turn to the left are below zero."""
    (ax, ay), (bx, by) = ((corners[:, n] - corners[:, 0]).T for n in (1, 2))
    found: Floats = ax * by - bx * ay
    return found


def fill(  # noqa: PLR0913, PLR0917 a triangle has no less to it
    keys: Keys,
    window: Window,
    corners: Floats,
    depth: Floats,
    names: Ints,
    seen: Callable[[Samples], Bools] | None = None,
) -> None:
    """Let samples show triangles, where nothing nearer is there.

    Parameters
    ----------
    keys : (rows * columns,) of a window, at first 0; changed in place, and read by `shown`
    corners : (F, 3, 2), of some area
    depth : (F, 3) above 0
    names : (F,) below 2**32
    seen : tells of which samples there is something to be seen; by default, of all
    """
    triangle, y, first, stop = _spans(corners, window)
    base, along, down = planes(corners, depth[..., None])[..., 0].T
    start = base[triangle] + along[triangle] * first + down[triangle] * y
    place = (y - window.top) * window.width + first - window.left
    span, step = _spread(stop - first)
    near = start.astype("<f4")[span]
    near += along.astype("<f4")[triangle][span] * step
    made = np.empty((len(near), 2), "<u4")  # the low half of a key, then the high one
    made[:, 0] = (names[triangle] + 1).astype("<u4")[span]
    made[:, 1] = near.view("<u4")
    new, where = made.view("<u8")[:, 0], place[span] + step
    if seen is not None:
        some = seen(Samples(first[span] + step, y[span], triangle[span]))
        new, where = new[some], where[some]
    np.maximum.at(keys, where, new)


def shown(keys: Keys) -> Ints:
    """Return the names of the triangles that samples show; below 0 where there are none."""
    return (keys & np.uint64(0xFFFFFFFF)).astype(np.intp) - 1


def depths(keys: Keys) -> npt.NDArray[np.float32]:
    """Return the depth of samples; 0 where they show nothing."""
    return (keys >> np.uint64(32)).astype("<u4").view("<f4")


def _spans(corners: Floats, window: Window) -> tuple[Ints, Ints, Ints, Ints]:
    """Return the samples that triangles cover, row by row: triangle, row, first, past the last.

    They lie between the longest of the edges, downwards, and the other two, one below the other.
    A sample on an edge is on its right and lower side only, so that neighbours share none; that
    they agree to the last bit, each edge is followed from its upper end.
    """
    order = np.argsort(corners[..., 1], axis=1)[..., None]
    upper, middle, lower = np.take_along_axis(corners, order, axis=1).swapaxes(0, 1)
    top, bottom = (_whole(end[:, 1], window.top, window.bottom) for end in (upper, lower))
    triangle, step = _spread(bottom - top)
    y = top[triangle] + step
    second = 2 * triangle + (y >= middle[triangle, 1])
    starts, stops = (
        np.stack(ends, axis=1).reshape(-1, 2) for ends in ((upper, middle), (middle, lower))
    )
    sides = (_crossing(upper, lower, triangle, y), _crossing(starts, stops, second, y))
    first = _whole(np.minimum(*sides), window.left, window.right)
    return triangle, y, first, _whole(np.maximum(*sides), window.left, window.right)


def _crossing(starts: Floats, stops: Floats, edge: Ints, y: Ints) -> Floats:
    """Return where edges, given by their numbers, cross rows."""
    across, rise = (stops - starts).T
    slope = across / np.where(rise < LEVEL, 1.0, rise)
    found: Floats = starts[edge, 0] + slope[edge] * (y - starts[edge, 1])
    return found


def _whole(values: Floats, least: int, most: int) -> Ints:
    """Return the next whole numbers, within bounds."""
    return np.ceil(values).clip(least, most).astype(np.intp)


def _spread(counts: Ints) -> tuple[Ints, Ints]:
    """Return an owner for each of some things that are counted, and its number there from 0."""
    counts = np.maximum(counts, 0)
    owners = np.repeat(np.arange(len(counts)), counts)
    return owners, np.arange(len(owners)) - (np.cumsum(counts) - counts)[owners]
