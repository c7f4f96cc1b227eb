"""What every command says alike: exit codes, counts, JSON, and what is at work."""

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from lipsync_lang.errors import LipsyncError

SOUND, FAULTS, MISUSE, INTERRUPTED = 0, 1, 2, 130
"""Exit codes."""


@contextmanager
def working(what: str) -> Iterator[None]:
    """Say on a terminal what is at work, and wipe it out afterwards."""
    shows = sys.stderr is not None and sys.stderr.isatty()
    if shows:
        print(f"{what} ...", end="\r", file=sys.stderr, flush=True)
    try:
        yield
    finally:
        if shows:
            print("\x1b[2K", end="\r", file=sys.stderr, flush=True)


def lines_of(file: Path | None) -> list[str]:
    """Return the lines of a file that hold text."""
    if file is None:
        raise LipsyncError("give a TEXT, or a file of lines with --file FILE")
    try:
        lines = file.read_text("utf-8-sig").splitlines()
    except UnicodeDecodeError as error:
        raise LipsyncError(
            f"{file}: is not UTF-8 text (byte {error.start}); save it as UTF-8"
        ) from None
    return [line for line in lines if line.strip()]


def count(number: int, thing: str) -> str:
    """Return a number of things in words."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def as_json(data: object) -> str:
    """Return JSON that the output can hold."""
    encoding = getattr(sys.stdout, "encoding", None) or "ascii"
    plain = not encoding.lower().startswith("utf")
    return json.dumps(data, ensure_ascii=plain, indent=2, default=str)
