"""Decoders of compressed models: Draco meshes, and buffer views of meshoptimizer.

Both libraries are an extra, loaded only for a model that needs them. Neither limits its output, so
the stated counts are compared with the compressed bytes before anything is decoded. Errors are
`ValueError`s; the caller knows the file.
"""

from collections.abc import Iterator
from importlib import import_module
from itertools import islice
from typing import Any

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.json_object import Json
from lipsync_lang.faces.rigs.container import LARGEST
from lipsync_lang.faces.rigs.model import is_index

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
