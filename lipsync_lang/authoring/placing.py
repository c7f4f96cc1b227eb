"""The place of a model among the packs: its original path, or a copy beside the new pack.

Paths in a pack are POSIX paths relative to the folder of the pack.
"""

from filecmp import cmp
from os.path import relpath
from pathlib import Path
from shutil import copyfileobj
from typing import BinaryIO, NamedTuple

from lipsync_lang.errors import LipsyncError, PackError


class Placed(NamedTuple):
    """A file reference of a pack, with the source of a pending copy."""

    stated: str
    """Path in the pack, relative to the folder of the pack."""
    copy: Path | None
    """Source of the copy into the folder of the pack; None if no copy is necessary."""

    def write(self, stream: BinaryIO) -> None:
        """Write the copy to a binary stream."""
        if self.copy is not None:
            with self.copy.open("rb") as source:
                copyfileobj(source, stream)


def place_model(model: Path, pack: Path) -> Placed:
    """Determine the reference of a pack to a model, and the copy that it requires.

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
        return Placed(Path(relpath(model.resolve(), there)).as_posix(), None)
    # Other formats may refer to buffers and textures outside the file, which a copy would lose.
    if model.suffix.lower() != ".glb":
        raise LipsyncError(
            f"{model}: may refer to other files; export it as GLB, or move it with these files "
            f"into {pack.parent} first"
        )
    copy = pack.with_name(model.name)
    if copy.is_file() and cmp(model, copy, shallow=False):
        return Placed(model.name, None)
    if copy.exists():
        raise PackError(f"{copy}: already exists and differs; use that model, or move it")
    return Placed(model.name, model)
