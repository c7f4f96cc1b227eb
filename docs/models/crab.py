"""Make the crab that the pose set `crab` is shown on, and write it to posesets/crab/model.glb.

Run `python docs/models/crab.py`, or give another path to write to. The same bytes each time.

The shell, the lips and the inside of the mouth are one sheet of rings, from the back of the crab
round to its face, over the lips and down its throat. The face is flat for this purpose: a point of
it is an angle to the right and an angle upwards, seen from the middle of the crab, and a mouth is
two loops there, the lips' outer edge and the line where they meet. A pose is the sheet for another
`Mouth`, less the sheet at rest; so poses add up as they do in the animation.

Built with the body 2.4 wide, and scaled to a crab of 25 centimetres.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from mesh import (
    Part,
    bump,
    catmull_rom,
    ellipsoid,
    loft,
    merged,
    mirrored,
    rotation,
    smoothstep,
    srgb,
    take,
    transformed,
    tube,
    with_normals,
    write_head,
)

if TYPE_CHECKING:
    from mesh import Points, Shape

OUT = Path(__file__).parents[2] / "posesets" / "crab" / "model.glb"
SCALE = 0.1

SHELL, RIM, SPOT = srgb("#d9432b"), srgb("#b52f24"), srgb("#f0875a")
FACE, LIPS, THROAT = srgb("#f08a55"), srgb("#cc4430"), srgb("#3a0a12")
TONGUE, TEETH = srgb("#e2607a"), srgb("#fff6e0")
WHITE, IRIS, BLACK, GLINT = srgb("#fbfaf4"), srgb("#2f8f83"), srgb("#0d0f14"), srgb("#ffffff")

AROUND = 56
"""Columns of the sheet: vertices around the mouth."""
COLUMN = np.arange(AROUND) * 2 * np.pi / AROUND
ACROSS, UP = np.cos(COLUMN), np.sin(COLUMN)
UPPER, LOWER = np.maximum(UP, 0), np.maximum(-UP, 0)

BODY = np.array([1.2, 0.86, 0.9])
"""Half the body: width, height, depth."""
SQUARENESS = 2.5
HEIGHT = -0.16
"""Height of the closed mouth in radians."""
EDGE = 1.35
"""Radians from the middle of the face at which it no longer moves with the lips."""


@dataclass(frozen=True)
class Mouth:
    """How far each pose stands: at most one of them, at 1, makes a morph target."""

    open: float = 0.0
    ring: float = 0.0
    bare: float = 0.0
    smile: float = 0.0
    frown: float = 0.0


REST = Mouth()
MOUTHS = {
    "mouthOpen": Mouth(open=1),
    "mouthOO": Mouth(ring=1),
    "bareTeeth": Mouth(bare=1),
    "smile": Mouth(smile=1),
    "frown": Mouth(frown=1),
}
TONGUES = ("tongueTip", "tongueBack", "tongueOut")
GESTURES = ("lids", "stalksUp", "stalksLeft", "stalksRight", "clawLeft", "clawRight", "clawsOpen")
POSES = (*MOUTHS, *TONGUES, *GESTURES)


# --- the sheet


def body(face: Points) -> Points:
    """Points (..., 2) of the flat face on the body (..., 3)."""
    angle = np.linalg.norm(face, axis=-1, keepdims=True)
    side = face / np.maximum(angle, 1e-9)
    way = np.concatenate([side * np.sin(angle), np.cos(angle)], -1)
    length = (np.abs(way / BODY) ** SQUARENESS).sum(-1, keepdims=True)
    point = way / length ** (1 / SQUARENESS)
    point[..., 1] -= 0.35 * np.maximum(point[..., 1], 0) ** 2  # room under the upper shell
    return point


def seam(mouth: Mouth) -> Points:
    """The line where the lips meet, (N, 2): upper and lower lip apart by as much as it opens."""
    wide = 0.64 * (1 - 0.12 * mouth.open - 0.69 * mouth.ring + 0.05 * mouth.bare)
    wide *= 1 + 0.2 * mouth.smile - 0.08 * mouth.frown
    corner = 0.1 - 0.17 * mouth.open - 0.1 * mouth.ring + 0.16 * mouth.smile - 0.26 * mouth.frown
    level = HEIGHT - 0.02 * mouth.ring - 0.05 * mouth.smile + 0.05 * mouth.frown
    square = 1 - ACROSS**6  # bared teeth show as a box, not as an almond
    upper = (0.06 * mouth.open + 0.15 * mouth.ring - 0.012) * UPPER + 0.16 * mouth.bare * square
    lower = (0.42 * mouth.open + 0.15 * mouth.ring - 0.012) * LOWER + 0.1 * mouth.bare * square
    y = level + corner * ACROSS**2 + np.where(UP >= 0, upper, -lower)
    return np.stack([wide * ACROSS, y], 1)


def rim(mouth: Mouth) -> Points:
    """The outer edge of the lips, (N, 2)."""
    thick = 0.088 + 0.02 * mouth.ring - 0.02 * mouth.bare
    lower = thick * (1.15 + 0.25 * mouth.frown)
    out = np.stack([0.075 * ACROSS, np.where(UP >= 0, thick * UPPER**0.7, -lower * LOWER**0.7)], 1)
    return seam(mouth) + out


def jaw(mouth: Mouth, face: Points, lip: Points) -> Points:
    """Displacement (..., 3) of points by the lower shell: `lip` says how much of a lip they are.

    `lip` is the share of the column's own side, the lower lip moving and the upper one staying.
    """
    below = smoothstep(HEIGHT + 0.15, HEIGHT - 0.75, face[..., 1])
    front = smoothstep(2.2, 0.9, np.linalg.norm(face, axis=-1))
    along = below * front * (1 - lip) + lip * LOWER**0.8
    return along[..., None] * np.array([0, -0.3, -0.06]) * mouth.open


def sheet(mouth: Mouth) -> Points:
    """The rings (R, N, 3) from the back of the crab to the bottom of its throat."""
    return np.concatenate([_skin(mouth), _lips(mouth), _throat(mouth)])


SKIN_RINGS, LIP_RINGS = 18, 6


def _skin(mouth: Mouth) -> Points:
    back = np.linspace(3.0, EDGE, 7)[:-1, None, None]
    circle = np.stack([ACROSS, UP], 1)
    share = np.linspace(0, 1, SKIN_RINGS - 6)[:, None, None] ** 0.85
    at_edge = np.broadcast_to(circle * EDGE, (SKIN_RINGS - 6, AROUND, 2))
    face = at_edge + (rim(mouth) - at_edge) * share
    face = np.concatenate([back * circle, face])
    lip = np.concatenate([np.zeros(6), share[:, 0, 0] ** 2])[:, None]
    return body(face) + jaw(mouth, face, lip) + _pushed(mouth, lip) + _cheeks(mouth, face)


def _pushed(mouth: Mouth, lip: Points) -> Points:
    """How far rings go forwards with the lips, (..., 3)."""
    out = 0.26 * mouth.ring - 0.03 * mouth.bare + 0.05 * mouth.frown * LOWER
    out = out + 0.02 * mouth.smile
    return (lip**2 * out)[..., None] * np.array([0, 0, 1.0])


def _cheeks(mouth: Mouth, face: Points) -> Points:
    """Round cheeks beside the corners of the mouth, rounder in a smile, (..., 3)."""
    x, y = np.abs(face[..., 0]), face[..., 1]
    middle = 0.82 + 0.04 * mouth.smile
    near = bump(np.hypot((x - middle) * 0.9, y - HEIGHT - 0.1 - 0.08 * mouth.smile), 0, 0.4)
    return (near * (0.05 + 0.09 * mouth.smile - 0.03 * mouth.ring))[..., None] * np.array(
        [0.3, 0.2, 1.0]
    )


def _lips(mouth: Mouth) -> Points:
    share = np.linspace(0, 1, LIP_RINGS + 1)[1:, None, None]
    outer, inner = rim(mouth), seam(mouth)
    face = outer + (inner - outer) * share
    lip = np.ones((LIP_RINGS, 1))
    full = 0.09 * (1 + 0.3 * mouth.ring - 0.3 * mouth.bare)
    bulge = full * np.sin(np.pi * share[..., 0] ** 0.8) * (0.35 + 0.65 * np.abs(UP) ** 0.5)
    bulge = bulge - 0.04 * share[..., 0] ** 3
    forward = bulge[..., None] * np.array([0, 0, 1.0])
    return body(face) + jaw(mouth, face, lip) + _pushed(mouth, lip) + forward


def _throat(mouth: Mouth) -> Points:
    """The inside of the mouth: behind the lips it widens, and closes far back."""
    edge, rest = _lips(mouth)[-1], _lips(REST)[-1]
    shift = (edge - rest) * (1 - 0.5 * mouth.ring)  # the ring is small, the throat stays
    shift[:, 0] = edge[:, 0] - rest[:, 0]
    pocket = np.stack([0.64 * ACROSS, 0.28 * UPPER - 0.27 * LOWER + HEIGHT + 0.02], 1)
    rings = []
    for room, depth, size, follow in THROAT_RINGS:
        ring = np.empty((AROUND, 3))
        ring[:, :2] = rest[:, :2] * (1 - room) + pocket * size * room
        ring[:, 2] = rest[:, 2] * (1 - depth) + 0.02
        rings.append(ring + shift * [follow**2, follow, follow])
    return np.array(rings)


# share of the pocket's outline, depth, size, and how far the ring goes with the lips
THROAT_RINGS = (
    (0.0, 0.07, 1.0, 0.98),
    (0.9, 0.16, 1.0, 0.84),
    (1.0, 0.36, 1.0, 0.76),
    (1.0, 0.8, 0.85, 0.5),
    (1.0, 0.95, 0.4, 0.2),
)


def mouth_parts() -> list[Part]:
    """Face, lips and throat: one sheet in three colours."""
    rest = sheet(REST)
    positions, triangles = loft(rest)
    targets = {name: loft(sheet(mouth))[0] - positions for name, mouth in MOUTHS.items()}
    whole = with_normals(Part("body", positions, triangles, targets=targets))
    ring = np.append(np.arange(rest.shape[0] * AROUND) // AROUND, [-1, rest.shape[0]])
    first = ring[triangles].min(1)
    skin, inside = SKIN_RINGS - 1, SKIN_RINGS + LIP_RINGS - 1
    parts = [
        take(whole, first < skin, "face", color=FACE, roughness=0.5),
        take(whole, (first >= skin) & (first < inside), "lips", color=LIPS, roughness=0.35),
        take(whole, first >= inside, "throat", color=THROAT, roughness=0.9),
    ]
    return [replace(parts[0], colors=_face_tints(parts[0].positions)), *parts[1:]]


def _face_tints(positions: Points) -> Points:
    """Pale below and around the mouth, blushing at the cheeks."""
    x, y, z = positions.T
    pale = smoothstep(0.1, -0.6, y) * smoothstep(-0.3, 0.5, z)
    blush = bump(np.hypot(np.abs(x) - 0.86, y - 0.02), 0, 0.34) * smoothstep(0, 0.4, z)
    tint = np.ones_like(positions) * [0.9, 0.84, 0.84]
    tint += pale[:, None] * np.array([0.1, 0.16, 0.16])
    return tint * (1 - blush[:, None] * np.array([0.06, 0.42, 0.4]))


# --- in the mouth


def jaw_shift(mouth: Mouth) -> Points:
    """How far the middle of the lower lip goes with the jaw, (3,)."""
    lowest = AROUND * 3 // 4
    return _lips(mouth)[-1, lowest] - _lips(REST)[-1, lowest]


JAW = jaw_shift(Mouth(open=1)) * [0, 0.86, 1] - [0, 0, 0.07]
UPPER_BACK, LOWER_BACK = np.array([0, 0.05, -0.1]), np.array([0, -0.19, -0.1])
LOWER_UP = np.array([0, 0.06, 0])
"""Movement of the teeth: out of the way of a ring, or up from behind the lower lip."""


def teeth() -> Part:
    """Two rows of blunt teeth, the upper middle ones the largest; shut at rest."""
    upper = ((0.105, 0.108, 0.17), (0.305, 0.092, 0.135), (0.47, 0.078, 0.105))
    lower = ((0.088, 0.084, 0.1), (0.25, 0.08, 0.1), (0.4, 0.074, 0.09))
    parts = []
    for row, up in ((upper, 1), (lower, -1)):
        for x, width, height in row:
            for side in (-1, 1):
                face = np.array([0.9 * x * side, HEIGHT])
                place = body(face) - [0, 0, 0.19 - 0.06 * x - 0.03 * up]
                y = place[1] + up * height * 0.98 - 0.05
                shape = ellipsoid([0, 0, 0], (width, 0.07, height), 6, 10, exponent=3)
                turn = rotation([0, 1, 0], side * x * 0.7) @ rotation([1, 0, 0], -np.pi / 2)
                part = Part("teeth", *shape, color=TEETH, roughness=0.25)
                part = transformed(part, turn=turn, move=[place[0], y, place[2]])
                still = np.zeros_like(part.positions)
                part.targets["mouthOO"] = still + (UPPER_BACK if up > 0 else LOWER_BACK)
                if up < 0:
                    part.targets["bareTeeth"] = still + LOWER_UP
                    part.targets["mouthOpen"] = still + JAW
                parts.append(part)
    return merged(parts, "teeth")


def tongue() -> Part:
    """A flat tongue on the floor of the mouth; it goes down with the jaw."""
    heights = [-0.36, -0.26, -0.22, -0.21, -0.21, -0.215]
    depths = [0.12, 0.25, 0.4, 0.52, 0.6, 0.64]
    radii = np.array(
        [(0.22, 0.1), (0.32, 0.11), (0.35, 0.1), (0.34, 0.085), (0.25, 0.065), (0.06, 0.02)]
    )
    moved = {  # how far each point of the path goes up, and forwards
        "tongueTip": ([0, 0.02, 0.08, 0.2, 0.32, 0.38], [0, 0, 0.02, 0.02, -0.02, -0.06]),
        "tongueBack": ([0.3, 0.32, 0.14, 0, -0.08, -0.09], [0, -0.04, -0.12, -0.17, -0.18, -0.18]),
        "tongueOut": ([0, 0.02, 0.06, 0.12, 0.08, -0.02], [0, 0.1, 0.36, 0.66, 0.92, 1.0]),
    }
    path = np.stack([np.zeros(6), heights, depths], 1)
    count, segments = 14, 16

    def shape(spine: Points) -> Shape:
        return tube(catmull_rom(spine, count), catmull_rom(radii, count), segments)

    positions, triangles = shape(path)
    part = Part("tongue", positions, triangles, color=TONGUE, roughness=0.4)
    groove = bump(positions[:, 0], 0, 0.1) * smoothstep(-0.3, -0.22, positions[:, 1])
    part.positions = positions - groove[:, None] * np.array([0, 0.025, 0])
    deep = smoothstep(0.62, 0.28, positions[:, 2])[:, None]
    part.colors = 1 - deep * np.array([0.55, 0.65, 0.65])
    for name, shift in moved.items():
        part.targets[name] = shape(path + np.stack([np.zeros(6), *shift], 1))[0] - positions
    tip = smoothstep(0.45, 0.62, positions[:, 2])
    part.targets["tongueTip"][:, 0] -= 0.4 * tip * positions[:, 0]
    front = smoothstep(0.2, 0.6, positions[:, 2])
    part.targets["tongueBack"][:, 0] -= 0.25 * front * positions[:, 0]
    share = smoothstep(-0.2, 0.2, positions[:, 2])[:, None]
    part.targets["mouthOpen"] = share * JAW * [0, 0.92, 0.5]
    return part


# --- what does not speak


def carapace() -> list[Part]:
    """The upper shell like a hat pulled down to the brows: a scalloped rim, and spots."""
    count = 64
    turn = np.arange(count)[::-1] * 2 * np.pi / count
    front = np.maximum(np.sin(turn), 0)  # turn runs over the front from the right to the left
    edge = 0.2 + 0.12 * front**2
    scallop = 1 + 0.045 * np.abs(np.sin(5 * turn)) ** 0.7 * smoothstep(0.95, 0.6, front)
    lip = [(0.86, 0.05), (0.95, -0.03), (1.0, -0.045), (1.035, 0.0), (1.02, 0.05)]
    dome = [(np.cos(rise) ** 0.75, rise) for rise in np.linspace(0.12, 0.5 * np.pi, 12)[:-1]]
    inset = np.array([i for i, _ in lip + dome])[:, None]
    height = [edge + drop for _, drop in lip]
    height += [edge * np.cos(rise) ** 2 + 0.04 + 0.76 * np.sin(rise) for _, rise in dome]
    rings = np.stack(
        [
            1.28 * inset * scallop * np.cos(turn),
            np.array(height),
            1.02 * inset * scallop * np.sin(turn),
        ],
        -1,
    )
    positions, triangles = loft(rings, cap_start=False)
    shell = with_normals(Part("shell", positions, triangles, color=SHELL, roughness=0.35))
    spots = []
    for row, column, size in SPOTS:
        at = row * count + column % count
        ahead = shell.normals[at]
        side = np.cross([0, 1, 0], ahead)
        side /= np.linalg.norm(side)
        turned = np.stack([side, np.cross(ahead, side), ahead], 1)
        spot = Part("spots", *ellipsoid([0, 0, 0], (size, size * 0.85, 0.014), 4, 14))
        spot = replace(spot, color=SPOT, roughness=0.4)
        spots.append(transformed(spot, turn=turned, move=positions[at]))
    return [shell, *spots]


SPOTS = (  # ring and column of the upper shell, radius
    (8, 45, 0.1),
    (7, 41, 0.06),
    (8, 38, 0.075),
    (8, 52, 0.07),
    (7, 55, 0.1),
    (9, 57, 0.06),
    (7, 59, 0.05),
)


def eyes() -> list[Part]:
    """Eyes on stalks, with heavy lids: a calm fellow.

    A target moves points on straight lines, so that lids which turn round the ball would cut
    through it half-way. They grow as they turn, and the ball is drawn in.
    """
    path = np.array([[0.36, 0.6, 0.36], [0.36, 0.82, 0.4], [0.37, 0.98, 0.42], [0.38, 1.1, 0.44]])
    spread = catmull_rom(path, 5)
    stalk = Part("stalks", *tube(spread, np.linspace(0.13, 0.1, 5), 12), color=SHELL, roughness=0.4)
    centre, radius = EYE, 0.34
    ball = Part("eyes", *ellipsoid(centre, [radius] * 3, 12, 18), color=WHITE, roughness=0.15)
    look = rotation([0, 1, 0], -0.1) @ rotation([1, 0, 0], 0.06)
    parts = [stalk, ball]
    for name, color, reach, lift in (
        ("irises", IRIS, 0.6, 1.012),
        ("pupils", BLACK, 0.38, 1.022),
    ):
        disc = _cap(centre, radius * lift, look, reach)
        parts.append(Part(name, *disc, color=color, roughness=0.1))
    shine = look @ rotation([0, 1, 0], 0.2) @ rotation([1, 0, 0], -0.22)
    glint = _cap(centre, radius * 1.035, shine, 0.11)
    lid = _cap(centre, radius * 1.045, rotation([0, 0, 1], -0.12) @ rotation([1, 0, 0], -1.9), 1.6)
    parts.append(Part("glints", *glint, color=GLINT, roughness=0.1))
    for part in parts[1:]:
        part.targets["lids"] = (centre - part.positions) * 0.18 - DIP
    stalk.targets["lids"] = -_bend(stalk) * DIP
    low = _cap(centre, radius * 1.03, rotation([1, 0, 0], 2.1), 1.0)
    shut_lid = rotation([1, 0, 0], 0.9) @ rotation([0, 0, 1], 0.12)
    for shape, turn in ((lid, shut_lid), (low, rotation([1, 0, 0], -0.6))):
        part = Part("lids", *shape, color=SHELL, roughness=0.4)
        shut = (part.positions - centre) @ turn.T * 1.08 + centre
        part.targets["lids"] = shut - part.positions - DIP
        parts.append(part)
    return [_on_a_stalk(part) for one in parts for part in (one, mirrored(one, one.name))]


EYE = np.array([0.38, 1.24, 0.46])
DIP = np.array([0, 0.08, 0])
"""How far a blink lowers the stalk."""


def _bend(part: Part) -> Points:
    """The share (V, 1) of points that goes with the eye: less towards the foot of a stalk."""
    foot = part.name == "stalks"
    return smoothstep(0.6, 1.1, part.positions[:, 1:2]) if foot else np.ones((1, 1))


def _on_a_stalk(part: Part) -> Part:
    """Let an eye, or its stalk, rise and turn."""
    centre = EYE * [np.sign(part.positions[:, 0].mean()), 1, 1]
    share = _bend(part)
    part.targets["stalksUp"] = share * np.array([0, 0.2, 0.03]) + np.zeros_like(part.positions)
    for name, way in (("stalksLeft", 1), ("stalksRight", -1)):
        turned = (part.positions - centre) @ rotation([0, 1, 0], 0.55 * way).T + centre
        part.targets[name] = share * (turned - part.positions + [0.14 * way, -0.02, 0])
    return part


def _cap(centre: Points, radius: float, turn: Points, reach: float) -> Shape:
    """The part of a sphere within `reach` radians of the direction that +z is turned to."""
    rings, segments = max(2, round(4 * reach)), 20
    angle = np.linspace(reach, 0, rings + 1)[:-1, None]
    around = np.arange(segments) * 2 * np.pi / segments
    points = np.stack(
        [
            np.sin(angle) * np.cos(around),
            np.sin(angle) * np.sin(around),
            np.broadcast_to(np.cos(angle), (rings, segments)),
        ],
        -1,
    )
    positions, triangles = loft(points, cap_start=False)
    positions[-1] = [0, 0, 1]
    return positions @ turn.T * radius + centre, triangles


def claws() -> list[Part]:
    """A big claw and a smaller one, as fiddler crabs have them: each rises, and both open."""
    parts = []
    shoulder, wrist = np.array([0.95, -0.3, 0.3]), np.array([1.62, -0.36, 0.52])
    raised, outwards = rotation([0, 0, 1], 0.4), rotation([0, 0, 1], -0.8)
    for side, size, name in ((1, 1.0, "clawLeft"), (-1, 1.3, "clawRight")):
        arm = catmull_rom([[0.95, -0.3, 0.3], [1.32, -0.5, 0.42], [1.62, -0.36, 0.52]], 9)
        thick = catmull_rom([[0.13], [0.15], [0.12]], 9)[:, 0]
        limb = Part("arms", *tube(arm, thick, 12, side=(0, 0, 1)), color=RIM, roughness=0.4)
        claw = [
            transformed(part, scale=size, turn=rotation([0, 0, 1], -0.12), move=[1.66, -0.18, 0.55])
            for part in _claw()
        ]
        for part in (limb, *claw):
            turned = part.positions
            if part is not limb:  # the claw leans away from the shell
                turned = (turned - wrist) @ outwards.T + wrist
            turned = (turned - shoulder) @ raised.T + shoulder
            part.targets[name] = turned - part.positions
        parts += [limb, *claw] if side > 0 else [mirrored(p, p.name) for p in (limb, *claw)]
    return parts


def _claw() -> list[Part]:
    palm = ellipsoid([0, 0.02, 0], (0.25, 0.27, 0.18), 9, 14)
    parts = [Part("claws", *palm, color=SHELL, roughness=0.35)]
    for path, first, opening in (
        ([[0.12, 0.1, 0], [0.25, 0.34, 0], [0.2, 0.56, 0], [0.02, 0.7, 0.02]], 0.16, -0.3),
        ([[-0.14, 0.12, 0], [-0.24, 0.3, 0], [-0.22, 0.46, 0], [-0.1, 0.58, 0.02]], 0.12, 0.5),
    ):
        along = np.linspace(0, 1, 10)
        shape = tube(catmull_rom(path, 10), first * (1 - along) ** 0.6 + 0.01, 10, side=(0, 0, 1))
        finger = Part("claws", *shape, color=SHELL, roughness=0.35)
        from_root = finger.positions - path[0]
        open_ = from_root @ rotation([0, 0, 1], opening).T
        finger.targets["clawsOpen"] = open_ - from_root
        parts.append(finger)
    return parts


def legs() -> list[Part]:
    """Three pointed legs on either side."""
    parts = []
    for turn, long in ((0.35, 1.0), (-0.1, 1.25), (-0.55, 1.3)):
        out = np.array([np.cos(turn), 0, np.sin(turn)])
        path = [
            out * 0.75 + [0, -0.45, 0],
            out * (0.75 + 0.5 * long) + [0, -0.42, 0],
            out * (0.75 + 0.66 * long) + [0, -0.72, 0],
            out * (0.75 + 0.62 * long) + [0, -1.08, 0],
        ]
        radii = catmull_rom([[0.12], [0.12], [0.085], [0.012]], 10)[:, 0]
        shape = tube(catmull_rom(path, 10), radii, 8, side=np.cross(out, [0, 1, 0]))
        leg = Part("legs", *shape, color=RIM, roughness=0.4)
        parts += [leg, mirrored(leg, "legs")]
    return parts


def crab() -> list[Part]:
    """Every part, those of one material together."""
    parts = [*mouth_parts(), teeth(), tongue(), *carapace(), *eyes(), *claws(), *legs()]
    names = list(dict.fromkeys(part.name for part in parts))
    whole = [merged([part for part in parts if part.name == name], name) for name in names]
    return [transformed(part, scale=SCALE) for part in whole]


def main() -> None:
    """Write the model to the path on the command line, or where it belongs."""
    out = Path(sys.argv[1]) if sys.argv[1:] else OUT
    write_head(out, crab(), POSES, "crab")


if __name__ == "__main__":
    main()
