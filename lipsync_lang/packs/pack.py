"""A validated pack, with the place of each of its values in the files that state it."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Generic, NamedTuple, TypeVar

from lipsync_lang.base.errors import did_you_mean
from lipsync_lang.packs.yaml.faults import Fault
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.packs.yaml.source import Loc, YamlSource

if TYPE_CHECKING:
    from lipsync_lang.packs import models

M = TypeVar("M", bound="models.PackModel")


class FilePlace(NamedTuple):
    """A place in a file; `str` gives ``file:line:column``."""

    file: Path
    line: int
    column: int

    def __str__(self) -> str:
        return f"{shown(self.file)}:{self.line}:{self.column}"


@dataclass(frozen=True, eq=False)
class Pack(Generic[M]):
    """A validated pack, with the files that state it.

    `sources` has one file, or several for a language that extends another, the child first.
    """

    model: M
    sources: tuple[YamlSource, ...]

    @property
    def path(self) -> Path:
        """The pack's own file."""
        return self.sources[0].path

    @property
    def source(self) -> YamlSource:
        """The pack's own file as data."""
        return self.sources[0]

    @property
    def lineage(self) -> tuple[str, ...]:
        """Name of the pack, and of the languages that it extends."""
        return tuple(source.data["name"] for source in self.sources)

    def states(self, loc: Loc) -> bool:
        """Return True for a value that a file of the pack states."""
        return any(source.known(loc) == len(loc) for source in self.sources)

    def where(self, loc: Loc, *, key: bool = False) -> FilePlace:
        """Return the place of the value at `loc`, or of its key, in the file that states it."""
        # `max` takes the first of equals: the child, which overrides its parents
        source = max(self.sources, key=lambda s: s.known(loc))
        return FilePlace(source.path, *source.where(loc, key=key))

    def fault(self, loc: Loc, code: str, what: str, hint: str = "", *, key: bool = False) -> Fault:
        """Return a fault at the place of the value at `loc`."""
        place = self.where(loc, key=key)
        return Fault(shown(place.file), place.line, place.column, code, what, hint)

    def warning(
        self, loc: Loc, code: str, what: str, hint: str = "", *, key: bool = False
    ) -> Fault:
        """Return a warning at the place of the value at `loc`."""
        return replace(self.fault(loc, code, what, hint, key=key), severity="warning")

    def unknown(  # noqa: PLR0913 the name, its place and what is known
        self, loc: Loc, code: str, noun: str, name: str, known: Iterable[str], *, key: bool = False
    ) -> Fault:
        """Return the fault of a name that is not known, with the nearest known one as a hint."""
        hint = did_you_mean(name, known)
        return self.fault(loc, code, f"unknown {noun} '{name}'", hint, key=key)
