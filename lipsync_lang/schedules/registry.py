"""Which input formats are known, and which one a file is in."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from lipsync_lang.errors import ScheduleError
from lipsync_lang.schedules.schedule import Schedule

Read = Callable[[Path, bytes], Schedule]

LARGEST = 64 * 2**20
"""Bytes; a larger file of timings is not one."""


@dataclass(frozen=True)
class Reader:
    """One input format: its name, the suffixes it is known by, and what reads it."""

    name: str
    suffixes: tuple[str, ...]
    title: str
    read: Read


READERS: dict[str, Reader] = {}


def reader(name: str, *suffixes: str) -> Callable[[Read], Read]:
    """Register a function ``(path, content) -> Schedule`` as the reader of a format."""

    def register(read: Read) -> Read:
        title = (read.__doc__ or "").strip().splitlines()[0]
        READERS[name] = Reader(name, suffixes, title, read)
        return read

    return register


def load_readers() -> dict[str, Reader]:
    """Import every module of this folder, so that each has registered itself."""
    from lipsync_lang import schedules

    for module in iter_modules(schedules.__path__):
        import_module(f"{schedules.__name__}.{module.name}")
    return READERS


def read_schedule(path: str | Path, notation: str | None = None) -> Schedule:
    """Read timed phonemes from a file.

    Parameters
    ----------
    path : the file; its suffix names the format
    notation : the labels' notation (`arpabet`, `ipa`, ...); None lets the language pack tell

    Raises
    ------
    ScheduleError
        The file is missing, too large, of no known format, or its timings are unsound.
    """
    from dataclasses import replace

    path = Path(path)
    readers = load_readers()
    known = {suffix: r for r in readers.values() for suffix in r.suffixes}
    found = known.get(path.suffix.lower())
    if found is None:
        what = f"no reader for '{path.suffix}'" if path.suffix else "has no suffix to tell a format"
        raise ScheduleError(f"{path}: {what}; known: {', '.join(sorted(known))}")
    try:
        if path.stat().st_size > LARGEST:
            raise ScheduleError(f"{path}: is larger than {LARGEST >> 20} MB; is it a schedule?")
        content = path.read_bytes()
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise ScheduleError(f"{path}: cannot be read: {why}; check the path") from None
    schedule = found.read(path, content)
    return replace(schedule, notation=notation) if notation else schedule
