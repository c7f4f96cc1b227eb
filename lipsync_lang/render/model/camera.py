"""From where a model is looked at: a bust of who speaks, from the front."""

from dataclasses import dataclass

import numpy as np

from lipsync_lang.render.model.gltf import Floats
from lipsync_lang.render.model.scene import Scene

FIELD = 24.0
"""Degrees from the lower edge of a picture to the upper one."""

ROOM = 1.06
"""How much more than the head a picture shows."""

BUST = 5.0
"""Of a body, a picture shows this many times the height of what moves."""

MOVED = 0.1
"""Of the largest movement; what moves less is no part of the mouth."""

SIDE = 0.4
"""Of a model's depth: what moves is not nearer to its back than this."""


@dataclass(frozen=True)
class Camera:
    """An eye at a distance from what it looks at.

    Parameters
    ----------
    middle : (3,) what it looks at
    turn : (3, 3) rows: where the model's axes go, seen from the eye: x right, y up, z to it
    distance : of the eye from there, in the model's units
    half : as far as it sees around there, in all directions
    """

    middle: Floats
    turn: Floats
    distance: float
    half: float

    def see(self, points: Floats, size: int) -> tuple[Floats, Floats]:
        """Project points on a picture of `size` by `size` samples.

        Returns
        -------
        (V, 2) columns and rows; (V,) 1 / distance from the eye, not above 0 where it is behind it
        """
        seen = (points - self.middle) @ self.turn
        depth = self.distance - seen[:, 2]
        near = np.where(depth > self.distance / 100, 1 / np.where(depth, depth, 1.0), 0.0)
        scale = size / 2 / np.tan(np.radians(FIELD / 2))
        flat = seen[:, :2] * near[:, None] * scale * (1, -1) + size / 2 - 0.5
        return flat, near


def framed(scene: Scene) -> Camera:
    """Look at the head that speaks, or at as much of a body as shows how it does.

    The front is glTF's own, unless what moves faces the other way, as in some models it does.
    """
    low, high = _box(scene)
    middle = (low + high) / 2
    half = max(high[:2] - low[:2]) / 2 * ROOM
    turn = np.diag([-1.0, 1.0, -1.0]) if _faces_back(scene) else np.eye(3)
    distance = half / np.tan(np.radians(FIELD / 2)) + (high[2] - low[2]) / 4
    return Camera(middle, turn, float(distance), float(half))


def _box(scene: Scene) -> tuple[Floats, Floats]:
    """Return the least and greatest (3,) of what is looked at."""
    moved = scene.moves >= MOVED * scene.moves.max()
    mouth = scene.rest[moved]
    whole = scene.rest[np.isin(scene.shown_by, scene.shown_by[moved])]
    low, high = whole.min(axis=0), whole.max(axis=0)
    wanted = BUST * float(np.ptp(mouth[:, 1]))
    if wanted >= high[1] - low[1]:
        return low, high
    middle = mouth.min(axis=0) / 2 + mouth.max(axis=0) / 2
    middle[1] += wanted * 0.1
    room = np.array([wanted / 2, wanted / 2, np.inf])
    return np.maximum(low, middle - room), np.minimum(high, middle + room)


def _faces_back(scene: Scene) -> bool:
    """Tell whether what moves is on the far side of its model's middle."""
    back, front = scene.rest[:, 2].min(), scene.rest[:, 2].max()
    mouth = np.average(scene.rest[:, 2], weights=scene.moves)
    return bool(mouth < back + SIDE * (front - back))
