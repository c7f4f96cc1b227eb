"""The project file: options that hold for every command in a folder.

`lipsync.yaml` lies in the current folder. Within a repository it may lie in a folder above too, up
to the root. Folders above are searched nowhere else: a file in a shared folder such as the home
folder would change commands of everybody below it.
"""

from pathlib import Path
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from lipsync_lang.packs.library import Pack
    from lipsync_lang.packs.models import Project

FILE = "lipsync.yaml"
"""The name of the file."""

PROJECT = "project"

NARRATOR = "narrator"
"""Value of `{speaker}` in paths where a line has no speaker."""

ROOTS = (".git", ".hg", ".svn", ".jj")
"""Entries of a folder that make it the root of a repository."""


def find_project(folder: Path | None = None) -> Path | None:
    """Return the project file of a folder, the current one unless it is named."""
    here = Path.cwd() if folder is None else folder.absolute()
    searched = [here]
    for at in (here, *here.parents):
        if any((at / name).exists() for name in ROOTS):
            searched = [here, *(one for one in here.parents if one.is_relative_to(at))]
            break
    found = (at / FILE for at in searched)
    return next((path for path in found if path.is_file()), None)


def load_project(path: Path) -> "Pack[Project]":
    """Read a project file.

    Raises
    ------
    PackFaults
        The file is unsound; every fault of its form.
    """
    from lipsync_lang.packs.library import Library

    return cast("Pack[Project]", Library(project=None).load(path, PROJECT))
