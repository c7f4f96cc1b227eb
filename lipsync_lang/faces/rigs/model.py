"""Metadata of a 3D model: the names of its morph targets and nodes.

Models are glTF 2.0. The JSON holds all names and rest weights, so the binary data stays unread.
"""

import json
import time
from collections import Counter
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import isfinite
from pathlib import Path
from typing import NamedTuple, NoReturn, TypeGuard

from lipsync_lang.base.errors import shortlist
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs import expressions
from lipsync_lang.faces.rigs.container import EXPORT, Chunk, fail, open_model

GLTF_LISTS = ("accessors", "animations", "buffers", "bufferViews", "images", "meshes", "nodes")
"""Lists of the document that are read or extended."""

MAX_KNOWN_BYTES = 32 * 2**20
"""Maximum size of a cached model; larger models are read again for each animation."""

SETTLED_SECONDS = 2.0
"""Minimum age of a file whose times show its next change reliably."""


class Mesh(NamedTuple):
    """A mesh with n morph targets, their names and their weights at rest.

    `number` is its index in the document. The name is unique, unlike the one `given` in the file.
    """

    number: int
    name: str
    given: str | None
    shapes: tuple[str, ...]
    rest: tuple[float, ...]
    binds: tuple[tuple[str, str, float], ...] = ()
    """Expressions of an avatar, each with a shape of this mesh and its weight."""


@dataclass(frozen=True, eq=False)
class Model:
    """Contents of a model file.

    The document is the file's JSON, shared and therefore read-only: copy it before a change. Chunks
    are the parts of a GLB after its JSON.
    """

    path: Path
    nodes: tuple[str, ...]
    meshes: tuple[Mesh, ...]
    document: Json
    chunks: tuple[Chunk, ...]

    @cached_property
    def shape_names(self) -> tuple[str, ...]:
        """Distinct names of the morph targets of all meshes, in order."""
        return tuple(dict.fromkeys(name for mesh in self.meshes for name in mesh.shapes))

    @cached_property
    def texts(self) -> dict[str, str]:
        """The values of the document as JSON, by name; a ModelError if it is nested too deep."""
        return {name: self.text(value) for name, value in self.document.items()}

    def text(self, value: object) -> str:
        """Return a value for the document as JSON."""
        try:
            return json.dumps(value, ensure_ascii=False, separators=(",", ":"))
        except RecursionError:
            fail(self.path, "its JSON is nested too deep for a model")


def read_model(path: Path, *, bones: bool = False) -> Model:
    """Read the metadata of a model, .glb or .gltf; with `bones`, it may lack morph targets."""
    text, chunks = open_model(path)
    document = _document(path, text)
    nodes = document.get("nodes", [])
    meshes = _meshes(path, document, bones=bones)
    for number, node in enumerate(nodes):
        if not isinstance(node.get("name", ""), str):
            fail(path, f"the name of node {number} is not text")
        if "mesh" in node and not is_index(node["mesh"], len(document.get("meshes", ()))):
            fail(path, f"node {number} has a mesh that does not exist")
    return Model(path, tuple(movable_nodes(document).values()), meshes, document, chunks)


def movable_nodes(document: Json) -> dict[int, str]:
    """Return the names of the nodes that can move, by number.

    Eyes and teeth often stand beside the face, not below it. A turn of the face's node would leave
    them behind, so the mesh with the most shapes stays unless its node carries all other meshes.
    """
    nodes, meshes = document.get("nodes", []), document.get("meshes", [])

    def shapes(number: int) -> int:
        primitives = meshes[nodes[number]["mesh"]]["primitives"]
        return max((len(one.get("targets", ())) for one in primitives), default=0)

    drawn = [number for number, node in enumerate(nodes) if "mesh" in node]
    face = max(drawn, key=shapes, default=-1)
    carried, below = {face}, [face] if drawn else []
    while below:
        children = nodes[below.pop()].get("children")
        for one in children if isinstance(children, list) else ():
            if is_index(one, len(nodes)) and one not in carried:
                carried.add(one)
                below.append(one)
    stays = -1 if carried.issuperset(drawn) else face
    return {n: node["name"] for n, node in enumerate(nodes) if "name" in node and n != stays}


def known_model(path: Path, *, bones: bool = False) -> Model:
    """Read the metadata of a model, with a cache for files that many lines are written into.

    A file is identified by its times, size and number. A recently changed file is read again,
    because clocks of file systems are coarse. Errors are those of `read_model`.
    """
    try:
        there = path.stat()
    except (OSError, ValueError):
        return read_model(path, bones=bones)
    changed = max(there.st_mtime, there.st_ctime)
    if there.st_size > MAX_KNOWN_BYTES or abs(time.time() - changed) < SETTLED_SECONDS:
        return read_model(path, bones=bones)
    state = (there.st_mtime_ns, there.st_ctime_ns, there.st_size, there.st_ino, there.st_dev)
    return _known(path, bones, state)


