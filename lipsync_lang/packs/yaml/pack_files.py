"""Files of packs as bytes, and their paths in messages: all that a start from the cache needs."""

from pathlib import Path

from lipsync_lang.base.errors import PackError

MAX_PACK_BYTES = 2**20
"""Largest pack file, in bytes."""


def shown(path: Path) -> str:
    """Return a path for a message: relative to the current folder if it lies below."""
    try:
        return str(path.relative_to(Path.cwd()))
    except (ValueError, OSError):
        return str(path)


def read_bytes(path: Path) -> bytes:
    """Return the bytes of a pack file, cut off just above the size limit; raise `PackError`.

    The cut lets the builder refuse an endless file (a device, a pipe) for its size.
    """
    try:
        with path.open("rb") as stream:
            return stream.read(MAX_PACK_BYTES + 1)
    except OSError as error:
        raise PackError(f"{shown(path)}: cannot be read: {error.strerror or error}") from None
