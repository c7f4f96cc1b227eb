"""Points and faces of Wavefront OBJ files; a fault is named with its line."""

from itertools import pairwise
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np

from lipsync_lang import ModelError
from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.base.files import read_input

MAX_OBJ_BYTES = 64 * 2**20
"""Size limit in bytes of an OBJ file."""


def obj_points(path: Path, count: int | None = None) -> Floats:
    """Read the points of a file, (V, 3); with `count`, it must have as many."""
    rows = _rows(path, b"v ")
    try:
        # All numbers at once, because a row at a time takes far longer. Some programs write a
        # colour after each point.
        found = np.array(b" ".join(rows).split(), float).reshape(len(rows), -1)[:, :3]
    except ValueError:
        found = np.zeros((0, 0))
    if found.shape[1] != 3:  # noqa: PLR2004 of space
        _tell_line(path, b"v ", 3)
    if count is not None and len(found) != count:
        raise ModelError(f"{path}: has {len(found):,} points instead of {count:,}; clone it again")
    if not np.isfinite(found).all():
        raise ModelError(f"{path}: has a point that is not finite; clone or export it again")
    return found


class ObjMesh(NamedTuple):
    """A mesh of V points and F triangles, with texture coordinates (V, 2); nan if it has none."""

    points: Floats
    triangles: Ints
    """(F, 3) point numbers."""
    faces: Ints
    """(F,) number of the face of each triangle in the file."""
    places: Floats


def obj_mesh(path: Path, count: int | None = None) -> ObjMesh:
    """Read points, and faces of three or more corners; with `count`, it has so many points."""
    points = obj_points(path, count)
    try:
        uv = np.array([row.split()[:2] for row in _rows(path, b"vt")], float).reshape(-1, 2)
    except ValueError:
        _tell_line(path, b"vt", 2)
    places = np.full((len(points), 2), np.nan)
    triangles, faces = [], []
    for face, row in enumerate(_rows(path, b"f ")):
        try:
            corners = [[int(n or 0) for n in corner.split(b"/")] for corner in row.split()]
        except ValueError:
            corners = []
        # Points are counted from 1, and negative ones back from the last.
        ring = [one[0] - 1 if one[0] > 0 else len(points) + one[0] for one in corners]
        if len(ring) < 3 or not all(0 <= corner < len(points) for corner in ring):  # noqa: PLR2004 of a triangle
            shown = row[:40].decode("latin-1").strip()
            what = f"face {face + 1} ('{shown}') does not name three of its {len(points):,} points"
            raise ModelError(f"{path}: {what}; export or clone it again")
        for corner, one in zip(ring, corners, strict=True):
            if len(one) > 1 and 0 < one[1] <= len(uv):
                places[corner] = uv[one[1] - 1]
        # A fan around the first corner, which is right for convex faces alone.
        triangles += [(ring[0], *pair) for pair in pairwise(ring[1:])]
        faces += [face] * (len(ring) - 2)
    if not triangles:
        raise ModelError(f"{path}: has no faces; export it as a mesh")
    return ObjMesh(points, np.array(triangles), np.array(faces), places)


def obj_comment(path: Path) -> str:
    """Read the comment at the head of a file, which holds its licence."""
    with path.open("rb") as stream:
        head = stream.read(2**14).decode("utf-8", "replace").splitlines()
    lines = []
    for line in head:
        if line and not line.startswith("#"):
            break
        lines.append(line.strip("# "))
    return "\n".join(lines).strip()


def _rows(path: Path, start: bytes) -> list[bytes]:
    data = read_input(path, MAX_OBJ_BYTES, error=ModelError, mend="export it with fewer points")
    return [line[2:] for line in data.splitlines() if line.startswith(start)]


def _tell_line(path: Path, start: bytes, width: int) -> NoReturn:
    """Raise an error at the first line that does not hold numbers."""
    data = read_input(path, MAX_OBJ_BYTES, error=ModelError, mend="export it with fewer points")
    for number, line in enumerate(data.splitlines(), 1):
        if line.startswith(start):
            try:
                values = [float(value) for value in line[2:].split()]
            except ValueError:
                values = []
            if len(values) < width:
                shown = line[:40].decode("latin-1")
                raise ModelError(
                    f"{path}:{number}: '{shown}' does not hold {width} numbers; clone it again"
                )
    raise ModelError(f"{path}: its points do not all have as many numbers; clone it again")
