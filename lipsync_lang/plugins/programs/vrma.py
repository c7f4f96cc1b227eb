"""A VRM animation, `.vrma`: a GLB whose nodes stand for the expressions of an avatar.

Based on VRMC_vrm_animation 1.0 (github.com/vrm-c/vrm-specification). The x of a node's translation
is the weight of its expression. Columns that match no preset of VRM are custom expressions. Turns
of the head are the rotation of a bone, for which the extension wants a whole humanoid at rest:
`vrm-humanoid.json`, with T-pose, y up and z to the front. Other bones are left out. Keys are
joined by straight lines, because players read no other values. glTF has no negative time;
`audio_start` in the animation's extras is the start of the sound in seconds.
"""

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO

import numpy as np

from lipsync_lang.animations.fixed import names, shape_columns, shapes_from_zero
from lipsync_lang.animations.keys import ERROR, KeyedCurve, needed
from lipsync_lang.animations.moving_shapes import expressions, expressions_with
from lipsync_lang.animations.writers import Animation, binary_writer
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.container import write_container
from lipsync_lang.faces.rigs.shape_matching import placed
from lipsync_lang.faces.rigs.transforms import HeadTurn

VRM_ANIMATION = "VRMC_vrm_animation"
FLOAT_TYPE = 5126

VRM_PRESETS = Path(__file__).with_name("vrm-names.txt")

HUMANOID = Path(__file__).with_name("vrm-humanoid.json")
"""The bones that VRM requires, as nodes of glTF."""

SHUTTING = ("block", "blend")
"""Values of `overrideMouth` at which players shut a mouth that speaks."""

TURN_ERROR = 0.001
"""Largest error of the components of a quaternion: a tenth of a degree."""


def without_presets(animation: Animation) -> Iterator[str]:
    """Yield warnings about what a `.vrma` cannot hold, and about poses that are no presets."""
    yield from shapes_from_zero(animation, "a .vrma", head=True)
    shut = expressions_with(animation, "overrideMouth", SHUTTING)
    if lost := [name for name, values in _moves(animation) if name in shut and values.any()]:
        yield (
            f"{animation.model}: '{lost[0]}' shuts a mouth that speaks (`overrideMouth`), so the "
            "file leaves it out; set its override of the mouth to none in the avatar"
        )
    binary = expressions_with(animation, "isBinary", [True])
    if jump := [name for name, values in _moves(animation) if name in binary and values.any()]:
        yield (
            f"{animation.model}: '{jump[0]}' is on or off (`isBinary`), so players show nothing of "
            "it up to a weight of 0.5, and all of it above; switch that off in the avatar"
        )
    known = {*names(VRM_PRESETS).shapes, *expressions(animation)}
    if not any(name in known for name, _ in _moves(animation)):
        yield (
            "none of these poses is a preset of VRM, so only avatars move that have custom "
            "expressions of their names, as for perfect sync; for all, take a pose set of presets"
        )


