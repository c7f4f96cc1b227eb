"""Extension points: formats and engines by name, built-in ones and those of installed plug-ins.

A decorator puts each into its `Extensions`: the same one for what comes with the program and for
what another distribution brings. That distribution names the module to import in an entry point
of the group `lipsync_lang.KIND`, such as `lipsync_lang.writers`.

Built-in ones come first. They are imported at the first question, and entry points are read only
when no built-in one answers: importing `importlib.metadata` takes longer than most questions.
"""

import logging
import os
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from threading import RLock
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from lipsync_lang.errors import LipsyncError, did_you_mean

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

T = TypeVar("T")
PROGRAM = "lipsync-lang"
"""The name of the program's own distribution."""

_log = logging.getLogger(__name__)
_lock = RLock()


class PluginWarning(UserWarning):
    """An installed plug-in, or a part of it, that is left out."""


class Extensions(Mapping[str, T]):
    """Everything of one kind, by name.

    Parameters
    ----------
    kind : the last part of the entry point group: `writers`
    title : one of them, as messages call it: `format`
    room : the package whose modules register the built-in ones; all are imported together
    modules : the modules of built-in ones by name, each imported when it is asked for
    """

    origin: ClassVar[str | None] = None
    """The distribution whose plug-in is being imported."""
    journal: ClassVar[list[tuple["Extensions[Any]", str]]] = []
    """What that plug-in has registered so far, to be taken back if it fails."""

    def __init__(
        self,
        kind: str,
        title: str,
        *,
        room: str | None = None,
        modules: Mapping[str, str] | None = None,
    ) -> None:
        self.group = f"lipsync_lang.{kind}"
        self.title = title
        self.room = room
        self.modules = dict(modules or {})
        self.known: dict[str, T] = {}
        self.origins: dict[str, str] = {}
        self._plugged = False

    def add(self, name: str, value: T, module: str) -> None:
        """Register a value that `module` defines; its decorator calls this.

        Raises
        ------
        LipsyncError
            Another distribution has the name already. A plug-in's other names stay: for it the
            clash is a `PluginWarning`.
        """
        here = _owner(module)
        here = here if here == PROGRAM else self.origin or here
        first = PROGRAM if name in self.modules else self.origins.get(name, here)
        if first != here:
            # built-in ones are imported late, and have their names all the same
            winner, loser = (here, first) if here == PROGRAM else (first, here)
            what = f"{self.title} '{name}' of {loser} is left out: {winner} has one of that name"
            if self.origin is None and here != PROGRAM:
                raise LipsyncError(f"{what}; choose another name")
            warnings.warn(what, PluginWarning, stacklevel=2)
            if here != PROGRAM:
                return
        self.known[name] = value
        self.origins[name] = here
        if self.origin is not None:
            self.journal.append((self, name))

    def register(self, name: str) -> Callable[[T], T]:
        """Decorate a function to be known by a name."""

        def add(value: T) -> T:
            self.add(name, value, value.__module__)
            return value

        return add

    def built_in(self) -> dict[str, T]:
        """Return what comes with the program."""
        with _lock:
            if self.room is not None:
                for found in iter_modules(import_module(self.room).__path__):
                    import_module(f"{self.room}.{found.name}")
                self.room = None
            for module in self.modules.values():
                import_module(module)
        return {name: one for name, one in self.known.items() if self.origins.get(name) == PROGRAM}

    def find(self, name: str, error: type[LipsyncError] = LipsyncError) -> T:
        """Return the one of a name.

        Raises
        ------
        LipsyncError
            As the class given: there is none; the message names the nearest.
        """
        if name not in self:
            raise error(f"no {self.title} '{name}'; {did_you_mean(name, self)}")
        return self[name]

    def __getitem__(self, name: str) -> T:
        if name in self.modules:
            import_module(self.modules[name])
        elif name not in self.built_in():
            self._plug_in()
        return self.known[name]

    def __contains__(self, name: object) -> bool:
        return name in self.modules or name in self.built_in() or name in self._plug_in()

    def __iter__(self) -> Iterator[str]:
        self.built_in()
        return iter(list(self._plug_in()))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def _plug_in(self) -> dict[str, T]:
        """Import the plug-ins of this kind, once."""
        with _lock:
            if not self._plugged:
                self._plugged = True
                for entry_point in installed(self.group):
                    _load(entry_point)
        return self.known


