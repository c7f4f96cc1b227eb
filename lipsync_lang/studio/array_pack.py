"""Arrays of a page: one compressed block of bytes, and references to its parts in JSON.

Numbers of several bytes are stored as differences between neighbours, with the first bytes of all
numbers before the second bytes of all: smooth curves then pack to a third. `unpack.js` reads it.
"""

import zlib
from base64 import b64encode

import numpy as np
import numpy.typing as npt

from lipsync_lang.base.json_object import Json

NUMBER_TYPES = ("u1", "i1", "u2", "i2", "u4", "f4")
"""Types of numbers, little-endian."""

SOUND_BLOCK = 256
"""Samples of a sound with the same step."""

SOUND_STEP = 12**0.5 * 10 ** (-33 / 20)
"""Step of a sound per its loudness in a block: the error is 33 dB below the sound."""

COMPRESSION_LEVEL = 6
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
        self._compressor = zlib.compressobj(COMPRESSION_LEVEL)
        self._compressed, self._count = b"", 0

    def copy(self) -> "ArrayPack":
        """Return a pack that goes on from this one; what both begin with is compressed once."""
        self._compress()
        made = ArrayPack()
        vars(made).update(vars(self), _rows=[*self._rows], _data=[*self._data])
        made._compressor = self._compressor.copy()
        return made

    def _compress(self) -> None:
        new = b"".join(self._data[self._count :])
        self._compressed += self._compressor.compress(new)
        self._count = len(self._data)

    def add(self, values: npt.ArrayLike, kind: str, scale: float = 1.0) -> dict[str, int]:
        """Append an array and return its reference; the page sees its values in one row.

        `kind` is a name in `NUMBER_TYPES`. Integers are values times `scale`, rounded, and clipped
        to their range.
        """
        flat, dtype = np.asarray(values).ravel(), np.dtype(f"<{kind}")
        if dtype.kind == "f":
            content = flat.astype(dtype).tobytes()
        else:
            range_, size = np.iinfo(dtype), dtype.itemsize
            whole = np.rint(flat * scale).clip(range_.min, range_.max).astype(dtype)
            if size > 1:  # unsigned differences wrap around, as `unpack.js` expects
                unsigned = whole.view(f"<u{size}")
                whole = np.diff(unsigned, prepend=unsigned.dtype.type(0)).astype(f"<u{size}")
            # The first bytes of smooth curves are noise and the last ones nearly all 0: apart, zlib
            # finds the runs of the latter.
            content = whole.view(np.uint8).reshape(-1, size).T.tobytes()
        self._rows.append((kind, flat.size))
        self._data.append(content)
        return {REFERENCE: len(self._rows) - 1}

    def layout(self) -> list[list[str | int]]:
        """Return the type and the length of each array as JSON data."""
        return [[kind, count] for kind, count in self._rows]

    def block(self) -> bytes:
        """Return the arrays, one after the other."""
        return b"".join(self._data)

    def text(self) -> str:
        """Return the block, compressed, in base64."""
        self._compress()
        return b64encode(self._compressed + self._compressor.copy().flush()).decode("ascii")

    def add_sound(self, samples: "npt.NDArray[np.int16]") -> Json:
        """Append a sound, in steps as large as its loudness allows, at some 3 bits a sample."""
        filled = np.pad(samples.astype(float), (0, -len(samples) % SOUND_BLOCK))
        blocks = filled.reshape(-1, SOUND_BLOCK)
        peak, loudness = abs(blocks).max(axis=1), np.sqrt((blocks**2).mean(axis=1))
        least = np.maximum(SOUND_STEP * loudness, peak / 127)
        steps = np.ceil(np.maximum(least, 1.0))
        # Counts are within -127 and 127, and wrap around to a byte, as their changes do.
        counts = np.rint(blocks / steps[:, None]).ravel()[: len(samples)].astype(np.uint8)
        changes = np.diff(counts, prepend=np.uint8(0))  # wraps around, as `unpack.js` expects
        return {
            "block": SOUND_BLOCK,
            "steps": self.add(steps, "u2"),
            "changes": self.add(changes, "u1"),
        }
