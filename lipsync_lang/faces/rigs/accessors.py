"""Reader for accessors, buffer views and sparse data of glTF 2.0.

Arrays have the shape (count, width), with one row per element. Compressed buffer views
(meshoptimizer) and Draco meshes are decoded when they are read. Both libraries are an extra, loaded
only for a model that needs them.

Model files are untrusted. Each index, offset, stride and count is checked against the available
bytes before an array is allocated. Neither library limits its output, so the stated counts are
compared with the compressed bytes before anything is decoded. `MAX_ACCESSOR_VALUES` limits the
total size of all arrays, because a small file can name the same bytes many times.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from itertools import islice
from math import prod
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.extras import install_line
from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.container import LARGEST, binary_of, fail
from lipsync_lang.faces.rigs.model import Model, is_index

DRACO = "KHR_draco_mesh_compression"

MESHOPT = ("EXT_meshopt_compression", "KHR_meshopt_compression")
"""Both names of one format; the later one adds a filter for colours."""

BYTES_PER_BYTE = 1024
"""Maximum decoded bytes per compressed byte: meshoptimizer stores 256 rows of a word in a byte."""

NUMBERS_PER_BYTE = 64
"""Maximum corners and points per compressed byte; heads have 2, and a flat grid has 10."""

DRACO_START = (b"DRACO\x02\x02\x01", 11)
"""Signature of a mesh in bitstream 2.2, which glTF requires, and the size of the header."""

EDGEBREAKER = 1
"""Draco's encoding method with another byte before the counts; the other method is sequential."""

Array = npt.NDArray[Any]

