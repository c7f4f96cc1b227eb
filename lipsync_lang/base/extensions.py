"""Extension points: registries of built-in and plug-in formats and engines, by name.

A decorator adds an extension to its `Extensions` registry; built-in extensions and plug-ins use the
same decorators. A plug-in distribution declares an entry point in the group `lipsync_lang.KIND`,
for example `lipsync_lang.writers`, with the name of the module to import.

Built-in extensions take precedence. They are imported on first use, and the entry points of other
distributions are read only for names without a built-in match.
"""

import logging
import os
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, reduce
from importlib import import_module
from importlib.util import find_spec
from itertools import chain
from pathlib import Path
from pkgutil import iter_modules
from threading import RLock
from traceback import walk_tb
from typing import Any, ClassVar, NamedTuple, TypeVar

from lipsync_lang.base.errors import LipsyncError, did_you_mean
from lipsync_lang.base.extras import importable
from lipsync_lang.base.grouping import grouped

T = TypeVar("T")
PROGRAM = "lipsync-lang"
"""Name of the program's own distribution."""

PACKS = "lipsync_lang.packs"
"""Group of the entry points that name folders of packs; these are never imported."""

_log = logging.getLogger(__name__)
_lock = RLock()


class PluginWarning(UserWarning):
    """A plug-in, or part of a plug-in, was skipped."""


class EntryPoint(NamedTuple):
    """A module, or a name in one, that a distribution declares for a group."""

    dist: str
    group: str
    name: str
    value: str
    version: str
    """Version of the distribution."""

    @property
    def module(self) -> str:
        """The module to import."""
        return self.value.partition("[")[0].partition(":")[0].strip()

    def load(self) -> object:
        """Import the module, and return it or what it names."""
        names = self.value.partition("[")[0].partition(":")[2].strip()
        return reduce(getattr, filter(None, names.split(".")), import_module(self.module))


class Extensions(Mapping[str, T]):
    """All extensions of one kind, by name.

    Parameters
    ----------
    kind : last part of the entry point group, such as `writers`
    title : singular noun for messages, such as `format`
    package : package with the modules of built-in extensions; all are imported together
    modules : modules of built-in extensions by name; each is imported on demand
    """

    origin: ClassVar[str | None] = None
    """Distribution of the plug-in during its import, else None."""
    journal: ClassVar[list[tuple["Extensions[Any]", str]]] = []
    """Registrations of that plug-in, for rollback after a failed import."""
    packages: ClassVar[dict[str, str]] = {}
    """Distribution of each imported plug-in, by its top-level module."""

    def __init__(
        self,
        kind: str,
        title: str,
        *,
        package: str | None = None,
        modules: Mapping[str, str] | None = None,
    ) -> None:
        self.group = f"lipsync_lang.{kind}"
        self.title = title
        self.package = package
        self.modules = dict(modules or {})
        self.known: dict[str, T] = {}
        self.origins: dict[str, str] = {}
        self._plugged = False
        self._joined = set[str | None]()

    def add(self, name: str, value: T, module: str) -> None:
        """Register a value defined in `module`; called by the decorators.

        Raises LipsyncError if the name belongs to another distribution. During a plug-in import,
        the clash is a `PluginWarning`, and the other names of the plug-in stay registered.
        """
        here = PROGRAM if _top(module) == _top(__name__) else self.origin or _top(module)
        first = PROGRAM if name in self.modules else self.origins.get(name, here)
        if first != here:
            # Built-in names are reserved, even before the import of their modules.
            winner, loser = (here, first) if here == PROGRAM else (first, here)
            what = f"{self.title} '{name}' of {loser} is left out: {winner} has the same name"
            if self.origin is None and here != PROGRAM:
                raise LipsyncError(f"{what}; choose another name")
            warnings.warn(what, PluginWarning, stacklevel=2)
            if here != PROGRAM:
                return
        self.known[name] = value
        self.origins[name] = here
        if self.origin is not None:
            self.journal.append((self, name))

    def drop(self, module: str) -> None:
        """Forget what `module` registered."""
        for name in [name for name, origin in self.origins.items() if origin == _top(module)]:
            del self.known[name], self.origins[name]

    def beside(self, module: str) -> set[str]:
        """Return the names that others than `module` registered."""
        return {name for name in self if self.origins[name] != _top(module)}

    def register(self, name: str) -> Callable[[T], T]:
        """Register the decorated function under a name."""

        def add(value: T) -> T:
            self.add(name, value, value.__module__)
            return value

        return add

    def register_instance(self, name: str) -> Callable[[type[T]], type[T]]:
        """Register an instance of the decorated class, which takes no arguments, under a name."""

        def add(made: type[T]) -> type[T]:
            self.add(name, made(), made.__module__)
            return made

        return add

    def built_in(self) -> dict[str, T]:
        """Return the built-in extensions."""
        with _lock:
            if self.package is not None:
                for found in iter_modules(import_module(self.package).__path__):
                    import_module(f"{self.package}.{found.name}")
                self.package = None
            for module in self.modules.values():
                import_module(module)
        return {name: one for name, one in self.known.items() if self.origins.get(name) == PROGRAM}

    def find(self, name: str, error: type[LipsyncError] = LipsyncError) -> T:
        """Look up an extension by name.

        If it is unknown, an error of the given class suggests the nearest name.
        """
        if name not in self:
            raise error(f"unknown {self.title} '{name}'; {did_you_mean(name, self)}")
        return self[name]

    def __getitem__(self, name: str) -> T:
        if name in self.modules:
            import_module(self.modules[name])
        elif not self._alone(name) and name not in self.built_in():
            self._plug_in()
        return self.known[name]

    def __contains__(self, name: object) -> bool:
        alone = name in self.modules or self._alone(name)
        return alone or name in self.built_in() or name in self._plug_in()

    def _alone(self, name: object) -> bool:
        """Import the built-in module of a name without those beside it; return True if known."""
        if self.package is not None and str(name).isidentifier() and not str(name).startswith("_"):
            module = f"{self.package}.{name}"
            if find_spec(module) is not None:
                import_module(module)
        return name in self.known

    def __iter__(self) -> Iterator[str]:
        self.built_in()
        # A copy, because an import within the loop may register more.
        return iter(list(self._plug_in()))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def _plug_in(self) -> dict[str, T]:
        """Import the plug-ins of this kind, once."""
        with _lock:
            if not self._plugged:
                # Set first: a plug-in may ask for all names while it is imported.
                self._plugged = True
                for entry_point in installed(self.group):
                    _load(entry_point)
        return self.known


