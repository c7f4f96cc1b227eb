"""Heads of a few points whose shapes move the mouth: made like avatars of several makers."""

import json
import struct

import numpy as np

ACROSS = np.linspace(-0.5, 0.5, 11)
UPPER, LOWER, CHIN = slice(0, 11), slice(11, 22), slice(22, 33)
POINTS = np.concatenate(
    [np.column_stack([ACROSS, np.full(11, y), 0.3 - ACROSS**2]) for y in (0.01, -0.01, -0.7)]
)
"""Both lips, which touch, and a chin; the corners lie at x = -0.5 and 0.5."""

ARKIT = (
    "jawOpen", "mouthClose", "mouthFunnel", "mouthPucker", "mouthRollLower", "mouthRollUpper",
    "mouthSmileLeft", "mouthSmileRight", "mouthStretchLeft", "mouthStretchRight",
    "mouthPressLeft", "mouthPressRight", "mouthLowerDownLeft", "mouthLowerDownRight",
    "mouthUpperUpLeft", "mouthUpperUpRight", "mouthShrugLower", "mouthShrugUpper", "tongueOut",
)  # fmt: skip
OCULUS = tuple(
    f"viseme_{n}"
    for n in ("PP", "FF", "TH", "DD", "kk", "CH", "SS", "nn", "RR", "aa", "E", "I", "O", "U")
)
VROID = tuple(f"Face.M_F00_000_Fcl_MTH_{n}" for n in "AIUEO")
OPENINGS = {
    "jawOpen": 0.6, "viseme_aa": 0.5, "viseme_O": 0.3, "viseme_E": 0.3, "viseme_I": 0.15,
    **dict(zip(VROID, (0.6, 0.15, 0.1, 0.3, 0.4), strict=True)),
}  # fmt: skip
NARROWINGS = {"mouthPucker": 0.3, "viseme_U": 0.25, "viseme_O": 0.1, "viseme_CH": 0.1}


def moved(name, dead=()):
    """Return the offsets of a shape: it opens, narrows, or moves the lips a little forward."""
    offsets = np.zeros_like(POINTS)
    if name in dead:
        return offsets
    if name in OPENINGS:
        offsets[LOWER, 1] = -OPENINGS[name] * (1 - 4 * ACROSS**2)
        offsets[CHIN, 1] = -OPENINGS[name]
    else:
        aside = name.endswith("Left") - int(name.endswith("Right"))
        offsets[:22, 2] = 0.05 * (POINTS[:22, 0] * aside >= 0)
    offsets[:22, 0] = -NARROWINGS.get(name, 0) * POINTS[:22, 0]
    return offsets


def face(  # noqa: PLR0913 each a way in which heads differ
    path,
    *shapes,
    dead=(),
    above=("Armature",),
    meshes=("Wolf3D_Head",),
    still=(),
    turn=None,
    **rest,
):
    """Write a model whose meshes lie below the nodes `above`, each with all the shapes.

    Shapes of `dead` move no point, and neither do those of the meshes `still`. The (3, 3) `turn` is
    applied to all points.
    """
    arrays = [POINTS, *(moved(name, dead) for name in shapes)]
    arrays = arrays if turn is None else [array @ turn for array in arrays]
    blocks = [array.astype("<f4").tobytes() for array in arrays]
    chain = [{"name": name, "children": [n + 1]} for n, name in enumerate(above)]
    first = len(above)
    if chain:
        chain[-1]["children"] = [*range(first, first + len(meshes))]
    targets = [{"POSITION": n} for n in range(1, len(arrays))]
    primitive = {"attributes": {"POSITION": 0}, "mode": 0, "targets": targets}
    unmoved = {**primitive, "targets": [{}] * len(shapes)}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0] if chain else [*range(len(meshes))]}],
        "nodes": [*chain, *({"name": name, "mesh": n} for n, name in enumerate(meshes))],
        "meshes": [
            {
                "name": name, "primitives": [unmoved if name in still else primitive],
                "extras": {"targetNames": [*shapes]},
            }
            for name in meshes
        ],
        "accessors": [
            {
                "bufferView": n, "componentType": 5126, "count": len(POINTS), "type": "VEC3",
                "min": array.astype("<f4").min(axis=0).tolist(),
                "max": array.astype("<f4").max(axis=0).tolist(),
            }
            for n, array in enumerate(arrays)
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": n * len(block), "byteLength": len(block)}
            for n, block in enumerate(blocks)
        ],
        "buffers": [{"byteLength": sum(map(len, blocks))}],
        **rest,
    }  # fmt: skip
    text, data = json.dumps(document).encode(), b"".join(blocks)
    text += b" " * (-len(text) % 4)
    body = struct.pack("<II", len(text), 0x4E4F534A) + text
    body += struct.pack("<II", len(data), 0x004E4942) + data
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body)
    return path
