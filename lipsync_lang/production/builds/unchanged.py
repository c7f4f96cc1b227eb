"""The index of a build without work: the next build answers by it, and reads nothing.

The index lists the files and folders that the build read and left, each with its state before it
was read, and what the build said. While all states and the options are the same, so is the answer.
A file that changed shortly before the build may change again without another time, so no index is
kept then.
"""

import json
import logging
import os
import sys
import time
import warnings
from argparse import Namespace
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from hashlib import blake2b
from itertools import chain
from pathlib import Path
from typing import Any

from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.files.reach import PATH_VARIABLE
from lipsync_lang.base.files.writing import atomic
from lipsync_lang.base.version import __version__

FOLDER = ".lipsync_lang"
"""Folder of a project for the records of builds."""

RECORDS_FILE = "build.sqlite"

INDEX = "unchanged.txt"
"""File of the index, beside the record."""

TICK_NANOSECONDS = 2_000_000_000
"""Coarsest time stamps of a file system; a file may change twice in this time."""

LAST_LINE = b"end"
"""First word of the last line, whose second is a digest of all others."""

SHAPE = {"figures": dict, "words": list, "passed": bool, "remarks": list}
"""Types of the parts of an answer."""

MAX_INDEX_LINE_BYTES = 2**24
"""Maximum length of a line of the index; a longer one matches nothing."""

SYSTEM = ("/proc/", "/sys/", "/dev/")
"""Folders of the system, whose contents change with each look and are no input."""

READERS = "lipsync_lang.packs.library"
"""Module of the reader of packs: a process that has loaded it may have read packs before."""


def answer(project: Path, part: str, options: Namespace) -> dict[str, Any] | None:
    """Return what the last build said, if nothing has changed since; None if anything may have."""
    index, whole = project / FOLDER / part / INDEX, blake2b()
    wrong = OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError
    # A log names what is read; a pipe would never end.
    if logging.getLogger("lipsync_lang").isEnabledFor(logging.INFO) or not index.is_file():
        return None
    with suppress(*wrong), index.open("rb") as stream:
        lines = iter(partial(stream.readline, MAX_INDEX_LINE_BYTES), b"")
        head = json.loads(first := next(lines, b""))
        if head["key"] != _key(options):
            return None
        whole.update(first)
        for line in lines:
            known, _, path = line[:-1].partition(b"\t")
            if known == LAST_LINE:
                fits = {name: type(value) for name, value in head["said"].items()} == SHAPE
                return head["said"] if fits and path.decode() == whole.hexdigest() else None
            if known != (_folder_state if known[:1] == b"d" else _file_state)(os.fsdecode(path)):
                return None
            whole.update(line)
    return None


