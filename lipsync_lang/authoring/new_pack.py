"""The parts that all drafts of packs share: name, title, head, model reference and files.

Paths in a pack are POSIX paths relative to the folder of the pack.
"""

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from filecmp import cmp
from os.path import relpath
from pathlib import Path
from shutil import copyfileobj
from typing import BinaryIO

from lipsync_lang.errors import LipsyncError, PackError
from lipsync_lang.files import write_all

_PACK_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,79}")

NewFiles = Mapping[Path, bytes | Path]
"""Content of each new file, or the file of which it is a copy."""


@dataclass(frozen=True, eq=False)
class PackDraft:
    """A drafted pack with the files that it needs, before they are written."""

    path: Path
    outputs: NewFiles

    def write(self) -> None:
        """Write the pack and its files.

        Raises
        ------
        OutputError
            A file is not writable; no file is changed.
        """
        write_new(self.outputs)


def write_new(files: NewFiles) -> None:
    """Write all files or none, in folders that need not exist."""

    def writer(content: bytes | Path) -> Callable[[BinaryIO], object]:
        def write(stream: BinaryIO) -> None:
            if isinstance(content, bytes):
                stream.write(content)
                return
            with content.open("rb") as source:
                copyfileobj(source, stream)

        return write

    for path in files:
        path.parent.mkdir(parents=True, exist_ok=True)
    write_all({path: writer(content) for path, content in files.items()}, durable=True)


def check_name(name: str, existing: Path | None = None) -> None:
    """Check the name of a new pack, and that its file does not exist.

    Raises
    ------
    LipsyncError
        The name has other characters than a pack's name, or `existing` is a file.
    """
    if not _PACK_NAME.fullmatch(name):
        raise LipsyncError(f"'{name}' cannot be a pack's name; write letters, digits, - and _")
    if existing is not None and existing.exists():
        raise PackError(f"{existing}: already exists; choose another name, or delete it first")


def title_of(name: str, title: str | None) -> str:
    """Return a title on one line; by default, the name in words."""
    return " ".join((title or "").split()) or re.sub("[-_]", " ", name).title()


def head(kind: str, name: str) -> Iterator[str]:
    """Yield the first lines of a pack."""
    yield f"kind: {kind}"
    yield "format: 1"
    yield f"name: {name}"


def place_model(model: Path, pack: Path) -> tuple[str, Path | None]:
    """Return the reference of a pack to a model, and the path of the copy that it requires.

    Parameters
    ----------
    model : path of the model file
    pack : path of the pack file; its references must stay within the parent of its folder

    Raises
    ------
    LipsyncError
        A required copy is impossible: the model is not GLB, or a different file has its name.
    """
    there = pack.parent.resolve()
    if model.resolve().is_relative_to(there.parent):
        return Path(relpath(model.resolve(), there)).as_posix(), None
    # Other formats may refer to buffers and textures outside the file, which a copy would lose.
    if model.suffix.lower() != ".glb":
        raise LipsyncError(
            f"{model}: may refer to other files; export it as GLB, or move it with these files "
            f"into {pack.parent} first"
        )
    copy = pack.with_name(model.name)
    if copy.is_file() and cmp(model, copy, shallow=False):
        return model.name, None
    if copy.exists():
        raise PackError(f"{copy}: already exists and differs; use that model, or move it")
    return model.name, copy
