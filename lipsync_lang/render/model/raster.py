"""Triangle rasteriser: the visible triangle of each sample.

Coordinates are samples from the upper left corner, x to the right and y down; samples lie at whole
coordinates. Depth is 1 / distance: it is linear across a triangle, and larger values are nearer.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.arrays import Bools, Floats, Ints, Singles
from lipsync_lang.pipeline import kernel

DepthKeys = npt.NDArray[np.uint64]

MIN_RISE = 1e-9
"""Minimum rise of an edge in samples; flatter edges cross no row."""

MIN_AREA = 1e-6
"""Minimum area in samples; smaller triangles are invisible."""


class Window(NamedTuple):
    """A rectangle of a picture: first column and row, and exclusive last ones."""

    left: int
    top: int
    right: int
    bottom: int

    @property
    def width(self) -> int:
        """Number of columns."""
        return self.right - self.left


class Samples(NamedTuple):
    """Columns, rows and triangles of n covered samples, (n,) each."""

    x: Ints
    y: Ints
    triangle: Ints


def planes(corners: Floats, values: Floats) -> Floats:
    """Compute the linear functions of values across triangles.

    Of corners (F, 3, 2) of non-zero area, with values (F, 3, k), the functions are (F, 3, k):
    ``p[0] + p[1] * x + p[2] * y``.
    """
    (ax, ay), (bx, by) = ((corners[:, n] - corners[:, 0]).T[..., None] for n in (1, 2))
    a, b = (values[:, n] - values[:, 0] for n in (1, 2))
    area = ax * by - bx * ay
    along, down = (a * by - b * ay) / area, (b * ax - a * bx) / area
    x, y = corners[:, 0].T[..., None]
    return np.stack([values[:, 0] - along * x - down * y, along, down], axis=1)


def area(corners: Floats) -> Floats:
    """Compute twice the signed area of triangles, (F,); left turns are negative."""
    (ax, ay), (bx, by) = ((corners[:, n] - corners[:, 0]).T for n in (1, 2))
    return ax * by - bx * ay


def fill(  # noqa: PLR0913, PLR0917 the buffers and a triangle
    keys: DepthKeys,
    window: Window,
    corners: Floats,
    depth: Floats,
    names: Ints,
    seen: Callable[[Samples], Bools] | None = None,
) -> None:
    """Rasterise triangles into samples with a depth test.

    Parameters
    ----------
    keys : (rows * columns,) depth and name of a window, at first 0; changed in place; see `shown`
    corners : (F, 3, 2), of non-zero area
    depth : (F, 3) above 0
    names : (F,) numbers of the triangles, below 2**32
    seen : predicate that masks visible samples; by default, all are visible
    """
    if seen is None and kernel.compiled is not None:
        kernel.compiled.fill(keys, *window, corners, depth, names)
        return
    triangle, y, first, stop = _spans(corners, window)
    base, along, down = planes(corners, depth[..., None])[..., 0].T
    start = base[triangle] + along[triangle] * first + down[triangle] * y
    place = (y - window.top) * window.width + first - window.left
    span, step = _spread(stop - first)
    # Positive floats compare like their bits, so depth and name fit into one integer, and one
    # `maximum` does both the depth test and the write.
    near = start.astype("<f4")[span]
    near += along.astype("<f4")[triangle][span] * step
    new = near.view("<u4").astype("<u8") << 32 | (names[triangle] + 1).astype("<u8")[span]
    where = place[span] + step
    if seen is not None:
        some = seen(Samples(first[span] + step, y[span], triangle[span]))
        new, where = new[some], where[some]
    np.maximum.at(keys, where, new)


def shown(keys: DepthKeys) -> Ints:
    """Extract the triangle numbers of samples; negative for empty ones."""
    return (keys & np.uint64(0xFFFFFFFF)).astype(np.intp) - 1


def depths(keys: DepthKeys) -> Singles:
    """Extract the depth of samples; 0 for empty ones."""
    return (keys >> np.uint64(32)).astype("<u4").view("<f4")


def _spans(corners: Floats, window: Window) -> tuple[Ints, Ints, Ints, Ints]:
    """Compute the covered samples row by row: triangle, row, first, past the last.

    A span lies between the longest edge and the chain of the other two. A sample on an edge counts
    only for the triangle on its right or lower side, so neighbours share none. Interpolation starts
    at the upper end of each edge, so that neighbours agree to the last bit.
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
    """Compute the crossings of edges, given by number, with rows."""
    across, rise = (stops - starts).T
    slope = across / np.where(rise < MIN_RISE, 1.0, rise)
    return starts[edge, 0] + slope[edge] * (y - starts[edge, 1])


def _whole(values: Floats, least: int, most: int) -> Ints:
    """Round up to whole numbers, within bounds."""
    return np.ceil(values).clip(least, most).astype(np.intp)


def _spread(counts: Ints) -> tuple[Ints, Ints]:
    """Expand counts: the owner of each item, and its number within the owner from 0."""
    counts = np.maximum(counts, 0)
    owners = np.repeat(np.arange(len(counts)), counts)
    return owners, np.arange(len(owners)) - (np.cumsum(counts) - counts)[owners]