class BuildLog:
    """Files that a process reads from the start of a build, and folders that it lists.

    Names in the current folder and in the `folder` of the project are tried without a list of it,
    and a folder of LIPSYNC_LANG_PATH may be made later.
    """

    def __init__(self, folder: Path) -> None:
        self.settled = time.time_ns() - TICK_NANOSECONDS
        self.states: dict[tuple[str, bool], bytes] = {}
        # A process that has read packs before does not read all of them again.
        self.whole = self.listens = READERS not in sys.modules
        if self.whole:
            for place in ("", folder, *os.environ.get(PATH_VARIABLE, "").split(os.pathsep)):
                self._note("os.scandir", (place,))
            sys.addaudithook(self._note)
            self._show, warnings.showwarning = warnings.showwarning, self._warn

    def keep(
        self,
        own: Path,
        options: Namespace,
        *,
        said: dict[str, Any],
        files: Iterable[str],
        reports: Sequence[Path],
    ) -> None:
        """Write the index, unless something may have changed during the build.

        `own` is the folder of the record, and the `files` of lines must be there.
        """
        self.listens = False
        if not self.whole:
            return
        modules = (getattr(one, "__file__", None) for one in list(sys.modules.values()))
        states = chain(
            ((state, path) for (path, _), state in self.states.items()),
            ((_file_state(path, self.settled), path) for path in filter(None, modules)),
            ((_file_state(path, self.settled, lost=b""), path) for path in files),
            ((_file_state(str(path)), str(path)) for path in self._written(own, reports)),
        )
        head, whole = {"key": _key(options), "said": said}, blake2b()
        with suppress(OutputError, OSError):
            (own / INDEX).unlink(missing_ok=True)  # it may be a link to any file, or a pipe
            with atomic(own / INDEX) as stream:
                for line in chain([json.dumps(head).encode()], map(_line, states)):
                    whole.update(line + b"\n")
                    stream.write(line + b"\n")
                stream.write(b"%s\t%s\n" % (LAST_LINE, whole.hexdigest().encode()))

    def _written(self, own: Path, reports: Iterable[Path]) -> Iterator[Path]:
        """Yield the record, its part that a killed build leaves, and the reports with pages."""
        yield from (own / RECORDS_FILE, own / f"{RECORDS_FILE}-wal")
        for report in reports:
            yield report
            yield from pages_folder(report).rglob("*")

    def _warn(self, *given: Any, **named: Any) -> None:
        self.whole = False  # the next build must say it again
        self._show(*given, **named)

    def _note(self, event: str, given: tuple[Any, ...]) -> None:
        if not self.listens or event not in ("open", "os.listdir", "os.scandir"):
            return
        path = given[0] or "."
        if isinstance(path, int) or (event == "open" and given[2] & (os.O_WRONLY | os.O_RDWR)):
            return
        place = os.path.abspath(os.fsdecode(path))  # noqa: PTH100 thousands of files
        noted, state = (place, event == "open"), _file_state if event == "open" else _folder_state
        # Sources stand for their compiled forms.
        unread = place.endswith((f"{os.sep}{FOLDER}", ".pyc")) or place.startswith(SYSTEM)
        if noted not in self.states and not unread:
            self.states[noted] = b""  # a list of it, made here, is an event as well
            self.states[noted] = state(place, self.settled)


def pages_folder(report: Path) -> Path:
    """Return the folder of the pages that a report links to."""
    return report.with_name(f"{report.stem}-lines")


def _key(options: Namespace) -> str:
    """Return a digest of all that an answer depends on, beside files."""
    stated = {name: value for name, value in vars(options).items() if not callable(value)}
    named = {name for name in os.environ if name.startswith(("LIPSYNC_LANG_", "PYTHON", "XDG_"))}
    variables = [(name, os.environ.get(name)) for name in sorted({*named, "PATH", "HOME"})]
    whole = (__version__, sys.version, sys.path, str(Path.cwd()), variables, sorted(stated.items()))
    return blake2b(repr(whole).encode("utf-8", "surrogatepass")).hexdigest()


def _line(found: tuple[bytes, str]) -> bytes:
    """Return a line of the index; raise an error for a file that changed too late."""
    state, path = found
    if not state or "\n" in path:
        raise OutputError("a file changed too late to be trusted")
    return b"%s\t%s" % (state, os.fsencode(path))


def _file_state(path: str, settled: int | None = None, lost: bytes = b"f") -> bytes:
    """Return the size, times and number of a file, or the state of a `lost` one.

    The text is empty if the file changed after the time `settled`. A link that leads elsewhere, or
    a folder of another name, may hold files of one size that were unpacked at once: their numbers
    differ.
    """
    try:
        stat = os.stat(path)  # noqa: PTH116 thousands of files
    except (OSError, ValueError):
        return lost
    if settled is not None and max(stat.st_mtime_ns, stat.st_ctime_ns) > settled:
        return b""
    return b"f %d %d %d %d" % (stat.st_size, stat.st_mtime_ns, stat.st_ctime_ns, stat.st_ino)


def _folder_state(path: str, settled: int | None = None) -> bytes:
    """Return a digest of the names in a folder, and of the times of the folders in it.

    A pack may be a file in a folder of its own. Hidden folders change with each build. The text is
    empty if a folder in it changed after the time `settled`.
    """
    found: list[tuple[str, int]] = []
    with suppress(OSError), os.scandir(path) as entries:
        shown = (one for one in entries if not one.name.startswith((".", "__pycache__")))
        found = sorted((one.name, one.stat().st_mtime_ns if one.is_dir() else 0) for one in shown)
    if settled is not None and any(changed > settled for _, changed in found):
        return b""
    whole = repr(found).encode("utf-8", "surrogatepass")
    return b"d " + blake2b(whole, digest_size=16).hexdigest().encode()
