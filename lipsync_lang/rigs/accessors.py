"""Reader for accessors, buffer views and sparse data of glTF 2.0.

Arrays have the shape (count, width), with one row per element.

Model files are untrusted. Each index, offset, stride and count is checked against the available
bytes before an array is allocated. `MAX_VALUES` limits the total size of all arrays, because a
small file can name the same bytes many times.
"""

from math import prod
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import numpy.typing as npt

from lipsync_lang.rigs.container import Json, binary_of, fail
from lipsync_lang.rigs.model import Model, is_index

Array = npt.NDArray[Any]

COMPONENT_TYPES = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
"""glTF component type codes, with their numpy types."""

WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
"""Components per element. MAT2 and MAT3 are left out: faces do not use their padded columns."""

INDICES = {5121, 5123, 5125}
"""Component types for the indices of sparse accessors."""

LARGEST_STRIDE = 252
"""Maximum stride in bytes (glTF 2.0, 3.6.2.4)."""

MAX_VALUES = 2**26
"""Maximum values read from one model; a head of 100,000 points with 52 shapes has 16 million."""

COMPRESSIONS = {"EXT_meshopt_compression", "KHR_meshopt_compression"}
"""Buffer view extensions with compressed content, which has no plain numbers."""


class Accessors:
    """Arrays in a model's first buffer.

    Parameters
    ----------
    model : the model
    path : its name in messages; None for its own path

    Raises
    ------
    ModelError
        Binary data is missing or external to the file.

    Examples
    --------
    >>> points = Accessors(model)[0]  # doctest: +SKIP
    >>> points.shape  # doctest: +SKIP
    (5023, 3)
    """

    def __init__(self, model: Model, path: Path | None = None) -> None:
        self.path = path or model.path
        self._rows = model.document.get("accessors", [])
        self._views = model.document.get("bufferViews", [])
        self._binary = binary_of(model.path, model.document, model.chunks)
        self._left = MAX_VALUES

    def __getitem__(self, number: object) -> Array:
        """Read an accessor as (count, width) values; normalised integers become fractions.

        Raises
        ------
        ModelError
            The accessor is absent, of an unknown type, or exceeds the data.
        """
        if not is_index(number, len(self._rows)):
            fail(self.path, f"names accessor {_shown(number)}, but has {len(self._rows)}")
        what = f"accessor {number}"
        row = self._rows[number]
        shape, dtype = self._form(what, row)
        if "bufferView" in row:
            values = self._values(what, row, shape, dtype)
        else:
            values = np.zeros(shape, dtype)
        if "sparse" in row:
            values = self._changed(what, row["sparse"], values)
        if row.get("normalized") and dtype.kind in "iu":
            return np.maximum(values / np.iinfo(dtype).max, -1.0)
        return values

    def view(self, number: object) -> bytes:
        """Read the bytes of a buffer view."""
        start, length, _ = self._span(f"buffer view {_shown(number)}", number)
        return self._binary[start : start + length]

    def spend(self, values: int) -> None:
        """Add the size of an array to the model's total; fail past `MAX_VALUES`."""
        self._left -= values
        if self._left < 0:
            mend = "export it with fewer vertices, shapes or frames"
            fail(self.path, f"holds more than {MAX_VALUES:,} numbers", mend)

    def _form(self, what: str, row: Json) -> tuple[tuple[int, int], np.dtype[Any]]:
        """Validate the shape and type of an accessor, and add its size to the total."""
        kind, width = row.get("componentType"), WIDTHS.get(str(row.get("type")))
        if not is_index(kind, max(COMPONENT_TYPES) + 1) or kind not in COMPONENT_TYPES or not width:
            self._fail(what, "holds numbers of an unknown kind")
        # A stored value takes a byte or more; sparse-only accessors hold offsets of stored points.
        count = row.get("count")
        if not is_index(count, len(self._binary) + 1) or count == 0:
            self._fail(what, f"states {_shown(count)} values in {len(self._binary)} bytes of data")
        shape = (int(count), width)
        self.spend(prod(shape))
        return shape, np.dtype(COMPONENT_TYPES[kind])

    def _values(self, what: str, row: Json, shape: tuple[int, int], dtype: np.dtype[Any]) -> Array:
        """View values in place, without a copy."""
        start, length, stride = self._span(what, row.get("bufferView"))
        offset, size = row.get("byteOffset", 0), shape[1] * dtype.itemsize
        step = size if stride is None else stride
        if not is_index(step, LARGEST_STRIDE + 1) or step < size:
            self._fail(what, f"lies {_shown(step)} bytes apart, and takes {size}")
        reach = (shape[0] - 1) * step + size
        if not is_index(offset, length) or offset + reach > length:
            self._fail(what, "lies past the end of its data")
        return np.ndarray(shape, dtype, self._binary, start + offset, (step, dtype.itemsize))

    def _span(self, what: str, number: object) -> tuple[int, int, object]:
        """Compute the offset, length and stride of a view in bytes."""
        if not is_index(number, len(self._views)):
            self._fail(what, "lies in no buffer view")
        view = self._views[number]
        if view.get("buffer", 0) != 0:
            fail(self.path, "keeps its data in several places", "export the model as GLB")
        packed = COMPRESSIONS.intersection(_keys(view.get("extensions")))
        if packed:
            fail(self.path, f"is compressed ({min(packed)})", "export it without compression")
        start, length = view.get("byteOffset", 0), view.get("byteLength")
        total = len(self._binary)
        if not is_index(start, total + 1) or not is_index(length, total - start + 1):
            self._fail(what, "lies past the end of its data")
        return start, int(length), view.get("byteStride")

    def _changed(self, what: str, sparse: object, values: Array) -> Array:
        """Copy values and apply sparse replacements."""
        if not isinstance(sparse, dict):
            self._fail(what, "has sparse values that are no object")
        few, places, others = (sparse.get(name) for name in ("count", "indices", "values"))
        if not isinstance(places, dict) or not isinstance(others, dict):
            self._fail(what, "has sparse values without their places")
        if not is_index(few, len(values) + 1) or few == 0:
            self._fail(what, f"replaces {_shown(few)} of {len(values)} values")
        kind = places.get("componentType")
        if not is_index(kind, max(INDICES) + 1) or kind not in INDICES:
            self._fail(what, "has sparse values whose places are of an unknown kind")
        where = self._values(what, places, (few, 1), np.dtype(COMPONENT_TYPES[kind]))[:, 0]
        if int(where.max()) >= len(values):
            self._fail(what, f"replaces value {where.max()} of {len(values)}")
        changed = values.copy()
        changed[where] = self._values(what, others, (few, values.shape[1]), values.dtype)
        return changed

    def _fail(self, what: str, wrong: str) -> NoReturn:
        fail(self.path, f"{what} {wrong}")


def _shown(value: object) -> str:
    return repr(value)[:20]


def _keys(value: object) -> set[str]:
    return set(value) if isinstance(value, dict) else set()
