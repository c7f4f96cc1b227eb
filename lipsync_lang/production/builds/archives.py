"""Archives of outputs: `takes/english-facefx.zip/line.csv` is the member `line.csv` of a ZIP file.

18 million small files fill the tables of a file system before its disk. An archive is rewritten
beside itself and put in place whole; members that stay are copied as they are, compressed, so that
a change of 200 lines does not compress 50,000. Equal members make equal archives: names are sorted,
times are fixed. Outputs that stand on the disk are compared with the record of the last build.
"""

import os
import re
import struct
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, suppress
from functools import cache
from pathlib import Path, PurePosixPath
from shutil import copyfileobj
from typing import BinaryIO, NamedTuple
from zipfile import ZIP64_LIMIT, ZIP_DEFLATED, ZIP_STORED, BadZipFile, ZipFile, ZipInfo
from zlib import crc32

from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.files.reach import is_reached
from lipsync_lang.base.files.reading import MIB_BYTES
from lipsync_lang.base.files.writing import atomic
from lipsync_lang.production.builds.digests import output_digest, output_file_digest
from lipsync_lang.production.builds.takes import TAKES_SUFFIX, archive_of, write_takes

ARCHIVE_SUFFIXES = (".zip", TAKES_SUFFIX)

ARCHIVED = re.compile("|".join(map(re.escape, ARCHIVE_SUFFIXES)), re.IGNORECASE).search

TAKE_SUFFIX = ".keys"
"""End of the name of every member of an archive of takes."""

TIME = (1980, 1, 1, 0, 0, 0)
"""Earliest time of ZIP; true times would change archives with the same content."""

MODE = 0o100644 << 16
"""Mode of a regular file that everyone may read."""

UNIX = 3

ZIP_HEAD = struct.Struct("<4s22xHH")
"""Header of a member: its signature, and the lengths of the following name and extra data."""

ZIP_START = b"PK\x03\x04"
ENCRYPTED = 0x1

NewMember = Path | bytes


class Member(NamedTuple):
    """Content of a member according to the archive."""

    crc: int
    """CRC-32."""
    size: int
    """Bytes."""


def split_archive(path: str) -> tuple[str, str] | None:
    """Split an output's path into an archive and its member; None for a separate file.

    >>> split_archive("takes/english-crab.zip/act1/l1.csv")
    ('takes/english-crab.zip', 'act1/l1.csv')
    >>> split_archive("takes/l1.zip") is None
    True
    """
    if not ARCHIVED(path):
        return None
    # Most outputs are files of their own, and a million paths are split in a build: the search for
    # a suffix above is cheap, parts of paths are not.
    parts = PurePosixPath(path).parts
    for number, part in enumerate(parts[:-1], 1):
        if part.lower().endswith(ARCHIVE_SUFFIXES):
            return str(PurePosixPath(*parts[:number])), "/".join(parts[number:])
    return None


def members(path: Path) -> dict[str, Member]:
    """Return the members of an archive by name; none if there is no such file.

    Raises OutputError if the file cannot be read, or is not an archive.
    """
    if not path.exists():
        return {}
    if _holds_takes(path):
        found = archive_of(path).takes.items()
        return {name + TAKE_SUFFIX: Member(crc32(one), len(one)) for name, one in found}
    with _opened(path) as (archive, _):
        return {one.filename: Member(one.CRC, one.file_size) for one in archive.infolist()}


def rewrite(path: Path, new: Mapping[str, NewMember], drop: Iterable[str] = ()) -> None:
    """Add members to an archive and remove others; all other members do not change.

    A crash loses nothing, because the old archive is kept until the new one is complete. An empty
    archive is deleted. Raises OutputError if the archive is damaged or encrypted, or cannot be
    written.

    Parameters
    ----------
    path : the archive; its folder exists
    new : content by name, as bytes or as a file to read; they replace members of their names
    drop : names of members to remove; unknown names are ignored
    """
    gone = {*drop} - {*new}
    if _holds_takes(path):
        _rewrite_takes(path, new, gone)
        return
    if not path.exists():
        if new:
            _write(path, new, {}, None)
        return
    with _opened(path) as (archive, stream):
        kept = {
            one.filename: one
            for one in archive.infolist()
            if one.filename not in gone and one.filename not in new
        }
        if new or kept:
            _write(path, new, kept, stream)
            return
    _delete(path)


def _holds_takes(path: Path) -> bool:
    return path.name.lower().endswith(TAKES_SUFFIX)


def _rewrite_takes(path: Path, new: Mapping[str, NewMember], gone: set[str]) -> None:
    takes = archive_of(path).takes if path.exists() else {}
    for name in gone:
        takes.pop(name.removesuffix(TAKE_SUFFIX), None)
    for name, one in new.items():
        content = one if isinstance(one, bytes) else one.read_bytes()
        takes[name.removesuffix(TAKE_SUFFIX)] = content
    if takes:
        write_takes(path, takes)
    elif path.exists():
        _delete(path)


def _delete(path: Path) -> None:
    try:
        path.unlink()
    except OSError as error:
        raise OutputError(f"{path}: cannot be deleted: {error.strerror}") from None


