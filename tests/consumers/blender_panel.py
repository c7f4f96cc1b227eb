"""Install the add-on in a real Blender, and let a face speak by its panel.

Blender as a module needs an environment of its own, so this is no test of the suite; run it where
the add-on has changed: bpy 5.0 needs Python 3.11, and 5.3 needs 3.13::

    python3.13 -m venv .venv-blender
    .venv-blender/bin/pip install bpy==5.3.0
    .venv-blender/bin/python tests/consumers/blender_panel.py .venv/bin/lipsync-lang

It selects the shipped head, speaks a text, and tells the largest value of each shape key.
"""

import sys
from pathlib import Path

import bpy

import addon_utils  # isort: skip, it is there after bpy

ROOT = Path(__file__).parents[2]
PANEL = "lipsync_lang_panel"


def main():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    addon_utils.enable("io_scene_gltf2")
    bpy.ops.preferences.addon_install(filepath=str(ROOT / f"docs/downloads/{PANEL}.py"))
    bpy.ops.preferences.addon_enable(module=PANEL)
    bpy.context.preferences.addons[PANEL].preferences.program = sys.argv[1]
    bpy.ops.import_scene.gltf(filepath=str(ROOT / "posesets/facefx/model.glb"))
    scene = bpy.context.scene
    scene.render.fps = 24
    (face,) = (one for one in bpy.data.objects if one.type == "MESH" and one.data.shape_keys)
    bpy.ops.object.select_all(action="DESELECT")
    face.select_set(state=True)
    line = scene.lipsync_line
    line.text, line.frame = "Hello, people. Bob buys maps.", 25
    assert bpy.ops.lipsync.speak() == {"FINISHED"}
    largest = {}
    for frame in range(10, 110):
        scene.frame_set(frame)
        seen = face.evaluated_get(bpy.context.evaluated_depsgraph_get()).data.shape_keys
        for key in seen.key_blocks[1:]:
            largest[key.name] = max(largest.get(key.name, 0.0), key.value)
    assert largest["open"] > 0.3, "the mouth stays shut"
    assert largest["PBM"] > 0.7, "the lips never meet"
    assert len(scene.sequence_editor.strips) == 1
    sys.stdout.write(f"Blender {bpy.app.version_string}: {largest}\n")


main()