@dataclass(frozen=True)
class Format:
    """A file format: its name, its suffixes, and a one-line description."""

    name: str
    suffixes: tuple[str, ...]
    title: str

    @property
    def suffix(self) -> str:
        """Default suffix."""
        return self.suffixes[0]


F = TypeVar("F", bound=Format)
D = TypeVar("D", bound=Callable[..., object])


class Formats(Extensions[F]):
    """File formats by name and by file suffix."""

    def built_in(self, path: Path | None = None) -> dict[str, F]:
        """Return the program's own formats, those of its plug-ins among them.

        The formats compete for a file by its content and its suffix, so all of them take part. With
        a path, plug-ins of other suffixes need not: entry points such as `azure.json` state them.
        """
        found = super().built_in()
        end = None if path is None else path.name.lower().rpartition(".")[2]
        with _lock:
            if not {None, end} & self._joined:
                self._joined.add(end)
                for one in _every("lipsync_lang"):  # no other distribution is read
                    fitting = "." not in one.name or end in (None, *one.name.split(".")[1:])
                    own = fitting and (one.group, one.dist) == (self.group, PROGRAM)
                    if own and one.module not in sys.modules:
                        _load(one)
                found = super().built_in()
        return found

    def ending(self, path: Path) -> list[F]:
        """Return the formats with a matching suffix of a path, longest suffix first."""
        found = _ending(path, self.built_in(path))
        # The suffix `.take.json` of a plug-in must win over the built-in `.json`.
        if not found or len(path.suffixes) > 1:
            found = _ending(path, self)
        return found

    def named(self, path: Path) -> F | None:
        """Return the format that a path's only suffix names; those beside it are not imported."""
        name = path.suffix[1:].lower()
        found = self.known[name] if len(path.suffixes) == 1 and self._alone(name) else None
        return found if found and f".{name}" in found.suffixes else None

    def first(self, path: Path) -> F | None:
        """Return the first format of `ending`; the one that is named after a suffix leads."""
        return self.named(path) or next(iter(self.ending(path)), None)

    def suffixes(self) -> list[str]:
        """Return all known suffixes, sorted."""
        return sorted({suffix for one in self.values() for suffix in one.suffixes})

    def adding(self, make: Callable[[str, D], F]) -> Callable[[D], D]:
        """Return a decorator that adds the format made of a function's title and the function.

        The title is the first line of its docstring.
        """

        def add(function: D) -> D:
            title = (function.__doc__ or function.__name__).strip().splitlines()[0]
            made = make(title, function)
            self.add(made.name, made, function.__module__)
            return function

        return add


def _ending(path: Path, formats: Mapping[str, F]) -> list[F]:
    name = path.name.lower()
    fitting = (one for one in formats.values() if name.endswith(one.suffixes))
    found = [(s, one) for one in fitting for s in one.suffixes if name.endswith(s)]
    return [one for _, one in sorted(found, key=lambda pair: -len(pair[0]))]


