"""GLB container: a header, a JSON chunk and chunks of binary data.

All lengths and offsets are bytes. Every length is checked against the real file size before a
read, so that a false length costs no memory. A .gltf file is plain JSON.
"""

import struct
from base64 import b64decode
from binascii import Error as NotBase64
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import BinaryIO, NamedTuple, NoReturn

from lipsync_lang.base.errors import ModelError, OutputError
from lipsync_lang.base.json_object import Json

LARGEST = 2**30
"""Maximum model size in bytes, beyond what a browser or a game would load."""

LARGEST_WRITTEN = 2**32 - 1
"""Maximum GLB size in bytes: the header stores the length in 32 bits."""

GLB_MAGIC = b"glTF"
JSON_CHUNK = 0x4E4F534A
BINARY_CHUNK = 0x004E4942

EXPORT = "export the model as GLB (binary glTF 2.0)"

CONVERT = f"{EXPORT} or VRM, with its shape keys (in Blender: File > Export > glTF 2.0)"
"""Cure for a model in the format of another program."""

SEEMS = {
    "an FBX file": (b"kaydara fbx", b"; fbx"),
    "a PNG image": (b"\x89png",),
    "a JPEG image": (b"\xff\xd8\xff",),
    "a zip archive; unpack it first": (b"pk\x03\x04",),
    "a gzip archive; unpack it first": (b"\x1f\x8b",),
    "a Blender file": (b"blender",),
    "a compressed Blender file": (b"\x28\xb5\x2f\xfd",),
    "a Maya file": (b"//maya", b"for4"),
    "a USD file": (b"pxr-usdc", b"#usda"),
    "a Git LFS pointer; fetch the file itself with `git lfs pull`": (b"version https://git-lfs",),
    "a web page; download the file itself": (b"<!doctype html", b"<html"),
    "XML, such as COLLADA": (b"<?xml",),
    "a PLY file": (b"ply",),
    "an STL file": (b"solid",),
}
"""Other file types by their names in messages, with their signatures in small letters."""

OBJ_LINES = ("#", "mtllib ", "o ", "g ", "v ", "vt ", "vn ", "f ", "usemtl ", "s ")


MOST_CHUNKS = 1000
"""Maximum number of chunks; two are usual."""


class Chunk(NamedTuple):
    """Position of a chunk in its file."""

    kind: int
    start: int
    length: int


def fail(path: Path, what: str, mend: str = f"it is damaged; {EXPORT} again") -> NoReturn:
    """Raise an error with the fault of a model and a remedy."""
    raise ModelError(f"{path}: {what}; {mend}")


def open_model(path: Path) -> tuple[bytes, tuple[Chunk, ...]]:
    """Read the JSON of a model and locate the other chunks of its file, or raise a ModelError."""
    try:
        size = path.stat().st_size
        if size > LARGEST:
            fail(path, "is larger than 1 GB", "export it with smaller textures and fewer vertices")
        with path.open("rb") as stream:
            head = stream.read(256)
            if head.startswith(GLB_MAGIC):
                return _container(path, stream, head, size)
            if not head.lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"{"):
                fail(path, f"is not GLB; it seems to be {_seems(head)}", CONVERT)
            stream.seek(0)
            return stream.read(size), ()
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        fail(path, f"cannot be read: {why}", "check the path")


def _container(
    path: Path, stream: BinaryIO, head: bytes, size: int
) -> tuple[bytes, tuple[Chunk, ...]]:
    if len(head) < 20:  # noqa: PLR2004 a header, and that of a chunk
        fail(path, f"ends after {size} bytes", "copy or download it again")
    _, version, length = struct.unpack_from("<4sII", head)
    if version != 2:  # noqa: PLR2004
        fail(path, f"is GLB version {version}", f"{EXPORT}, version 2")
    if length > size:
        fail(path, f"ends after {size} of {length} bytes", "copy or download it again")
    if length < size:
        fail(path, f"has {size} bytes, but its header states {length}")
    chunks: list[Chunk] = []
    start = 12
    while start < size:
        stream.seek(start)
        length, kind = struct.unpack("<2I", stream.read(8).ljust(8, b"\0"))
        start += 8
        if length > size - start:
            fail(path, f"ends in the middle of a part of {length} bytes")
        chunks.append(Chunk(kind, start, length))
        if len(chunks) > MOST_CHUNKS:
            fail(path, f"has more than {MOST_CHUNKS} parts")
        start += length
    first, *rest = chunks
    if first.kind != JSON_CHUNK:
        fail(path, "does not begin with JSON, which GLB requires")
    stream.seek(first.start)
    # Chunks are filled up to four bytes, by some programs with zeros.
    return stream.read(first.length).rstrip(b"\0 "), tuple(rest)


