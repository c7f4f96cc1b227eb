"""Where a model goes that a new pack names: it stays where it is, or is copied beside the pack."""

from filecmp import cmp
from os.path import relpath
from pathlib import Path
from shutil import copyfileobj
from typing import BinaryIO, NamedTuple

from lipsync_lang.errors import LipsyncError, PackError


class Placed(NamedTuple):
    """How a pack names a file, and what is to be copied for it."""

    stated: str
    """As the pack says it: from the pack's folder."""
    copy: Path | None
    """A file to copy into the pack's folder; None where it is there, or among packs, already."""

    def write(self, stream: BinaryIO) -> None:
        """Write the copy."""
        if self.copy is not None:
            with self.copy.open("rb") as source:
                copyfileobj(source, stream)


def place_model(model: Path, pack: Path) -> Placed:
    """Say how a pack names a model, and whether the file has to be copied beside it.

    Parameters
    ----------
    model : the model's file
    pack : the pack's file, which names no other than those in the folder of its kind's folder

    Raises
    ------
    LipsyncError
        It must be copied, and cannot be: it may have parts in other files, or the place is taken.
    """
    there = pack.parent.resolve()
    if model.resolve().is_relative_to(there.parent):
        return Placed(Path(relpath(model.resolve(), there)).as_posix(), None)
    if model.suffix.lower() != ".glb":
        raise LipsyncError(
            f"{model}: has parts in other files, perhaps; export it as GLB, or put all of it into "
            f"{pack.parent} first"
        )
    copy = pack.with_name(model.name)
    if copy.is_file() and cmp(model, copy, shallow=False):
        return Placed(model.name, None)
    if copy.exists():
        raise PackError(f"{copy}: is there already; name that one, or move it")
    return Placed(model.name, model)
