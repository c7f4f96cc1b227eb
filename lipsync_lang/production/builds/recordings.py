"""Recordings and timings of lines, from folders that are listed once."""

import os
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import NamedTuple

from lipsync_lang.base.files.names import folded_name
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.text.lines.line_readers import LineFile
from lipsync_lang.text.lines.timings import TIMING_SUFFIXES, is_timed

COMMON_SUFFIXES = {".csv", ".dat", ".json", ".jsonl", ".lab", ".tsv", ".txt", ".xml"}
"""Suffixes of timings that other files have too; the content decides."""

RARE_SUFFIXES = tuple(sorted({*TIMING_SUFFIXES} - COMMON_SUFFIXES))
"""Suffixes of timings only."""


class Listing(NamedTuple):
    """The files of a folder: by folded name, and those that may be timings by folded stem."""

    names: dict[str, str]
    timings: dict[str, list[str]]
    used: set[str]
    links: frozenset[str]
    place: str
    """The folder itself."""

    def file(self, name: str, project: Path) -> Path:
        """Return a file, and count it as used; a link out of the project is refused."""
        found = Path(f"{self.place}/{name}")
        if name in self.links:
            refuse_outside(found, project)
        self.used.add(name)
        return found


class Recordings:
    """Files beside the lines of a script, below a project's folder."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._listings: dict[str, Listing] = {}

    def find(self, path: str) -> Path | None:
        """Return the file of a path from the folder; other case or normal form counts as well."""
        at, _, name = path.rpartition("/")
        listing = self._listing(at)
        found = listing.names.get(folded_name(name)) if listing.names else None
        return None if found is None else listing.file(found, self._folder)

    def timings_beside(self, path: str, taken: Callable[[], Collection[str]]) -> Path | None:
        """Return the file of timings that has the stem of a recording, but none of `taken`.

        Suffixes that only timings have come first.
        """
        at, _, name = path.rpartition("/")
        listing = self._listing(at)
        if not listing.timings:
            return None
        for candidate in listing.timings.get(folded_name(name.rpartition(".")[0] or name), ()):
            if f"{at}/{candidate}".lstrip("/") in taken():
                continue
            rare = candidate.lower().endswith(RARE_SUFFIXES)
            if candidate in listing.links:
                refuse_outside(Path(listing.place, candidate), self._folder)
            # Remarks are ignored, because the reading of the timings repeats them.
            if rare or is_timed(LineFile(Path(listing.place, candidate), lambda _: None)):
                return listing.file(candidate, self._folder)
        return None

    def used(self) -> Iterator[str]:
        """Yield the files that were returned, as paths from the folder."""
        for at, listing in self._listings.items():
            for name in listing.used:
                yield f"{at}/{name}".lstrip("/")

    def unused(self, suffix: str) -> Iterator[str]:
        """Yield the files with a suffix that `find` never returned, as paths from the folder."""
        for at, listing in sorted(self._listings.items()):
            for name in sorted(set(listing.names.values()) - listing.used):
                if name.lower().endswith(suffix.lower()):
                    yield f"{at}/{name}".lstrip("/")

    def _listing(self, at: str) -> Listing:
        if at not in self._listings:
            refuse_outside(self._folder / at, self._folder)
            try:
                with os.scandir(self._folder / at) as entries:
                    links = {entry.name: entry.is_symlink() for entry in entries}
            except OSError:
                links = {}
            names = sorted(links)
            timings: dict[str, list[str]] = {}
            for name in names:
                stem, suffix = os.path.splitext(name)  # noqa: PTH122
                if suffix.lower() in TIMING_SUFFIXES:
                    timings.setdefault(folded_name(stem), []).append(name)
            for some in timings.values():
                some.sort(key=lambda name: (not name.lower().endswith(RARE_SUFFIXES), name))
            known = {folded_name(name): name for name in reversed(names)}
            linked = frozenset(name for name in names if links[name])
            self._listings[at] = Listing(known, timings, set(), linked, str(self._folder / at))
        return self._listings[at]
