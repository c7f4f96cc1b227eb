"""Blend shapes moved by an animation, by mesh, with the names used in the model."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.fixed import shape_columns, shapes_from_zero
from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.grouping import grouped
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.expressions import stating
from lipsync_lang.faces.rigs.model import Mesh, Model, is_index, known_model
from lipsync_lang.faces.rigs.shape_matching import on_mesh

if TYPE_CHECKING:
    from lipsync_lang.animations.keys import KeyedCurve


class MovingShape(NamedTuple):
    """A blend shape and its curve."""

    mesh: str
    """Name of the mesh; empty for a single or unknown mesh."""
    name: str
    values: Floats
    """(T,) weights."""
    floor: float
    """Level that a contact holds; 0 for none."""


def shapes(animation: Animation) -> list[MovingShape]:
    """Return the moving shapes, without bones.

    With a known model, the result lists its shapes mesh by mesh, in the spelling of the model.
    Otherwise each column is one shape. The larger of two columns for one shape is used.
    """
    animation = unbound(animation)
    columns = grouped(((mesh, name), column) for mesh, name, column in on_model(animation))
    alone = [(animation.columns[column], column) for column in shape_columns(animation)]
    columns = columns or grouped(((one.mesh or "", one.name), column) for one, column in alone)
    found = []
    for key, own in columns.items():
        floor = max(animation.contacts.get(animation.poses[column], 0.0) for column in own)
        found.append(MovingShape(*key, animation.weights[:, own].max(axis=1), floor))
    return found


def keys(animation: Animation, found: list[MovingShape], suits: float) -> "list[KeyedCurve]":
    """Return the keyframes of each shape; see `Animation.keyframes`."""
    names = tuple(str(number) for number in range(len(found)))  # meshes may share a name
    floors = {number: shape.floor for number, shape in zip(names, found, strict=True)}
    values = np.column_stack([shape.values for shape in found])
    shown = replace(animation, poses=names, weights=values, contacts=floors)
    return shown.keyframes(suits)


def on_model(animation: Animation) -> list[tuple[str, str, int]]:
    """Return mesh, shape name and column of each shape that moves points of a known model."""
    from lipsync_lang.faces.rigs.read_outs import still_by_mesh

    if animation.model is None:
        return []
    model = known_model(animation.model, bones=True)
    still = still_by_mesh(model)
    return [
        (_label(model, mesh), name, column)
        for mesh in model.meshes
        for column, names in on_mesh(animation.columns, mesh).shapes.items()
        for name in names
        if name not in still.get(mesh.name, ())
    ]


def in_words_of_model(animation: Animation) -> Animation:
    """Name the columns as the known model names its shapes, for files of bare columns.

    A column that moves several shapes is repeated. Of two columns for one shape, the larger value
    is kept. Bones, and columns without a shape, keep their names.
    """
    return animation if animation.export.pose_names else _by_shapes(animation)


def unbound(animation: Animation) -> Animation:
    """Return the shapes that the expressions of an avatar move, if any column is an expression."""
    if animation.model is None:
        return animation
    bones = any(channel.node is not None for channel in animation.columns)
    meshes = known_model(animation.model, bones=bones).meshes
    bound = any(mesh.binds and on_mesh(animation.columns, mesh).bound for mesh in meshes)
    return _by_shapes(animation) if bound else animation


def expressions(animation: Animation) -> tuple[str, ...]:
    """Return the names of the avatar's expressions that move shapes; none for another model."""
    if animation.model is None:
        return ()
    meshes = known_model(animation.model, bones=True).meshes
    return tuple(dict.fromkeys(name for mesh in meshes for name, _, _ in mesh.binds))


def expressions_with(animation: Animation, field: str, values: Sequence[object]) -> frozenset[str]:
    """Return the expressions of the avatar whose field has one of the values."""
    if animation.model is None:
        return frozenset()
    return stating(known_model(animation.model, bones=True).document, field, values)


