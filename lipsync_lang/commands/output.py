"""What every command says alike: exit codes, counts, JSON, and what is at work."""

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lipsync_lang.errors import LipsyncError
from lipsync_lang.files import STANDARD_STREAM, read_input
from lipsync_lang.terminal import progress, wipe

MAX_LINES_BYTES = 16 * 2**20
"""Bytes of a file of lines that are read aloud."""

SOUND, FAULTS, MISUSE, INTERRUPTED = 0, 1, 2, 130
"""Exit codes."""


@contextmanager
def working(what: str) -> Iterator[None]:
    """Say on a terminal what is at work, and wipe it out afterwards."""
    progress(f"{what} ...")
    try:
        yield
    finally:
        wipe()


def lines_of(file: Path | None) -> list[str]:
    """Return the lines of a file, or of standard input, that hold text."""
    if file is None:
        raise LipsyncError("give a TEXT, or a file of lines with --file FILE")
    content = read_input(file, MAX_LINES_BYTES, mend="give it in parts")
    try:
        lines = content.decode("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise LipsyncError(
            f"{file}: is not UTF-8 text (byte {error.start}); save it as UTF-8"
        ) from None
    return [line for line in lines if line.strip()]


def tell_written(path: Path) -> None:
    """Name a file that was written; standard output speaks for itself."""
    if path != STANDARD_STREAM:
        print(f"wrote {path}", file=sys.stderr)


def count(number: int, thing: str) -> str:
    """Return a number of things in words."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def as_json(data: object) -> str:
    """Return JSON that the output can hold."""
    encoding = getattr(sys.stdout, "encoding", None) or "ascii"
    plain = not encoding.lower().startswith("utf")
    return json.dumps(data, ensure_ascii=plain, indent=2, default=str)
