"""Read inputs up to a size limit, even from endless pipes and devices."""

import codecs
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.targets import STANDARD_STREAM

MIB_BYTES = 2**20

WIDE_MARKS = {
    codecs.BOM_UTF32_LE: "utf-32",
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
"""Byte-order marks with their encodings. Those of UTF-32 come first: they begin with UTF-16's."""


def read_input(
    path: Path, max_bytes: int, *, error: type[LipsyncError] = LipsyncError, mend: str
) -> bytes:
    """Return the bytes of a file, or of standard input if `path` is ``-``.

    Parameters
    ----------
    max_bytes : size limit, which holds whatever size the file states
    error : class of the error for a file that is unreadable or too large
    mend : advice for a file that is too large
    """
    try:
        if path != STANDARD_STREAM:
            with path.open("rb") as stream:
                content = b"".join(read_blocks(stream, max_bytes + 1))
        elif sys.stdin is None:
            raise ValueError("there is no standard input here")  # noqa: TRY301 told below
        else:
            content = b"".join(read_blocks(sys.stdin.buffer, max_bytes + 1))
    except (OSError, ValueError) as wrong:
        why = getattr(wrong, "strerror", None) or wrong
        raise error(f"{path}: cannot be read: {why}; check the path") from None
    if len(content) > max_bytes:
        gibibytes, rest = divmod(max_bytes, 2**10 * MIB_BYTES)
        size = f"{gibibytes} GB" if gibibytes and not rest else f"{max_bytes // MIB_BYTES} MB"
        raise error(f"{path}: is larger than {size}; {mend}")
    return content


def input_text(
    path: Path, max_bytes: int, *, error: type[LipsyncError] = LipsyncError, mend: str
) -> str:
    """Return the text of a file in UTF-8, or of standard input, as `read_input` does."""
    return utf8_text(path, read_input(path, max_bytes, error=error, mend=mend), error)


def utf8_text(path: Path, content: bytes, error: type[LipsyncError] = LipsyncError) -> str:
    """Decode the content of a file, with or without a byte-order mark; `path` is for messages."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        what = f"is not UTF-8 text (byte {fault.start}); save it as UTF-8"
        raise error(f"{path}: {what}") from None


def marked_encoding(content: bytes) -> str | None:
    """Return the encoding of which a file has the byte-order mark; None for UTF-8 or no mark."""
    return next((name for mark, name in WIDE_MARKS.items() if content.startswith(mark)), None)


def read_blocks(stream: BinaryIO, max_bytes: int) -> Iterator[bytes]:
    """Yield the bytes in blocks; one `read` of the whole limit would allocate all of it."""
    left = max_bytes
    while block := stream.read(min(left, MIB_BYTES)):
        yield block
        left -= len(block)
