"""A Godot animation resource, for use in an AnimationPlayer.

The file uses the text resource format 2 (docs.godotengine.org, "TSCN file format"), which Godot 3
writes and Godot 4 still reads, including `PoolRealArray`. Each shape is a value track on the
property `blend_shapes/<name>` of a MeshInstance. For models with several meshes, the track begins
with the name of the node; otherwise the node is the root of the AnimationPlayer. Godot has no
negative time. If
movement starts before the sound, all times are shifted, and the metadata `audio_start` (Godot 4)
is the start of the sound in seconds.

With `keys`, tracks are Bezier tracks instead. Handles a third of the way to the next key make their
curves cubic in time.
"""

from collections.abc import Iterable, Mapping
from functools import partial
from typing import TextIO

import numpy as np

from lipsync_lang.animations.keys import ERROR, KeyedCurve
from lipsync_lang.animations.moving_shapes import keys, node_chains, shapes, unshown
from lipsync_lang.animations.writers import Animation, writer

GODOT = "Godot"

IN_NODES = str.maketrans("", "", '.:@/"%')
"""Characters that Godot removes from node names."""

IN_SHAPES = str.maketrans(":", "_")
"""Characters that Godot replaces in shape names."""


@writer("godot", suffix=".tres", remarks=partial(unshown, program=GODOT))
def write_godot(animation: Animation, out: TextIO) -> None:
    """An animation for Godot 3 and 4: a track of keyframes for each blend shape."""
    tracks = shapes(animation)
    out.write(
        '[gd_resource type="Animation" format=2]\n\n[resource]\n'
        f"length = {_number(animation.timeline[-1])}\n"
        f"step = {_number(1 / animation.fps)}\n"
    )
    curves, chains = keys(animation, tracks, ERROR), node_chains(animation)
    placed = (
        (node, track, curve)
        for track, curve in zip(tracks, curves, strict=True)
        for node in _nodes(track.mesh, chains)
    )
    for number, (node, track, curve) in enumerate(placed):
        kind = "bezier" if curve.cubic else "value"
        path = f"{node}:blend_shapes/{track.name.translate(IN_SHAPES)}"
        path = path.replace("\\", "\\\\").replace('"', '\\"')
        out.write(
            f'tracks/{number}/type = "{kind}"\n'
            f'tracks/{number}/path = NodePath("{path}")\n'
            f"tracks/{number}/interp = 1\n"
            f"tracks/{number}/loop_wrap = true\n"
            f"tracks/{number}/imported = false\n"
            f"tracks/{number}/enabled = true\n"
            f"tracks/{number}/keys = {{\n{_keys(curve)}}}\n"
        )
    out.write(f"metadata/audio_start = {_number(animation.begins)}\n")


def _nodes(mesh: str, chains: Mapping[str, list[list[str]]]) -> Iterable[str]:
    """Return the nodes that show a mesh, as Godot names them; the root for the only mesh."""
    if not mesh:
        return (".",)
    names = (chain[-1] for chain in chains.get(mesh, [[mesh]]))
    return dict.fromkeys(name.translate(IN_NODES) or "." for name in names)


def _keys(curve: KeyedCurve) -> str:
    """Format the keys of a track; those of Bezier curves have two handles, relative to the key."""
    if not curve.cubic:
        return (
            f'"times": {_pool("Real", map(_number, curve.times))},\n'
            f'"transitions": {_pool("Real", "1" * len(curve.times))},\n'
            f'"update": 0,\n"values": [ {", ".join(map(_number, curve.values))} ]\n'
        )
    thirds = np.diff(curve.times) / 3
    before, after = np.append(0, thirds), np.append(thirds, 0)
    handles = (-before, -before * curve.arriving, after, after * curve.leaving)
    # Adding 0.0 turns a negative zero into zero, which is one character shorter.
    points = np.column_stack((curve.values, *handles)).ravel() + 0.0
    return (
        f'"handle_modes": {_pool("Int", "0" * len(curve.times))},\n'
        f'"points": {_pool("Real", map(_number, points))},\n'
        f'"times": {_pool("Real", map(_number, curve.times))}\n'
    )


def _pool(kind: str, items: Iterable[str]) -> str:
    """Return a packed array of Godot 3, which Godot 4 reads as well."""
    return f"Pool{kind}Array( {', '.join(items)} )"


def _number(value: float) -> str:
    """Format a number with a decimal point, so that Godot reads a float."""
    text = f"{value:.6f}".rstrip("0")
    return text + "0" if text.endswith(".") else text
