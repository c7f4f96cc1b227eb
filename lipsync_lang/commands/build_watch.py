"""Watching of a project: build whenever an input of it has changed."""

import sys
from argparse import Namespace
from collections.abc import Callable, Iterable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.extras import install_line
from lipsync_lang.commands.output import SOUND

if TYPE_CHECKING:
    from lipsync_lang.packs.yaml.faults import Fault
    from lipsync_lang.production.builds.project_build import ProjectBuild

WAKE_MILLISECONDS = 500
"""Longest wait for a change before the watcher looks at signals; the first one comes before the
first build, so that nothing that is saved during it is missed."""


class StandingRemarks:
    """Prints each remark once while it holds, since every build repeats it."""

    def __init__(self) -> None:
        self._before: set[str | Fault] = set()
        self._now: set[str | Fault] = set()

    def begin(self) -> None:
        """Begin another build."""
        self._before, self._now = self._now, set()

    def __call__(self, text: "str | Fault") -> None:
        """Print a remark, unless the build before printed it."""
        if text not in self._before | self._now:
            print(text, file=sys.stderr)
        self._now.add(text)

    @property
    def changed(self) -> bool:
        """True if this build has other remarks than the one before."""
        return self._now != self._before


class MadeByBuilds:
    """The files that builds of a project write, which are not a reason for another build."""

    def __init__(self) -> None:
        self._files: frozenset[str] = frozenset()
        self._folders: tuple[str, ...] = ()

    def learn(self, project: "ProjectBuild", reports: Iterable[Path]) -> None:
        """Read the current files of a project."""
        from lipsync_lang.production.builds.archives import split_archive
        from lipsync_lang.production.builds.build_reports import pages_folder

        files = {str(path.absolute()) for path in reports}
        for line in project.lines:
            for _, path in line.outputs:
                split = split_archive(path)
                files.add(str(project.folder / (path if split is None else split[0])))
        self._files = frozenset(files)
        self._folders = tuple(f"{pages_folder(path.absolute())}" for path in reports)

    def has(self, path: str) -> bool:
        """Return True for a file that builds write."""
        from lipsync_lang.base.files.temporary import SUFFIX
        from lipsync_lang.production.builds.faces import FACE_SUFFIX
        from lipsync_lang.production.builds.records import FOLDER

        at = Path(path)
        return (
            path in self._files
            or path.endswith((SUFFIX, FACE_SUFFIX))
            or FOLDER in at.parts
            or any(at.is_relative_to(folder) for folder in self._folders)
        )


def watch_project(options: Namespace, build: Callable[[StandingRemarks, MadeByBuilds], int]) -> int:
    """Build at once and whenever an input changes, until Ctrl-C.

    A fault of the project or its packs is told, and watching goes on.
    """
    try:
        from watchfiles import Change, DefaultFilter, watch
    except ImportError:
        raise LipsyncError(f"--watch needs watchfiles: {install_line('watch')}") from None
    remarks, made, usual = StandingRemarks(), MadeByBuilds(), DefaultFilter()

    def is_input(change: Change, path: str) -> bool:
        if not usual(change, path):
            return False
        return change == Change.deleted or not made.has(path)

    def tried() -> None:
        remarks.begin()
        try:
            build(remarks, made)
        except (LipsyncError, OSError) as error:
            remarks(f"lipsync-lang: {error}")

    changes: Iterable[Any] = watch(
        *_folders(options),
        watch_filter=is_input,
        raise_interrupt=True,
        yield_on_timeout=True,
        rust_timeout=WAKE_MILLISECONDS,
    )
    told = False
    for number, found in enumerate(changes):
        if number == 0 or found:
            tried()
        if not told:
            print("watching; end it with Ctrl-C", file=sys.stderr, flush=True)
        told = True
    return SOUND


def _folders(options: Namespace) -> list[Path]:
    """Return the folders with the inputs of the current project."""
    from lipsync_lang.packs.project import find_project, load_project

    file = find_project()
    folder = (file or Path.cwd() / "none").absolute().parent
    found = [folder, *options.path]
    if file is not None:
        with suppress(LipsyncError):  # the first build tells it
            found += [folder / path for path in load_project(file).model.paths]
    return [path for path in found if path.exists()]
