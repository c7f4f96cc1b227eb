"""Requests and responses of the studio, independent of the web server."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path, PurePath
from typing import Any

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.base.json_object import Json
from lipsync_lang.studio.array_pack import ArrayPack
from lipsync_lang.studio.workshop import Workshop

MAX_PATH_DIGITS = 9
"""Maximum number of digits of a number in a path or a query."""

MAX_TEXT_CHARS = 10_000
"""Maximum length of a text in a request, such as that of a recording of ten minutes."""

MAX_FILE_NAME_CHARS = 100
"""Maximum length of the name of a sent file; longer ones lose their beginning."""


@dataclass
class StudioRequest:
    """A request: data in its path, its query, and its content.

    Its text is valid Unicode: it is the door through which every text enters the studio.
    """

    name: str = ""
    query: Mapping[str, str] = field(default_factory=dict)
    content: bytes = b""

    def __post_init__(self) -> None:
        self.name = _short("path", _valid(self.name))
        self.query = {_valid(key): _short(key, _valid(text)) for key, text in self.query.items()}

    @cached_property
    def body(self) -> Json:
        """Content as a JSON object; raises LipsyncError if it is none."""
        try:
            found = json.loads(self.content or b"{}", parse_constant=_refuse_constant)
            # Through text again, because escapes may spell half a character at any depth.
            found = json.loads(_valid(json.dumps(found, ensure_ascii=False)))
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
        return _short(name, found)

    def number(self, name: str, low: float, high: float) -> float:
        """Return a number of the body within a range."""
        found = self.body.get(name)
        if isinstance(found, bool) or not isinstance(found, (int, float)):
            raise LipsyncError(f"the request needs a number '{name}'")
        if not (math.isfinite(found) and low <= found <= high):
            raise LipsyncError(f"'{name}' is {found}; give a number from {low:g} to {high:g}")
        return float(found)


def _short(name: str, text: str) -> str:
    """Refuse a long text; the search for a path or a label of strangers could take seconds."""
    if len(text) > MAX_TEXT_CHARS:
        raise LipsyncError(f"'{name[:20]}' has more than {MAX_TEXT_CHARS:,} characters; shorten it")
    return text


def _valid(text: str) -> str:
    """Replace lone surrogates: halves of characters, which JSON can state and no file can hold."""
    return text.encode("utf-16-le", "surrogatepass").decode("utf-16-le", "replace")


def _refuse_constant(word: str) -> None:
    """Refuse `NaN` and `Infinity`, which Python's reader of JSON would accept."""
    raise ValueError(word)


class UnresolvedConflict(LipsyncError):  # noqa: N818 the answer to a request
    """A request with conflicts that the user must resolve first: entries to choose from."""

    def __init__(self, message: str, conflict: list[Json]) -> None:
        super().__init__(message)
        self.conflict = conflict


@dataclass(frozen=True)
class PackedResponse:
    """A response with arrays, which goes to the browser as bytes."""

    document: Json
    arrays: ArrayPack

    def content(self) -> bytes:
        """Return the length of the JSON (4 bytes, little-endian), the JSON, and the arrays."""
        whole = self.document | {"arrays": self.arrays.layout()}
        text = json.dumps(whole, separators=(",", ":")).encode()
        return len(text).to_bytes(4, "little") + text + self.arrays.block()


RouteResult = Json | PackedResponse
Route = Callable[[Workshop, StudioRequest], RouteResult]
"""Function that answers a request for a workshop."""


def whole_number(text: str) -> int | None:
    """Return a number from 0 on in a path or a query; None for other text."""
    plain = text.isascii() and text.isdecimal() and len(text) <= MAX_PATH_DIGITS
    return int(text) if plain else None


MAX_TITLE_CHARS = 80
"""Maximum length of the title of an edit."""

MAX_TAB_CHARS = 40
"""Maximum length of the name of a tab."""


def tab_of(request: StudioRequest) -> str:
    """Return the name of the tab that asks."""
    return str(request.body.get("tab", ""))[:MAX_TAB_CHARS]


def listed(value: Any, what: str) -> list[Any]:
    """Return a value of a request that must be a list."""
    if not isinstance(value, list):
        raise LipsyncError(f"the request needs a list of {what}")
    return value


def sent_file(request: StudioRequest, folder: Path) -> Path:
    """Write a sent file into a folder, under the last part of its name."""
    # A browser on Windows may send a whole path.
    name = PurePath(request.query.get("name", "").replace("\\", "/")).name
    if not name or name in {".", ".."} or not name.isprintable():
        raise LipsyncError("the file has no name")
    path = folder / name[-MAX_FILE_NAME_CHARS:]
    path.write_bytes(request.content)
    return path
