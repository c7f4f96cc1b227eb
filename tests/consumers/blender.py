"""Import files into a real Blender, and compare the results.

Blender as a module needs Python 3.11 and an environment of its own, so this is no test of the
suite; run it where an exporter has changed::

    python3.11 -m venv .venv-blender
    .venv-blender/bin/pip install bpy==5.0.1
    lipsync-lang run "Bob will tell" -l english -c arkit --model head.glb --keys lines:0 \
        -o line.py -o line.glb -o line.json
    .venv-blender/bin/python tests/consumers/blender.py head.glb line

It imports the model and runs the script on it, then imports our model with its animation, and
compares what Blender evaluates at twelve times of each with the JSON.
"""

import json
import runpy
import sys
from pathlib import Path

import bpy

CLOSE = 1e-4
TIMES = 12
WHOLE = 60
"""Frames per second of the scene into which the model is imported."""


def say(text):
    sys.stdout.write(text + "\n")


def weights(document, seconds):
    """Return the interpolated weights of each shape at a time."""
    place = (seconds - document["start"]) * document["fps"]
    first = min(max(int(place), 0), len(document["frames"]) - 2)
    before, after = document["frames"][first : first + 2]
    share = place - first
    values = [(1 - share) * one + share * other for one, other in zip(before, after, strict=True)]
    return dict(zip(document["poses"], values, strict=True))


def evaluated(frame):
    """Return the values of all shape keys of all meshes at a frame, by mesh and name."""
    bpy.context.scene.frame_set(int(frame // 1), subframe=frame % 1)
    graph = bpy.context.evaluated_depsgraph_get()
    meshes = [one for one in bpy.data.objects if one.type == "MESH" and one.data.shape_keys]
    return {
        (mesh.name, key.name): key.value
        for mesh in meshes
        for key in mesh.evaluated_get(graph).data.shape_keys.key_blocks[1:]
    }


def compare(what, document, first):
    """Compare Blender's values with the weights; `first` is the first frame of the sound."""
    render = bpy.context.scene.render
    rate = render.fps / render.fps_base
    length = (len(document["frames"]) - 1) / document["fps"]
    worst, seen = 0.0, 0
    for number in range(TIMES):
        seconds = document["start"] + length * number / (TIMES - 1)
        there, ours = evaluated(first + seconds * rate), weights(document, seconds)
        for (_, name), value in there.items():
            worst = max(worst, abs(value - ours.get(name, 0.0)))
            seen += value > 0
    moving = len({mesh for mesh, _ in there})
    say(f"{what}: {moving} meshes at {rate:g} fps, {seen} values above 0, off by {worst:.2g}")
    assert seen, f"{what}: nothing moves"
    assert worst <= CLOSE, f"{what}: off by {worst}"


def main(model, line):
    document = json.loads(Path(f"{line}.json").read_text("utf-8"))
    say(f"Blender {bpy.app.version_string}")

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=model)
    bpy.ops.object.select_all(action="DESELECT")
    runpy.run_path(f"{line}.py")
    render = bpy.context.scene.render
    assert abs(render.fps / render.fps_base - document["fps"]) < CLOSE
    compare("script", document, 1 + document["offset"] * document["fps"])

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = WHOLE  # the importer takes `fps_base` the wrong way round
    bpy.ops.import_scene.gltf(filepath=f"{line}.glb")
    compare("model", document, max(document["offset"], -document["start"]) * WHOLE)


if __name__ == "__main__":
    main(*sys.argv[1:])
