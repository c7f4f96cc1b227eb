"""The parts that all drafts of packs share: name, template, model reference and files.

`templates` has the text of each kind of pack. Paths in a pack are POSIX paths relative to the
folder of the pack.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from filecmp import cmp
from functools import partial
from os.path import relpath
from pathlib import Path
from typing import BinaryIO

from lipsync_lang.base.errors import LipsyncError, PackError
from lipsync_lang.base.files import write_all
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.base.presentation.text_templates import filled
from lipsync_lang.packs.finding import WHOLE_MODELS
from lipsync_lang.packs.yaml.value_text import as_scalar, on_one_line

WRAP_CHARS = 100
"""Maximum line width in characters for wrapped lists."""

_PACK_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,79}")

NewFiles = Mapping[Path, bytes | Path]
"""Content of each new file, or the file of which it is a copy."""


@dataclass(frozen=True)
class PackWish:
    """Request for a new pack; each kind of pack adds its sources."""

    name: str
    title: str | None = field(default=None, kw_only=True)

    @property
    def heading(self) -> str:
        """The title on one line; by default, the name in words."""
        stated, name = " ".join((self.title or "").split()), re.sub("[-_]", " ", self.name).title()
        # a title such as No or 007 may be read as something else
        return stated or (name if as_scalar(name) == name else f"Pack {name}")


@dataclass(frozen=True, eq=False)
class PackDraft:
    """A drafted pack with the files that it needs, before they are written."""

    path: Path
    outputs: NewFiles

    def write(self) -> None:
        """Write the pack and its files, or none of them."""
        write_new(self.outputs)


def write_new(files: NewFiles) -> None:
    """Write all files or none, in folders that need not exist."""

    def fill(content: bytes | Path, stream: BinaryIO) -> None:
        stream.write(content if isinstance(content, bytes) else content.read_bytes())

    for path in files:
        # A stranger's project may hold links out of it; a folder that the user names is his.
        if path.absolute().is_relative_to(Path.cwd()):
            refuse_outside(path, Path.cwd())
        path.parent.mkdir(parents=True, exist_ok=True)
    write_all({path: partial(fill, content) for path, content in files.items()}, durable=True)


def check_name(name: str, existing: Path | None = None) -> None:
    """Refuse a name that no pack can have, and a file that exists."""
    if not _PACK_NAME.fullmatch(name):
        raise LipsyncError(f"'{name}' cannot be a pack's name; write letters, digits, - and _")
    if existing is not None and existing.exists():
        raise PackError(f"{existing}: already exists; choose another name, or delete it first")


def from_template(name: str, /, **known: object) -> str:
    """Return the text of a pack."""
    # YAML would take a name such as 007 for a number, and "no" for false.
    return filled(__package__ or "", f"templates/{name}", known, yaml=on_one_line)


def place_model(model: Path, pack: Path) -> tuple[str, NewFiles]:
    """Return the reference of a pack to a model, and the copy that it requires, if any.

    The references of a pack file must stay within the parent of its folder. Raises LipsyncError if
    a required copy is impossible: the model is not GLB, or a different file has its name.
    """
    there = pack.parent.resolve()
    if model.resolve().is_relative_to(there.parent):
        return Path(relpath(model.resolve(), there)).as_posix(), {}
    # Other formats may refer to buffers and textures outside the file, which a copy would lose.
    if not model.name.lower().endswith(WHOLE_MODELS):
        mend = f"export it as GLB, or move it with these files into {pack.parent} first"
        raise LipsyncError(f"{model}: may refer to other files; {mend}")
    copy = pack.with_name(model.name)
    # an earlier draft has copied the same model
    if copy.is_file() and cmp(model, copy, shallow=False):
        return model.name, {}
    if copy.exists():
        raise PackError(f"{copy}: already exists and differs; use that model, or move it")
    return model.name, {copy: model}
