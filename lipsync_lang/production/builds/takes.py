"""Archives of takes (`.takes`): one file that players map into memory, and patches of them.

An archive is a function of its takes alone: equal takes make equal bytes, in whatever order and
on however many machines they were made. `docs/reference/takes.md` has the layout. Takes are named
by language and line, such as `english/intro_001`, and are the bytes of `.keys` files.
"""

import struct
from collections.abc import Iterator, Mapping
from itertools import pairwise
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import NamedTuple
from zlib import crc32

from lipsync_lang.animations.writers.take import TAKE_HEAD, TAKE_MAGIC, TAKE_TRACK, TEXT_LENGTH
from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.files.writing import atomic

TAKES_SUFFIX = ".takes"

TAKES_MAGIC = b"LLTAKES\0"
TAKES_VERSION = 1

TAKES_HEADER = struct.Struct("<8sHHIIIQQQIIII")
"""Magic, version, kind, takes, slots, poses, and positions of the index, the takes and the end of
the file. Then CRC-32 of the header with names and index, of the takes, and of a patch's base and
result."""

INDEX_SLOT = struct.Struct("<QII")
"""Position of a take (0 for a free slot), hash of its name, bytes."""

TAKE_NAME = struct.Struct("<2H")
"""Bytes of a take's name, 1 for a take that a patch removes."""

PATCH_KIND = 1
"""Kind of a file that changes another; 0 is a whole archive."""

MAX_POSES = 2**16 - 1
"""Maximum number of poses of an archive: their numbers have two bytes."""

MAX_POSE_BYTES = 1_000
"""Longest name of a pose that is read: each take repeats it."""

HEAD_CRC_AT = 48
"""Position of the header's own checksum."""

MEND_TAKES = "make it again with `lipsync-lang build`, or take a copy"


class TakesFile(NamedTuple):
    """All takes of an archive or a patch."""

    takes: dict[str, bytes]
    """Content of `.keys` files by name; empty for one that a patch removes."""
    patch: tuple[int, int] | None
    """Checksums of the archive that a patch changes, and of the result; None for an archive."""


def name_hash(name: bytes) -> int:
    """Return the 32-bit FNV-1a hash of a take's name.

    >>> name_hash(b"english/l1")
    2467626995
    """
    value = 0x811C9DC5
    for byte in name:
        value = (value ^ byte) * 0x01000193 & 0xFFFFFFFF
    return value


def read_takes(path: Path) -> TakesFile:
    """Read an archive or a patch, and check all of it.

    Raises OutputError if it cannot be read, is damaged, or has an unknown version.
    """
    try:
        with path.open("rb") as stream:
            if not stream.read(1):
                raise OutputError(f"{path}: is empty; {MEND_TAKES}")
            with mmap(stream.fileno(), 0, access=ACCESS_READ) as data:
                return _decoded(path, data)
    except OSError as error:
        raise OutputError(f"{path}: cannot be read: {error.strerror or error}") from None
    except (ValueError, IndexError, OverflowError, struct.error) as error:
        raise OutputError(f"{path}: is a damaged archive ({error}); {MEND_TAKES}") from None


def _decoded(path: Path, data: mmap) -> TakesFile:
    if data[:8] != TAKES_MAGIC:
        raise OutputError(f"{path}: is not an archive of takes; {MEND_TAKES}")
    if len(data) < TAKES_HEADER.size:
        raise ValueError("its header ends early")
    _, version, kind, count, slots, poses, index, takes, end, head, body, base, result = (
        TAKES_HEADER.unpack_from(data)
    )
    if version != TAKES_VERSION:
        what = f"has version {version}, and this program reads {TAKES_VERSION}; update it"
        raise OutputError(f"{path}: {what}")
    if end != len(data):
        raise ValueError(f"it has {len(data):,} bytes of {end:,}")
    if not TAKES_HEADER.size <= index <= takes <= end or takes - index != slots * INDEX_SLOT.size:
        raise ValueError("its parts overlap")
    if _head_crc(data[:takes]) != head:
        raise ValueError("the checksum of its index is wrong")
    if crc32(memoryview(data)[takes:]) != body:
        raise ValueError("the checksum of its takes is wrong")
    names, _ = _texts(data, TAKES_HEADER.size, poses)
    if (longest := max(map(len, names), default=0)) > MAX_POSE_BYTES:
        raise ValueError(f"the name of a pose has {longest:,} bytes")
    read = dict(_records(data, index, slots, names))
    if len(read) != count:
        raise ValueError(f"it has {len(read):,} takes of {count:,}")
    return TakesFile(dict(sorted(read.items())), (base, result) if kind == PATCH_KIND else None)


def _head_crc(head: bytes) -> int:
    return crc32(head[HEAD_CRC_AT + 4 :], crc32(head[:HEAD_CRC_AT]))


def _texts(data: mmap | bytes, at: int, count: int) -> tuple[list[bytes], int]:
    """Return texts that follow each other, and the position after them."""
    found = []
    for _ in range(count):
        (length,) = TEXT_LENGTH.unpack_from(data, at)
        found.append(bytes(data[at + 2 : at + 2 + length]))
        at += 2 + length
    return found, at


