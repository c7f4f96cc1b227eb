"""Decode files into numbered lines, one line in memory at a time.

The encoding is the one given, or UTF-16 or UTF-32 if the file has their byte-order mark, or UTF-8.
Line ends may be mixed.
"""

from collections.abc import Callable, Iterator
from functools import partial
from io import TextIOWrapper
from pathlib import Path
from typing import BinaryIO

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.reading import marked_encoding

MAX_LINE_CHARS = 1_000_000
"""Maximum length of a line, in characters."""


OpenFile = Callable[[], BinaryIO]
"""Function that opens a file at its start; called more than once."""


def numbered(
    path: Path, opened: OpenFile, encoding: str | None = None
) -> Iterator[tuple[int, str]]:
    """Yield (number from 1, line without its end) for the lines of a file.

    `path` is for messages only. Raises LipsyncError if the file cannot be read, is not text, or is
    in another encoding.
    """
    try:
        with opened() as stream:
            chosen = encoding or marked_encoding(stream.read(4)) or "utf-8-sig"
        with opened() as stream, TextIOWrapper(stream, chosen, newline=None) as text:
            lines = iter(partial(text.readline, MAX_LINE_CHARS), "")
            for number, line in enumerate(lines, 1):
                if "\0" in line:
                    raise LipsyncError(
                        f"{path}:{number}: has zero bytes, so it is not text; leave the file out, "
                        "or, if it is UTF-16 without its mark, state `encoding='utf-16-le'`"
                    )
                if len(line) == MAX_LINE_CHARS:
                    raise LipsyncError(
                        f"{path}:{number}: this line is longer than {MAX_LINE_CHARS:,} characters; "
                        "check that it is a script"
                    )
                yield number, line.removesuffix("\n")
    except UnicodeError as error:
        raise LipsyncError(_misread(path, opened, encoding, chosen, error)) from None
    except LookupError:
        raise LipsyncError(
            f"`encoding={encoding!r}`: unknown encoding; try utf-8, utf-16, cp1252 or shift_jis"
        ) from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise LipsyncError(f"{path}: cannot be read: {why}; check the path") from None


def _misread(
    path: Path, opened: OpenFile, asked: str | None, chosen: str, error: UnicodeError
) -> str:
    where, number = str(path), 0
    if chosen == "utf-8-sig":  # the error tells of a chunk, not of the line
        with opened() as stream:
            for number, line in enumerate(stream, 1):  # noqa: B007 the last one, if none is faulty
                try:
                    line.decode()
                except UnicodeDecodeError:
                    break
        where = f"{path}:{number}"
    why = getattr(error, "reason", error)
    if asked:
        return f"{where}: is not {asked} ({why}); name another `encoding`, or save it as UTF-8"
    if chosen != "utf-8-sig":
        mark = f"starts with the mark of {chosen.upper()} but is not valid ({why})"
        return f"{where}: {mark}; save it as UTF-8"
    return (
        f"{where}: is not UTF-8 ({why}), and has no mark of UTF-16 or UTF-32 at its start; name "
        "its encoding (`encoding='cp1252'`), save it as UTF-8, or leave it out if it is not text"
    )
