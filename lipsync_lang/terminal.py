"""Text on a terminal: no character of a file's commands it.

Names, words and labels come from files of strangers. Printed raw, an escape sequence in them
recolours, erases or types; an override of direction makes text read otherwise than it is. The
streams of `safe_streams` write such characters out, whoever prints. Newlines and tabs stay.
"""

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

COMMANDS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""C0 (without newline and tab), DEL and C1, and characters that override or isolate direction."""

WIPE = "\x1b[2K"
"""Erases the line that the cursor is on."""


def spelled_out(text: str) -> str:
    r"""Write out the characters that command a terminal.

    ``\u202e`` is also how JSON spells the character, so JSON that is printed stays JSON.

    >>> print(spelled_out("red \033[31m"))
    red \x1b[31m
    """
    return COMMANDS.sub(_spelled, text)


def _spelled(found: re.Match[str]) -> str:
    code = ord(found[0])
    return f"\\x{code:02x}" if code < 0x20 else f"\\u{code:04x}"  # noqa: PLR2004 JSON escapes C0


class _SafeStream:
    """A text stream that spells out commands on their way to another stream."""

    def __init__(self, stream: TextIO) -> None:
        self.raw = stream

    def write(self, text: str) -> int:
        self.raw.write(spelled_out(text))
        return len(text)

    def writelines(self, lines: Any) -> None:
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.raw, name)


@contextmanager
def safe_streams() -> Iterator[None]:
    """Let everything printed go through `spelled_out`."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (
        cast("TextIO", stream if stream is None else _SafeStream(stream)) for stream in before
    )
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def progress(text: str) -> None:
    """Show on a terminal, and nowhere else, what is at work; the next text takes its place."""
    _show(f"{WIPE}{spelled_out(text)}\r")


def wipe() -> None:
    """Take progress away."""
    _show(f"{WIPE}\r")


def _show(text: str) -> None:
    stream = sys.stderr
    if stream is not None and stream.isatty():
        stream = getattr(stream, "raw", stream)
        stream.write(text)
        stream.flush()
