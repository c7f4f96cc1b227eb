"""Find the target of an output: the regular file behind links, or a stream."""

import errno
import os
import re
import stat
from pathlib import Path

from lipsync_lang.base.errors import OutputError

STANDARD_STREAM = Path("-")
"""The name of standard output, and of standard input for inputs."""

MAX_LINKS = 40
"""Maximum number of links followed to one file; Linux has the same limit."""

WRITE_BITS = stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH
"""Permission bits; a file without any of them is read-only, even for root."""

_DESCRIPTORS = re.compile(r"/dev/fd|/proc/(?P<process>\d+)(?:/task/\d+)?/fd")


def argument_path(text: str | Path) -> Path:
    """Return the path of an argument: ``-`` is the standard stream, ``./-`` a file of that name."""
    path = Path(text)
    return path if path != STANDARD_STREAM or str(text) == "-" else Path.cwd() / path


def file_behind(path: Path) -> Path | None:
    """Return the regular file that a path leads to; None for a stream, device or pipe.

    Raises
    ------
    OutputError
        The path is a folder, a read-only file, a disk, a socket, or a circle of links.
    OSError, ValueError
        The path cannot be examined.
    """
    if path == STANDARD_STREAM or descriptor(path) is not None:
        return None
    target = Path(os.path.realpath(path))
    if target.is_symlink():
        raise OutputError(f"{path}: is a link that leads in a circle; name another place")
    if not path.exists():
        return target
    there = path.stat()
    if stat.S_ISDIR(there.st_mode):
        raise OutputError(f"{path}: is a folder; name a file in it")
    if stat.S_ISBLK(there.st_mode):
        raise OutputError(f"{path}: is a disk; name a file on it")
    if stat.S_ISSOCK(there.st_mode):
        raise OutputError(f"{path}: is a socket; write to - and pipe it into a program")
    if not stat.S_ISREG(there.st_mode):
        return None
    refuse_locked(path, there.st_mode)
    if not may_write(path):
        raise OutputError(f"{path}: is write-protected; ask its owner, or name another file")
    return target


def refuse_locked(path: Path, mode: int) -> None:
    """Raise an error if the mode of a file makes it read-only.

    Version control marks files that are not checked out so, and root must heed it too.
    """
    if not mode & WRITE_BITS:
        raise OutputError(
            f"{path}: is read-only; open it in your version control or make it writable "
            "(chmod u+w), or name another file"
        )


def may_write(path: Path) -> bool:
    """Return True if the effective user may write a file, or into a folder."""
    return os.access(path, os.W_OK, effective_ids=os.access in os.supports_effective_ids)


def read_only(path: Path, error: OSError | ValueError) -> str:
    """Describe the read-only folder or disk that refused a path, with its cure; else empty."""
    folder = next((one for one in (path, *path.parents) if os.path.isdir(one)), path)  # noqa: PTH112 no error
    if getattr(error, "errno", None) == errno.EROFS:
        return f"the disk of the folder {folder} is read-only; make it writable"
    if isinstance(error, PermissionError) and not may_write(folder):
        return f"the folder {folder} is read-only; make it writable (chmod u+w) or ask its owner"
    return ""


def descriptor(path: Path) -> int | None:
    """Return the number of the open descriptor that a path such as `/dev/stdout` names."""
    for _ in range(MAX_LINKS):
        folder = os.path.realpath(path.parent)
        found = _DESCRIPTORS.fullmatch(folder)
        if found and path.name.isdecimal():
            return int(path.name) if found["process"] in (None, str(os.getpid())) else None
        if not path.is_symlink():
            return None
        path = Path(folder, path.readlink())
    return None
