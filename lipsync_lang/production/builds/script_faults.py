"""Faults of a project and its script, collected so that a person can mend all of them at once."""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.yaml.faults import Fault

if TYPE_CHECKING:
    from lipsync_lang.packs.models import Project
    from lipsync_lang.packs.pack import Pack
    from lipsync_lang.packs.yaml.source import Loc

_ENCODING = re.compile(r"`encoding='([\w-]+)'`")

SHOWN_FAULTS = 12
"""Maximum number of a script's faults in a message; further faults are counted."""


class PlanningError(LipsyncError):
    """Faults that keep a project from being built.

    Parameters
    ----------
    stated : faults of the project's file
    told : faults of its script in words, each with its place
    """

    def __init__(self, stated: Iterable[Fault], told: Sequence[str] = ()) -> None:
        self.stated, self.told = sorted(stated), tuple(told)
        more = len(self.stated) - SHOWN_FAULTS
        rest = [f"and {more} more of this project; `lipsync-lang validate` lists all"] * (more > 0)
        super().__init__("\n".join([*map(str, self.stated[:SHOWN_FAULTS]), *rest, *self.told]))


def in_words_of_project(error: LipsyncError) -> str:
    """Return the message of a reader of scripts, whose argument `encoding` is a field here."""
    return _ENCODING.sub(r"`encoding: \1`", str(error))


class ScriptFaults:
    """Faults of a project's file, and those of its script, the first few of them in words."""

    def __init__(self, project: "Pack[Project]") -> None:
        self._project = project
        self.stated: list[Fault] = []
        self._shown: list[str] = []
        self._count = 0

    def state(self, loc: "Loc", code: str, what: str, hint: str = "") -> None:
        """Add a fault of the project's file, or a warning, by the first letter of its code."""
        add = self._project.warning if code.startswith("W") else self._project.fault
        self.stated.append(add(loc, code, what, hint))

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
        return self._count + sum(fault.severity == "fault" for fault in self.stated)

    def raise_any(self) -> None:
        """Raise all faults as one error, if there are any."""
        if len(self):
            more = self._count - len(self._shown)
            rest = [f"and {more} more of this script"] if more else []
            faults = (one for one in self.stated if one.severity == "fault")
            raise PlanningError(faults, [*self._shown, *rest])
