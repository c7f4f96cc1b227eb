"""Digests of values, contents and files: equal digests stand for equal values."""

import json
from dataclasses import asdict, is_dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any
from zlib import crc32

import numpy as np

from lipsync_lang.base.files.reading import MIB_BYTES

VALUE_BYTES = 8
"""Length of a value's digest in bytes."""

CONTENT_BYTES = 16
"""Length of the digest of a file's content in bytes."""


def digest(*values: object) -> bytes:
    """Return the digest of plain values, arrays, and dictionaries, lists and dataclasses of them.

    >>> digest("m", 1.5) == digest("m", 1.5), digest("m", 1.5) == digest("m", 1.25)
    (True, False)
    """
    content = json.dumps(values, sort_keys=True, default=_plain, separators=(",", ":"))
    return joined(content.encode())


def joined(*parts: bytes) -> bytes:
    """Return the digest of bytes."""
    return blake2b(b"".join(parts), digest_size=VALUE_BYTES).digest()


def output_digest(crc: int, size: int) -> str:
    """Return the digest of an output: its CRC, which archives list too, and its size.

    A line may write megabytes. Their CRC takes a quarter of the time of a cryptographic digest,
    and nobody edits a file by hand to have the CRC of another.
    """
    return f"crc-{crc:08x}-{size}"


def output_file_digest(path: Path) -> str:
    """Return the digest of an output that is a file of its own."""
    crc = size = 0
    with path.open("rb") as stream:
        while block := stream.read(MIB_BYTES):
            crc, size = crc32(block, crc), size + len(block)
    return output_digest(crc, size)


def file_digest(path: Path) -> str:
    """Return the digest of a file's content."""
    whole = blake2b(digest_size=CONTENT_BYTES)
    # Without a buffer: `hashlib.file_digest` fills one of 256 kB for each small file.
    with path.open("rb", buffering=0) as stream:
        while block := stream.read(MIB_BYTES):
            whole.update(block)
    return whole.hexdigest()


def _plain(value: object) -> Any:
    if isinstance(value, np.ndarray):
        # Equal bytes of another type or shape are another array.
        return [value.dtype.str, value.shape, value.tobytes().hex()]
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (set, frozenset)):
        return sorted(value)
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    return str(value)
