"""Registry of output formats, and the function that saves an animation to a file."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, partial
from io import TextIOWrapper
from pathlib import Path
from typing import BinaryIO, TextIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.extensions import Format, Formats
from lipsync_lang.base.files import STANDARD_STREAM, argument_path, atomic

WriteText = Callable[[Animation, TextIO], None]
WriteBytes = Callable[[Animation, BinaryIO], None]
Remarks = Callable[[Animation], Iterable[str]]
Refuse = Callable[[Animation], object]


@dataclass(frozen=True)
class Writer(Format):
    """An output format and its write function."""

    write: WriteBytes
    remarks: Remarks = lambda _: ()
    """Generator of warnings about an animation in this format, such as unsupported channels."""
    reasons: bool = False
    """True if files of this format tell the files and lines of packs that made a value."""
    shows: bool = False
    """True if people watch files of this format: then they have gestures by default."""
    refuse: Refuse = lambda _: None
    """Raises an error if no line of an animation's character and rate fits this format."""


WRITERS: Formats[Writer] = Formats("writers", "format", package="lipsync_lang.animations.writers")


def writer(  # noqa: PLR0913 the settings of a format
    name: str,
    *,
    suffix: str,
    remarks: Remarks = lambda _: (),
    reasons: bool = False,
    shows: bool = False,
    refuse: Refuse = lambda _: None,
) -> Callable[[WriteText], WriteText]:
    """Register ``(animation, text stream) -> None`` as the writer of a text format."""

    def encoded(write: WriteText, animation: Animation, out: BinaryIO) -> None:
        text = TextIOWrapper(out, "utf-8", "backslashreplace", newline="", write_through=True)
        write(animation, text)
        text.flush()
        # The wrapper would close the stream of the caller when it is collected.
        text.detach()

    settings = remarks, reasons, shows, refuse
    return WRITERS.adding(
        lambda title, write: Writer(name, (suffix,), title, partial(encoded, write), *settings)
    )


def binary_writer(
    name: str,
    *,
    suffix: str,
    remarks: Remarks = lambda _: (),
    shows: bool = False,
    refuse: Refuse = lambda _: None,
) -> Callable[[WriteBytes], WriteBytes]:
    """Register ``(animation, byte stream) -> None`` as the writer of a binary format."""
    settings = remarks, False, shows, refuse
    return WRITERS.adding(lambda title, write: Writer(name, (suffix,), title, write, *settings))


@cache
def template(module: str) -> list[str]:
    """Read the template of a writer: parts of the text beside its module, with ``=====`` between.

    Parameters
    ----------
    module : the ``__file__`` of the writer; the text has its name and the suffix `.txt`
    """
    return Path(module).with_suffix(".txt").read_text(encoding="utf-8").split("=====\n")


def find_writer(path: Path, name: str | None = None) -> Writer:
    """Find a writer by name, or by the longest matching suffix of a path."""
    if name is not None:
        return WRITERS.find(name, OutputError)
    if path == STANDARD_STREAM:
        raise OutputError("-: standard output has no suffix; name the format, such as csv:-")
    found = WRITERS.first(path)
    if found is None:
        what = f"no writer for '{path.suffix}'" if path.suffix else "has no suffix"
        raise OutputError(f"{path}: {what}; use one of {', '.join(WRITERS.suffixes())}")
    return found


def parse_output(text: str) -> tuple[Path, Writer]:
    """Parse an output argument: ``line.csv``, or ``csv:-`` with an explicit format name."""
    name, colon, rest = text.partition(":")
    if colon and rest and name in WRITERS:
        return argument_path(rest), WRITERS[name]
    path = argument_path(text)
    return path, find_writer(path)


def save(animation: Animation, path: Path, name: str | None = None) -> None:
    """Write an animation to `path` atomically; ``-`` is standard output."""
    chosen = find_writer(path, name)
    with atomic(path) as stream:
        chosen.write(animation, stream)
