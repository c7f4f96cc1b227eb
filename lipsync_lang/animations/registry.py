"""Which output formats are known, and writing to one of them."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from io import TextIOWrapper
from pathlib import Path
from pkgutil import iter_modules
from typing import BinaryIO, TextIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.errors import OutputError, did_you_mean
from lipsync_lang.files import STANDARD_STREAM, argument_path, atomic

GROUP = "lipsync_lang.writers"
"""Entry points of modules that register writers when they are imported."""

WriteText = Callable[[Animation, TextIO], None]
WriteBytes = Callable[[Animation, BinaryIO], None]
Remarks = Callable[[Animation], Iterable[str]]


@dataclass(frozen=True)
class Writer:
    """One output format: its name, suffix and what writes it to an open stream."""

    name: str
    suffix: str
    title: str
    write: WriteBytes
    remarks: Remarks = lambda _: ()
    """What is worth a word about an animation in this format, such as what it cannot hold."""


WRITERS: dict[str, Writer] = {}


def writer(
    name: str, *, suffix: str, remarks: Remarks = lambda _: ()
) -> Callable[[WriteText], WriteText]:
    """Register ``(animation, text stream) -> None`` as the writer of a text format."""

    def register(write: WriteText) -> WriteText:
        def encoded(animation: Animation, out: BinaryIO) -> None:
            text = TextIOWrapper(out, "utf-8", "backslashreplace", newline="", write_through=True)
            write(animation, text)
            text.flush()
            text.detach()

        WRITERS[name] = Writer(name, suffix, _title(write), encoded, remarks)
        return write

    return register


def binary_writer(
    name: str, *, suffix: str, remarks: Remarks = lambda _: ()
) -> Callable[[WriteBytes], WriteBytes]:
    """Register ``(animation, byte stream) -> None`` as the writer of a binary format."""

    def register(write: WriteBytes) -> WriteBytes:
        WRITERS[name] = Writer(name, suffix, _title(write), write, remarks)
        return write

    return register


def _title(write: Callable[..., None]) -> str:
    return (write.__doc__ or "").strip().splitlines()[0]


@cache
def load_writers() -> dict[str, Writer]:
    """Import every module of this folder and of the entry points, once: each registers itself."""
    from importlib.metadata import entry_points

    from lipsync_lang import animations

    for module in iter_modules(animations.__path__):
        import_module(f"{animations.__name__}.{module.name}")
    for found in entry_points(group=GROUP):
        found.load()
    return WRITERS


def find_writer(path: Path, name: str | None = None) -> Writer:
    """Return the writer that is named, or else that of the longest suffix a path ends in."""
    writers = load_writers()
    if name is not None:
        if name not in writers:
            raise OutputError(
                f"{path}: no format is called '{name}'; {did_you_mean(name, writers)}"
            )
        return writers[name]
    if path == STANDARD_STREAM:
        raise OutputError("-: standard output tells no format; name it, such as csv:-")
    found = [one for one in writers.values() if path.name.lower().endswith(one.suffix)]
    if not found:
        known = ", ".join(sorted(one.suffix for one in writers.values()))
        what = f"no writer for '{path.suffix}'" if path.suffix else "has no suffix to tell a format"
        raise OutputError(f"{path}: {what}; end it in {known}")
    return max(found, key=lambda one: len(one.suffix))


def parse_output(text: str) -> tuple[Path, Writer]:
    """Read ``line.csv``, or ``csv:-`` with the name of a format before the file."""
    name, colon, rest = text.partition(":")
    if colon and rest and name in load_writers():
        return argument_path(rest), WRITERS[name]
    path = argument_path(text)
    return path, find_writer(path)


def save(animation: Animation, path: Path, name: str | None = None) -> None:
    """Write an animation to `path`, whole or not at all; ``-`` is standard output."""
    chosen = find_writer(path, name)
    with atomic(path) as stream:
        chosen.write(animation, stream)
