"""Requests and responses of the studio, independent of the web server."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path, PurePath
from typing import Any

from lipsync_lang.errors import LipsyncError
from lipsync_lang.rigs.container import Json
from lipsync_lang.studio.array_pack import ArrayPack
from lipsync_lang.studio.workshop import Workshop


@dataclass(frozen=True)
class Wish:
    """A request: data in its path, its query, and its content."""

    name: str = ""
    query: Mapping[str, str] = field(default_factory=dict)
    content: bytes = b""

    @property
    def body(self) -> Json:
        """Content as a JSON object.

        Raises
        ------
        LipsyncError
            The content is not a JSON object.
        """
        try:
            found = json.loads(self.content or b"{}", parse_constant=_refuse)
        except (ValueError, RecursionError):
            found = None
        if not isinstance(found, dict):
            raise LipsyncError("the request is not a JSON object")
        return found

    def text(self, name: str) -> str:
        """Return a string of the body."""
        found = self.body.get(name)
        if not isinstance(found, str):
            raise LipsyncError(f"the request needs a string '{name}'")
        return found

    def number(self, name: str, low: float, high: float) -> float:
        """Return a number of the body within a range."""
        found = self.body.get(name)
        if isinstance(found, bool) or not isinstance(found, (int, float)):
            raise LipsyncError(f"the request needs a number '{name}'")
        if not (math.isfinite(found) and low <= found <= high):
            raise LipsyncError(f"'{name}' is {found}; give a number from {low:g} to {high:g}")
        return float(found)


def _refuse(word: str) -> None:
    raise ValueError(word)


class Refused(LipsyncError):  # noqa: N818 the answer to a request
    """A request with conflicts that the user must resolve first.

    Parameters
    ----------
    conflict : entries to choose from
    """

    def __init__(self, message: str, conflict: list[Json]) -> None:
        super().__init__(message)
        self.conflict = conflict


@dataclass(frozen=True)
class Packed:
    """A response with arrays, which goes to the browser as bytes."""

    document: Json
    arrays: ArrayPack

    def content(self) -> bytes:
        """Return the length of the JSON (4 bytes, little-endian), the JSON, and the arrays."""
        whole = self.document | {"arrays": self.arrays.layout()}
        text = json.dumps(whole, separators=(",", ":")).encode()
        return len(text).to_bytes(4, "little") + text + self.arrays.block()


Answer = Json | Packed
Route = Callable[[Workshop, Wish], Answer]
Routes = dict[str, Route]
"""Functions by method and path, such as ``GET bigram/{name}``."""


def listed(value: Any, what: str) -> list[Any]:
    """Return a value of a request that must be a list."""
    if not isinstance(value, list):
        raise LipsyncError(f"the request needs a list of {what}")
    return value


def sent_file(wish: Wish, folder: Path) -> Path:
    """Write a sent file into a folder, under the last part of its name."""
    name = PurePath(wish.query.get("name", "").replace("\\", "/")).name
    if not name or name in {".", ".."} or not name.isprintable():
        raise LipsyncError("the file has no name")
    path = folder / name[-100:]
    path.write_bytes(wish.content)
    return path
