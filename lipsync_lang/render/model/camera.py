"""Camera for a model: a bust portrait of the speaker from the front."""

from dataclasses import dataclass

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.render.model.scene import MOMENTS, Scene

FIELD_DEGREES = 24.0
"""Vertical field of view in degrees."""

ROOM = 1.06
"""Size of the frame relative to the head."""

BUST = 5.0
"""Height of the frame relative to the moving region, for a model with a body."""

MOVED = 0.1
"""Fraction of the largest movement; points that move less do not count as the mouth."""

MOUTH = 0.5
"""Fraction of the largest mean movement over all shapes; nearly every shape moves the lips, few the
chin."""

CLOSE = 1.15
"""Size of the frame of a close-up relative to the lips."""

SIDE = 0.4
"""Fraction of the model's depth: minimum distance of the moving region from the back."""


@dataclass(frozen=True)
class Camera:
    """An eye at a fixed distance from its target, the `middle`, in the model's units.

    `turn` rotates the model's axes into eye axes, as rows: x right, y up, z to the eye. `half` is
    half the side of the visible square at the target.
    """

    middle: Floats
    turn: Floats
    distance: float
    half: float

    def see(self, points: Floats, size: int) -> tuple[Floats, Floats]:
        """Project points onto a picture: (V, 2) columns and rows, and (V,) 1 / distance."""
        seen = (points - self.middle) @ self.turn
        depth = self.distance - seen[:, 2]
        # Points at the eye or behind it have no place on the picture; 0 marks them.
        near = np.where(depth > self.distance / 100, 1 / np.where(depth, depth, 1.0), 0.0)
        scale = size / 2 / np.tan(np.radians(FIELD_DEGREES / 2))
        flat = seen[:, :2] * near[:, None] * scale * (1, -1) + size / 2 - 0.5
        return flat, near


def framed(scene: Scene) -> Camera:
    """Frame the speaking head, or the upper part of a body with the mouth in view.

    The front follows glTF's convention unless the moving points lie on the opposite side, because
    some models are exported backwards.
    """
    moved = scene.moves >= MOVED * scene.moves.max()
    whole = scene.rest[np.isin(scene.shown_by, scene.shown_by[moved])]
    low, high = whole.min(axis=0), whole.max(axis=0)
    mouth = scene.rest[moved]
    wanted = BUST * float(np.ptp(mouth[:, 1]))
    if wanted < high[1] - low[1]:  # a body
        middle = mouth.min(axis=0) / 2 + mouth.max(axis=0) / 2
        middle[1] += wanted * 0.1
        room = np.array([wanted / 2, wanted / 2, np.inf])
        low, high = np.maximum(low, middle - room), np.minimum(high, middle + room)
    back, front = scene.rest[:, 2].min(), scene.rest[:, 2].max()
    # The moving points are the mouth: on a head that faces us, they are far from the back.
    faces_back = np.average(scene.rest[:, 2], weights=scene.moves) < back + SIDE * (front - back)
    turn = np.diag([-1.0, 1.0, -1.0]) if faces_back else np.eye(3)
    return _around(low, high, turn, ROOM)


def close_up(swept: Scene) -> Camera:
    """Frame the mouth from the front, by a movement of one shape after the other, 1 s each."""
    times = np.unique(np.linspace(1.0, swept.seconds, MOMENTS).round())
    stir = np.mean([np.abs(swept.points(time) - swept.rest).sum(axis=1) for time in times], axis=0)
    mouth = swept.rest[stir >= MOUTH * stir.max()]
    return _around(mouth.min(axis=0), mouth.max(axis=0), framed(swept).turn, CLOSE)


def _around(low: Floats, high: Floats, turn: Floats, room: float) -> Camera:
    """Frame a box by its corners; the frame has `room` times its size."""
    half = max(high[:2] - low[:2]) / 2 * room
    distance = half / np.tan(np.radians(FIELD_DEGREES / 2)) + (high[2] - low[2]) / 4
    return Camera((low + high) / 2, turn, float(distance), float(half))