def _records(data: mmap, index: int, slots: int, names: list[bytes]) -> Iterator[tuple[str, bytes]]:
    spans = sorted(
        (at, size)
        for at, _, size in INDEX_SLOT.iter_unpack(data[index : index + slots * INDEX_SLOT.size])
        if at
    )
    # One record behind many names would fill the memory.
    if any(at + size > after for (at, size), (after, _) in pairwise(spans)):
        raise ValueError("its takes overlap")
    for at, size in spans:
        length, gone = TAKE_NAME.unpack_from(data, at)
        first = at + TAKE_NAME.size
        body = data[first + length + -length % 4 : at + size]
        yield data[first : first + length].decode(), b"" if gone else _single(body, names)


def _single(body: bytes, names: list[bytes]) -> bytes:
    """Return a take of an archive as a file of its own, with the names of its poses."""
    tracks = TAKE_HEAD.unpack_from(body)[4]
    own, table = [], bytearray(body)
    for number in range(tracks):
        at = TAKE_HEAD.size + number * TAKE_TRACK.size
        own.append(names[TEXT_LENGTH.unpack_from(body, at)[0]])
        TEXT_LENGTH.pack_into(table, at, number)
    if len({*own}) < len(own):
        raise ValueError("a take names a pose twice")
    told = b"".join(TEXT_LENGTH.pack(len(name)) + name for name in own)
    return TAKE_MAGIC + TEXT_LENGTH.pack(tracks) + told + bytes(table)


def _parted(take: bytes, name: str) -> tuple[list[bytes], bytes]:
    """Return the names of a take's poses, and the rest of the file."""
    if take[: len(TAKE_MAGIC)] != TAKE_MAGIC:
        raise OutputError(f"'{name}' is not a take of version {TAKE_MAGIC[4]}")
    (count,) = TEXT_LENGTH.unpack_from(take, len(TAKE_MAGIC))
    names, at = _texts(take, len(TAKE_MAGIC) + 2, count)
    return names, take[at:]


def encoded(takes: Mapping[str, bytes], patch: tuple[int, int] | None = None) -> bytes:
    """Return an archive or a patch of takes.

    Raises OutputError if one is not a take, or all have more than 65,535 poses.
    """
    parts = {name: _parted(one, name) if one else None for name, one in sorted(takes.items())}
    poses = sorted({pose for part in parts.values() if part for pose in part[0]})
    if len(poses) > MAX_POSES:
        raise OutputError(f"{len(poses):,} poses are too many for an archive; use several")
    numbers = {pose: number for number, pose in enumerate(poses)}
    told = b"".join(TEXT_LENGTH.pack(len(pose)) + pose for pose in poses)
    index_at = TAKES_HEADER.size + len(told) + -(TAKES_HEADER.size + len(told)) % 8
    # A power of two, at most two thirds full, so that players find a name by a mask and few steps.
    slots = 1 << (len(parts) * 3 // 2).bit_length()
    first = at = index_at + slots * INDEX_SLOT.size
    index, records = bytearray(slots * INDEX_SLOT.size), []
    for name, part in parts.items():
        record = _record(name.encode(), part, numbers)
        value = name_hash(name.encode())
        slot = value % slots
        while INDEX_SLOT.unpack_from(index, slot * INDEX_SLOT.size)[0]:
            slot = (slot + 1) % slots
        INDEX_SLOT.pack_into(index, slot * INDEX_SLOT.size, at, value, len(record))
        records.append(record + b"\0" * (-len(record) % 8))
        at += len(records[-1])
    body = b"".join(records)
    kind = 0 if patch is None else PATCH_KIND
    stated = (TAKES_MAGIC, TAKES_VERSION, kind, len(parts), slots, len(poses), index_at, first, at)
    rest = told.ljust(index_at - TAKES_HEADER.size, b"\0") + index
    head = bytearray(TAKES_HEADER.pack(*stated, 0, crc32(body), *(patch or (0, 0))) + rest)
    struct.pack_into("<I", head, HEAD_CRC_AT, _head_crc(bytes(head)))
    return bytes(head) + body


def _record(
    name: bytes, part: tuple[list[bytes], bytes] | None, numbers: Mapping[bytes, int]
) -> bytes:
    head = TAKE_NAME.pack(len(name), int(part is None)) + name + b"\0" * (-len(name) % 4)
    if part is None:
        return head
    body = bytearray(part[1])
    for number, pose in enumerate(part[0]):
        TEXT_LENGTH.pack_into(body, TAKE_HEAD.size + number * TAKE_TRACK.size, numbers[pose])
    return head + bytes(body)


def write_takes(path: Path, takes: Mapping[str, bytes]) -> None:
    """Write an archive whole."""
    with atomic(path) as out:
        out.write(encoded(takes))


def archive_of(path: Path) -> TakesFile:
    """Read a whole archive; refuse a patch."""
    found = read_takes(path)
    if found.patch is not None:
        raise OutputError(f"{path}: is a patch; `lipsync-lang archive apply` makes the archive")
    return found
