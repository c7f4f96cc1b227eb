"""Checks of files that the studio may edit, and writing of several files together."""

import os
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from lipsync_lang.base.errors import OutputError
from lipsync_lang.base.files import write_all
from lipsync_lang.base.files.targets import file_behind
from lipsync_lang.base.files.writing import cannot_write
from lipsync_lang.packs.finding import Finder
from lipsync_lang.packs.yaml.faults import shown


def refuse(path: Path, shipped: Iterable[Path], others: Iterable[Path]) -> None:
    """Raise `OutputError` for a file in a folder of `shipped` packs, or among `others` with edits.

    A file is edited under one name only.
    """
    if not path.is_absolute() or path.suffix != ".yaml":
        raise OutputError(
            f"{path}: is not the file of a pack; give an absolute path with the suffix .yaml"
        )
    # Links may lead into the installed packs, or give one file two names.
    real = Path(os.path.realpath(path))
    folder = next((root for root in shipped if real.is_relative_to(root)), None)
    if folder is not None:
        raise OutputError(
            f"{shown(path)}: belongs to an installed distribution, whose updates undo edits; "
            f"copy it to {real.relative_to(folder)} in your project and edit it there"
        )
    try:
        file_behind(path)
    except OSError as error:
        raise OutputError(f"{shown(path)}: {error.strerror or error}") from None
    other = next((p for p in others if p != path and Path(os.path.realpath(p)) == real), None)
    if other is not None:
        raise OutputError(f"{shown(path)}: is the same file as {shown(other)}; edit that one")


def shipped_folders() -> tuple[Path, ...]:
    """Return the pack folders of installed distributions, including the built-in packs."""
    return tuple(
        root.path.resolve()
        for root in Finder().roots
        if root.origin.startswith(("built-in", "installed"))
    )


def write_together(
    contents: Mapping[Path, bytes | None], ready: Callable[[], object] = bool
) -> None:
    """Write all files or none, and create missing folders; None deletes a file.

    For `ready` see `write_all`.
    """

    def writer(content: bytes) -> Any:
        return lambda stream: stream.write(content)

    for path in contents:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise cannot_write(path.parent, error) from None
    outputs = {path: writer(content) for path, content in contents.items() if content is not None}
    write_all(outputs, durable=True, ready=ready)
    for path in contents.keys() - outputs.keys():
        try:
            path.unlink(missing_ok=True)
        except OSError as error:
            raise cannot_write(path, error) from None
