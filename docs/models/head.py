r"""Build the head that shows the FaceFX speech poses: one morph target for each pose.

A few more are for lids, brows and eyes, which gestures move, and for the lips of styles.

    python docs/models/head.py [posesets/facefx/model.glb]

The picture of its poses, docs/images/facefx-poses.png, then has its colours reduced to 256:

    node docs/models/sheet.mjs posesets/facefx/model.glb facefx-poses.png --size 280 \
        --focus 0,-0.058,0.08,0.036 --poses "neutral; open; W; ShCh; PBM; FV; wide; \
        tBack, open=0.5; tRoof, open=0.5; tTeeth, open=0.4"

The skin is one sheet. Its edge loops are ellipses about the line between the lips, so that they
turn into circles farther out; they lie where rays from inside the head meet a soft sum of simple
solids. At the lips the sheet turns inwards and becomes the pocket that holds teeth and tongue.

Lengths are centimetres until the end. The middle of the head is the origin, y is up, the face looks
along +z, and "left" is the side of +x.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import mesh
import numpy as np
from mesh import Part, bump, smoothstep, srgb

if TYPE_CHECKING:
    from mesh import Points
    from numpy.typing import NDArray

OUT = Path(__file__).parents[2] / "posesets/facefx/model.glb"
TARGETS = ["open", "W", "ShCh", "PBM", "FV", "wide", "tBack", "tRoof", "tTeeth"]
GESTURES = ["blink", "browUp", "eyesLeft", "eyesRight"]
POSTURES = ["smileLeft", "smileRight", "frownLeft", "frownRight", "sneerLeft", "sneerRight"]

SKIN = srgb("#f3c3a3")
LIP = srgb("#e59a8c")
POCKET = srgb("#6b2226")
TONGUE = srgb("#e0757a")
GUM = srgb("#d97f80")
TOOTH = srgb("#fffaf0")
EYEBALL = srgb("#fdfbf7")
IRIS = srgb("#5aa59b")
PUPIL = srgb("#1d1512")
HAIR = srgb("#7d4126")
LASH = srgb("#3a2018")
WOOL = srgb("#3f8f94")


# --- the solid that the skin lies on


def norm(points: Points) -> Points:
    """The length of each vector."""
    return np.linalg.norm(points, axis=-1)


def ellipsoid(p: Points, centre: tuple[float, ...], radii: tuple[float, ...]) -> Points:
    """About the distance of each point from an ellipsoid, negative inside."""
    offset = p - np.array(centre)
    k0 = norm(offset / np.array(radii))
    k1 = norm(offset / np.array(radii) ** 2)
    return k0 * (k0 - 1) / np.maximum(k1, 1e-9)


def capsule(p: Points, ends: tuple[Points, Points], radii: tuple[float, float]) -> Points:
    """The distance from a rod with round ends, thicker at one end than at the other."""
    a, b = (np.asarray(end, float) for end in ends)
    along = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return norm(p - a - along[..., None] * (b - a)) - (radii[0] + along * (radii[1] - radii[0]))


def union(a: Points, b: Points, soft: float) -> Points:
    """Both solids, melted together over a distance of about `soft`."""
    h = np.clip(0.5 + 0.5 * (b - a) / soft, 0, 1)
    return b + (a - b) * h - soft * h * (1 - h)


def without(a: Points, b: Points, soft: float) -> Points:
    """The first solid less the second, with a soft edge."""
    return -union(-a, b, soft)


def head_solid(p: Points) -> Points:
    """The head without ears: about the distance from its skin. Both sides are alike."""
    p = np.stack([np.abs(p[..., 0]), p[..., 1], p[..., 2]], -1)
    d = ellipsoid(p, (0, 2.9, -0.9), (8.0, 8.4, 8.9))
    d = union(d, ellipsoid(p, (0, -3.6, 1.4), (6.95, 6.8, 6.5)), 3.0)  # jaw
    d = union(d, ellipsoid(p, (0, -8.6, 4.9), (3.3, 2.0, 2.3)), 2.4)  # chin
    d = union(d, ellipsoid(p, (4.2, -2.5, 4.5), (2.8, 2.5, 2.6)), 2.2)  # cheeks
    d = union(d, ellipsoid(p, (0, -5.4, 5.7), (3.6, 2.3, 2.2)), 1.6)  # around the mouth
    d = union(d, ellipsoid(p, (2.8, 4.3, 6.0), (2.6, 0.8, 1.4)), 1.6)  # brow
    d = without(d, ellipsoid(p, (3.1, 1.2, 8.7), (2.4, 2.0, 1.5)), 1.2)  # eye socket
    d = without(d, ellipsoid(p, (0, -7.5, 9.5), (2.2, 0.35, 1.1)), 0.9)  # above the chin
    bridge = capsule(p, (np.array([0, 2.2, 6.9]), np.array([0, -1.0, 8.6])), (0.7, 0.95))
    d = union(d, bridge, 1.4)
    d = union(d, ellipsoid(p, (0, -1.5, 9.05), (1.35, 1.2, 1.15)), 0.9)  # tip of the nose
    d = union(d, ellipsoid(p, (1.1, -1.85, 8.15), (0.85, 0.75, 0.9)), 0.8)  # its wings
    return without(d, ellipsoid(p, (0, -3.75, 9.1), (0.32, 0.9, 0.5)), 0.5)  # philtrum


CENTRE = np.array([0.0, -5.0, 0.0])  # rays from here meet the skin once


def on_skin(directions: Points, centre: Points = CENTRE) -> Points:
    """Points where rays from the centre leave the head."""
    unit = directions / norm(directions)[..., None]
    steps = np.linspace(3.0, 15.0, 97)
    inside = np.stack([head_solid(centre + unit * step) < 0 for step in steps])
    low = steps[len(steps) - 1 - np.argmax(inside[::-1], axis=0)]
    high = low + (steps[1] - steps[0])
    for _ in range(24):
        middle = (low + high) / 2
        within = head_solid(centre + unit * middle[..., None]) < 0
        low, high = np.where(within, middle, low), np.where(within, high, middle)
    return centre + unit * low[..., None]


def onto_skin(p: Points) -> Points:
    """The points moved straight onto the skin near them."""
    for _ in range(4):
        nudge = np.eye(3) * 1e-3
        slope = np.stack([head_solid(p + e) - head_solid(p - e) for e in nudge], -1) / 2e-3
        slope /= np.maximum((slope**2).sum(-1, keepdims=True), 1e-6)
        p = p - head_solid(p)[..., None] * slope
    return p


# --- the sheet of skin

AROUND = 52  # vertices in an edge loop
MOUTH = 2.7  # half the width of the mouth
MOUTH_AT = np.array([0.0, -5.75, 8.4])
# half the height of each edge loop, from the line between the lips to the back of the head
LIP_LOOPS = [0.0, 0.11, 0.28, 0.48, 0.7]
FACE_LOOPS = [0.86, 1.05, 1.3, 1.65, 2.05, 2.45, 2.85, 3.25, 3.65, 4.1, 4.7, 5.4, 6.2, 7.0]
SKULL_LOOPS = [7.9, 9.0, 10.4, 12.2, 14.5, 18.0, 22.5]
LIPS_BEGIN = -2  # two loops inside the mouth
LOOPS = np.array(LIP_LOOPS + FACE_LOOPS + SKULL_LOOPS)
BORDER = LIP_LOOPS[-1]
# how far the lips stand out at each of their loops, in the middle and at the corners
LIP_RELIEF = [-0.42, 0.06, 0.32, 0.27, -0.01]
CORNER_RELIEF = [-0.35, -0.23, -0.12, -0.04, 0.0]
# the pocket behind the lips, from the lips inwards: how much wider than the line between the lips,
# how far above or below it, how far behind it
POCKET_LOOPS = [
    (1.0, 0.10, 0.10),
    (1.0, 0.38, 0.20),
    (1.03, 1.0, 0.26),
    (1.06, 1.8, 0.7),
    (1.05, 2.25, 2.0),
    (0.95, 2.1, 3.9),
    (0.6, 1.3, 5.4),
]


@dataclass
class Sheet:
    """The vertices of the skin by loop and by angle about the mouth (0 at its left corner)."""

    points: Points  # (loops, angles, 3), from the lips to the back of the head
    inner: Points  # (loops, angles, 3), from the lips into the mouth
    flat: Points  # (loops, angles, 2): the skin as if rolled out about the mouth
    sin: Points  # of the angle of each column: above 0 on the upper lip
    cos: Points


def angles() -> Points:
    """The angle of each column about the mouth: closer in the middle, for a round hole."""
    even = np.arange(AROUND) * 2 * np.pi / AROUND
    return even + 0.2 * np.sin(2 * even)


def flat_loops() -> Points:
    """The loops as if rolled out: ellipses with their foci at the corners of the mouth."""
    angle = angles()
    height = LOOPS[:, None]
    # the lower lip is the fuller one
    lip = np.where(np.sin(angle) > 0, 0.92, 1.12) * np.ones_like(height)
    height = height * (1 + (lip - 1) * smoothstep(1.6, 0.6, height))
    x = np.sqrt(MOUTH**2 + height**2) * np.cos(angle)
    y = height * np.sin(angle)
    near = smoothstep(2.2, 0.0, height)
    smile = 0.38 * (x / MOUTH) ** 2 - 0.05 - 0.05 * bump(x, 0, 0.9)
    y = y + near * np.where(np.abs(x) < 2 * MOUTH, smile, 0)
    bow = 0.10 * bump(np.abs(x), 0.55, 0.6) - 0.10 * bump(x, 0, 0.45)
    y = y + bow * (np.sin(angle) > 0) * bump(height, BORDER, 0.6)
    return np.stack([x, y], -1)


def directions_at(flat: Points) -> Points:
    """The directions of rays that meet the skin at points rolled out about the mouth."""
    ahead = MOUTH_AT - CENTRE
    radius = float(norm(ahead))
    ahead = ahead / radius
    right = np.array([1.0, 0.0, 0.0])
    above = np.cross(ahead, right)
    far = norm(flat)
    away = flat / np.maximum(far, 1e-9)[..., None]
    tilt = np.minimum(far / radius, np.pi)[..., None]
    return np.cos(tilt) * ahead + np.sin(tilt) * (away[..., :1] * right + away[..., 1:] * above)


def spread(points: Points) -> Points:
    """The loops outside the lips, drawn to their neighbours until evenly spread over the skin."""
    free = smoothstep(1.2, 3.0, LOOPS) * smoothstep(20, 10, LOOPS)
    for _ in range(12):
        ring = (np.roll(points, 1, 1) + np.roll(points, -1, 1)) / 2
        across = (np.roll(points, 1, 0) + np.roll(points, -1, 0)) / 2
        pull = 0.5 * free[:, None, None] * ((ring + across) / 2 - points)
        points = np.where(free[:, None, None] > 0, onto_skin(points + pull), points)
    return points


def build_sheet() -> Sheet:
    """The skin at rest."""
    angle = angles()
    sin, cos = np.sin(angle), np.cos(angle)
    flat = flat_loops()
    points = spread(on_skin(directions_at(flat)))
    lip = np.abs(sin) ** 0.7
    for loop, (relief, corner) in enumerate(zip(LIP_RELIEF, CORNER_RELIEF, strict=True)):
        fuller = np.where((sin < 0) & (relief > 0), 1.2, 1.0)
        points[loop, :, 2] += corner + (relief * fuller - corner) * lip
    line = points[0]
    inner = []
    for wider, off, behind in POCKET_LOOPS:
        shift = np.stack([line[:, 0] * (wider - 1), off * sin, np.full(AROUND, -behind)], 1)
        inner.append(line + shift)
    return Sheet(points, np.stack(inner), flat, sin, cos)


# --- how the skin moves

HINGE = np.array([0.0, -1.0, -1.0])  # of the jaw
JAW_TURN, JAW_SLIDE = 0.17, np.array([0.0, -0.9, 0.4])


def jaw_shift(p: Points) -> Points:
    """Displacement of a point that is fixed to the jaw when the mouth opens in full."""
    turned = (p - HINGE) @ mesh.rotation((1, 0, 0), JAW_TURN).T + HINGE
    return turned - p + JAW_SLIDE


class Lips(NamedTuple):
    """How one loop of the lips moves in a pose: in the middle above and below, and at the corners.

    `up` is upwards, `out` forwards, `side` outwards from the middle.
    """

    side: float = 0.0
    above_up: float = 0.0
    below_up: float = 0.0
    corner_up: float = 0.0
    above_out: float = 0.0
    below_out: float = 0.0
    corner_out: float = 0.0


@dataclass(frozen=True)
class LipPose:
    """A pose of the lips: the line between them, their middle and their border."""

    line: Lips
    middle: Lips
    border: Lips
    reach: float = 3.5  # how far the skin about the lips goes along
    square: float = 1.0  # below 1 the opening is less pointed at the corners


LIP_POSES = {
    "W": LipPose(
        line=Lips(-2.1, 0.18, -0.36, -0.4, 0.7, 0.7, 1.45),
        middle=Lips(-0.53, 0.32, -0.32, -0.28, 1.25, 1.25, 0.9),
        border=Lips(-0.48, 0.3, -0.2, -0.15, 0.85, 0.85, 0.6),
        reach=3.8,
    ),
    "ShCh": LipPose(
        line=Lips(-1.7, 0.55, -0.5, -0.2, 0.65, 0.65, 1.2),
        middle=Lips(-0.66, 0.72, -0.72, -0.15, 1.15, 1.15, 0.9),
        border=Lips(-0.48, 0.42, -0.48, -0.1, 0.75, 0.75, 0.6),
        reach=3.6,
        square=0.65,
    ),
    "PBM": LipPose(
        line=Lips(0.1, -0.15, 0.55, 0.0, -0.5, -0.42, -0.12),
        middle=Lips(0.1, -0.15, 0.57, 0.0, -0.2, -0.16, -0.05),
        border=Lips(0.1, -0.16, 0.27, 0.0, -0.06, 0.0, -0.02),
        reach=2.4,
    ),
    "FV": LipPose(
        line=Lips(0.0, 0.34, 0.24, 0.06, -0.05, -0.5, -0.05),
        middle=Lips(0.0, 0.31, 0.34, 0.06, -0.08, -0.6, -0.05),
        border=Lips(0.0, 0.22, 0.33, 0.05, 0.0, -0.38, -0.03),
        reach=2.6,
        square=0.95,
    ),
    "wide": LipPose(
        line=Lips(0.58, -0.02, 0.03, 0.3, -0.18, -0.18, -0.5),
        middle=Lips(0.58, -0.08, 0.1, 0.3, -0.28, -0.28, -0.5),
        border=Lips(0.55, -0.08, 0.1, 0.32, -0.2, -0.2, -0.45),
        reach=3.8,
    ),
}

POSTURE_POSES = {
    "smile": LipPose(
        line=Lips(0.62, 0.12, 0.0, 0.95, -0.15, -0.15, -0.6),
        middle=Lips(0.62, 0.08, 0.06, 0.95, -0.25, -0.25, -0.6),
        border=Lips(0.6, 0.08, 0.08, 0.95, -0.2, -0.2, -0.5),
        reach=4.2,
    ),
    "frown": LipPose(
        line=Lips(0.15, 0.12, 0.3, -0.85, 0.1, 0.2, -0.2),
        middle=Lips(0.15, 0.1, 0.32, -0.85, 0.12, 0.3, -0.2),
        border=Lips(0.15, 0.08, 0.3, -0.85, 0.05, 0.2, -0.15),
        reach=3.4,
    ),
    "sneer": LipPose(
        line=Lips(0.12, 0.75, -0.1, 0.3, -0.1, 0.0, -0.1),
        middle=Lips(0.12, 0.8, -0.1, 0.3, 0.0, 0.0, -0.1),
        border=Lips(0.1, 0.7, -0.1, 0.3, 0.1, 0.0, -0.05),
        reach=3.2,
        square=0.6,
    ),
}
"""Lips of styles; each has a target for either side of the face."""


def loop_shift(lips: Lips, square: float, sin: Points, cos: Points) -> Points:
    """The movement of one loop of the lips, (angles, 3)."""
    height = np.abs(sin) ** square
    up = np.where(sin > 0, lips.above_up, lips.below_up) * height + lips.corner_up * cos**2
    out = np.where(sin > 0, lips.above_out, lips.below_out) * sin**2 + lips.corner_out * cos**2
    return np.stack([lips.side * cos, up, out], -1)


def from_mouth(flat: Points) -> Points:
    """Distance of each rolled-out point from the line between the lips."""
    beyond = np.maximum(np.abs(flat[..., 0]) - MOUTH, 0)
    return np.hypot(beyond, flat[..., 1])


def lip_shift(sheet: Sheet, pose: LipPose) -> tuple[Points, Points]:
    """The movement of the sheet in a pose of the lips: outside and inside."""
    line, middle, border = (
        loop_shift(lips, pose.square, sheet.sin, sheet.cos)
        for lips in (pose.line, pose.middle, pose.border)
    )
    half = LIP_LOOPS[2]
    outer = np.empty_like(sheet.points)
    for number, loop in enumerate(LOOPS):
        if loop <= BORDER:
            outer[number] = (
                line * (loop - half) * (loop - BORDER) / (half * BORDER)
                + middle * loop * (loop - BORDER) / (half * (half - BORDER))
                + border * loop * (loop - half) / (BORDER * (BORDER - half))
            )
        else:
            far = from_mouth(sheet.flat[number]) - BORDER * np.abs(sheet.sin)
            outer[number] = border * smoothstep(pose.reach, 0, far)[:, None]
    along = smoothstep(4, -1, np.arange(len(POCKET_LOOPS)))
    return outer, line[None] * along[:, None, None]


def open_shift(sheet: Sheet) -> tuple[Points, Points]:
    """The movement of the sheet when the mouth opens in full."""
    sin, cos = sheet.sin, sheet.cos
    at_lips = np.where(sin > 0, 0.4 - 0.4 * sin, 0.4 - 0.6 * sin)
    far = from_mouth(sheet.flat)
    down = 0.5 - 0.5 * sheet.flat[..., 1] / np.maximum(norm(sheet.flat), 1e-9)
    begin = 5.0 * smoothstep(0.45, 1.0, down)
    end = 3.2 + 3.3 * smoothstep(0.0, 0.5, down) + 3.5 * smoothstep(0.5, 1.0, down)
    weight = at_lips * smoothstep(1, 0, (far - begin) / (end - begin))
    near = smoothstep(3.0, 0.0, far)
    narrow = np.stack([-0.2 * cos, 0.22 * np.maximum(sin, 0), 0.0 * sin], -1)
    outer = jaw_shift(sheet.points) * weight[..., None] + narrow * near[..., None]
    # the pocket: its floor goes with the jaw, its roof stays
    deep = np.linspace(0, 1, len(POCKET_LOOPS))[:, None]
    inside = at_lips * (1 - deep) + np.maximum(-sin, 0) * deep
    inside = inside * smoothstep(1.15, 0.6, deep)
    inner = jaw_shift(sheet.inner) * inside[..., None] + narrow * (1 - deep)[..., None] ** 2
    return outer, inner


def skin_shifts(sheet: Sheet) -> dict[str, tuple[Points, Points]]:
    """All movements of the sheet."""
    shifts = {"open": open_shift(sheet)}
    shifts |= {name: lip_shift(sheet, pose) for name, pose in LIP_POSES.items()}
    shifts["wide"][0][...] += cheek_lift(sheet.points)
    for name, pose in POSTURE_POSES.items():
        outer, inner = lip_shift(sheet, pose)
        if name == "smile":
            outer = outer + cheek_lift(sheet.points)
        for side, end in ((1, "Left"), (-1, "Right")):
            both = (sheet.points, sheet.inner)
            out, within = (smoothstep(-1.2, 1.2, side * p[..., :1]) for p in both)
            shifts[name + end] = outer * out, inner * within
    return shifts


def cheek_lift(p: Points) -> Points:
    """The cheeks swell a little when the corners of the mouth go apart."""
    side = np.sign(p[..., 0])
    swell = smoothstep(
        2.8, 0.0, norm((p * [1, 1, 0.6]) - side[..., None] * [4.7, 0, 0] - [0, -3, 4])
    )
    return swell[..., None] * np.stack([0.22 * side, 0.24 + 0 * side, 0.26 + 0 * side], -1)


def blush(p: Points, sheet: Sheet) -> Points:
    """Colour of the skin: rosy cheeks and nose, multiplied into its base colour."""
    x, y, z = np.abs(p[..., 0]), p[..., 1], p[..., 2]
    front = smoothstep(2, 6, z)
    cheek = smoothstep(2.9, 0.2, np.hypot(x - 4.3, (y + 2.6) * 1.15)) * front
    nose = smoothstep(2.0, 0.3, norm(np.stack([x, y + 1.8, z - 9.6], -1)))
    lip = smoothstep(0.5, 0.0, from_mouth(sheet.flat) - BORDER) * 0.3
    under = smoothstep(-8.0, -12.0, y) * 0.4 * smoothstep(6, 2, z)
    rosy = np.clip(cheek * 0.75 + nose * 0.6 + lip + under, 0, 1)
    return 1 - rosy[..., None] * np.array([0.03, 0.33, 0.36])


def sheet_mesh(sheet: Sheet) -> tuple[Part, NDArray[np.int64]]:
    """The whole sheet from the throat to the back of the head; the loop each triangle begins at.

    Loops are counted from the line between the lips, those inside the mouth below 0.
    """
    rows = np.concatenate([sheet.inner[::-1], sheet.points])
    throat, back = sheet.inner[-1:].mean(1), on_skin(np.array([CENTRE - MOUTH_AT]))
    positions = np.concatenate([rows.reshape(-1, 3), throat, back])
    j = np.arange(AROUND)
    nxt, last = (j + 1) % AROUND, (len(rows) - 1) * AROUND
    fan = np.stack([j, nxt, np.full(AROUND, len(positions) - 2)], 1)
    end = np.stack([last + nxt, last + j, np.full(AROUND, len(positions) - 1)], 1)
    between = mesh.grid_faces(len(rows), AROUND, wrap=True)[:, ::-1]
    loops = np.repeat(np.arange(-1, len(rows)), [AROUND, *[2 * AROUND] * (len(rows) - 1), AROUND])
    targets = {}
    for name, (outer, inner) in skin_shifts(sheet).items():
        shift = np.concatenate([inner[::-1], outer])
        ends = np.concatenate([shift[:1].mean(1), np.zeros((1, 3))])
        targets[name] = np.concatenate([shift.reshape(-1, 3), ends])
    part = Part("skin", positions, np.concatenate([fan, between, end]), SKIN, 0.62, targets)
    return part, loops - len(sheet.inner)


def skin_parts(sheet: Sheet) -> list[Part]:
    """The skin, the lips and the pocket behind them, shaded as one."""
    whole, loops = sheet_mesh(sheet)
    whole.colors = sheet_colors(sheet, len(sheet.inner))
    lips = (loops >= LIPS_BEGIN) & (loops < len(LIP_LOOPS) - 1)
    hidden = under_hair(whole.positions)[whole.triangles].all(1)
    pocket = mesh.take(whole, loops < LIPS_BEGIN, "mouth", color=POCKET, roughness=1.0)
    return [
        mesh.take(whole, (loops >= len(LIP_LOOPS) - 1) & ~hidden, "skin"),
        mesh.take(whole, lips, "lips", color=LIP, roughness=0.42),
        # too dark inside for its shading to matter as it moves
        replace(pocket, target_normals={}),
    ]


def sheet_colors(sheet: Sheet, inside: int) -> Points:
    """The tint of each vertex of the sheet, in the order of `skin_parts`."""
    outer = blush(sheet.points, sheet)
    depth = np.array([0.62, 0.75, 0.92, 1.0, 1.0])[:, None, None]
    lip_tint = 1 - (1 - depth) * np.array([0.35, 1.0, 0.9])
    outer[: len(LIP_LOOPS)] = lip_tint
    deep = np.linspace(0.3, 1.0, inside)[:, None, None] * np.ones((inside, AROUND, 3))
    deep[LIPS_BEGIN:] = lip_tint[0]
    return np.concatenate([deep.reshape(-1, 3), outer.reshape(-1, 3), deep[0, :1], outer[-1, :1]])


# --- teeth and tongue

LINE = -5.83  # height of the line between the lips in the middle
TEETH = 7.22  # z of the middle of the front teeth


def arch(samples: int, y: float, back: float) -> Points:
    """Points along a row of teeth, from right to left. The lower row, set back, sinks behind."""
    angle = np.linspace(-1.35, 1.35, samples)
    x, z = (2.6 - back * 0.4) * np.sin(angle), TEETH - back - 2.5 * (1 - np.cos(angle))
    return np.stack([x, y - 1.2 * back * (1 - np.cos(angle)), z], 1)


# half the width, the height and the sharpness of each tooth, from the middle to the side
UPPER_TEETH = [
    (0.43, 1.0, 0.0),
    (0.33, 0.92, 0.0),
    (0.36, 1.0, 0.5),
    (0.34, 0.86, 0.2),
    (0.36, 0.8, 0.1),
]
LOWER_TEETH = [
    (0.27, 0.92, 0.0),
    (0.29, 0.94, 0.0),
    (0.33, 1.0, 0.4),
    (0.34, 0.9, 0.2),
    (0.38, 0.85, 0.1),
]
TOOTH_GAP = 0.015


def tooth(wide: float, high: float, sharp: float, edge: int) -> mesh.Shape:
    """A tooth that stands at the origin, with its edge `high` above or below its middle.

    It is narrow at the gum, wide and flat at its edge; `edge` is 1 if that points up.
    """
    at = np.array([-1.0, -0.55, 0.0, 0.5, 0.82, 1.0])
    path = np.stack([0 * at, high * at * edge, -0.05 * at**2], 1)
    across = wide * np.array([0.68, 0.84, 0.97, 1.0, 0.95 - 0.3 * sharp, 0.72 - 0.45 * sharp])
    deep = np.array([0.22, 0.24, 0.22, 0.17, 0.12, 0.06])
    return mesh.tube(path, np.stack([across, deep], 1), 10, exponent=2.8)


def tooth_row(name: str, y: float, height: float, *, back: float = 0.0) -> Part:
    """A row of ten teeth; `height` is half the height of a tooth. Lower teeth are set `back`."""
    shapes, edge = (LOWER_TEETH, 1) if back else (UPPER_TEETH, -1)
    line = arch(401, y, back)
    along = np.concatenate([[0.0], np.cumsum(norm(np.diff(line, axis=0)))])
    middle, teeth = along[-1] / 2, []
    place = TOOTH_GAP
    for wide, high, sharp in shapes:
        for side in (1, -1):
            spot = middle + side * (place + wide)
            at = np.array([np.interp(spot, along, line[:, axis]) for axis in range(3)])
            ahead = np.array([np.interp(spot + d, along, line[:, 2]) for d in (-0.1, 0.1)])
            sideways = np.array([np.interp(spot + d, along, line[:, 0]) for d in (-0.1, 0.1)])
            turn = mesh.rotation(
                (0, 1, 0), np.arctan2(ahead[0] - ahead[1], sideways[1] - sideways[0])
            )
            part = Part(name, *tooth(wide, high * height, sharp, edge), TOOTH, 0.28)
            grown = at - [0, edge * height * (1 - high), 0]  # all stand in the gum alike
            teeth.append(mesh.transformed(mesh.with_normals(part), turn=turn, move=grown))
        place += 2 * wide + TOOTH_GAP
    row = mesh.merged(teeth, name)
    row.colors = in_the_dark(row.positions, 6.9, 4.2)
    return row


def in_the_dark(p: Points, light: float, dark: float) -> Points:
    """A tint that darkens towards the throat, between two values of z."""
    return 1 - smoothstep(light, dark, p[:, 2:]) * np.array([0.6, 0.75, 0.75])


def gum(name: str, y: float, height: float, *, back: float = 0.0) -> Part:
    """The flesh that a row of teeth stands in, scalloped over each tooth."""
    each = 4
    path = arch(10 * each + 1, y, back)
    number = np.arange(len(path))
    end = np.where(np.minimum(number, number[::-1]) == 0, 0.5, 1.0)
    scallop = 1 + 0.16 * np.cos(2 * np.pi * number / each)
    radii = np.stack([height * scallop, np.full(len(path), 0.27)], 1) * end[:, None]
    part = Part(name, *mesh.tube(path, radii, 8, side=(0, 1, 0)), GUM, 0.4)
    part.colors = in_the_dark(part.positions, 6.9, 4.0)
    return part


def on_jaw(part: Part) -> Part:
    """The part goes down with the jaw."""
    return replace(part, targets={**part.targets, "open": jaw_shift(part.positions)})


# the middle line of the tongue from root to tip as (height above the line of the lips, distance
# behind the teeth), with half its width and half its thickness
TONGUES = {
    "rest": [
        (-2.9, 5.6, 1.3, 0.8),
        (-2.1, 5.1, 1.5, 0.9),
        (-1.35, 4.2, 1.65, 0.85),
        (-0.95, 2.9, 1.55, 0.7),
        (-0.8, 1.75, 1.35, 0.5),
        (-0.7, 1.05, 1.2, 0.38),
        (-0.64, 0.62, 1.0, 0.3),
    ],
    "tBack": [
        (-2.7, 5.9, 1.4, 0.8),
        (-1.6, 5.6, 1.7, 1.0),
        (-0.4, 4.9, 1.9, 1.0),
        (-0.2, 3.9, 1.85, 0.9),
        (-0.75, 2.9, 1.6, 0.6),
        (-1.15, 1.9, 1.2, 0.38),
        (-1.2, 1.3, 0.9, 0.28),
    ],
    "tRoof": [
        (-2.9, 5.6, 1.3, 0.8),
        (-2.1, 5.1, 1.5, 0.9),
        (-1.35, 4.2, 1.6, 0.85),
        (-0.75, 2.9, 1.55, 0.65),
        (-0.15, 1.75, 1.4, 0.42),
        (0.75, 1.0, 1.15, 0.3),
        (1.2, 0.72, 0.95, 0.24),
    ],
    "tTeeth": [
        (-2.9, 5.5, 1.3, 0.8),
        (-2.1, 4.8, 1.5, 0.9),
        (-1.2, 3.7, 1.6, 0.85),
        (-0.4, 2.2, 1.5, 0.6),
        (0.15, 0.8, 1.4, 0.38),
        (0.34, -0.5, 1.3, 0.28),
        (0.18, -1.7, 1.15, 0.24),
    ],
}


def tongue_shape(knots: list[tuple[float, ...]]) -> tuple[Points, mesh.Faces]:
    """A tongue along a middle line, with a groove on top and a round tip."""
    line = mesh.catmull_rom(np.array(knots), 16)
    tip = np.array([0.96, 0.84, 0.55, 0.15])
    line[-4:, 2] *= tip
    line[-4:, 3] *= np.sqrt(tip)
    path = np.stack([np.zeros(len(line)), LINE + line[:, 0], TEETH - line[:, 1]], 1)
    segments = 16
    positions, triangles = mesh.tube(path, line[:, 2:], segments)
    rings = positions[: len(path) * segments].reshape(len(path), segments, 3)
    ahead = np.gradient(path, axis=0)
    over = np.cross(ahead, [1.0, 0, 0])
    over /= norm(over)[:, None]
    angle = np.arange(segments) * 2 * np.pi / segments
    groove = bump(angle, np.pi / 2, 0.6) * 0.3
    rings -= over[:, None] * (groove[None, :] * line[:, 3:])[..., None]
    return positions, triangles


def tongue() -> Part:
    """The tongue and its three poses."""
    positions, triangles = tongue_shape(TONGUES["rest"])
    targets = {
        name: tongue_shape(knots)[0] - positions
        for name, knots in TONGUES.items()
        if name != "rest"
    }
    root = smoothstep(1.0, 4.0, positions[:, 2:])
    targets["open"] = jaw_shift(positions) * (0.45 + 0.5 * root)
    shade = 1 - 0.55 * smoothstep(6.0, 2.5, positions[:, 2:]) * np.array([0.7, 1, 1])
    return Part("tongue", positions, triangles, TONGUE, 0.4, targets, shade)


UP, DOWN = (1.12, 0.45), (-0.8, 0.3)  # how far rows of teeth go from rounded lips, and back


def cleared(part: Part, up: float, back: float) -> Part:
    """The part gets out of the way when the lips are rounded: the small opening stays dark."""
    shift = np.tile([0.0, up, -back], (len(part.positions), 1))
    # the lips part higher at their corners
    shift[:, 1] *= 1 + 0.6 * (part.positions[:, 0] / MOUTH) ** 2
    return replace(part, targets={**part.targets, "W": shift})


def mouth_parts() -> list[Part]:
    """Teeth, gums and tongue."""
    upper, lower = LINE + 0.35, LINE - 0.36
    uppers = cleared(tooth_row("teeth", upper, 0.52), *UP)
    lowers = cleared(on_jaw(tooth_row("lower teeth", lower, 0.46, back=0.3)), *DOWN)
    gums = [
        cleared(gum("gums", upper + 0.62, 0.4), *UP),
        cleared(on_jaw(gum("lower gums", lower - 0.55, 0.36, back=0.3)), *DOWN),
    ]
    return [
        mesh.merged([uppers, lowers], "teeth"),
        mesh.merged(gums, "gums"),
        cleared(tongue(), -0.7, 0.4),
    ]


# --- eyes

EYE, EYE_RADIUS, LID = np.array([3.05, 1.25, 5.9]), 2.0, 0.13
UPPER_LID, LOWER_LID = 0.54, -0.54  # where the edges of the lids are, in radians above the middle
SHUT = -0.22  # where they meet
BULGE = (
    0.08  # how far they stand out there: halfway a point moves straight, and so closer to the eye
)
GAZE = 0.36  # how far the eyes turn to a side, in radians


def eye_turn() -> Points:
    """The left eye looks a little outwards, and its outer corner is a little higher."""
    return mesh.rotation((0, 1, 0), 0.03) @ mesh.rotation((0, 0, 1), 0.07)


def on_ball(across: Points, above: Points, radius: Points | float) -> Points:
    """Points on a ball with poles at the corners of the eye: `across` is 0 at the inner one."""
    return (
        np.stack(
            [-np.cos(across), np.sin(across) * np.sin(above), np.sin(across) * np.cos(above)], -1
        )
        * np.asarray(radius)[..., None]
    )


def lid_edge(across: Points, middle: float) -> Points:
    """The edge of a lid: it opens wider towards the outer corner."""
    return middle * (1 - 0.10 * np.cos(across + 0.6))


LID_ROWS = np.array([0.0, 0.0, 0.05, 0.18, 0.45, 0.75, 1.0])[:, None] * np.ones(15)


def lid_points(middle: float, end: float, out: float = 0.0) -> Points:
    """A lid with its edge at `middle`, as a grid: part of a ball about the eyeball."""
    across = np.linspace(0.02, np.pi - 0.02, 15)
    edge = lid_edge(across, middle)
    sink = 0.9 if end > middle else -1.2  # below, the lid sinks into the cheek
    depth = np.interp(LID_ROWS, [0, 0.05, 0.18, 1], [0.6, 1.0, 1.05, sink])
    depth[0] = -0.02
    radius = EYE_RADIUS + LID * depth + out * smoothstep(1.0, 0.6, LID_ROWS)
    return on_ball(across + 0 * LID_ROWS, edge + (end - edge) * LID_ROWS, radius)


def lid(middle: float, end: float) -> Part:
    """A lid with a thick edge, which shuts. `end` is where it ends."""
    points = lid_points(middle, end)
    shut = lid_points(SHUT, end, BULGE) - points
    shade = 0.16 * smoothstep(0.9, 0.0, LID_ROWS)
    upwards = slice(None, None, 1 if end > middle else -1)
    part = Part("lids", *mesh.patch(points[upwards]), SKIN, 0.62)
    part.targets = {"blink": shut[upwards].reshape(-1, 3)}
    part.colors = 1 - shade[upwards].reshape(-1, 1) * np.array([0.5, 1.2, 1.2])
    return part


def lash() -> Part:
    """The dark line on the edge of the upper lid, which goes down with it."""
    across = np.linspace(0.35, np.pi - 0.22, 12)
    thick = np.interp(
        np.linspace(0, 1, 12), [0, 0.25, 0.75, 0.93, 1], [0.02, 0.07, 0.12, 0.12, 0.02]
    )

    def shape(middle: float, out: float) -> mesh.Shape:
        radius = EYE_RADIUS + LID * 0.9 + out
        path = on_ball(across, lid_edge(across, middle) + 0.01, radius)
        path[-2:] += np.array([[0.03, 0.05, 0.04], [0.12, 0.16, 0.08]])
        return mesh.tube(path, thick, 6)

    points, triangles = shape(UPPER_LID, 0.0)
    shut = shape(SHUT, BULGE)[0] - points
    return Part("lashes", points, triangles, LASH, 0.6, {"blink": shut})


def disc(radius: float, at: float, segments: int, rings: int) -> mesh.Shape:
    """A round cap on the eyeball: `radius` in radians, `at` the distance from its middle."""
    tilt = np.linspace(radius, 0, rings + 1)[:-1]
    turn = np.arange(segments) * 2 * np.pi / segments
    points = np.empty((rings, segments, 3))
    points[..., :2] = np.stack([np.cos(turn), np.sin(turn)], 1) * np.sin(tilt)[:, None, None]
    points[..., 2] = np.cos(tilt)[:, None]
    positions, triangles = mesh.loft(points * at, cap_start=False)
    positions[-1] = [0, 0, at]
    return positions, triangles


def iris() -> Part:
    """The coloured disc, darker at its rim and above."""
    radius = 0.56
    part = Part("irises", *disc(radius, EYE_RADIUS + 0.012, 24, 4), IRIS, 0.25)
    far = norm(part.positions[:, :2]) / np.sin(radius) / EYE_RADIUS
    above = smoothstep(-0.54, 0.81, part.positions[:, 1])
    light = np.clip(1 - 0.75 * smoothstep(0.8, 1.0, far) - 0.35 * above, 0.1, 1)
    part.colors = light[:, None] ** [1.2, 1, 1]
    return part


def turning(part: Part) -> Part:
    """A part of an eyeball, which turns to both sides and gives way to the lids."""
    shifts = {
        name: part.positions @ (mesh.rotation((0, 1, 0), way * GAZE) - np.eye(3)).T
        for name, way in (("eyesLeft", 1), ("eyesRight", -1))
    }
    back = np.tile([0.0, 0.0, -BULGE], (len(part.positions), 1))
    return replace(part, targets={**shifts, "blink": back})


def swapped(part: Part) -> Part:
    """The part of the other eye: a mirror swaps left and right."""
    other = {"eyesLeft": "eyesRight", "eyesRight": "eyesLeft"}
    shifts, normals = (
        {other.get(name, name): value for name, value in shapes.items()}
        for shapes in (part.targets, part.target_normals or {})
    )
    return replace(part, targets=shifts, target_normals=normals)


def eye_parts() -> list[Part]:
    """Both eyes with their lids and lashes."""
    ball = Part("eyes", *disc(1.7, EYE_RADIUS, 24, 7), EYEBALL, 0.22)
    ball.colors = 1 - 0.28 * smoothstep(0.2, 1.5, ball.positions[:, 1:2]) * np.array([1, 1, 0.8])
    pupil = Part("pupils", *disc(0.29, EYE_RADIUS + 0.03, 20, 2), PUPIL, 0.2)
    lids = mesh.merged([lid(UPPER_LID, 1.9), lid(LOWER_LID, -1.5)], "lids")
    parts = []
    for part in (turning(ball), turning(iris()), turning(pupil), lids, lash()):
        left = mesh.transformed(mesh.with_normals(part), turn=eye_turn(), move=EYE)
        right = swapped(mesh.mirrored(left, part.name))
        parts.append(mesh.merged([left, right], part.name))
    glints = [glint(side) for side in (-1, 1)]
    return [*parts, mesh.merged(glints, "glints")]


def glint(side: int) -> Part:
    """The light in an eye: on the same side in both."""
    turn = eye_turn() if side > 0 else np.diag([-1.0, 1, 1]) @ eye_turn() @ np.diag([-1.0, 1, 1])
    aim = turn @ mesh.rotation((0, 1, 0), -0.22) @ mesh.rotation((1, 0, 0), -0.24)
    spot = Part("glints", *disc(0.085, EYE_RADIUS + 0.05, 12, 2), EYEBALL, 0.3)
    spot.targets = {"blink": np.tile([0.0, 0.0, -2 * BULGE], (len(spot.positions), 1))}
    return mesh.transformed(spot, turn=aim, move=EYE * [side, 1, 1])


BROW = np.array([[1.3, 4.0], [2.4, 4.62], [3.9, 4.7], [5.35, 3.7]])
RAISED = np.array([[0.0, 0.8], [0.0, 1.05], [0.05, 1.1], [0.1, 0.7]])


def brow_shape(line: Points) -> mesh.Shape:
    """A tapered roll on the skin along a line seen from the front."""
    at = mesh.catmull_rom(line, 15)
    start = np.array([0.0, 2.0, -1.0])
    path = on_skin(np.stack([at[:, 0], at[:, 1] - 1.2, np.sqrt(70 - at[:, 0] ** 2)], 1), start)
    grow = np.interp(np.linspace(0, 1, 15), [0, 0.12, 0.4, 0.8, 1], [0.25, 0.8, 1, 0.65, 0.08])
    radii = np.stack([0.42 * grow, 0.22 * grow], 1)
    ahead = np.gradient(path, axis=0)
    side = np.cross(ahead, path - start)
    return mesh.tube(path + np.array([0, 0, 0.1]), radii, 8, side=side)


def brow_parts() -> list[Part]:
    """Brows, which rise."""
    points, triangles = brow_shape(BROW)
    up = brow_shape(BROW + RAISED)[0] - points
    left = Part("brows", points, triangles, HAIR, 0.7, {"browUp": up})
    return [mesh.merged([left, mesh.mirrored(left, "brows")], "brows")]


# --- ears, hair, neck


def ear_parts() -> list[Part]:
    """Ears: a bowl with a rolled rim."""
    turn = np.arange(22) * 2 * np.pi / 22
    # the outline, wider above, with a lobe below
    wide = 1.25 * (1 + 0.16 * np.sin(turn)) * np.cos(turn)
    high = 1.95 * np.sin(turn) * (1 - 0.06 * np.cos(turn))
    outline = np.stack([wide, high], 1)
    # size and height of each ring, from behind over the rim to the middle of the bowl
    rings = [(0.55, -0.9), (0.8, -0.35), (0.97, 0.05), (1.0, 0.22), (0.95, 0.36), (0.84, 0.36)]
    rings += [(0.74, 0.22), (0.6, 0.0), (0.35, -0.06)]
    front = smoothstep(0.2, 1.0, np.cos(turn))  # the rim fades towards the face
    points = np.empty((len(rings), 22, 3))
    for number, (size, lift) in enumerate(rings):
        points[number, :, :2] = outline * size
        points[number, :, 2] = lift - 0.5 * front * (lift > 0) * lift
    shape = mesh.loft(points, cap_start=False)
    ear = Part("ears", *shape, SKIN, 0.62)
    deep = smoothstep(0.9, 0.4, norm(ear.positions[:, :2] / [1.25, 1.95]))
    ear.colors = 1 - np.array([0.04, 0.3, 0.32]) * (0.35 + 0.65 * deep)[:, None]
    # the bowl looks sideways, a little forwards; front of the ear towards the face
    face_out = np.array([[0, 0, 1.0], [0, 1, 0], [-1.0, 0, 0]])
    aim = mesh.rotation((0, 1, 0), -0.42) @ mesh.rotation((1, 0, 0), -0.12) @ face_out
    left = mesh.transformed(ear, turn=aim, scale=1.15, move=(8.0, -0.6, -0.7))
    return [mesh.merged([left, mesh.mirrored(left, "ears")], "ears")]


def neck_parts() -> list[Part]:
    """A neck, and a collar to end it."""
    profile = [(3.3, -15.8), (3.3, -12.5), (3.3, -10.5), (3.5, -8.0), (3.5, -6.0), (3.2, -3.5)]
    neck = Part("neck", *mesh.revolved(profile, 28), SKIN, 0.62)
    neck = mesh.transformed(neck, move=(0, 0, -2.2))
    low = smoothstep(-13.0, -9.0, neck.positions[:, 1:2])
    neck.colors = 1 - 0.5 * low * np.array([0.3, 0.6, 0.6])
    roll = [(0.0, -15.6), (4.6, -15.5), (5.3, -15.0), (5.0, -14.2), (4.5, -13.6), (4.7, -13.0)]
    roll += [(4.75, -12.4), (4.5, -11.95), (4.05, -11.85), (3.7, -12.2), (3.5, -13.0)]
    smooth = mesh.catmull_rom(np.array(roll), 18)
    smooth[0, 0] = 0
    collar = Part("collar", *mesh.revolved(smooth, 24), WOOL, 0.9)
    return [neck, mesh.transformed(collar, move=(0, -1.3, -1.9))]  # clear of the lowest chin


HAIR_CENTRE = np.array([0.0, 1.0, -1.0])
CROWN = np.array([0.0, 0.8646, -0.5025])  # the way to it from there
LEFT = np.array([1.0, 0.0, 0.0])
# the hairline on the left side, from the middle of the forehead to the nape
HAIRLINE = [(0.0, 8.4, 6.4), (3.4, 7.9, 5.8), (5.9, 5.8, 4.7), (7.0, 2.5, 3.1), (7.3, -0.4, 2.3)]
HAIRLINE += [(7.5, 1.3, -0.7), (7.3, -1.4, -3.0), (5.8, -6.0, -5.2)]
HAIRLINE += [(3.0, -7.2, -6.8), (0.0, -7.4, -7.2)]
# locks that lie on the cap: direction from the middle of the head, and height above the skin
LOCKS = [
    [
        (2.9, 9.0, 5.4, 0.2),
        (0.9, 9.5, 6.4, 1.3),
        (-2.0, 8.5, 6.6, 1.5),
        (-4.6, 6.8, 5.5, 1.0),
        (-6.1, 4.6, 4.6, 0.3),
    ],
    [
        (2.7, 10.0, 4.2, 0.3),
        (0.0, 10.8, 5.2, 1.6),
        (-3.0, 9.8, 5.2, 1.6),
        (-5.6, 7.6, 4.4, 1.1),
        (-7.0, 4.6, 3.4, 0.4),
    ],
    [
        (2.4, 10.8, 2.4, 0.4),
        (-0.5, 11.6, 3.2, 1.5),
        (-3.8, 10.2, 3.2, 1.5),
        (-6.4, 7.6, 2.6, 1.1),
        (-7.8, 4.2, 1.8, 0.5),
    ],
    [
        (2.2, 11.2, 0.2, 0.4),
        (-0.8, 11.6, 0.8, 1.3),
        (-4.2, 10.0, 0.8, 1.3),
        (-6.9, 7.2, 0.4, 1.0),
        (-8.0, 3.6, -0.4, 0.5),
    ],
    [(2.7, 9.1, 5.3, 0.2), (3.9, 8.9, 5.4, 1.0), (5.5, 7.4, 4.8, 0.9), (6.9, 4.6, 3.6, 0.3)],
    [(2.5, 10.3, 3.4, 0.3), (4.3, 9.9, 3.5, 1.1), (6.3, 7.9, 3.0, 1.0), (7.6, 4.4, 2.0, 0.4)],
    [(2.3, 11.0, 1.2, 0.4), (4.6, 10.2, 1.2, 1.1), (6.8, 7.8, 0.8, 1.0), (7.9, 4.0, -0.2, 0.5)],
]


def lock(knots: list[tuple[float, ...]], width: float, thick: float) -> Part:
    """A flat, tapered lock of hair that lies on the head."""
    samples = 11
    line = mesh.catmull_rom(np.array(knots), samples)
    base = on_skin(line[:, :3] - HAIR_CENTRE, HAIR_CENTRE)
    out = base - HAIR_CENTRE
    out /= norm(out)[:, None]
    path = base + out * (line[:, 3:] - 0.1)
    at = np.linspace(0, 1, samples)
    grow = np.interp(at, [0, 0.15, 0.5, 0.8, 1], [0.35, 0.8, 1.0, 0.72, 0.06])
    side = np.cross(np.gradient(path, axis=0), out)
    radii = np.stack([width * grow, thick * grow], 1)
    shape = mesh.tube(path, radii, 7, side=side)
    shade = np.concatenate([np.repeat(0.72 + 0.28 * bump(at, 0.45, 0.6), 7), [0.72, 0.8]])
    return Part("hair", *shape, HAIR, 0.5, colors=shade[:, None] * np.ones(3))


def about_crown(points: Points) -> tuple[Points, Points]:
    """The angle of points around the crown, 0 towards the face, and their angle away from it."""
    away = points - HAIR_CENTRE
    away = away / norm(away)[:, None]
    turn = np.arctan2(away @ LEFT, away @ np.cross(LEFT, CROWN))
    return turn, np.arccos(np.clip(away @ CROWN, -1, 1))


def hairline(turn: Points) -> Points:
    """How far from the crown the hair reaches, at angles around it."""
    at, reach = about_crown(np.array(HAIRLINE))
    at, reach = np.concatenate([-at[:0:-1], at]), np.concatenate([reach[:0:-1], reach])
    degrees = np.linspace(-np.pi, np.pi, 361)
    sharp = np.interp(degrees, at, reach)[:-1]
    soft = sum(np.roll(sharp, shift) for shift in range(-5, 6)) / 11
    return np.interp(turn, degrees, np.append(soft, soft[0]))


def under_hair(points: Points) -> NDArray[np.bool_]:
    """Which points of the skin are well under the hair, so that nobody sees them."""
    turn, away = about_crown(points)
    return away < 0.8 * hairline(turn)


def cap() -> Part:
    """Short hair all over, in soft ridges that turn about the crown."""
    psi = np.linspace(-np.pi, np.pi, 60, endpoint=False)
    s = np.array([0.06, 0.2, 0.34, 0.48, 0.62, 0.75, 0.86, 0.94, 0.98, 1.0])[:, None]
    ridges = np.abs(np.sin((psi + 0.5 - 0.5 * s) * 6))
    phi = (hairline(psi) - 0.045 * (1 - ridges[-1])) * s
    turned = np.cos(psi)[:, None] * np.cross(LEFT, CROWN) + np.sin(psi)[:, None] * LEFT
    away = np.cos(phi)[..., None] * CROWN + np.sin(phi)[..., None] * turned
    thick = 0.8 * np.sqrt(np.clip(1.02 - s**6, 0, 1))
    thick = thick * (0.8 + 0.28 * ridges * smoothstep(0.0, 0.5, s)) - 0.3 * smoothstep(0.95, 1, s)
    points = on_skin(away, HAIR_CENTRE) + away * thick[..., None]
    shape = mesh.loft(points[::-1], cap_start=False)
    shade = (0.7 + 0.3 * ridges)[::-1].reshape(-1, 1)
    shade = np.concatenate([shade, shade[-1:]]) * np.ones(3)
    return Part("hair", *shape, HAIR, 0.5, colors=shade)


def hair_parts() -> list[Part]:
    """A cap of hair, and a fringe of locks that fall to both sides of a parting."""
    locks = [lock(knots, 1.35, 0.62) for knots in LOCKS]
    return [mesh.merged([cap(), *locks], "hair")]


# --- all of it


def build() -> list[Part]:
    """Every part, in metres."""
    parts = [*skin_parts(build_sheet()), *mouth_parts(), *eye_parts(), *brow_parts()]
    parts += [*ear_parts(), *neck_parts(), *hair_parts()]
    return [mesh.transformed(mesh.with_normals(part), scale=0.01) for part in parts]


def main() -> None:
    """Write the model to the path on the command line, or where it belongs."""
    out = Path(sys.argv[1]) if sys.argv[1:] else OUT
    mesh.write_head(out, build(), TARGETS + GESTURES + POSTURES, "head")


if __name__ == "__main__":
    main()
