"""Shared output helpers: exit codes, counts, JSON, progress, and names of options in messages."""

import json
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files import STANDARD_STREAM
from lipsync_lang.base.files.reading import input_text
from lipsync_lang.base.terminal import progress, wipe

MAX_LINES_BYTES = 16 * 2**20
"""Size limit in bytes of a file of lines."""

MAX_THING_CHARS = 40

SOUND, FAULTS, MISUSE, INTERRUPTED = 0, 1, 2, 130
"""Exit codes."""

OPTIONS = {
    name: f"--{name.replace('_', '-')}"
    for name in (
        "aligner", "alpha", "audio", "channels", "column", "correlation", "cut", "encoding", "fps",
        "gaps", "language", "model", "notation", "offset", "pairs", "power", "rate", "raters",
        "read_as", "recogniser", "schedule", "share", "tier", "unknown",
    )
} | {"engine": "--tts", "paths": "--path"}  # fmt: skip
"""Option names by Python argument name."""

_ARGUMENT = re.compile(r"`([a-z_]+)(?:=(['\"]?)([^`]*?)\2)?`")
_PLAIN = re.compile(r"[\w.,@%+:/-]+")


@contextmanager
def working(what: str) -> Iterator[None]:
    """Show a progress message on a terminal and erase it afterwards."""
    progress(f"{what} ...")
    try:
        yield
    finally:
        wipe()


@contextmanager
def listening(what: str) -> Iterator[None]:
    """Show a progress message with the share of a sound that has been heard, as `working` does."""
    from lipsync_lang.sound.speech.hearing.progress import followed

    with working(what), followed(lambda share: progress(f"{what}: {share:.0%} ...")):
        yield


def lines_of(file: Path | None) -> list[str]:
    """Return the non-blank lines of a file or of standard input."""
    if file is None:
        raise LipsyncError("give a TEXT, or a file of lines with --file FILE")
    lines = input_text(file, MAX_LINES_BYTES, mend="give it in parts").splitlines()
    return [line for line in lines if line.strip()]


def tell_all(lines: Iterable[object]) -> None:
    """Print lines to stderr."""
    for line in lines:
        print(line, file=sys.stderr)


def tell_written(*paths: Path) -> None:
    """Report written files on stderr, except for standard output."""
    tell_all(f"wrote {path}" for path in paths if path != STANDARD_STREAM)


def listed(things: Iterable[str], shown: int = 12) -> str:
    """List the first few of some names, each once."""
    named = list(dict.fromkeys(things))
    more = f" and {len(named) - shown} more" if len(named) > shown else ""
    return (
        " ".join(
            one if len(one) <= MAX_THING_CHARS else f"{one[:MAX_THING_CHARS]}..."
            for one in named[:shown]
        )
        + more
    )


def as_json(data: object) -> str:
    """Serialise to JSON, escaped as the output encoding requires."""
    # A test or an embedding program may replace standard output by an object without an encoding.
    encoding = getattr(sys.stdout, "encoding", None) or "ascii"
    plain = not encoding.lower().startswith("utf")
    return json.dumps(data, ensure_ascii=plain, indent=2, default=str)


def as_options(message: str) -> str:
    """Replace Python arguments in a message by options: `unknown='rest'` by --unknown rest."""
    # The library speaks of arguments, because scripts call it too.
    return _ARGUMENT.sub(_option, message)


def _option(found: re.Match[str]) -> str:
    name, _, value = found.groups()
    if name not in OPTIONS:
        return found[0]
    if value is None:
        return OPTIONS[name]
    return f"{OPTIONS[name]} {value}" if _PLAIN.fullmatch(value) else f'{OPTIONS[name]} "{value}"'
