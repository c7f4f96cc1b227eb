"""A glTF model with an animation: the weights of its morph targets by name.

Of several animations, the last is read, because new ones are appended. Of several meshes with the
same shape, the first animated mesh is used. `audio_start` in the animation's extras is the start
of the sound in seconds; by default, the sound starts with the animation.
"""

from pathlib import Path

import numpy as np

from lipsync_lang.animations.animation_readers import Recording, fail, reader
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.accessors import MAX_ACCESSOR_VALUES, Accessors
from lipsync_lang.faces.rigs.model import Model, numbers, read_model
from lipsync_lang.faces.rigs.tracks import drives


@reader("glb", suffix=".glb")
def read_glb(path: Path, content: bytes) -> Recording:
    """The last animation of a GLB: weights of morph targets by name."""
    del content  # read in parts, on demand
    model = read_model(path)
    takes = model.document.get("animations", [])
    if not takes:
        fail(path, "has no animation", "export the model with its animation")
    curves = _curves(model, takes[-1])
    if not curves:
        fail(path, "its last animation moves no morph target", "bake shape keys into it")
    frames = max((times for times, _ in curves.values()), key=len)
    if len(frames) * len(curves) > MAX_ACCESSOR_VALUES:
        what = f"has {len(curves)} shapes at {len(frames)} times, too many to judge"
        fail(path, what, "export the shapes that move, one line at a time")
    values = np.column_stack([np.interp(frames, *curve) for curve in curves.values()])
    remarks = [f"{path}: has {len(takes)} animations; the last is judged"] * (len(takes) > 1)
    extras = takes[-1].get("extras")
    shift = 0.0
    if isinstance(extras, dict) and "audio_start" in extras:
        [shift] = numbers(path, "audio_start of its animation", [extras["audio_start"]], 1)
    return Recording(str(path), frames - shift, tuple(curves), values, remarks=tuple(remarks))


def _curves(model: Model, take: Json) -> dict[str, tuple[Floats, Floats]]:
    """Return the times and weights of each animated shape."""
    meshes = {mesh.number: mesh for mesh in model.meshes}
    nodes = model.document.get("nodes", [])
    curves: dict[str, tuple[Floats, Floats]] = {}
    for drive in drives(model, Accessors(model), take, {"weights"}):
        mesh = meshes.get(nodes[drive.node].get("mesh", -1))
        if mesh is None:
            continue
        given, count = drive.values.shape[1], len(mesh.shapes)
        if given != count:
            what = f"has {given} weights at each key of '{mesh.name}', which has {count} shapes"
            fail(model.path, what, "export it again")
        for name, column in zip(mesh.shapes, drive.values.T, strict=True):
            # Some exporters give every mesh a track, even one at rest; the first that moves counts.
            if name not in curves or not curves[name][1].any():
                curves[name] = (drive.times, column)
    return curves
