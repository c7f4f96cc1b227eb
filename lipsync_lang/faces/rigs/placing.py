"""Places of a model's points: nodes turn, scale and move the meshes that they show.

Points are rows, so matrices are the transposes of those of glTF.
"""

from itertools import chain

import numpy as np

from lipsync_lang.base.arrays import Floats
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.accessors import Accessors
from lipsync_lang.faces.rigs.container import fail
from lipsync_lang.faces.rigs.model import Model

NODE_REST = {"translation": [0, 0, 0], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]}
"""Position of a node that states none."""


def parents(document: Json) -> dict[int, int | None]:
    """Return the visible nodes of a model with their parents, parents first."""
    nodes, scenes = document.get("nodes", []), document.get("scenes", [])
    children = set(chain.from_iterable(node.get("children", ()) for node in nodes))
    roots = [number for number in range(len(nodes)) if number not in children]
    if scenes:
        roots = scenes[document.get("scene", 0)].get("nodes", [])
    found: dict[int, int | None] = {}
    waiting: list[tuple[int, int | None]] = [(root, None) for root in roots]
    while waiting:
        number, parent = waiting.pop()
        # A damaged file may name a node twice, or as its own child.
        if number not in found:
            found[number] = parent
            waiting += [(child, number) for child in nodes[number].get("children", ())]
    return found


def local(node: Json, **moved: Floats) -> Floats:
    """Compute the (4, 4) matrix of a node relative to its parent, with animated values."""
    if "matrix" in node:
        return np.reshape(np.array(node["matrix"], float), (4, 4))
    own = {name: np.array(node.get(name, value), float) for name, value in NODE_REST.items()}
    own |= moved
    v, s = own["rotation"][:3], own["rotation"][3]
    # Rodrigues' formula of a quaternion, transposed: points are rows here.
    axes = (2 * s * s - 1) * np.eye(3) + 2 * np.outer(v, v) - 2 * s * np.cross(np.eye(3), v)
    matrix = np.eye(4)
    matrix[:3, :3] = own["scale"][:, None] * axes
    matrix[3, :3] = own["translation"]
    return matrix


def at_rest(document: Json) -> dict[int, Floats]:
    """Return the (4, 4) world matrix of each visible node."""
    found: dict[int, Floats] = {}
    for number, parent in parents(document).items():
        own = local(document["nodes"][number])
        found[number] = own if parent is None else own @ found[parent]
    return found


def placed(model: Model, arrays: Accessors, mesh: int, primitive: Json) -> Floats:
    """Return the (4, 4) matrix that takes the points of a part of a mesh to their place at rest.

    Bones move a skinned mesh, and not its own node. The bone of most of its points counts for all.
    Raises ModelError if the nodes are damaged.
    """
    try:
        with np.errstate(over="raise", invalid="raise"):
            matrix = _placed(model.document, arrays, mesh, primitive)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        matrix = np.full((4, 4), np.nan)
    if matrix.shape != (4, 4) or not np.isfinite(matrix).all():
        fail(model.path, f"the place of mesh {mesh} cannot be read")
    return matrix


def _placed(document: Json, arrays: Accessors, mesh: int, primitive: Json) -> Floats:
    nodes, world = document["nodes"], at_rest(document)
    node = next((one for one in world if nodes[one].get("mesh") == mesh), None)
    if node is None:
        return np.eye(4)
    attributes = primitive["attributes"]
    if "skin" not in nodes[node] or "JOINTS_0" not in attributes:
        return world[node]
    skin = document["skins"][nodes[node]["skin"]]
    bones, shares = arrays[attributes["JOINTS_0"]], arrays[attributes["WEIGHTS_0"]]
    bone = int(np.bincount(bones.ravel().astype(int), shares.ravel()).argmax())
    inverse = np.eye(4)
    if "inverseBindMatrices" in skin:
        inverse = arrays[skin["inverseBindMatrices"]].reshape(-1, 4, 4)[bone].astype(float)
    return inverse @ world.get(skin["joints"][bone], np.eye(4))
