"""The animation embedded in the character's glTF model (GLB).

Existing content stays unchanged: the animation is appended to the JSON lists and the binary data.
The JSON is edited directly, because glTF libraries drop unknown fields.

glTF has no negative time. If movement starts before the sound, all times are shifted, and
`audio_start` in the animation's extras is the start of the sound in seconds. Every frame is a key
by default; with straight lines within an error, only the frames needed by any column. With `keys`,
each sampler is a cubic spline, whose numbers share their keys: all shapes of a mesh, or all
components of a bone's transform.

With `face`, the model's data are in that file, and all lines beside it refer to it.
"""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import reduce
from pathlib import Path
from typing import BinaryIO
from urllib.parse import quote

import numpy as np
import numpy.typing as npt

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import binary_writer
from lipsync_lang.animations.keys import fit, margin, needed
from lipsync_lang.animations.moving_shapes import unbound
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.errors import OutputError, shortlist
from lipsync_lang.base.grouping import grouped
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.container import (
    binary_of,
    fail,
    has_binary,
    read_chunk,
    write_container,
)
from lipsync_lang.faces.rigs.face_on_model import find
from lipsync_lang.faces.rigs.model import Model, known_model, movable_nodes, numbers
from lipsync_lang.faces.rigs.shape_matching import on_mesh
from lipsync_lang.faces.rigs.transforms import parts, product, turns

FLOAT_COMPONENT = 5126
TINY_CHANGE = 1e-6
IDENTITY = (0.0, 0.0, 0.0, 1.0)


def unplaced(animation: Animation) -> Iterator[str]:
    """Yield warnings about channels that move nothing on the model, and other doubts."""
    if animation.model is None:
        return
    channels = animation.columns
    model = _model(animation.model, channels)
    found = find(channels, model)
    known = found.places.keys() | found.still
    lost = [number for number, channel in enumerate(channels) if channel.name not in known]
    if np.any(animation.weights[:, lost]):  # all are named, so that a build says it once
        names = dict.fromkeys(channels[number].node or channels[number].name for number in lost)
        yield f"{model.path} has nothing for {shortlist(names)}"
        if torn := names.keys() & {node.get("name") for node in model.document.get("nodes", ())}:
            yield (
                f"{model.path}: a turn of {shortlist(sorted(torn))} would leave other meshes "
                "behind, such as eyes and teeth; make them its children, and export the model again"
            )
    yield from (f"{model.path}: {doubt}" for doubt in found.doubts)


def animated_model(animation: Animation) -> Model:
    """Return the model that an animation moves; refuse an animation without one."""
    if animation.model is None:
        mend = "name one (`model`), or state `model:` in the character"
        raise OutputError(f"there is no model to animate; {mend}")
    return _model(animation.model, animation.columns)


def _model(path: Path, channels: tuple[Channel, ...]) -> Model:
    return known_model(path, bones=any(channel.node is not None for channel in channels))


@binary_writer("glb", suffix=".glb", remarks=unplaced, refuse=animated_model)
def write_glb(animation: Animation, out: BinaryIO) -> None:
    """The character's 3D model with the animation added, all else in it kept."""
    animation = unbound(animation)
    channels, model = animation.columns, animated_model(animation)
    times = animation.timeline.astype("<f4")
    # glTF wants rising times; close frames may be the same number in single precision.
    frames = np.flatnonzero(np.append(True, np.diff(times) > 0))
    error = animation.export.key_error
    if animation.export.key_lines and error is not None:
        kept = needed(times[frames].astype(float), animation.weights[frames], error)
        frames, error = frames[kept], None
    take = _NewAnimation(model, times[frames], error, quote(animation.export.face))
    floors = [animation.contacts.get(pose, 0.0) for pose in animation.poses]
    _move_shapes(take, channels, animation.weights[frames], floors)
    _move_nodes(take, channels, animation.weights[frames])
    if not take.channels:
        wanted = shortlist(channel.node or channel.name for channel in channels)
        raise OutputError(
            f"{model.path}: no shape has the name of a pose: it has "
            f"{shortlist(model.shape_names)}; the poses are {wanted}. Give the character a rig "
            "that says which pose moves what (`lipsync-lang characters new` drafts one)"
        )
    take.finish(animation.title, {"audio_start": round(animation.begins, 6)})
    # Half of a surrogate pair has no UTF-8. Its escape is the same name in JSON.
    text = take.text().encode("utf-8", "backslashreplace")
    others = model.chunks[has_binary(model.chunks) :]
    more = ((one.kind, [read_chunk(model.path, one)]) for one in others)
    write_container(out, text, [take.binary, *take.data], more)


