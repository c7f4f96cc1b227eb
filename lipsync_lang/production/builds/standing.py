"""Existing outputs on the disk: separate files, and members of archives."""

import os
from contextlib import suppress
from pathlib import Path

from lipsync_lang.base.files.reach import is_reached
from lipsync_lang.production.builds.archives import Member, members, rewrite, split_archive
from lipsync_lang.production.builds.digests import output_digest, output_file_digest


class StandingOutputs:
    """The outputs in a project's folder; archives are listed once."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._home = str(folder)
        self._listed: dict[str, dict[str, Member]] = {}
        self._within: dict[str, bool] = {}

    def stamp(self, path: str) -> tuple[int, int] | None:
        """Return size and time of change of a file, size and CRC of a member; None if absent."""
        split = split_archive(path)
        if split is not None:
            found = self._members(split[0]).get(split[1])
            return None if found is None else (found.size, found.crc)
        try:
            stat = os.stat(f"{self._home}/{path}")  # noqa: PTH116 ten thousands of them
        except OSError:
            return None
        return stat.st_size, stat.st_mtime_ns

    def digest(self, path: str) -> str:
        """Return the digest of an output's content; empty if it is absent or cannot be read."""
        split = split_archive(path)
        if split is not None:
            found = self._members(split[0]).get(split[1])
            return "" if found is None else output_digest(found.crc, found.size)
        with suppress(OSError):
            return output_file_digest(self.folder / path)
        return ""

    def is_within(self, path: str) -> bool:
        """Return True if an output is in the folder, since records may come from elsewhere."""
        parent = str(Path(path).parent)
        if parent not in self._within:
            self._within[parent] = is_reached(self.folder / parent, self.folder)
        return self._within[parent]

    def delete(self, paths: list[str]) -> None:
        """Delete outputs; absent ones do not matter."""
        members_: dict[str, list[str]] = {}
        for path in paths:
            split = split_archive(path)
            if split is None:
                (self.folder / path).unlink(missing_ok=True)
            else:
                members_.setdefault(split[0], []).append(split[1])
        for archive, names in members_.items():
            rewrite(self.folder / archive, {}, names)
            self._listed.pop(archive, None)

    def _members(self, archive: str) -> dict[str, Member]:
        if archive not in self._listed:
            self._listed[archive] = members(self.folder / archive)
        return self._listed[archive]