COMPONENT_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""glTF component type codes, with their numpy types."""

ACCESSOR_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
"""Components per element. MAT2 and MAT3 are left out: faces do not use their padded columns."""

INDICES = {5121, 5123, 5125}
"""Component types for the indices of sparse accessors."""

LARGEST_STRIDE = 252
"""Maximum stride in bytes (glTF 2.0, 3.6.2.4)."""

MAX_ACCESSOR_VALUES = 2**26
"""Maximum values read from one model; a head of 100,000 points with 52 shapes has 16 million."""


def meshopt_size(row: Json, compressed: int) -> int:
    """Return the decoded size in bytes of a buffer view; a ValueError if its data are too short."""
    counts: list[Any] = [row.get("count"), row.get("byteStride")]
    for value in counts:
        if not is_index(value, LARGEST + 1):
            raise ValueError(f"states {str(value)[:20]} for a count")
    count, stride = map(int, counts)
    if not 0 < count * stride <= BYTES_PER_BYTE * compressed:
        raise ValueError(f"states {count} rows of {stride} bytes in {compressed} bytes")
    return count * stride


def meshopt_rows(data: bytes, row: Json) -> memoryview:
    """Decode a buffer view of `meshopt_size` bytes, with its filter undone; or a ValueError."""
    library = import_module("meshopt")
    mode, kind = row.get("mode"), row.get("filter", "NONE")
    if kind != "NONE" and mode in ("TRIANGLES", "INDICES"):
        raise ValueError("has a filter for indices")
    found = library.decode_gltf_buffer(data, row["count"], row["byteStride"], mode, kind)
    return np.ascontiguousarray(found).view(np.uint8).reshape(-1).data


def draco_mesh(
    data: bytes, corners: int, points: int
) -> tuple[npt.NDArray[np.uint32], dict[int, npt.NDArray[Any]]]:
    """Decode a Draco mesh of N points.

    The data may hold no more corners and points than the document states. Returns (F * 3,) point
    numbers, and the (N, n) values of each attribute by its number in the data. Raises ImportError
    if the library is not installed, and ValueError if the data are damaged, or have other counts
    than stated.
    """
    library = import_module("DracoPy")
    signature, size = DRACO_START
    # The highest bit announces metadata, which would stand before the counts.
    if len(data) < size or not data.startswith(signature) or data[10] & 0x80:
        raise ValueError("is not a Draco mesh of bitstream 2.2 without metadata")
    if data[8] == EDGEBREAKER:
        own, faces = islice(_varints(data, size + 1), 2)
    else:
        faces, own = islice(_varints(data, size), 2)
    if 3 * faces > corners or own > points:
        what = f"has {3 * faces} corners of {own} points, but states {corners} of {points}"
        raise ValueError(what)
    if corners + points > NUMBERS_PER_BYTE * len(data):
        raise ValueError(f"states {corners} corners of {points} points in {len(data)} bytes")
    try:
        mesh = library.decode(data)
    except (MemoryError, RuntimeError, ValueError, library.FileTypeException):
        raise ValueError("has Draco data that cannot be decoded") from None
    found = {one["unique_id"]: np.asarray(one["data"]) for one in mesh.attributes}
    return np.asarray(mesh.faces, np.uint32).reshape(-1), found


def _varints(data: bytes, start: int) -> Iterator[int]:
    """Yield numbers of 7 bits per byte, the lowest first."""
    value = shift = 0
    for byte in data[start : start + 20]:
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:  # noqa: PLR2004 the last byte of a number
            yield value
            value = shift = 0
    raise ValueError("has Draco data that end within their header")


class Accessors:
    """Arrays in a model's first buffer, by number: ``Accessors(model)[0]``.

    Raises ModelError if binary data is missing or external to the file. Messages call the model
    `path`, by default its own path.
    """

    def __init__(self, model: Model, path: Path | None = None) -> None:
        self.path = path or model.path
        self._rows = model.document.get("accessors", [])
        self._views = model.document.get("bufferViews", [])
        self._binary = binary_of(model.path, model.document, model.chunks, alone=False)
        self._left = MAX_ACCESSOR_VALUES
        self._stored = len(self._binary)
        self._decoded: dict[int, memoryview] = {}
        self._unpacked: dict[int, Array] = {}

    def __getitem__(self, number: object) -> Array:
        """Read an accessor as (count, width) values; integers may become fractions."""
        row, what = self._row(number), f"accessor {_shown(number)}"
        if "bufferView" in row:
            self._span(what, row["bufferView"])  # what is decoded counts as stored
        kind, width = row.get("componentType"), ACCESSOR_WIDTHS.get(str(row.get("type")))
        # A list from a damaged file is no key of a dictionary, so it must be a number first.
        if not is_index(kind, max(COMPONENT_TYPES) + 1) or kind not in COMPONENT_TYPES or not width:
            self._fail(what, "has numbers of an unknown type")
        # A stored value takes a byte or more; sparse-only accessors hold offsets of stored points.
        count = row.get("count")
        if not is_index(count, self._stored + 1) or count == 0:
            self._fail(what, f"states {_shown(count)} values in {self._stored} bytes of data")
        shape, dtype = (int(count), width), np.dtype(COMPONENT_TYPES[kind])
        self.spend(prod(shape))
        if "bufferView" in row:
            values = self._values(what, row, shape, dtype)
        elif number in self._unpacked:
            decoded = self._unpacked[number]
            if decoded.shape != shape:
                self._fail(what, f"states {shape[0]} values, and has {len(decoded)}")
            values = decoded.astype(dtype)
        else:
            values = np.zeros(shape, dtype)
        if "sparse" in row:
            values = self._changed(what, row["sparse"], values)
        if row.get("normalized") and dtype.kind in "iu":
            # -128 / 127 is below -1, where glTF ends.
            return np.maximum(values / np.iinfo(dtype).max, -1.0)
        return values

    def view(self, number: object) -> bytes:
        """Read the bytes of a buffer view."""
        return bytes(self._span(f"buffer view {_shown(number)}", number)[0])

    def unpack(self, primitive: Json) -> None:
        """Decode the Draco data of a primitive, so that its accessors can be read.

        If a primitive also has plain data, the plain data is used. Raises ModelError if the data
        are damaged, or there is no decoder.
        """
        packed = _extensions(primitive).get(DRACO)
        places = {"indices": primitive.get("indices"), **primitive["attributes"]}
        if packed is None or "bufferView" in self._row(places["POSITION"]):
            return
        counts = []
        for number in (places["indices"], places["POSITION"]):
            count = self._row(number).get("count")
            if not is_index(count, MAX_ACCESSOR_VALUES + 1):
                self._fail(f"accessor {number}", f"states {_shown(count)} values")
            counts.append(count)
        self.spend(sum(counts))
        data = self.view(packed.get("bufferView"))
        what = f"buffer view {packed['bufferView']}"
        with self._decoding(what, DRACO):
            corners, attributes = draco_mesh(data, *counts)
        found = {"indices": corners[:, None]}
        for name, own in packed["attributes"].items():
            if own not in attributes:
                self._fail(what, f"has no {str(name)[:20]}")
            found[name] = attributes[own]
        self._unpacked |= {places[name]: values for name, values in found.items()}
        self._stored += sum(values.nbytes for values in found.values())

    def _row(self, number: object) -> Json:
        if not is_index(number, len(self._rows)):
            fail(self.path, f"refers to accessor {_shown(number)}, but has only {len(self._rows)}")
        return self._rows[number]

    @contextmanager
    def _decoding(self, what: str, extension: str) -> Iterator[None]:
        """Raise the errors of a decoder with their place."""
        try:
            yield
        except ImportError:
            mend = f"to read it: {install_line('models')}; or export it without compression"
            fail(self.path, f"is compressed ({extension})", mend)
        except (ValueError, MemoryError) as error:
            self._fail(what, str(error)[:120] or "needs too much memory")

    def spend(self, values: int) -> None:
        """Add the size of an array to the model's total; fail past `MAX_ACCESSOR_VALUES`."""
        self._left -= values
        if self._left < 0:
            mend = "export it with fewer vertices, shapes or frames"
            fail(self.path, f"holds more than {MAX_ACCESSOR_VALUES:,} numbers", mend)

    def _values(self, what: str, row: Json, shape: tuple[int, int], dtype: np.dtype[Any]) -> Array:
        """View values in place, without a copy."""
        data, stride = self._span(what, row.get("bufferView"))
        offset, size = row.get("byteOffset", 0), shape[1] * dtype.itemsize
        step = size if stride is None else stride
        if not is_index(step, LARGEST_STRIDE + 1) or step < size:
            self._fail(what, f"has values {_shown(step)} bytes apart, but each takes {size} bytes")
        # Nothing need follow the last value, even if values lie apart.
        reach = (shape[0] - 1) * step + size
        if not is_index(offset, len(data)) or offset + reach > len(data):
            self._fail(what, "lies past the end of its data")
        return np.ndarray(shape, dtype, data, offset, (step, dtype.itemsize))

    def _span(self, what: str, number: object) -> tuple[memoryview, object]:
        """Return the bytes of a view, decoded if compressed, and its stride."""
        if not is_index(number, len(self._views)):
            self._fail(what, "has no buffer view")
        view = self._views[number]
        packed = next((name for name in MESHOPT if name in _extensions(view)), None)
        if packed is None:
            return self._place(what, view), view.get("byteStride")
        if number not in self._decoded:
            row, where = view["extensions"][packed], f"buffer view {number}"
            if not isinstance(row, dict):
                self._fail(where, f"has an {packed} that is not an object")
            data = self._place(where, row)
            with self._decoding(where, packed):
                size = meshopt_size(row, len(data))
                self.spend(size // 4)
                self._decoded[number] = meshopt_rows(bytes(data), row)
            self._stored += size
        return self._decoded[number], view.get("byteStride")

    def _place(self, what: str, view: Json) -> memoryview:
        """Return the stored bytes of a view, after a check of its place."""
        if view.get("buffer", 0) != 0:
            fail(self.path, "has its data in several buffers", "export the model as GLB")
        start, length = view.get("byteOffset", 0), view.get("byteLength")
        total = len(self._binary)
        if not is_index(start, total + 1) or not is_index(length, total - start + 1):
            self._fail(what, "lies past the end of its data")
        return memoryview(self._binary)[start : start + length]

    def _changed(self, what: str, sparse: object, values: Array) -> Array:
        """Copy values and apply sparse replacements."""
        if not isinstance(sparse, dict):
            self._fail(what, "has sparse values that are not an object")
        few, places, others = (sparse.get(name) for name in ("count", "indices", "values"))
        if not isinstance(places, dict) or not isinstance(others, dict):
            self._fail(what, "has sparse values without indices")
        if not is_index(few, len(values) + 1) or few == 0:
            self._fail(what, f"replaces {_shown(few)} of {len(values)} values")
        kind = places.get("componentType")
        if not is_index(kind, max(INDICES) + 1) or kind not in INDICES:
            self._fail(what, "has sparse values with indices of an unknown type")
        where = self._values(what, places, (few, 1), np.dtype(COMPONENT_TYPES[kind]))[:, 0]
        # Indices are unsigned: the largest alone can be out of range.
        if int(where.max()) >= len(values):
            self._fail(what, f"replaces value {where.max()}, but has only {len(values)}")
        changed = values.copy()
        changed[where] = self._values(what, others, (few, values.shape[1]), values.dtype)
        return changed

    def _fail(self, what: str, wrong: str) -> NoReturn:
        fail(self.path, f"{what} {wrong}")


def _shown(value: object) -> str:
    return repr(value)[:20]


def _extensions(row: Json) -> Json:
    found = row.get("extensions")
    return found if isinstance(found, dict) else {}