class _NewAnimation:
    """An animation under construction: new JSON rows and binary data."""

    def __init__(
        self, model: Model, times: npt.NDArray[np.float32], error: float | None, face: str
    ) -> None:
        self.model, self.face, self.times = model, face, times.astype(float)
        self.error = None if error is None else margin(error)
        self.changed: Json = {}
        self.appended: dict[str, list[Json]] = {}
        self.binary = b"" if face else binary_of(model.path, model.document, model.chunks)
        self.data: list[bytes] = []
        self.samplers: list[Json] = []
        self.channels: list[Json] = []
        self._accessors: list[Json] = []
        self._lines = None if self.error else self._clock(times)

    def _add(self, kind: str, values: npt.NDArray[np.float32], **bounds: list[float]) -> int:
        """Append values to the binary data and return the index of their accessor."""
        offset = sum(map(len, self.data))
        self.data.append(values.astype("<f4").tobytes())
        count = values.size if kind == "SCALAR" else len(values)
        view = len(self.model.document.get("bufferViews", ()))
        place = {"bufferView": view, "byteOffset": offset, "componentType": FLOAT_COMPONENT}
        self._accessors.append({**place, "count": count, "type": kind, **bounds})
        return len(self.model.document.get("accessors", ())) + len(self._accessors) - 1

    def _clock(self, times: npt.NDArray[np.float32]) -> int:
        """Append times and return the index of their accessor."""
        return self._add("SCALAR", times, min=[float(times[0])], max=[float(times[-1])])

    def sample(
        self, kind: str, values: Floats, span: float = 1.0, floors: Floats | None = None
    ) -> int:
        """Append values (T, n) over time and return the index of the new sampler.

        `span` is the range of the values, of which the error of keys is a share; `floors` (n,) are
        levels that contacts hold.
        """
        clock, rows, way = self._lines, values, "LINEAR"
        if self.error:
            spline = fit(self.times, values, self.error * span, floors)
            clock, way = self._clock(self.times[spline.frames].astype(np.float32)), "CUBICSPLINE"
            parts = (spline.arriving, spline.values, spline.leaving)
            rows = np.stack(parts, axis=1).reshape(-1, values.shape[1])
        output = self._add(kind, rows.astype(np.float32))
        self.samplers.append({"input": clock, "output": output, "interpolation": way})
        return len(self.samplers) - 1

    def drive(self, node: int, path: str, sampler: int) -> None:
        """Connect a sampler to a property of a node."""
        self.channels.append({"sampler": sampler, "target": {"node": node, "path": path}})

    def finish(self, name: str, extras: Json) -> None:
        """Append the collected rows to the lists of the model."""
        # Floats begin at multiples of 4 bytes (glTF 2.0, 3.6.2.4), even if the data before do not.
        self.data.insert(0, b"\0" * (-len(self.binary) % 4))
        start = len(self.binary) + len(self.data[0])
        length = sum(map(len, self.data[1:]))
        view = {"buffer": 0, "byteOffset": start, "byteLength": length}
        first, *others = self.model.document.get("buffers") or [{}]
        # The first buffer of a GLB is its own binary data only if it has no `uri`.
        own = {key: value for key, value in first.items() if key != "uri"}
        if self.face:  # a GLB has its own data in the first buffer, so the others move up
            others = [own | {"uri": self.face}, *others]
            views = self.model.document.get("bufferViews", ())
            self.changed["bufferViews"] = list(map(_moved_up, views))
        self.changed["buffers"] = [own | {"byteLength": start + length}, *others]
        taken = [row.get("name") for row in self.model.document.get("animations", ())]
        number, free = 1, name
        while free in taken:
            number += 1
            free = f"{name} {number}"
        animation = {"name": free, "channels": self.channels}
        self.appended["bufferViews"] = [view]
        self.appended["accessors"] = self._accessors
        self.appended["animations"] = [animation | {"samplers": self.samplers, "extras": extras}]

    def text(self) -> str:
        """Return the document as JSON; what stays the same is not formatted again."""
        model = self.model
        texts = {**model.texts, **{name: model.text(new) for name, new in self.changed.items()}}
        for name, rows in self.appended.items():
            known, more = texts.get(name, "[]"), model.text(rows)
            texts[name] = more if known == "[]" else f"{known[:-1]},{more[1:]}"
        return "{" + ",".join(f"{model.text(name)}:{text}" for name, text in texts.items()) + "}"


