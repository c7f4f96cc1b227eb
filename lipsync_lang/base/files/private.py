"""Private files: readable by their owner alone, and not trusted if others could write them."""

import os
import stat
from contextlib import suppress
from pathlib import Path

MAX_PRIVATE_BYTES = 4096


def write_private(path: Path, content: bytes) -> None:
    """Replace a file by a new one that only its owner can read; raise OSError if that fails."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with suppress(FileNotFoundError):
        path.unlink()
    flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
    with os.fdopen(os.open(path, flags, 0o600), "wb") as stream:
        stream.write(content)


def read_private(path: Path) -> tuple[bytes, float] | None:
    """Return a file's content and the time of its writing.

    The result is None if there is no such file, if it is a link, if it belongs to somebody else, or
    if others may read or write it. Windows keeps files of a user's profile private without modes.
    """
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
    try:
        with os.fdopen(os.open(path, flags), "rb") as stream:
            found = os.fstat(stream.fileno())
            shared = os.name == "posix" and (found.st_uid != os.getuid() or found.st_mode & 0o077)
            if shared or not stat.S_ISREG(found.st_mode):
                return None
            return stream.read(MAX_PRIVATE_BYTES), found.st_mtime
    except OSError:
        return None
