#!/usr/bin/env bash
# usd-core 26.11 (Pixar's USD in Python; TOST licence), seen on 2026-11-28.
#
# Behaviour: a blend shape moves only if the schema `SkelBindingAPI` is applied both to the prim that has
# `skel:animationSource` and to the mesh that has `skel:blendShapes`. Without one of them, `UsdSkel.BakeSkinning`
# returns True, prints no warning, and bakes a mesh that stands still, although all properties are there. Only the
# validators of `UsdValidation`, which nothing runs by itself, name the missing schema.
#
# What a good engineer expects: the properties count without the schema, or baking fails, or warns.
# What to do: write `prepend apiSchemas = ["SkelBindingAPI"]` on both, and validate the stage.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/env"
"$work/env/bin/pip" install --quiet --disable-pip-version-check usd-core==26.11
"$work/env/bin/python" - > "$work/seen" 2> "$work/errors" <<'PYTHON' || { cat "$work/errors" >&2; exit 1; }
from importlib.metadata import version

from pxr import Gf, Sdf, Usd, UsdSkel, UsdValidation

STAGE = """#usda 1.0
(
    defaultPrim = "Face"
    metersPerUnit = 1
    upAxis = "Y"
)
def SkelRoot "Face"
{
    def Skeleton "Bones" (SKELETON_SCHEMA)
    {
        uniform token[] joints = ["root"]
        uniform matrix4d[] bindTransforms = [((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,0,1))]
        uniform matrix4d[] restTransforms = [((1,0,0,0), (0,1,0,0), (0,0,1,0), (0,0,0,1))]
        rel skel:animationSource = </Face/Speech>
    }
    def SkelAnimation "Speech"
    {
        uniform token[] joints = ["root"]
        float3[] translations = [(0, 0, 0)]
        quatf[] rotations = [(1, 0, 0, 0)]
        half3[] scales = [(1, 1, 1)]
        uniform token[] blendShapes = ["open"]
        float[] blendShapeWeights.timeSamples = { 0: [0], 1: [1] }
    }
    def Mesh "Lips" (MESH_SCHEMA)
    {
        int[] faceVertexCounts = [3]
        int[] faceVertexIndices = [0, 1, 2]
        point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
        uniform token[] skel:blendShapes = ["open"]
        rel skel:blendShapeTargets = </Face/Lips/open>
        rel skel:skeleton = </Face/Bones>
        def BlendShape "open"
        {
            uniform vector3f[] offsets = [(0, -1, 0)]
            uniform int[] pointIndices = [0]
        }
    }
}
"""
SCHEMA = 'prepend apiSchemas = ["SkelBindingAPI"]'

print("usd-core", version("usd-core"))
validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
for skeleton in ("", SCHEMA):
    for mesh in ("", SCHEMA):
        layer = Sdf.Layer.CreateAnonymous(".usda")
        text = STAGE.replace("SKELETON_SCHEMA", skeleton).replace("MESH_SCHEMA", mesh)
        layer.ImportFromString(text.replace(" ()", ""))
        stage = Usd.Stage.Open(layer)
        told = UsdValidation.ValidationContext(validators).Validate(stage)
        root = UsdSkel.Root(stage.GetPrimAtPath("/Face"))
        baked = UsdSkel.BakeSkinning(root, Gf.Interval(0, 1))
        points = stage.GetPrimAtPath("/Face/Lips").GetAttribute("points")
        ways = [points.Get(time)[0][1] for time in (0, 1)]
        print(f"skeleton {bool(skeleton)}, mesh {bool(mesh)}: baked {baked}, y {ways}", sorted({e.GetName() for e in told}))
PYTHON
cat "$work/errors" >> "$work/seen"
diff "$work/seen" - <<'SEEN'
usd-core 26.11
skeleton False, mesh False: baked True, y [0.0, 0.0] ['MissingSkelBindingAPI']
skeleton False, mesh True: baked True, y [0.0, 0.0] ['MissingSkelBindingAPI']
skeleton True, mesh False: baked True, y [0.0, 0.0] ['MissingSkelBindingAPI']
skeleton True, mesh True: baked True, y [0.0, -1.0] []
SEEN
echo "as before: without SkelBindingAPI on skeleton and mesh nothing moves, and only the validators say so"