@lru_cache(maxsize=8)
def _known(path: Path, bones: bool, _state: tuple[int, ...]) -> Model:  # noqa: FBT001
    return read_model(path, bones=bones)


def _document(path: Path, text: bytes) -> Json:
    try:
        whole = text.decode("utf-8-sig")
        document = json.loads(whole, parse_float=_finite, parse_constant=_no_number)
    except UnicodeDecodeError as error:
        fail(path, f"its JSON is not UTF-8 text (byte {error.start})")
    except ValueError as error:
        fail(path, f"its JSON cannot be read: {str(error)[:80]}")
    except RecursionError:
        fail(path, "its JSON is nested too deep for a model")
    asset = document.get("asset") if isinstance(document, dict) else None
    if not isinstance(asset, dict):
        fail(path, "is JSON, but not glTF", EXPORT)
    if not str(asset.get("version")).startswith("2."):
        fail(path, f"is glTF version {str(asset.get('version'))[:20]}", f"{EXPORT}, version 2")
    for name in GLTF_LISTS:
        check_list(path, f"its {name}", document.get(name, []))
    return document


def _finite(text: str) -> float:
    number = float(text)
    return number if isfinite(number) else _no_number(text)


def _no_number(text: str) -> NoReturn:
    raise ValueError(f"{text[:20]} is not a number")


def check_list(path: Path, name: str, rows: object) -> list[Json]:
    """Validate a list of objects in a document."""
    if not isinstance(rows, list) or not all(isinstance(row, dict) for row in rows):
        fail(path, f"{name} are not a list of objects")
    return rows


def is_index(value: object, count: int) -> TypeGuard[int]:
    """Test a value of a document for a valid index into a list of `count`."""
    return isinstance(value, int) and not isinstance(value, bool) and 0 <= value < count


def numbers(path: Path, what: str, values: object, count: int) -> tuple[float, ...]:
    """Validate and return `count` numbers of a document."""
    rows = values if isinstance(values, list) else []
    if len(rows) != count or not all(
        isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e30  # noqa: PLR2004 far within float32
        for value in rows
    ):
        fail(path, f"{what}: not a list of {count} numbers")
    return tuple(map(float, rows))


def _meshes(path: Path, document: Json, *, bones: bool) -> tuple[Mesh, ...]:
    rows = document.get("meshes", [])
    if not rows and not bones:
        fail(path, "has no meshes", "export the model itself, not only its animation or scene")
    names = [row.get("name", "") for row in rows]
    if not all(isinstance(name, str) for name in names):
        fail(path, "the name of a mesh is not text")
    taken, bound = Counter(names), [*expressions.binds(document)]
    labels = [
        (name if taken[name] == 1 else f"{name} (mesh {number})") if name else f"mesh {number}"
        for number, name in enumerate(names)
    ]
    found = []
    for number, (label, row) in enumerate(zip(labels, rows, strict=True)):
        if shapes := _shapes(path, label, row):
            given, count = row.get("weights"), len(shapes)
            rest = (0.0,) * count
            if given is not None:
                rest = numbers(path, f"weights of '{label}'", given, count)
            binds = tuple(
                (bind.expression, shapes[bind.target], bind.weight)
                for bind in bound
                if bind.mesh == number and is_index(bind.target, count)
            )
            found.append(Mesh(number, label, row.get("name"), shapes, rest, binds))
    if not found and not bones:
        mend = "export it with its shape keys (blend shapes)"
        fail(path, f"no mesh has morph targets (meshes: {shortlist(labels)})", mend)
    return tuple(found)


def _shapes(path: Path, label: str, row: Json) -> tuple[str, ...]:
    """List the morph target names of a mesh."""
    primitives = row.get("primitives")
    check_list(path, f"the primitives of '{label}'", primitives)
    what = f"the morph targets of '{label}'"
    counts = {len(check_list(path, what, one.get("targets", []))) for one in primitives or ()}
    if len(counts) > 1:
        fail(path, f"'{label}': its parts have different numbers of morph targets")
    count = next(iter(counts), 0)
    if not count or not primitives:
        return ()
    # UniVRM names them in the first primitive.
    given = _target_names(row) or _target_names(primitives[0])
    names = [f"target {number}" for number in range(count)] if given is None else given
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        fail(path, f"'{label}': the names of its morph targets are not a list of texts")
    if len(names) != count:
        fail(path, f"'{label}': has {count} morph targets, but {len(names)} names")
    mend = "give every morph target a name of its own and export the model again"
    nameless = next((number for number, name in enumerate(names) if not name.strip()), None)
    if nameless is not None:
        fail(path, f"'{label}': its morph target {nameless} has no name", mend)
    twice = [name for name, count in Counter(names).items() if count > 1]
    if twice:
        fail(path, f"'{label}': several morph targets share a name: {shortlist(twice)}", mend)
    return tuple(names)


def _target_names(holder: Json) -> object:
    extras = holder.get("extras")
    return extras.get("targetNames") if isinstance(extras, dict) else None