@dataclass(frozen=True)
class Format:
    """A file format: its name, the suffixes it is known by, and a line that says what it is."""

    name: str
    suffixes: tuple[str, ...]
    title: str

    @property
    def suffix(self) -> str:
        """The usual suffix."""
        return self.suffixes[0]


F = TypeVar("F", bound=Format)


class Formats(Extensions[F]):
    """File formats by name, and by the suffixes of files."""

    def ending(self, path: Path) -> list[F]:
        """Return the formats with a suffix that a path ends in, those with the longest first."""
        found = _ending(path, self.built_in())
        # a plug-in's `.take.json` is longer than the built-in `.json`
        if not found or len(path.suffixes) > 1:
            found = _ending(path, self)
        return found

    def suffixes(self) -> list[str]:
        """Return every suffix that is known, in order."""
        return sorted({suffix for one in self.values() for suffix in one.suffixes})


def _ending(path: Path, formats: Mapping[str, F]) -> list[F]:
    name = path.name.lower()
    found = [(s, one) for one in formats.values() for s in one.suffixes if name.endswith(s)]
    return [one for _, one in sorted(found, key=lambda pair: -len(pair[0]))]


def summary(described: Callable[..., object]) -> str:
    """Return the first line of a function's docstring: the title of what it registers."""
    return (described.__doc__ or described.__name__).strip().splitlines()[0]


# Plug-ins


def _load(entry_point: "EntryPoint") -> None:
    """Import a plug-in; one that fails is left out whole, with a warning."""
    before, start = Extensions.origin, len(Extensions.journal)
    Extensions.origin = distribution(entry_point)
    try:
        entry_point.load()
    except (Exception, SystemExit) as error:  # noqa: BLE001 whatever a stranger's module does
        for kind, name in Extensions.journal[start:]:
            kind.known.pop(name, None)
            kind.origins.pop(name, None)
        _log.debug("%s failed", entry_point.value, exc_info=True)
        what = f"{Extensions.origin} is left out: {entry_point.value} cannot be imported"
        warnings.warn(f"{what}: {type(error).__name__}: {error}", PluginWarning, stacklevel=2)
    else:
        _log.info("loaded %s of %s", entry_point.value, Extensions.origin)
    finally:
        Extensions.origin = before
        del Extensions.journal[start:]


def _owner(module: str) -> str:
    """Name the distribution that a module belongs to, as far as its name tells."""
    top = module.partition(".")[0]
    return PROGRAM if top == __name__.partition(".")[0] else top


def installed(group: str) -> "list[EntryPoint]":
    """List the entry points of a group, the program's own first, then by distribution."""
    if not any(group in _groups(folder) for folder in dict.fromkeys(sys.path)):
        return []
    from importlib.metadata import entry_points

    def rank(one: "EntryPoint") -> tuple[bool, str, str]:
        return distribution(one) != PROGRAM, distribution(one), one.name

    return sorted(entry_points(group=group), key=rank)


def distribution(entry_point: "EntryPoint") -> str:
    """Return the name of the distribution that an entry point belongs to."""
    return entry_point.dist.name if entry_point.dist is not None else entry_point.name


@cache
def _groups(folder: str) -> frozenset[str]:
    """Return our groups that distributions in a folder have: 10 times as fast as asking for one."""
    found: set[str] = set()
    try:
        names = os.listdir(folder or ".")  # noqa: PTH208 paths of hundreds of names take longer
    except OSError:
        return frozenset()
    for name in names:
        if name.endswith((".dist-info", ".egg-info", ".egg")):
            inner = "EGG-INFO" if name.endswith(".egg") else ""
            try:
                text = Path(folder, name, inner, "entry_points.txt").read_bytes()
            except OSError:
                continue
            heads = (line.strip() for line in text.splitlines() if b"[lipsync_lang." in line)
            found.update(head.strip(b"[]").decode("ascii", "replace") for head in heads)
    return frozenset(found)
