"""A model with an animation in it: the weights of its morph targets, by their names.

Of several animations the last is read, which is the one that was added last; of several meshes
with a shape of one name, the first that moves it. `audio_start` in the animation's extras, as
written here, says when the sound begins; without it the sound begins with the animation.
"""

from pathlib import Path
from typing import Any

import numpy as np

from lipsync_lang.animations.readers.animation_readers import Floats, Recording, fail, reader
from lipsync_lang.rigs.container import binary_of
from lipsync_lang.rigs.model import Mesh, Model, is_index, read_model

SCALES = {5120: 127.0, 5121: 255.0, 5122: 32767.0, 5123: 65535.0, 5126: 1.0}
TYPES = {5120: "i1", 5121: "u1", 5122: "<i2", 5123: "<u2", 5126: "<f4"}
"""Component types of accessors, and what their whole numbers are shares of."""

STEPS = {"LINEAR", "STEP", "CUBICSPLINE"}


@reader("glb", suffix=".glb")
def read_glb(path: Path, content: bytes) -> Recording:
    """The last animation of a GLB: weights of morph targets by name."""
    del content  # read by parts, as they are needed
    model = read_model(path)
    takes = model.document.get("animations", [])
    if not takes:
        fail(path, "has no animation", "export the model with its animation")
    take = takes[-1]
    data = binary_of(path, model.document, model.chunks)
    read = _Accessors(model, data)
    curves: dict[str, tuple[Floats, Floats]] = {}
    for mesh, sampler in _driven(model, take):
        times, values = _keys(read, sampler, len(mesh.shapes))
        for name, column in zip(mesh.shapes, values.T, strict=True):
            if name not in curves or not curves[name][1].any():
                curves[name] = (times, column)
    if not curves:
        fail(path, "its last animation moves no morph target", "bake shape keys into it")
    frames = max((times for times, _ in curves.values()), key=len)
    values = np.column_stack([np.interp(frames, *curve) for curve in curves.values()])
    extras = take.get("extras")
    start = extras.get("audio_start", 0.0) if isinstance(extras, dict) else 0.0
    shift = float(start) if isinstance(start, (int, float)) else 0.0
    remarks = [f"{path}: has {len(takes)} animations; the last is judged"] * (len(takes) > 1)
    return Recording(str(path), frames - shift, tuple(curves), values, remarks=tuple(remarks))


def _driven(model: Model, take: dict[str, Any]) -> list[tuple[Mesh, dict[str, Any]]]:
    """Return each mesh that an animation drives, and the sampler that does."""
    meshes = {mesh.number: mesh for mesh in model.meshes}
    nodes, samplers = model.document.get("nodes", []), take.get("samplers", [])
    found = []
    for channel in take.get("channels", []):
        target = channel.get("target", {})
        node, number = target.get("node"), channel.get("sampler")
        if target.get("path") != "weights" or not is_index(node, len(nodes)):
            continue
        mesh = meshes.get(nodes[node].get("mesh", -1))
        if mesh is not None and is_index(number, len(samplers)):
            found.append((mesh, samplers[number]))
    return found


def _keys(read: "_Accessors", sampler: dict[str, Any], count: int) -> tuple[Floats, Floats]:
    """Return the (T,) times of a sampler and its (T, count) values."""
    times, values = read(sampler.get("input")), read(sampler.get("output"))
    way = sampler.get("interpolation", "LINEAR")
    if way not in STEPS:
        fail(read.path, f"its keys are joined in an unknown way ('{str(way)[:20]}')")
    each = 3 if way == "CUBICSPLINE" else 1
    if len(values) != len(times) * count * each:
        fail(read.path, f"has {len(values)} weights for {len(times)} keys of {count} shapes")
    table = values.reshape(len(times), each, count)[:, each // 2]
    if way == "STEP" and len(times) > 1:  # a key just before each next one, so that lines step
        before = times[1:] - np.minimum(np.diff(times) / 2, 1e-4)
        order = np.argsort(np.concatenate((times, before)), kind="stable")
        return np.concatenate((times, before))[order], np.concatenate((table, table[:-1]))[order]
    return times, table


class _Accessors:
    """The numbers of a model's binary data."""

    def __init__(self, model: Model, data: bytes) -> None:
        self.path, self.document, self.data = model.path, model.document, data

    def __call__(self, number: object) -> Floats:
        """Return the numbers of an accessor, in one row."""
        rows, views = self.document.get("accessors", []), self.document.get("bufferViews", [])
        if not is_index(number, len(rows)):
            fail(self.path, "an animation names numbers that are not there")
        row = rows[number]
        if "sparse" in row or not is_index(row.get("bufferView"), len(views)):
            fail(self.path, "its animation is stored sparsely", "export it without compression")
        view = views[row["bufferView"]]
        kind, count = row.get("componentType"), row.get("count")
        if kind not in TYPES or not isinstance(count, int) or row.get("type") != "SCALAR":
            fail(self.path, "its animation holds numbers of an unknown kind")
        start = view.get("byteOffset", 0) + row.get("byteOffset", 0)
        size = count * np.dtype(TYPES[kind]).itemsize
        if view.get("buffer") != 0 or start < 0 or start + size > len(self.data):
            fail(self.path, "its animation lies past the end of its data", "export it again")
        values = np.frombuffer(self.data, TYPES[kind], count, start)
        return values.astype(np.float64) / SCALES[kind]
