"""Digests of values, contents and files: equal digests stand for equal values."""

import json
from dataclasses import asdict, is_dataclass
from hashlib import blake2b
from pathlib import Path
from typing import Any

import numpy as np

VALUE_BYTES = 8
"""Bytes of a value's digest."""

CONTENT_BYTES = 16
"""Bytes of the digest of a file's content."""

BLOCK_BYTES = 2**20
"""Bytes of a file that are read at once."""


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


def content_digest(content: bytes | memoryview) -> str:
    """Return the digest of a file's content, which is at hand."""
    return blake2b(content, digest_size=CONTENT_BYTES).hexdigest()


def file_digest(path: Path) -> str:
    """Return the digest of a file's content."""
    whole = blake2b(digest_size=CONTENT_BYTES)
    with path.open("rb") as stream:
        while block := stream.read(BLOCK_BYTES):
            whole.update(block)
    return whole.hexdigest()


def _plain(value: object) -> Any:
    if isinstance(value, np.ndarray):
        return [value.dtype.str, value.shape, value.tobytes().hex()]
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, (set, frozenset)):
        return sorted(value)
    if is_dataclass(value) and not isinstance(value, type):
        return asdict(value)
    return str(value)
