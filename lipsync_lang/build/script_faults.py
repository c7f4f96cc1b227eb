"""Faults of a script, collected so that a person can mend all of them at once."""

from pathlib import Path

from lipsync_lang.errors import LipsyncError

SHOWN_FAULTS = 12
"""Maximum number of faults in a message; further faults are counted."""


class ScriptFaults:
    """Faults with their places, the first few of them in words."""

    def __init__(self) -> None:
        self._shown: list[str] = []
        self._count = 0

    def add(self, where: str | Path, what: str) -> None:
        """Add a fault at a place, such as ``script.csv:4``."""
        self.add_error(f"{where}: {what}")

    def add_error(self, error: LipsyncError | str, *, first: bool = False) -> None:
        """Add an error whose message names its place; `first` if others may follow from it."""
        self._count += 1
        self._shown.insert(0 if first else self._count, str(error))
        del self._shown[SHOWN_FAULTS:]

    def __len__(self) -> int:
        """Return the number of faults, also of those that are not shown."""
        return self._count

    def raise_any(self) -> None:
        """Raise all faults as one error, if there are any."""
        if self._count:
            more = self._count - len(self._shown)
            rest = [f"and {more} more of this script"] if more else []
            raise LipsyncError("\n".join([*self._shown, *rest]))