def _by_shapes(animation: Animation) -> Animation:
    if animation.model is None:
        return animation
    model = known_model(animation.model, bones=True)
    sources, channels = _sources(model, animation.poses, animation.columns)
    single = [some[0][0] for some in sources.values() if len(some) == 1 and some[0][1] is None]
    values, lowest = animation.weights, animation.contacts
    floors = {
        name: max(lowest.get(animation.poses[column], 0.0) for column, _ in some)
        for name, some in (sources.items() if lowest else ())
    }
    return replace(
        animation,
        poses=tuple(sources),
        # columns at once, if no shape has two
        weights=values[:, single]
        if len(single) == len(sources)
        else np.column_stack([_moved(values, some) for some in sources.values()]),
        channels=channels,
        contacts={name: floor for name, floor in floors.items() if floor},
    )


@lru_cache(maxsize=8)  # the lines of a character share them
def _sources(
    model: Model, poses: tuple[str, ...], columns: tuple[Channel, ...]
) -> tuple[dict[str, list[tuple[int, float | None]]], tuple[Channel, ...]]:
    """Return the columns that move each shape, with their weights in binds, and its channel."""
    own: dict[int, dict[str, float | None]] = defaultdict(dict)
    for mesh in model.meshes:
        on = on_mesh(columns, mesh)
        for column, names in on.shapes.items():
            own[column] |= dict.fromkeys(names) | on.bound.get(column, {})
    kept = {pose for column, pose in enumerate(poses) if column not in own}
    sources: dict[str, list[tuple[int, float | None]]] = defaultdict(list)
    for column, pose in enumerate(poses):
        shapes = {name: weight for name, weight in own.get(column, {}).items() if name not in kept}
        for name, weight in (shapes or {pose: None}).items():
            sources[name].append((column, weight))
    known = dict(zip(poses, columns, strict=True))
    return sources, tuple(known[name] if name in kept else Channel(name) for name in sources)


def _moved(values: Floats, sources: Sequence[tuple[int, float | None]]) -> Floats:
    """Return a shape's (T,): the largest of the columns that are it, and the sum of its binds."""
    whole = [values[:, column] for column, weight in sources if weight is None]
    bound = [values[:, column] * weight for column, weight in sources if weight is not None]
    return np.max([*whole, np.sum(bound, axis=0)] if bound else whole, axis=0)


def _label(model: Model, mesh: Mesh) -> str:
    """Return the name of a mesh in the file; empty for the only one with shapes."""
    return (mesh.given or mesh.name) if len(model.meshes) > 1 else ""


def unshown(animation: Animation, program: str) -> Iterator[str]:
    """Yield warnings about omitted channels and a delayed sound, for shapes of a model."""
    from lipsync_lang.animations.writers.glb import unplaced

    yield from unplaced(animation)
    yield from shapes_from_zero(animation, program)


def node_chains(animation: Animation) -> dict[str, list[list[str]]]:
    """Return the nodes of each mesh by `MovingShape.mesh`: their names from the top of the model.

    A single mesh that is the whole model has an empty chain: programs make the model's own object
    of it. If a light or another mesh stands beside it, it is an object below the model's.
    """
    if animation.model is None:
        return {}
    model = known_model(animation.model, bones=True)
    nodes = model.document.get("nodes", [])
    below = [(n, node.get("children")) for n, node in enumerate(nodes)]
    above = {
        child: n
        for n, own in below
        for child in (own if isinstance(own, list) else ())
        if is_index(child, len(nodes))
    }
    found: dict[str, list[list[str]]] = defaultdict(list)
    for mesh in model.meshes:
        label = _label(model, mesh)
        for at in (n for n, node in enumerate(nodes) if node.get("mesh") == mesh.number):
            chain = [at]
            # A damaged model may have nodes below themselves.
            while above.get(chain[0], at) not in chain:
                chain.insert(0, above[chain[0]])
            whole = not label and len(chain) == 1 and len(nodes) - len(above) == 1
            names = [nodes[n].get("name") or mesh.name for n in chain]
            found[label].append([] if whole else names)
    return found