def _seems(head: bytes) -> str:
    if not head:
        return "empty"
    for what, starts in SEEMS.items():
        if head.lower().startswith(starts):
            return what
    lines = head.decode("latin-1").splitlines()
    # The last line of the head may be cut.
    if lines[0].startswith(OBJ_LINES) and lines[-2:][0].startswith(OBJ_LINES):
        return "an OBJ file, which has no morph targets"
    return "something else"


def binary_of(path: Path, document: Json, chunks: Sequence[Chunk], *, alone: bool = True) -> bytes:
    """Read a document's first buffer; a ModelError if data is missing, or lies in other files.

    Unless `alone`, other buffers may lie there: lines of a build share the data of their face.
    """
    first, *others = document.get("buffers") or [{}]
    for row in (first, *(others if alone else ()), *document.get("images", ())):
        uri = row.get("uri")
        within = uri is None or (isinstance(uri, str) and uri.lower().startswith(("data:", "http")))
        if not within:
            what = f"keeps a part in another file ('{str(uri)[:60]}')"
            fail(path, what, f"{EXPORT}, in one file")
    if first.get("uri") is None:
        data = read_chunk(path, chunks[0]) if has_binary(chunks) else b""
    else:
        try:
            data = b64decode(first["uri"].partition(",")[2], validate=True)
        except (NotBase64, ValueError):
            fail(path, "its binary data is not Base64")
    length = first.get("byteLength", 0)
    if isinstance(length, bool) or not isinstance(length, int) or not 0 <= length <= len(data):
        fail(path, f"has {len(data)} bytes of binary data, fewer than it states")
    return data


def has_binary(chunks: Sequence[Chunk]) -> bool:
    """Test for a binary chunk with the first buffer, directly after the JSON."""
    return bool(chunks) and chunks[0].kind == BINARY_CHUNK


def read_chunk(path: Path, chunk: Chunk) -> bytes:
    """Read the raw bytes of a chunk."""
    try:
        with path.open("rb") as stream:
            stream.seek(chunk.start)
            data = stream.read(chunk.length)
    except OSError as error:
        fail(path, f"cannot be read: {error.strerror}", "check the path")
    if len(data) < chunk.length:
        fail(path, "changed while it was read", "try again")
    return data


def write_container(
    out: BinaryIO,
    text: bytes,
    binary: Sequence[bytes],
    others: Iterable[tuple[int, Sequence[bytes]]] = (),
) -> None:
    """Write a GLB, its chunks filled up to full 32-bit words.

    Parameters
    ----------
    text : the JSON
    binary : pieces of the binary chunk, in order
    others : kind and pieces of each further chunk
    """
    known = []
    for kind, pieces in ((JSON_CHUNK, [text]), (BINARY_CHUNK, binary), *others):
        length = sum(map(len, pieces))
        filling = (b" " if kind == JSON_CHUNK else b"\0") * (-length % 4)
        known.append((kind, [*pieces, filling], length + len(filling)))
    total = 12 + sum(8 + length for _, _, length in known)
    if total > LARGEST_WRITTEN:
        raise OutputError("the animation is too long for one GLB; write fewer frames per second")
    out.write(struct.pack("<4sII", GLB_MAGIC, 2, total))
    for kind, pieces, length in known:
        out.write(struct.pack("<2I", length, kind))
        out.writelines(pieces)
