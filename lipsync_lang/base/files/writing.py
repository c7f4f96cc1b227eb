"""Write outputs: regular files appear whole or not at all; devices and pipes are written directly.

Every writer gets a seekable stream. Its bytes go to a temporary file beside the target, or into
memory if the target is a device, a pipe or standard output. When all outputs are written, the
files are renamed into place, and then the streams are written.

On Windows, a file is renamed also while a virus scanner reads it.
"""

import os
import stat
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from shutil import copyfileobj
from typing import IO, BinaryIO, cast

from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.files.signals import undisturbed
from lipsync_lang.base.files.targets import STANDARD_STREAM, descriptor, file_behind, read_only
from lipsync_lang.base.files.temporary import sweep, temporary_name

PAUSES_SECONDS = (0.02, 0.05, 0.1, 0.2, 0.4)
"""Pauses between attempts on Windows; scanners read a new file for less than their sum."""

IN_USE = (5, 32)
"""Windows error codes for a file in use by another program: access denied, sharing violation."""

MAX_SPOOLED_BYTES = 16 * 2**20
"""Maximum number of bytes in memory for a device or a pipe; more are kept on disk."""


def replace_file(source: Path, target: Path) -> None:
    """Rename a file, maybe over another, or a folder to a free name.

    Windows refuses that while any program has a file of them open. A virus scanner opens each new
    file for a moment, so the rename is attempted again there.
    """
    for seconds in PAUSES_SECONDS if sys.platform == "win32" else ():
        try:
            source.replace(target)
        except PermissionError:
            time.sleep(seconds)
        else:
            return
    try:
        source.replace(target)
    except OSError as error:
        error.filename = str(target)  # its user has never seen the temporary file
        raise


@contextmanager
def atomic(path: Path, *, durable: bool = False) -> Iterator[BinaryIO]:
    """Open a stream whose bytes appear at `path` only if the block ends without an error.

    Raises OutputError if the folder is missing or read-only, the file is read-only, the disk is
    full, or `path` is a folder.

    Parameters
    ----------
    path : a file, a link to one, a device, a pipe, or ``-`` for standard output
    durable : call `fsync`, so that a power loss leaves either the old file or the new one
    """
    with _prepared(durable=durable) as outputs, _worded(path):
        yield outputs.open(path)


def write_all(
    outputs: Mapping[Path, Callable[[BinaryIO], object]],
    *,
    durable: bool = False,
    ready: Callable[[], object] = lambda: None,
) -> None:
    """Write several outputs: prepare all of them, then put them in place together.

    Streams are written after the files, so that a pipe closed early loses no file. `ready` is
    called between the two, when the content of every file is on the disk; its error puts no file
    in place. The other parameters and errors are those of `atomic`.
    """
    with _prepared(durable=durable, ready=ready) as prepared:
        for path, write in outputs.items():
            with _worded(path):
                stream = prepared.open(path)
                write(stream)
                stream.flush()  # notice a full disk before any file is renamed


@contextmanager
def _worded(path: Path) -> Iterator[None]:
    """Turn an `OSError` into an `OutputError`; let `BrokenPipeError` through."""
    try:
        yield
    except BrokenPipeError:
        raise
    except OSError as error:
        raise cannot_write(path, error) from None


@contextmanager
def _prepared(*, durable: bool, ready: Callable[[], object] = lambda: None) -> Iterator["_Outputs"]:
    outputs = _Outputs(durable)
    try:
        yield outputs
        outputs.commit(ready)
    finally:
        outputs.discard()


@dataclass
class _Outputs:
    """Outputs that are put in place together."""

    durable: bool
    files: list["_Waiting"] = field(default_factory=list)
    streams: list[tuple[Path, IO[bytes]]] = field(default_factory=list)

    def open(self, path: Path) -> BinaryIO:
        """Return a seekable stream for the content of `path`."""
        try:
            target = file_behind(path)
            if target is None:
                from tempfile import SpooledTemporaryFile

                spooled = SpooledTemporaryFile(MAX_SPOOLED_BYTES)  # noqa: SIM115 closed by discard
                self.streams.append((path, spooled))
                return cast("BinaryIO", spooled)
            waiting = _Waiting(path, target, target.with_name(temporary_name(target.name)))
            self.files.append(waiting)  # before the file is created: a signal may come any time
            return waiting.open()
        except (OSError, ValueError) as error:
            raise cannot_write(path, error) from None

    def commit(self, ready: Callable[[], object]) -> None:
        """Put the files in place, then write the streams."""
        for file in self.files:
            with _worded(file.path):
                file.close(durable=self.durable)
        ready()
        with undisturbed():
            for file in self.files:
                with _worded(file.path):
                    replace_file(file.temporary, file.target)
        if self.durable:
            for folder in {file.target.parent for file in self.files}:
                _sync_folder(folder)
        for path, spooled in self.streams:
            spooled.seek(0)
            with _worded(path):
                _feed(path, spooled)

    def discard(self) -> None:
        """Delete the temporary files that are left."""
        with undisturbed():
            for file in self.files:
                file.discard()
            for _, spooled in self.streams:
                spooled.close()


