"""The places that a project may read and write: its own folder, and folders that its user named.

A project may come from a stranger, and its links and paths may lead to files of the reader. A user
names a folder with `--path`, once for each project, or in `LIPSYNC_LANG_PATH`.
"""

import os
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path

from lipsync_lang.base.errors import PackError

PATH_VARIABLE = "LIPSYNC_LANG_PATH"
"""The environment variable that lists folders of packs; they are named for every project."""


def refuse_outside(path: Path, folder: Path, others: Sequence[Path] = ()) -> None:
    """Raise an error if a path leads outside a project's folder and others that belong to it."""
    if not is_reached(path, folder, others):
        link = "" if ".." in path.parts else " by a link"
        raise PackError(
            f"{path}: leads outside {folder}{link}; copy the file into the folder, or allow the "
            "folder of its target once: --path FOLDER"
        )


def is_reached(path: Path, folder: Path, others: Sequence[Path] = ()) -> bool:
    """Return True if a path is in a project's folder, in others, or in one that the user named."""
    homes = list(dict.fromkeys([folder, *others]))  # each is looked up
    return _is_inside(path, homes) or _is_inside(path, [*homes, *_named(folder)])


def is_contained(path: Path, folder: Path) -> bool:
    """Return True if a folder and all that is in it are in a project's folder, as `is_reached`."""
    return is_reached(path, folder) and all(is_reached(one, folder) for one in path.rglob("*"))


def name_folders(folder: Path, named: Iterable[Path]) -> None:
    """Remember the folders that a user named for a project."""
    new = [path for path in named if path.is_dir() and not is_reached(path, folder)]
    memory = _memory(folder)
    with suppress(OSError):  # without a place to remember them, the variable names them
        if new:
            memory.parent.mkdir(parents=True, exist_ok=True)
            with memory.open("a", encoding="utf-8", newline="\n") as stream:
                stream.writelines(f"{os.path.realpath(path)}\n" for path in new)


def _named(folder: Path) -> list[Path]:
    found = [one for one in os.environ.get(PATH_VARIABLE, "").split(os.pathsep) if one]
    with suppress(OSError, ValueError):
        found += _memory(folder).read_text("utf-8").splitlines()
    return [Path(one) for one in found]


def _memory(folder: Path) -> Path:
    from hashlib import sha256

    from platformdirs import user_state_path

    name = sha256(os.fsencode(os.path.realpath(folder))).hexdigest()[:16]
    return user_state_path("lipsync-lang") / "named" / f"{name}.txt"


def _is_inside(path: Path, homes: Sequence[Path]) -> bool:
    """Return True if a path is in one of some folders, as it is written and with links followed.

    A path that is outside as it is written is not looked up: on Windows, a look-up on the server
    of a stranger would send the user's name there.
    """
    try:
        real = [os.path.realpath(home) for home in homes]
        stated = [*real, *map(os.path.abspath, homes)]
        return _is_below(os.path.abspath(path), stated) and _is_below(os.path.realpath(path), real)  # noqa: PTH100 `..` is text
    except (OSError, ValueError):  # a null in it
        return False


def _is_below(path: str, homes: Iterable[str]) -> bool:
    # `is_relative_to` is much slower
    whole = os.path.normcase(f"{path.rstrip(os.sep)}{os.sep}")
    return any(whole.startswith(os.path.normcase(f"{one.rstrip(os.sep)}{os.sep}")) for one in homes)