def _load(entry_point: EntryPoint) -> None:
    """Import a plug-in; after a failure, skip it completely with a warning."""
    before, start = Extensions.origin, len(Extensions.journal)
    Extensions.origin = entry_point.dist
    try:
        entry_point.load()
    except (Exception, SystemExit) as error:  # noqa: BLE001 a plug-in may raise anything
        lacking = error.name if isinstance(error, ModuleNotFoundError) else None
        closed = lacking is not None and f"{entry_point.module}.".startswith(f"{lacking}.")
        if Extensions.origin == PROGRAM and closed:  # a room such as `study` was removed
            _log.info("%s is left out, because its folder is not there", entry_point.value)
            return
        for kind, name in Extensions.journal[start:]:
            kind.known.pop(name, None)
            kind.origins.pop(name, None)
        _log.debug("%s failed", entry_point.value, exc_info=True)
        what = f"{Extensions.origin} is left out: {entry_point.value} cannot be imported"
        warnings.warn(f"{what}: {type(error).__name__}: {error}", PluginWarning, stacklevel=2)
    else:
        if Extensions.origin != PROGRAM:
            Extensions.packages[_top(entry_point.module)] = Extensions.origin
        _log.info("loaded %s of %s", entry_point.value, Extensions.origin)
    finally:
        Extensions.origin = before
        del Extensions.journal[start:]


def _top(module: str) -> str:
    return module.partition(".")[0]


def plug_in_behind(error: BaseException) -> str | None:
    """Return the distribution of the plug-in whose code an error passed through, if any."""
    frames = (frame for frame, _ in walk_tb(error.__traceback__))
    names = (_top(frame.f_globals.get("__name__", "")) for frame in frames)
    return next((Extensions.packages[name] for name in names if name in Extensions.packages), None)


def installed(group: str) -> list[EntryPoint]:
    """List the entry points of a group: the program's own first, then sorted by distribution."""
    found = (one for one in _every() if one.group == group)
    return sorted(found, key=lambda one: (one.dist != PROGRAM, one.dist, one.name))


def plug_ins() -> dict[str, list[EntryPoint]]:
    """Return the entry points of each installed plug-in, by its distribution."""
    return grouped((one.dist, one) for one in sorted(_every()) if one.dist != PROGRAM)


def removed_rooms() -> dict[str, list[EntryPoint]]:
    """Return the program's own entry points whose folder was removed, by the folder's package."""
    own = sorted(one for one in _every() if one.dist == PROGRAM and one.group != PACKS)
    rooms = grouped((one.module.rpartition(".")[0], one) for one in own)
    return {room: points for room, points in rooms.items() if not importable(room)}


def faults_of_plug_in(name: str) -> list[str]:
    """Import a plug-in as its first use does, and return the faults of its entry points."""
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", PluginWarning)
        for entry_point in plug_ins().get(name, ()):
            if entry_point.group != PACKS:
                _load(entry_point)
    return [str(one.message) for one in told]


def _every(start: str = "") -> Iterator[EntryPoint]:
    """Return our entry points of each distribution, in the first folder that has it."""
    found: dict[str, list[EntryPoint]] = {}
    for folder in dict.fromkeys(sys.path):
        found = {**_declared(folder, start), **found}
    return chain.from_iterable(found.values())


@cache
def _declared(folder: str, start: str) -> dict[str, list[EntryPoint]]:
    """Return our entry points in a folder by distribution, faster than `importlib.metadata`.

    `start` is the start of the names of folders or files that describe the distributions.
    """
    found: dict[str, list[EntryPoint]] = {}
    try:
        names = os.listdir(folder or ".")  # noqa: PTH208 paths of hundreds of names take longer
    except OSError:
        return found
    for name in names:
        if name.startswith(start) and name.endswith((".dist-info", ".egg-info", ".egg")):
            inner = os.path.join(folder, name, "EGG-INFO" if name.endswith(".egg") else "")  # noqa: PTH118 hundreds
            text = _text(f"{inner}/entry_points.txt")
            if "[lipsync_lang." not in text:
                continue
            head = _text(f"{inner}/METADATA") or _text(f"{inner}/PKG-INFO")
            stated = dict(re.findall(r"^(Name|Version):[ \t]*(\S+)", head, re.MULTILINE))
            dist, version = stated.get("Name", name.partition("-")[0]), stated.get("Version", "")
            group, own = "", list[EntryPoint]()
            for line in map(str.strip, text.splitlines()):
                key, equals, value = (part.strip() for part in line.partition("="))
                if line.startswith("["):
                    group = line.strip("[]")
                elif group.startswith("lipsync_lang.") and equals and key[0] not in "#;":
                    own.append(EntryPoint(dist, group, key, value, version))
            found.setdefault(dist, own)
    return found


def _text(path: str) -> str:
    try:
        with open(path, encoding="utf-8", errors="replace") as stream:  # noqa: PTH123 hundreds
            return stream.read()
    except OSError:
        return ""
