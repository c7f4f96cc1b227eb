"""Colours of a head's points, by place: skin with warmer parts, lips, the inner mouth, irises.

Colours are linear, (V, 3). Places are those of the neutral face, in its own units.
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from lipsync_lang.base.arrays import Bools, Floats
from lipsync_lang.base.json_object import Json
from lipsync_lang.plugins.heads.parts import srgb

LIP_EDGE = 0.16
"""Half the width in centimetres over which the lips fade into the skin."""

BROW_REACH = 0.5
"""Half the height of a brow in centimetres."""


def painted(points: Floats, on: dict[str, Bools], recipe: Json) -> Floats:
    """Paint (V, 3) points; `on` marks the points of each surface."""
    surfaces = recipe["surfaces"]
    colors = np.ones((len(points), 3))
    for name, mask in on.items():
        colors[mask] = linear(surfaces[name]["color"])
    skin = _skin(points, recipe)
    lips = lip_share(points, recipe)[:, None]
    skin = skin * (1 - lips) + linear(recipe["lips"]["color"]) * lips
    colors[on["skin"]] = skin[on["skin"]]
    mouth = on["mouth"] & ~on["skin"]
    deep = ramp(10.9, 9.7, points[:, 2])[:, None]
    inner = linear(recipe["lips"]["color"]) * (1 - deep) + colors * deep * _gloom(points)[:, None]
    colors[mouth] = inner[mouth]
    for name in ("gums", "tongue", "teeth"):
        colors[on[name]] *= _gloom(points)[on[name], None]
    colors[on["eyes"]] *= (1 - 0.35 * ramp(9.4, 8.2, points[:, 2]))[on["eyes"], None]
    colors[on["irises"]] = _irises(points, recipe)[on["irises"]]
    return colors


def linear(code: str) -> Floats:
    """Convert a web colour to (3,) linear values."""
    return np.array(srgb(code)[:3])


def ramp(low: float, high: float, x: Floats) -> Floats:
    """Rise from 0 at `low` to 1 at `high` in an S; with low > high it falls."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def brow_way(points: Floats, recipe: Json) -> tuple[Floats, Floats]:
    """Return the distance of each point from the brows, and how far inwards on them it lies."""
    far, along = np.full(len(points), np.inf), np.zeros(len(points))
    for line in recipe["brows"]["lines"]:
        knots = points[line]
        for number, (a, b) in enumerate(pairwise(knots)):
            share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
            apart = np.linalg.norm(points - a - share[:, None] * (b - a), axis=1)
            nearer = apart < far
            far[nearer] = apart[nearer]
            along[nearer] = ((number + share) / (len(knots) - 1))[nearer]
    return far, along


def _skin(points: Floats, recipe: Json) -> Floats:
    """Paint skin: warmer at cheeks, nose and ears, darker around the eyes and in the brows."""
    x, y, z = np.abs(points[:, 0]), points[:, 1], points[:, 2]

    def spot(centre: Sequence[float], size: float) -> Floats:
        away = np.stack([x, y, z], 1) - np.array(centre)
        return np.exp(-np.sum(away**2, axis=1) / size**2)

    warm = 0.34 * spot((4.6, -0.4, 9.0), 2.4) + 0.3 * spot((0, 0.2, 12.8), 1.3)
    warm += 0.14 * spot((0, -7.0, 10.5), 1.8) + 0.3 * ramp(7.0, 8.0, x) * ramp(-7, -2, y)
    warm += 0.22 * np.exp(-(((x - 3.1) / 2.1) ** 2) - ((y - 3.6) / 1.1) ** 2) * ramp(7, 8, z)
    base = linear(recipe["surfaces"]["skin"]["color"])
    found = base + np.clip(warm, 0, 0.6)[:, None] * (linear(recipe["colors"]["blush"]) - base)
    around = np.exp(-(((x - 3.1) / 1.9) ** 2) - ((y - 3.4) / 1.3) ** 2) * ramp(7, 8, z)
    found *= 1 - 0.16 * around[:, None]
    far, along = brow_way(points, recipe)
    cover = 0.9 * ramp(BROW_REACH, 0.15, far) * (0.5 + 0.5 * ramp(0, 0.3, along))
    return found + cover[:, None] * (linear(recipe["colors"]["brows"]) - found)


def lip_share(points: Floats, recipe: Json) -> Floats:
    """Return how much of each point is lip, seen from the front."""
    ring = points[recipe["lips"]["outer"]][:, :2]
    at = points[:, :2]
    far, inside = np.full(len(at), np.inf), np.zeros(len(at), bool)
    for a, b in zip(ring, np.roll(ring, -1, axis=0), strict=True):
        share = np.clip((at - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        far = np.minimum(far, np.linalg.norm(at - a - share[:, None] * (b - a), axis=1))
        with np.errstate(divide="ignore", invalid="ignore"):
            cross = a[0] + (at[:, 1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
        inside ^= ((a[1] > at[:, 1]) != (b[1] > at[:, 1])) & (at[:, 0] < cross)
    signed = np.where(inside, -far, far)
    return ramp(LIP_EDGE, -LIP_EDGE, signed) * ramp(8.0, 9.0, points[:, 2])


def _gloom(points: Floats) -> Floats:
    """Return the light that reaches points in the mouth: less farther back."""
    return 0.25 + 0.75 * ramp(4.5, 10.3, points[:, 2])


def _irises(points: Floats, recipe: Json) -> Floats:
    """Paint rings around the middle of each eye: pupil, iris, and its dark rim."""
    eye = recipe["eye"]
    off = np.stack([np.abs(points[:, 0]), points[:, 1]], 1) - np.array(eye["center"])
    out = np.linalg.norm(off, axis=1) / eye["radius"]
    rays = 1 + 0.12 * np.sin(17 * np.arctan2(off[:, 1], off[:, 0]))
    light = (0.75 + 0.5 * ramp(0.9, eye["pupil"], out)) * rays
    light *= 1 - 0.75 * ramp(eye["limbus"], 1.0, out)
    found: Floats = linear(recipe["surfaces"]["irises"]["color"]) * light[:, None]
    black = ramp(eye["pupil"] + 0.03, eye["pupil"] - 0.03, out)[:, None]
    found += black * (linear(recipe["colors"]["pupil"]) - found)
    return found
