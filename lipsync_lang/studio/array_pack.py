"""Arrays of a page: one compressed block of bytes, and references to its parts in JSON.

Numbers of several bytes are stored as differences between neighbours, with the first bytes of all
numbers before the second bytes of all: smooth curves then pack to a third. `unpack.js` reads it.
"""

import zlib
from base64 import b64encode
from typing import Any

import numpy as np
import numpy.typing as npt

KINDS = ("u1", "i1", "u2", "i2", "u4", "f4")
"""Types of numbers, little-endian."""

LEVEL = 6
"""Level of the compression, from 1 to 9."""

REFERENCE = "$array"
"""Key of an object that stands for an array."""


class ArrayPack:
    """A growing block of arrays.

    Examples
    --------
    >>> pack = ArrayPack()
    >>> pack.add(np.array([0.0, 0.5]), "u2", 65535)
    {'$array': 0}
    >>> pack.layout()
    [['u2', 2]]
    """

    def __init__(self) -> None:
        self._rows: list[tuple[str, int]] = []
        self._data: list[bytes] = []

    def add(self, values: npt.ArrayLike, kind: str, scale: float = 1.0) -> dict[str, int]:
        """Append an array and return its reference.

        Parameters
        ----------
        values : of any shape; the page sees them in one row
        kind : a name in `KINDS`; integers are rounded, and clipped to their range
        scale : factor of each value before rounding
        """
        flat = np.asarray(values).ravel()
        dtype = np.dtype(f"<{kind}")
        if dtype.kind == "f":
            whole = flat.astype(dtype)
        else:
            range_ = np.iinfo(dtype)
            whole = np.rint(flat * scale).clip(range_.min, range_.max).astype(dtype)
        self._rows.append((kind, len(whole)))
        self._data.append(_coded(whole))
        return {REFERENCE: len(self._rows) - 1}

    def add_bytes(self, content: bytes) -> dict[str, int]:
        """Append the content of a file."""
        return self.add(np.frombuffer(content, np.uint8), "u1")

    def layout(self) -> list[list[str | int]]:
        """Return the type and the length of each array as JSON data."""
        return [[kind, count] for kind, count in self._rows]

    def block(self) -> bytes:
        """Return the arrays, one after the other."""
        return b"".join(self._data)

    def text(self) -> str:
        """Return the block, compressed, in base64."""
        return b64encode(zlib.compress(self.block(), LEVEL)).decode("ascii")


def _coded(values: npt.NDArray[Any]) -> bytes:
    if values.dtype.itemsize == 1 or values.dtype.kind == "f":
        return values.tobytes()
    unsigned = values.view(f"<u{values.dtype.itemsize}")
    steps = np.diff(unsigned, prepend=unsigned.dtype.type(0))  # wraps around, as `unpack.js` does
    return (
        steps.astype(unsigned.dtype).view(np.uint8).reshape(-1, values.dtype.itemsize).T.tobytes()
    )
