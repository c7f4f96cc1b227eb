"""A VRM animation, `.vrma`: a GLB whose nodes stand for the expressions of an avatar.

Based on VRMC_vrm_animation 1.0 (github.com/vrm-c/vrm-specification). The x of a node's translation
is the weight of its expression. Columns that match no preset of VRM are custom expressions. Bones
are left out: the extension allows them only as part of a whole humanoid. Keys are joined by
straight lines, because players read no other values. glTF has no negative time; `audio_start` in
the animation's extras is the start of the sound in seconds.
"""

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import binary_writer
from lipsync_lang.animations.fixed import boneless, late, names, shape_columns
from lipsync_lang.animations.keys import ERROR, KeyedCurve
from lipsync_lang.json_object import Json
from lipsync_lang.rigs.container import BINARY_CHUNK, JSON_CHUNK, write_parts
from lipsync_lang.rigs.shape_matching import places

if TYPE_CHECKING:
    from lipsync_lang.arrays import Floats

VRM_ANIMATION = "VRMC_vrm_animation"
FLOAT_TYPE = 5126


def doubts(animation: Animation) -> Iterator[str]:
    """Yield warnings about bones and a delayed sound."""
    yield from boneless(animation, "a .vrma")
    yield from late(animation, "a .vrma")


@binary_writer("vrma", suffix=".vrma", remarks=doubts)
def write_vrma(animation: Animation, out: BinaryIO) -> None:
    """A VRM animation: keyframes of expressions, for every VRM avatar."""
    presets = set(names("vrm.txt").shapes)
    curves = _expressions(animation)
    made = [_rows(2 * number, curve) for number, curve in enumerate(curves)]
    blocks = [block for _, own in made for block in own]
    sizes = np.cumsum([0, *map(len, blocks)]).tolist()
    nodes = {curve.name: {"node": number} for number, curve in enumerate(curves)}
    known = {
        "preset": {name: node for name, node in nodes.items() if name in presets},
        "custom": {name: node for name, node in nodes.items() if name not in presets},
    }
    line = {
        "name": animation.title,
        "channels": [
            {"sampler": n, "target": {"node": n, "path": "translation"}} for n in range(len(curves))
        ],
        "samplers": [{"input": 2 * n, "output": 2 * n + 1} for n in range(len(curves))],
        "extras": {"audio_start": round(animation.begins, 6)},
    }
    expressions = {kind: own for kind, own in known.items() if own}
    document = {
        "asset": {"version": "2.0", "generator": "lipsync_lang"},
        "extensionsUsed": [VRM_ANIMATION],
        "extensions": {VRM_ANIMATION: {"specVersion": "1.0", "expressions": expressions}},
        "scene": 0,
        "scenes": [{"nodes": [*range(len(curves))]}],
        "nodes": [{"name": curve.name} for curve in curves],
        "animations": [line],
        "accessors": [accessor for accessors, _ in made for accessor in accessors],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(block)}
            for start, block in zip(sizes, blocks, strict=False)
        ],
        "buffers": [{"byteLength": sizes[-1]}],
    }
    text = json.dumps(document, ensure_ascii=False).encode("utf-8", "backslashreplace")
    write_parts(out, [(JSON_CHUNK, [text, b" " * (-len(text) % 4)]), (BINARY_CHUNK, blocks)])


def _expressions(animation: Animation) -> list[KeyedCurve]:
    """Return the keyframes of each expression; of two columns for a preset, the larger counts."""
    columns = shape_columns(animation)
    channels = [animation.columns[column] for column in columns]
    presets = places(channels, names("vrm.txt").shapes)
    sums: dict[str, Floats] = {}
    for number, column in enumerate(columns):
        values = animation.weights[:, column].clip(0.0, 1.0)
        for name in presets.get(number, [channels[number].name]):
            sums[name] = np.maximum(sums[name], values) if name in sums else values
    shown = replace(
        animation, poses=(*sums,), channels=(), weights=np.column_stack([*sums.values()])
    )
    return shown.keyframes(ERROR, lines=True)


def _rows(view: int, curve: KeyedCurve) -> tuple[list[Json], list[bytes]]:
    """Return the accessors of times and weights, in two buffer views, and their bytes."""
    times = curve.times.astype("<f4")
    kept = np.append(True, np.diff(times) > 0)
    weights = np.zeros((int(kept.sum()), 3), "<f4")
    weights[:, 0] = curve.values[kept]
    times = times[kept]
    plain: Json = {"componentType": FLOAT_TYPE, "count": len(times)}
    bounds = {"min": [float(times[0])], "max": [float(times[-1])]}
    accessors = [
        {"bufferView": view, "type": "SCALAR", **plain, **bounds},
        {"bufferView": view + 1, "type": "VEC3", **plain},
    ]
    return accessors, [times.tobytes(), weights.tobytes()]
