"""What is drawn of a glTF file: the arrays of its accessors, its textures and its nodes."""

from io import BytesIO
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from lipsync_lang.errors import OutputError
from lipsync_lang.rigs.container import Json, binary_of, fail
from lipsync_lang.rigs.model import Model

Floats = npt.NDArray[np.float64]
Texels = npt.NDArray[np.uint8]
Array = npt.NDArray[Any]

TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}

PACKED = {"KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"}
"""Extensions that leave nothing to draw to those who do not know them."""

MOST = 2**24
"""Values of an accessor; with more, nothing is drawn in time."""

LARGEST = 2048
"""Pixels of a texture's longer side; more are not seen."""


class Gltf:
    """A model's document and its binary data.

    Parameters
    ----------
    model : what is read
    path : what messages call it
    """

    def __init__(self, model: Model, path: Path) -> None:
        self.path, self.document = path, model.document
        self._binary = binary_of(model.path, model.document, model.chunks)
        packed = PACKED.intersection(self.document.get("extensionsRequired", ()))
        if packed:
            fail(path, f"is compressed ({min(packed)})", "export the model without compression")

    def array(self, number: int) -> Array:
        """Return an accessor's values, (count, n); integers that mean fractions are those."""
        row = self.document["accessors"][number]
        kind, count, width = row["componentType"], row["count"], WIDTHS[row["type"]]
        if not 0 < count <= MOST:
            raise ValueError(f"an accessor has {count} values")
        if "bufferView" in row:
            values = self._values(row, kind, count, width)
        else:
            values = np.zeros((count, width), TYPES[kind])
        if "sparse" in row:
            few, places, others = (row["sparse"][name] for name in ("count", "indices", "values"))
            values = values.copy()
            where = self._values(places, places["componentType"], few, 1)[:, 0]
            values[where] = self._values(others, kind, few, width)
        if row.get("normalized"):
            return np.maximum(values / np.iinfo(values.dtype).max, -1.0)
        return values

    def _values(self, row: Json, kind: int, count: int, width: int) -> Array:
        view = self.document["bufferViews"][row["bufferView"]]
        if view.get("buffer", 0) != 0:
            fail(self.path, "keeps its data in several places", "export the model as GLB")
        dtype = np.dtype(TYPES[kind])
        start = view.get("byteOffset", 0) + row.get("byteOffset", 0)
        step = view.get("byteStride") or width * dtype.itemsize
        return np.ndarray((count, width), dtype, self._binary, start, (step, dtype.itemsize))

    def texture(self, number: int) -> Texels | None:
        """Return a texture's picture, (H, W, 4); None where it cannot be read."""
        row = self.document["textures"][number]
        kinds = (row, *row.get("extensions", {}).values())
        sources = [kind["source"] for kind in kinds if "source" in kind]
        image = self.document["images"][sources[0]] if sources else {}
        if "bufferView" not in image:
            return None
        view = self.document["bufferViews"][image["bufferView"]]
        start = view.get("byteOffset", 0)
        return _picture(self._binary[start : start + view["byteLength"]])

    # Nodes

    def order(self) -> dict[int, int | None]:
        """Return the nodes that are shown, each with its parent and after it."""
        nodes, scenes = self.document.get("nodes", []), self.document.get("scenes", [])
        children = set(chain.from_iterable(node.get("children", ()) for node in nodes))
        roots = [number for number in range(len(nodes)) if number not in children]
        if scenes:
            roots = scenes[self.document.get("scene", 0)].get("nodes", [])
        found: dict[int, int | None] = {}
        waiting: list[tuple[int, int | None]] = [(root, None) for root in roots]
        while waiting:
            number, parent = waiting.pop()
            if number not in found:
                found[number] = parent
                waiting += [(child, number) for child in nodes[number].get("children", ())]
        return found

    def local(self, number: int, **moved: Floats) -> Floats:
        """Return a node's (4, 4) matrix within its parent.

        Parameters
        ----------
        moved : its `translation` or `rotation`, where that is not what the file says
        """
        node = self.document["nodes"][number]
        if "matrix" in node:
            return np.reshape(np.array(node["matrix"], float), (4, 4))
        rest = {"translation": (0, 0, 0), "rotation": (0, 0, 0, 1), "scale": (1, 1, 1)}
        own = {name: np.array(node.get(name, value), float) for name, value in rest.items()}
        own |= moved
        matrix = np.eye(4)
        matrix[:3, :3] = own["scale"][:, None] * _axes(own["rotation"])
        matrix[3, :3] = own["translation"]
        return matrix


def _axes(quaternion: Floats) -> Floats:
    """Return where the three axes go, one a row."""
    v, s = quaternion[:3], quaternion[3]
    cross = np.cross(np.eye(3), v)
    found: Floats = (2 * s * s - 1) * np.eye(3) + 2 * np.outer(v, v) - 2 * s * cross
    return found


def _picture(data: bytes) -> Texels | None:
    image = pillow()
    try:
        picture = image.open(BytesIO(data)).convert("RGBA")
    except (OSError, ValueError, SyntaxError, image.DecompressionBombError):
        return None
    picture.thumbnail((LARGEST, LARGEST))
    return np.asarray(picture)


def pillow() -> Any:
    """Return the library that reads and writes pictures, or say how to get it."""
    try:
        from PIL import Image
    except ImportError:
        raise OutputError('pictures need Pillow: pip install "lipsync-lang[video]"') from None
    return Image
