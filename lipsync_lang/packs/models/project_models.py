"""The model of `lipsync.yaml`, which states once what a folder's commands leave out."""

import re
from pathlib import PurePosixPath, PureWindowsPath
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from lipsync_lang.packs.models.fields import Data, Name, OrOne, PackModel, Parent, Short, Text
from lipsync_lang.packs.models.pose_models import MotionFields

_RATE = r"^\d+(\.\d+)?(/\d+)?$"


def _within(output: str) -> str:
    """Refuse outputs elsewhere: a stranger's project writes into its own folder alone."""
    path = re.sub(r"^[a-z0-9-]{2,}:", "", output)
    outside = ".." in re.split(r"[/\\]", path)
    if outside or PurePosixPath(path).is_absolute() or PureWindowsPath(path).is_absolute():
        what = "'{path}' is outside the project's folder; name it with -o instead"
        raise PydanticCustomError("P106", what, {"path": path})
    return output


def _rate(value: Data) -> Data:
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return f"{value:g}" if number else value


def _preset(value: Data) -> Data:
    return {"preset": value} if isinstance(value, str) else value


def _or(form: dict[str, Any]) -> Any:
    return lambda full: [full, form]


Output = Annotated[Text, AfterValidator(_within)]
"""A file, or FORMAT:FILE."""


class Project(PackModel):
    """Defaults for the commands of a folder; an option of the command line wins."""

    kind: Literal["project"]
    """The kind of file."""
    name: Name = "project"
    """Name of the project."""
    language: Parent | None = None
    """The language of its lines, by name or tag."""
    character: Name | None = None
    """The face that speaks: a character or a pose set."""
    fps: (
        Annotated[
            str, Field(pattern=_RATE), Short(_rate, forms=_or({"type": "number", "minimum": 1}))
        ]
        | None
    ) = None
    """Frames per second: a number, or a fraction such as 24000/1001."""
    motion: Annotated[MotionFields, Short(_preset, forms=_or({"type": "string"}))] | None = None
    """Motion settings over the character's own; a preset's name alone is short for it."""
    shades: bool | None = None
    """False to perform each shade as its parent; unless stated, only the paper's thresholds do."""
    outputs: Annotated[tuple[Output, ...], OrOne] = ()
    """Outputs of `run`, from this folder: FILE or FORMAT:FILE; `{line}` stands for the line."""
    paths: Annotated[tuple[Text, ...], OrOne] = ()
    """Folders of packs to search first, from this folder."""