@contextmanager
def _opened(path: Path) -> Iterator[tuple[ZipFile, BinaryIO]]:
    """Open an archive, and a stream of its bytes."""
    mend = "move it away; the build makes a new one"
    try:
        with path.open("rb") as stream, ZipFile(stream) as archive:
            found = sorted((one.header_offset, one.compress_size) for one in archive.infolist())
            ends = (at + ZIP_HEAD.size + size for at, size in found)
            # A small forged archive whose members share bytes would be copied into a huge one.
            if any(end > after for end, (after, _) in zip(ends, found[1:], strict=False)):
                raise BadZipFile("its members overlap")  # noqa: TRY301 told below
            yield archive, stream
    except OSError as error:
        raise OutputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except (BadZipFile, NotImplementedError, ValueError, struct.error, EOFError) as error:
        raise OutputError(f"{path}: is a damaged archive ({error}); {mend}") from None


def _write(
    path: Path, new: Mapping[str, NewMember], kept: Mapping[str, ZipInfo], old: BinaryIO | None
) -> None:
    # The old archive is closed before the new one takes its place: Windows replaces no open file.
    with atomic(path) as out, old or nullcontext(), ZipFile(out, "w") as archive:
        for name in sorted({*new, *kept}):
            if name in new:
                put_member(archive, name, new[name])
            elif old is not None:
                _copy(archive, kept[name], old)


def _fresh(name: str, compression: int) -> ZipInfo:
    """Return a member without data that depends on the machine or the time."""
    info = ZipInfo(name, TIME)
    info.compress_type, info.create_system, info.external_attr = compression, UNIX, MODE
    return info


def put_member(archive: ZipFile, name: str, content: NewMember) -> None:
    """Compress a new member."""
    info = _fresh(name, ZIP_DEFLATED)
    if isinstance(content, bytes):
        archive.writestr(info, content)
        return
    # `ZipFile.open` decides by this size whether the header needs 64 bits.
    info.file_size = content.stat().st_size
    with content.open("rb") as source, archive.open(info, "w") as target:
        copyfileobj(source, target, MIB_BYTES)


def _copy(archive: ZipFile, old: ZipInfo, source: BinaryIO) -> None:
    """Copy a member as it is, compressed; `zipfile` has no function for it."""
    if old.flag_bits & ENCRYPTED or old.compress_type not in (ZIP_STORED, ZIP_DEFLATED):
        raise BadZipFile(f"'{old.filename}' is encrypted, or compressed in another way")
    source.seek(old.header_offset)
    # The directory at the end of a ZIP does not tell the length of the member's own header: its
    # extra data may differ from those of the directory.
    head = source.read(ZIP_HEAD.size)
    if len(head) < ZIP_HEAD.size:
        raise BadZipFile(f"'{old.filename}' ends early")
    mark, name, further = ZIP_HEAD.unpack(head)
    if mark != ZIP_START:
        raise BadZipFile(f"'{old.filename}' is not at the position that the archive states")
    source.seek(name + further, 1)
    info = _fresh(old.filename, old.compress_type)
    info.CRC, info.compress_size, info.file_size = old.CRC, old.compress_size, old.file_size
    out = archive.fp
    assert out is not None  # noqa: S101 it is open
    info.header_offset = out.tell()
    out.write(info.FileHeader(zip64=max(info.file_size, info.compress_size) > ZIP64_LIMIT))
    left = info.compress_size
    while left:
        block = source.read(min(left, MIB_BYTES))
        if not block:
            raise BadZipFile(f"'{old.filename}' ends early")
        out.write(block)
        left -= len(block)
    # `zipfile` writes the directory from these two and `start_dir` when it is closed; it has no
    # public way to add a member that is compressed already.
    archive.filelist.append(info)
    archive.NameToInfo[info.filename] = info
    archive.start_dir = out.tell()


class StandingOutputs:
    """The outputs in a project's folder; archives are listed once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._home = str(folder)
        self._members = cache(lambda archive: members(folder / archive))
        self._reached = cache(lambda parent: is_reached(folder / parent, folder))

    def stamp(self, path: str) -> tuple[int, int] | None:
        """Return size and time of change of a file, size and CRC of a member; None if absent."""
        split = split_archive(path)
        if split is not None:
            found = self._members(split[0]).get(split[1])
            return None if found is None else (found.size, found.crc)
        try:
            stat = os.stat(f"{self._home}/{path}")  # noqa: PTH116 ten thousands of them
        except OSError:
            return None
        return stat.st_size, stat.st_mtime_ns

    def digest(self, path: str) -> str:
        """Return the digest of an output's content; empty if it is absent or cannot be read."""
        split = split_archive(path)
        if split is not None:
            found = self._members(split[0]).get(split[1])
            return "" if found is None else output_digest(found.crc, found.size)
        with suppress(OSError):
            return output_file_digest(self.folder / path)
        return ""

    def is_within(self, path: str) -> bool:
        """Return True if an output is in the folder, since records may come from elsewhere."""
        return self._reached(Path(path).parent)

    def delete(self, paths: list[str]) -> None:
        """Delete outputs; absent ones do not matter."""
        members_: dict[str, list[str]] = {}
        for path in paths:
            split = split_archive(path)
            if split is None:
                (self.folder / path).unlink(missing_ok=True)
            else:
                members_.setdefault(split[0], []).append(split[1])
        for archive, names in members_.items():
            rewrite(self.folder / archive, {}, names)
        self._members.cache_clear()
