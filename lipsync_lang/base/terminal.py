"""Print text from files without letting it control the terminal.

Names, words and labels come from files of strangers. An escape sequence in them could recolour or
erase the screen, or type into it. A direction override could disguise a text. The streams of
`safe_streams` escape such characters in everything printed. Newlines and tabs stay.
"""

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

COMMANDS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")
"""C0 (without newline and tab), DEL, C1, and direction overrides and isolates."""

WIPE = "\x1b[2K"
"""Escape sequence that erases the cursor's line."""


def spelled_out(text: str) -> str:
    r"""Escape the characters that control a terminal.

    The escapes ``\u202e`` are those of JSON, so that printed JSON stays valid.

    >>> print(spelled_out("red \033[31m"))
    red \x1b[31m
    """
    return COMMANDS.sub(_spelled, text)


def _spelled(found: re.Match[str]) -> str:
    code = ord(found[0])
    return f"\\x{code:02x}" if code < 0x20 else f"\\u{code:04x}"  # noqa: PLR2004 JSON escapes C0


class _SafeStream:
    """A text stream that escapes control characters and passes the text on."""

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
    """Pass standard output and standard error through `spelled_out` within the block."""
    before = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (
        cast("TextIO", stream if stream is None else _SafeStream(stream)) for stream in before
    )
    try:
        yield
    finally:
        sys.stdout, sys.stderr = before


def progress(text: str) -> None:
    """Show a line of progress on a terminal only; the next line replaces it."""
    stream = sys.stderr
    if stream is not None and stream.isatty():
        # The safe stream would escape our own sequence, too.
        stream = getattr(stream, "raw", stream)
        stream.write(f"{WIPE}{spelled_out(text)}\r")
        stream.flush()


def wipe() -> None:
    """Erase the line of progress."""
    progress("")