def _moved_up(row: Json) -> Json:
    """Move a buffer view, with the views in its extensions, to the next buffer."""
    moved = {name: _moved_up(one) if isinstance(one, dict) else one for name, one in row.items()}
    return moved | {"buffer": row["buffer"] + 1} if "buffer" in row else moved


def _move_shapes(
    take: _NewAnimation, channels: tuple[Channel, ...], values: Floats, floors: Sequence[float]
) -> None:
    """Animate the morph weights of every node whose mesh has a matching shape.

    The larger of two columns for one target is used.
    """
    meshes = {mesh.number: mesh for mesh in take.model.meshes}
    driven: dict[int, dict[int, list[int]]] = {}
    for mesh in take.model.meshes:
        columns = driven.setdefault(mesh.number, defaultdict(list))
        for column, shapes in on_mesh(channels, mesh).shapes.items():
            for shape in shapes:
                columns[mesh.shapes.index(shape)].append(column)
    samplers: dict[tuple[int, tuple[float, ...]], int] = {}
    for number, node in enumerate(take.model.document.get("nodes", ())):
        if node.get("mesh", -1) not in meshes:
            continue
        mesh = meshes[node["mesh"]]
        given, what = node.get("weights", [*mesh.rest]), f"weights of node {number}"
        rest = numbers(take.model.path, what, given, len(mesh.rest))
        columns, key = driven[mesh.number], (mesh.number, rest)
        if columns and key not in samplers:
            levels = np.zeros(len(rest))
            # A sampler has the weights of all targets of a mesh; those without a pose stay at rest.
            weights = np.tile(np.array(rest), (len(values), 1))
            for target, sources in columns.items():
                levels[target] = max(floors[source] for source in sources)
                weights[:, target] = values[:, sources].max(axis=1)
            samplers[key] = take.sample("SCALAR", weights, floors=levels)
        if columns:
            take.drive(number, "weights", samplers[key])


def _move_nodes(take: _NewAnimation, channels: Sequence[Channel], values: Floats) -> None:
    """Rotate and translate bone nodes relative to their rest transform."""
    moves = grouped((one.node, (one, values[:, at])) for at, one in enumerate(channels))
    for number, name in movable_nodes(take.model.document).items():
        if name in moves:
            _move_node(take, number, moves[name])


def _move_node(take: _NewAnimation, number: int, moves: list[tuple[Channel, Floats]]) -> None:
    path, node = take.model.path, take.model.document["nodes"][number]
    what = f"node '{node['name']}'"
    node = _parted(path, what, node)
    take.changed.setdefault("nodes", list(take.model.document["nodes"]))[number] = node
    rotations = [turns(np.array(c.rotation, float), v) for c, v in moves if c.rotation is not None]
    if rotations:
        rest = numbers(path, f"rotation of {what}", node.get("rotation", [*IDENTITY]), 4)
        length = float(np.linalg.norm(rest))
        if length < TINY_CHANGE:
            fail(path, f"rotation of {what}: is 0 throughout")
        # Some exporters round quaternions so far that their length is not 1.
        values = reduce(product, rotations, np.array([rest]) / length)
        take.drive(number, "rotation", take.sample("VEC4", values, _range(values)))
    shifts = [np.outer(v, c.translation) for c, v in moves if c.translation is not None]
    if shifts:
        rest = numbers(path, f"translation of {what}", node.get("translation", [0.0] * 3), 3)
        values = np.array(rest) + sum(shifts)
        take.drive(number, "translation", take.sample("VEC3", values, _range(values)))


def _range(values: Floats) -> float:
    """Return the widest range of a component; 1 for values that stand still."""
    return float(np.ptp(values, axis=0).max()) or 1.0


def _parted(path: Path, what: str, node: Json) -> Json:
    """Return a node with its matrix decomposed, because glTF cannot animate a matrix."""
    if "matrix" not in node:
        return node
    found = parts(np.reshape(numbers(path, f"matrix of {what}", node["matrix"], 16), (4, 4)))
    if found is None:
        mend = "apply its transform in your 3D program and export the model again"
        fail(path, f"{what} is sheared or flat, so it cannot be animated", mend)
    own = {name: part.tolist() for name, part in found.items()}
    return {key: value for key, value in node.items() if key != "matrix"} | own