@dataclass
class _Waiting:
    """A temporary file beside its target."""

    path: Path
    """The target as named by the user, for messages."""
    target: Path
    temporary: Path
    stream: BinaryIO | None = None

    def open(self) -> BinaryIO:
        """Create the file; the kernel applies the umask, which a program cannot read safely."""
        sweep(self.target.parent)
        there = self.target.stat() if self.target.exists() else None
        mode = 0o666 if there is None else stat.S_IMODE(there.st_mode) & 0o666
        # Without O_BINARY, Windows writes two characters for each line break.
        flags = os.O_RDWR | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)
        self.stream = os.fdopen(os.open(self.temporary, flags, mode), "w+b")
        if there is not None:
            mine = self.temporary.stat()
            if hasattr(os, "chown") and (mine.st_uid, mine.st_gid) != (there.st_uid, there.st_gid):
                with suppress(PermissionError):  # only root can keep the owner
                    os.chown(self.temporary, there.st_uid, there.st_gid)
            self.temporary.chmod(stat.S_IMODE(there.st_mode) & 0o777)
        return self.stream

    def close(self, *, durable: bool) -> None:
        """Flush and close the file."""
        if self.stream is not None:
            self.stream.flush()
            if durable:
                os.fsync(self.stream.fileno())
            self.stream.close()

    def discard(self) -> None:
        """Delete the file unless it was renamed into place."""
        with suppress(OSError, ValueError):
            if self.stream is not None:
                self.stream.close()
        with suppress(OSError):
            self.temporary.unlink(missing_ok=True)


# Streams


def _feed(path: Path, source: IO[bytes]) -> None:
    if path == STANDARD_STREAM:
        _feed_standard(source)
        return
    number = descriptor(path)
    if number is not None:
        if sys.stdout is not None:
            sys.stdout.flush()
        # A copy: closing the stream must not close the descriptor of the caller.
        handle = os.dup(number)
    else:
        # A terminal that is opened would become the one of this process, and send it Ctrl-C.
        handle = os.open(path, os.O_WRONLY | getattr(os, "O_NOCTTY", 0))
    with os.fdopen(handle, "wb") as out:
        copyfileobj(source, out, MAX_SPOOLED_BYTES)


def _feed_standard(source: IO[bytes]) -> None:
    """Write bytes to standard output; refuse binary data on a terminal."""
    out = sys.stdout
    if out is None:
        raise OutputError("-: there is no standard output here; name a file")
    out.flush()
    binary = getattr(out, "buffer", None)
    if binary is not None and not out.isatty():
        copyfileobj(source, binary, MAX_SPOOLED_BYTES)
        binary.flush()
        return
    try:
        text = source.read().decode("utf-8")
    except UnicodeDecodeError:
        text = "\0"
    if "\0" in text:
        raise OutputError("-: a terminal cannot show these bytes; name a file, or pipe them on")
    # On Windows, a text stream makes \r\n of each \n by itself.
    out.write(text.replace("\r\n", "\n"))
    out.flush()


def _sync_folder(folder: Path) -> None:
    """Make renames in a folder durable; errors of file systems without support are ignored."""
    with suppress(OSError):
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def cannot_write(
    path: Path, error: OSError | ValueError, mend: str = "name another place"
) -> OutputError:
    """Return an error for a path that cannot be written, with the reason and cures."""
    if isinstance(error, FileNotFoundError):
        return OutputError(f"{path}: the folder {path.parent} does not exist; make it first")
    if why := read_only(path, error):
        return OutputError(f"{path}: {why}, or {mend}")
    if getattr(error, "winerror", None) in IN_USE:
        why = "is open in another program, or write-protected; close it there"
        return OutputError(f"{path}: {why}, or {mend}")
    why = getattr(error, "strerror", None) or str(error)
    return OutputError(f"{path}: cannot be written: {why}; {mend}")
