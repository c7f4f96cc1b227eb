"""Files are written whole or not at all."""

import os
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import BinaryIO

from lipsync_lang.errors import OutputError


@contextmanager
def atomic(path: Path) -> Iterator[BinaryIO]:
    """Open a stream whose bytes appear at `path` only if the block ends well.

    Raises
    ------
    OutputError
        The folder is missing or read-only, the disk is full, or `path` is a folder.
    """
    try:
        if path.is_dir():
            raise OutputError(f"{path}: is a folder; name a file in it")
        handle, name = tempfile.mkstemp(prefix=f".{path.name[:40]}-", dir=path.parent)
    except (OSError, ValueError) as error:
        raise _cannot_write(path, error) from None
    try:
        with os.fdopen(handle, "wb") as stream:
            yield stream
        Path(name).chmod(_mode(path))
        Path(name).replace(path)
    except OSError as error:
        raise _cannot_write(path, error) from None
    finally:
        Path(name).unlink(missing_ok=True)


def _mode(path: Path) -> int:
    """Keep the permissions of the file that is replaced; a new one gets the usual ones."""
    if path.exists():
        return path.stat().st_mode & 0o777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask


def write_all(outputs: Mapping[Path, Callable[[BinaryIO], None]]) -> None:
    """Write several files, all of them or none."""
    with ExitStack() as open_files:
        for path, write in outputs.items():
            stream = open_files.enter_context(atomic(path))
            write(stream)
            stream.flush()  # a full disk is noticed while nothing is in its place yet


def _cannot_write(path: Path, error: OSError | ValueError) -> OutputError:
    if isinstance(error, FileNotFoundError):
        return OutputError(f"{path}: the folder {path.parent} does not exist; make it first")
    why = getattr(error, "strerror", None) or error
    return OutputError(f"{path}: cannot be written: {why}; name another place")
