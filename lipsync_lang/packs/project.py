"""The project file: options that hold for every command in a folder.

`lipsync.yaml` lies in the current folder. Within a repository it may lie in a folder above too, up
to the root. Folders above are searched nowhere else: a file in a shared folder such as the home
folder would change commands of everybody below it.
"""

from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, cast

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.files.reach import is_reached, refuse_outside

if TYPE_CHECKING:
    from collections.abc import Iterator

    from lipsync_lang.packs.models import Project
    from lipsync_lang.packs.models.pose_models import MouthOrigin
    from lipsync_lang.packs.pack import Pack
    from lipsync_lang.packs.yaml.faults import Fault

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
    # the nearest root ends the search: a repository within another has its own project
    for at in (here, *here.parents):
        if any((at / name).exists() for name in ROOTS):
            searched = [here, *(one for one in here.parents if one.is_relative_to(at))]
            break
    found = (at / FILE for at in searched)
    return next((path for path in found if path.is_file()), None)


def load_project(path: Path, content: bytes | None = None) -> "Pack[Project]":
    """Read a project file; raise an error if it is unsound, or a link out of its folder.

    `content` is that of the file, if it was read before.
    """
    from lipsync_lang.packs.library import Library

    refuse_outside(path, path.parent)
    unsaved = {} if content is None else {path: content}
    pack = cast("Pack[Project]", Library(project=None, unsaved=unsaved).load(path, PROJECT))
    if faults := [*check_paths(pack)]:
        from lipsync_lang.packs.yaml.faults import PackFaults

        raise PackFaults(faults)
    return pack


def stated_mouth(folder: Path | None) -> "MouthOrigin | None":
    """Return where the targets of all faces come from, if the project of a folder states it.

    An unsound project states nothing here; the commands tell its faults.
    """
    path = None if folder is None else find_project(folder)
    # most projects state none, and a project is read in some milliseconds
    if path is None or b"mouth" not in path.read_bytes():
        return None
    with suppress(LipsyncError):
        return load_project(path).model.mouth
    return None


def check_paths(pack: "Pack[Project]") -> "Iterator[Fault]":
    """Yield a fault for each of `paths` that is no folder of the project or of its user."""
    folder = pack.path.absolute().parent
    for number, stated in enumerate(pack.model.paths):
        path, loc = folder / stated, ("paths", number)
        if not is_reached(path, folder):
            what = f"'{stated}' is outside the project's folder"
            hint = f"if you know this folder, allow it once: --path {stated}"
            yield pack.fault(loc, "P106", what, hint)
        elif path.exists() and not path.is_dir():
            yield pack.fault(loc, "P106", f"'{stated}' is not a folder", "name a folder of packs")
