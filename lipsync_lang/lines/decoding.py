"""Files as numbered lines of text, whatever their encoding and line ends.

UTF-8 with or without its mark, UTF-16 and UTF-32 by theirs, or the encoding that is asked for.
Line ends may be mixed. Only so much is held at a time as one line is long.
"""

import codecs
from collections.abc import Callable, Iterator
from io import TextIOWrapper
from pathlib import Path
from typing import BinaryIO, TextIO

from lipsync_lang.errors import LipsyncError

MARKS = {
    codecs.BOM_UTF32_LE: "utf-32",
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
"""Marks at the start of a file, longer ones first, and what they are the mark of."""

LONGEST = 1_000_000
"""Characters; a longer line is no line of a script."""


Open = Callable[[], BinaryIO]
"""Opens a file from its start, as often as wanted."""


def numbered(path: Path, opened: Open, encoding: str | None = None) -> Iterator[tuple[int, str]]:
    """Yield the lines of a file with their numbers from 1, without their ends.

    `path` is the file as messages call it.

    Raises
    ------
    LipsyncError
        The file cannot be read, is no text, or is in another encoding.
    """
    try:
        with opened() as stream:
            head = stream.read(4)
        chosen = encoding or _marked(head)
        with opened() as stream, TextIOWrapper(stream, chosen, newline=None) as text:
            yield from _lines(path, text)
    except UnicodeError as error:
        raise LipsyncError(_misread(path, opened, encoding, chosen, error)) from None
    except LookupError:
        raise LipsyncError(
            f"--encoding {encoding}: no encoding has this name; try utf-8, utf-16, cp1252 or "
            "shift_jis"
        ) from None
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise LipsyncError(f"{path}: cannot be read: {why}; check the path") from None


def _marked(head: bytes) -> str:
    return next((name for mark, name in MARKS.items() if head.startswith(mark)), "utf-8-sig")


def _lines(path: Path, text: TextIO) -> Iterator[tuple[int, str]]:
    number = 0
    while line := text.readline(LONGEST):
        number += 1
        if "\0" in line:
            raise LipsyncError(
                f"{path}:{number}: holds zero bytes, so it is no text; leave the file out, or, if "
                "it is UTF-16 without its mark, say --encoding utf-16-le"
            )
        if len(line) == LONGEST:
            raise LipsyncError(
                f"{path}:{number}: this line is longer than {LONGEST:,} characters; is it a script?"
            )
        yield number, line.removesuffix("\n")


def _misread(path: Path, opened: Open, asked: str | None, chosen: str, error: UnicodeError) -> str:
    where = f"{path}:{_faulty(opened)}" if chosen == "utf-8-sig" else str(path)
    why = getattr(error, "reason", error)
    if asked:
        return f"{where}: is not {asked} ({why}); name another --encoding, or save it as UTF-8"
    if chosen != "utf-8-sig":
        return f"{where}: has the mark of {chosen.upper()} but is not ({why}); save it as UTF-8"
    return (
        f"{where}: is not UTF-8 ({why}), and has no mark of UTF-16 or UTF-32 at its start; name "
        "its encoding (--encoding cp1252), save it as UTF-8, or leave it out if it is no text"
    )


def _faulty(opened: Open) -> int:
    """Return the number of the first line that is not UTF-8."""
    number = 0
    with opened() as stream:
        for number, line in enumerate(stream, 1):  # noqa: B007 the last one, if none is faulty
            try:
                line.decode()
            except UnicodeDecodeError:
                break
    return number