@binary_writer("vrma", suffix=".vrma", remarks=without_presets)
def write_vrma(animation: Animation, out: BinaryIO) -> None:
    """A VRM animation: keyframes of expressions and of the head, for every VRM avatar."""
    presets = set(names(VRM_PRESETS).shapes)
    curves, turned = _expressions(animation), _head(animation)
    bones = [] if turned is None else json.loads(HUMANOID.read_text("utf-8"))
    nodes = {one.name: {"node": number} for number, one in enumerate(curves, len(bones))}
    humanoid = {bone["name"]: {"node": number} for number, bone in enumerate(bones)}
    tracks = [
        (nodes[one.name]["node"], "translation", one.times, np.outer(one.values, (1.0, 0.0, 0.0)))
        for one in curves
    ]
    if turned is not None:
        tracks.append((humanoid["head"]["node"], "rotation", *turned))
    made = [_rows(2 * number, *keys) for number, (_, _, *keys) in enumerate(tracks)]
    blocks = [block for _, own in made for block in own]
    sizes = np.cumsum([0, *map(len, blocks)]).tolist()
    known = {
        "preset": {name: node for name, node in nodes.items() if name in presets},
        "custom": {name: node for name, node in nodes.items() if name not in presets},
    }
    line = {
        "name": animation.title,
        "channels": [
            {"sampler": n, "target": {"node": node, "path": path}}
            for n, (node, path, *_) in enumerate(tracks)
        ],
        "samplers": [{"input": 2 * n, "output": 2 * n + 1} for n in range(len(tracks))],
        "extras": {"audio_start": round(animation.begins, 6)},
    }
    expressions = {kind: own for kind, own in known.items() if own}
    extension: Json = {"specVersion": "1.0", "expressions": expressions}
    if humanoid:
        extension["humanoid"] = {"humanBones": humanoid}
    document = {
        "asset": {"version": "2.0", "generator": "lipsync_lang"},
        "extensionsUsed": [VRM_ANIMATION],
        "extensions": {VRM_ANIMATION: extension},
        "scene": 0,
        # The first bone is the parent of all others; expressions have no parent.
        "scenes": [{"nodes": [*range(bool(bones)), *(one["node"] for one in nodes.values())]}],
        "nodes": [*bones, *({"name": name} for name in nodes)],
        "animations": [line],
        "accessors": [accessor for accessors, _ in made for accessor in accessors],
        "bufferViews": [
            {"buffer": 0, "byteOffset": start, "byteLength": len(block)}
            for start, block in zip(sizes, blocks, strict=False)
        ],
        "buffers": [{"byteLength": sizes[-1]}],
    }
    text = json.dumps(document, ensure_ascii=False).encode("utf-8", "backslashreplace")
    write_container(out, text, blocks)


def _expressions(animation: Animation) -> list[KeyedCurve]:
    """Return the keyframes of each expression; of two columns for a preset, the larger counts."""
    sums: dict[str, Floats] = {}
    shut = expressions_with(animation, "overrideMouth", SHUTTING)
    for name, values in _moves(animation):
        if name not in shut:
            sums[name] = np.maximum(sums[name], values) if name in sums else values
    shown = replace(
        animation, poses=(*sums,), channels=(), weights=np.column_stack([*sums.values()])
    )
    return shown.keyframes(ERROR, lines=True)


def _moves(animation: Animation) -> Iterator[tuple[str, Floats]]:
    """Yield the values (T,) of expressions by their names: those of the avatar, or of VRM."""
    columns = shape_columns(animation)
    channels = [animation.columns[column] for column in columns]
    presets = placed(channels, names(VRM_PRESETS).shapes).shapes
    # VRM 0 calls a preset `a`, and its loaders take `aa` for it: presets come first.
    known = placed(channels, expressions(animation)).shapes | presets
    for number, column in enumerate(columns):
        values = animation.weights[:, column].clip(0.0, 1.0)
        for name in known.get(number, [channels[number].name]):
            yield name, values


def _head(animation: Animation) -> tuple[Floats, Floats] | None:
    """Return the times and the quaternions of the head; None for a head that rests."""
    turn = HeadTurn.of(animation.columns)
    if not animation.weights[:, [*turn.columns]].any():
        return None
    turned = turn(animation.weights)
    kept = needed(animation.timeline, turned, TURN_ERROR)
    return animation.timeline[kept], turned[kept]


def _rows(view: int, times: Floats, values: Floats) -> tuple[list[Json], list[bytes]]:
    """Return the accessors of times and values, in two buffer views, and their bytes."""
    seconds = times.astype("<f4")
    # glTF wants rising times; close keys may be the same number in single precision.
    kept = np.append(True, np.diff(seconds) > 0)
    seconds, rows = seconds[kept], values[kept].astype("<f4")
    plain: Json = {"componentType": FLOAT_TYPE, "count": len(seconds)}
    bounds = {"min": [float(seconds[0])], "max": [float(seconds[-1])]}
    accessors = [
        {"bufferView": view, "type": "SCALAR", **plain, **bounds},
        {"bufferView": view + 1, "type": f"VEC{rows.shape[1]}", **plain},
    ]
    return accessors, [seconds.tobytes(), rows.tobytes()]
