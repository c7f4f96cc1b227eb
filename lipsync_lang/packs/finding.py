"""Find pack files by name, without parsing YAML.

Folders are searched in this order: the folders given, those of the environment variable, the
project, installed distributions, and the built-in packs. The first pack of a name shadows the
others.
"""

import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import Literal, NamedTuple, get_args

from lipsync_lang.base.errors import PackError, did_you_mean
from lipsync_lang.base.extensions import PACKS, EntryPoint, installed
from lipsync_lang.base.files.reach import PATH_VARIABLE, is_contained, is_reached, refuse_outside
from lipsync_lang.packs.yaml.pack_files import read_bytes
from lipsync_lang.text.phonology.language_names import folded_language

Kind = Literal["language", "poseset", "character"]

Paths = str | Path | Iterable[str | Path]
"""Folders of packs, in the order of search; a file stands for its pack alone."""

COMMON = "common"
"""The file of `languages` with the common phonemes; it is not a language."""

IPA = "ipa"
"""Name of the IPA's file in `languages`, of its kind of pack, and of its notation."""

SHARED = {COMMON: "phonemes", IPA: IPA}
"""Files of `languages` that are not languages, with their kinds of pack."""

FOLDERS: dict[Kind, str] = {kind: f"{kind}s" for kind in get_args(Kind)}
"""The folder of each kind of pack."""

POSESET = "poseset.yaml"
"""The file with the poses, in a pose set's folder."""

BENEATH = "beneath"
"""The kind of look-up for the pack that a file shadows."""

PACK_SUFFIXES = (".yaml", ".yml")
"""Endings of text that names a pack's file."""

WHOLE_MODELS = (".glb", ".vrm")
"""Endings of text that names a model with all its parts in one file."""

MODEL_SUFFIXES = (*WHOLE_MODELS, ".gltf", ".fbx", ".obj", ".blend", ".ma", ".mb", ".usd", ".usdz")
"""Endings of text that names a model; for other formats than glTF, an error says how to export."""

PART_FOLDERS = {"banks": "bank", "rigs": "rig"}
"""The folders within a pose set, with their kinds of pack."""

KIND_WORDS: dict[Kind, str] = {kind: kind for kind in FOLDERS} | {"poseset": "pose set"}
"""The name of each kind in messages."""

NONE_UNSAVED: Mapping[Path, bytes] = MappingProxyType({})
"""No contents in place of files."""

_PACK_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")
_KIND_FIELD = re.compile(rb"^kind:[ \t]*[\"']?([a-z]+)", re.MULTILINE)


class Root(NamedTuple):
    """A folder that holds `languages`, `posesets` or `characters`, or a file of a single pack."""

    path: Path
    origin: str
    """Why it is searched."""


class FoundPack(NamedTuple):
    """A pack file, and the file that shadows it, if any."""

    name: str
    path: Path
    root: Root
    shadowed_by: Path | None


class Finder:
    """Finds pack files by kind and name.

    Parameters
    ----------
    paths : folders to search first, and files of single packs
    project : the project's folder, searched next; None for no project
    unsaved : contents of files, absolute, in place of those on the disk or beside them; empty for a
        deleted file

    Attributes
    ----------
    roots : the folders searched, in order, each once
    missing : entry points of installed distributions whose folders do not exist
    """

    def __init__(
        self,
        paths: Paths = (),
        project: Path | None = Path(),
        unsaved: Mapping[Path, bytes] = NONE_UNSAVED,
    ) -> None:
        self.unsaved = unsaved
        self.paths = folders_of(paths)
        self.project = None if project is None else project.absolute()
        self.missing: list[EntryPoint] = []
        self._listed: dict[tuple[Path, Kind], dict[str, Path]] = {}
        roots: dict[Path, Root] = {}
        for path, origin in self._places():
            roots.setdefault(path.resolve(), Root(path, origin))
        self.roots = tuple(roots.values())
        self._beginnings = {_beginning(root.path): root for root in self.roots}

    def names(self, kind: Kind) -> list[FoundPack]:
        """List every pack of a kind, shadowed packs included, by name and then search order."""
        found: list[FoundPack] = []
        first: dict[str, Path] = {}
        for root in self.roots:
            for name, path in self._list(root.path, kind).items():
                found.append(FoundPack(name, path, root, first.get(name)))
                first.setdefault(name, path)
        return sorted(found, key=lambda f: f.name)

    def overriding(self, kind: Kind, name: str) -> tuple[Path, ...]:
        """Return the project's pack that is found in place of a built-in one, if it is."""
        listed = ((root.origin, self._list(root.path, kind).get(name)) for root in self.roots)
        found = {origin: path for origin, path in listed if path is not None}
        first = next(iter(found), "")
        return (found[first],) if first == "project" and "built-in" in found else ()

    def column_names(self, language: str, word: str | None = None) -> tuple[str, ...]:
        """Return what the column of a language may be called, the likeliest first.

        A project has a `word` for the language; then come its name as given, and those of its pack.
        """
        known = [
            name for path in self.lookup("language", language)[:1] for name in named_as(Path(path))
        ]
        return tuple(dict.fromkeys([*filter(None, [word]), language, *known]))

    def find(self, kind: Kind, name: str) -> Path:
        """Return the file of the first pack of that name; raise `PackError` if there is none.

        If no file has the name, languages are searched by tag and alias. Case is ignored there,
        and `_` equals `-`. An unknown tag falls back to a shorter one: `pt-BR` to `pt`.
        """
        for path in self.lookup(kind, name):
            return Path(path)
        raise self.unknown(name, kind)

    def lookup(self, kind: str, name: str) -> tuple[str, ...]:
        """Return the files found for a name, in order; empty if there are none.

        Besides the kinds with names, there are these kinds of look-up. `phonemes` finds the common
        phonemes, and the kind of the IPA its features. `beneath` takes the path of a pack,
        and finds the one that it shadows. `banks` and `rigs` find those of a pose set.
        A folder searched before the pose set's own may hold banks and rigs for it, so that a
        project can extend a pose set of another owner; these come first.
        """
        if kind in SHARED.values():
            shared = (root.path / FOLDERS["language"] / f"{name}.yaml" for root in self.roots)
            return tuple(str(path) for path in shared if path.is_file())[:1]
        if kind == BENEATH:
            path = Path(name)
            shadowing: Kind = "poseset" if path.name == POSESET else "language"
            found = [self._list(one.path, shadowing).get(pack_name(path)) for one in self.roots]
            under = found[found.index(path) + 1 :] if path in found else []
            return tuple(str(other) for other in under if other not in (None, path))[:1]
        if kind in PART_FOLDERS:
            return tuple(map(str, self._parts(kind, name)))
        if kind not in KIND_WORDS:
            raise ValueError(f"packs of kind {kind!r} cannot be looked up")
        first = self._first(kind, name)
        if first is None and kind == "language":
            first = self._answering(name)
        return () if first is None else (str(first),)

    def language_of(self, name: str) -> str | None:
        """Return the name of the language that answers to a name, tag or alias, or None."""
        return next((Path(found).stem for found in self.lookup("language", name)), None)

    def unknown(self, name: str, *kinds: Kind) -> PackError:
        """Return the error for an unknown name; it suggests the nearest known name."""
        known = {found.name for kind in kinds for found in self.names(kind)}
        return PackError(f"unknown {KIND_WORDS[kinds[0]]} '{name}': {did_you_mean(name, known)}")

    def _first(self, kind: Kind, name: str) -> Path | None:
        """Find the first pack of a name; if there is none, a face's in other letters."""
        found = [self._list(root.path, kind).get(name) for root in self.roots]
        if kind != "language" and not any(found):
            # reversed: of two faces whose names differ in case alone, the first folder's counts
            spelled = {folded_language(one.name): one.name for one in reversed(self.names(kind))}
            own = spelled.get(folded_language(name), name)
            found = [self._list(root.path, kind).get(own) for root in self.roots]
        return next((path for path in found if path is not None), None)

    def _parts(self, kind: str, poseset: str) -> Iterator[Path]:
        """Yield the banks or rigs of a pose set, folder by folder."""
        home = self._first("poseset", poseset)
        for root in self.roots if home is not None else ():
            folder = root.path / FOLDERS["poseset"] / poseset
            # a pose set that was named by its file may lie in a folder of another name
            folder = home.parent if root.path == home else folder
            for path in yaml_files(folder / kind, self.unsaved).values():
                self.refuse_outside(path)
                yield path
            if folder / POSESET == home:
                return

    def _answering(self, name: str) -> Path | None:
        """Return the first language that has the name as its tag or alias, or None.

        Order of preference: tag or alias, file name in another case, tag shortened at a hyphen.
        """
        names, answers = self._answers
        asked = folded_language(name)
        if asked in names and asked not in answers:
            return names[asked]
        while asked and asked not in answers:
            # only tags get shorter; a name of several words would lose its last one
            asked = "" if " " in name else asked.rpartition("-")[0]
        return answers.get(asked)

    @cached_property
    def _answers(self) -> tuple[dict[str, Path], dict[str, Path]]:
        """Languages by folded name, and by what else they answer to."""
        names: dict[str, Path] = {}
        answers: dict[str, Path] = {}
        for root in self.roots:
            for own, path in self._list(root.path, "language").items():
                # a shadowed language must not answer: the pack over it may have another tag
                if self._first("language", own) == path:
                    names.setdefault(folded_language(own), path)
                    for answer in answers_of(path):
                        answers.setdefault(answer, path)
        return names, answers

    def refuse_outside(self, path: Path) -> None:
        """Raise `PackError` for a file in a folder of packs that is a link out of all of them.

        Installers may link their files, so those of distributions are not asked.
        """
        whole = _beginning(path)
        holding = [one for one in self._beginnings if whole.startswith(one)]
        root = self._beginnings[max(holding, key=len)] if holding else None
        if root is not None and not root.origin.startswith(("built-in", "installed")):
            roots = [root.path, *(one.path for one in self.roots)]
            refuse_outside(path, self.project or root.path, roots)

    def _list(self, root: Path, kind: Kind) -> dict[str, Path]:
        """Map pack names to files for one folder, sorted by name; listed once and remembered."""
        key = root, kind
        if key not in self._listed:
            folder, unsaved = root / FOLDERS[kind], self.unsaved
            if root.is_file():
                name = pack_name(root)
                fits = _kind(root) in (kind, "") and _PACK_NAME.fullmatch(name)
                found = {name: root} if fits else {}
            elif kind == "poseset":
                named = [p for p in entries(folder, unsaved) if _PACK_NAME.fullmatch(p.name)]
                files = {p.name: p / POSESET for p in named}
                found = {n: p for n, p in files.items() if _is_there(p, unsaved)}
            else:
                found = yaml_files(folder, unsaved)
            for path in found.values():
                self.refuse_outside(path)
            if kind == "language":
                found = {n: p for n, p in found.items() if n not in SHARED}
            elif kind == "character" and not root.is_file():
                # a character's banks lie beside it and are not characters
                found = {n: p for n, p in found.items() if _kind(p, unsaved) != "bank"}
            self._listed[key] = found
        return self._listed[key]

    def _places(self) -> Iterator[tuple[Path, str]]:
        """Yield the folders to search, and why each is searched."""
        for path in self.paths:
            if not path.is_dir() and not path.is_file():
                raise PackError(f"{path}: no such folder; name one that holds packs")
            yield path, "path"
        for entry in os.environ.get(PATH_VARIABLE, "").split(os.pathsep):
            if entry and Path(entry).is_dir():
                yield Path(entry).absolute(), PATH_VARIABLE
        if self.project is not None:
            yield self.project, "project"
        for entry_point in installed(PACKS):
            folder = location(entry_point)
            if folder is None:
                self.missing.append(entry_point)
            else:
                yield folder, f"installed: {entry_point.dist}"
        yield built_in(), "built-in"


def _beginning(path: Path) -> str:
    """Return the text with which all paths in a folder begin; `is_relative_to` is much slower."""
    return f"{os.path.normcase(path).rstrip(os.sep)}{os.sep}"


def folders_of(paths: Paths) -> tuple[Path, ...]:
    """Return folders and files to search, absolute, from one or several."""
    given = [paths] if isinstance(paths, (str, Path)) else paths
    return tuple(Path(path).absolute() for path in given)


def located(paths: Paths, **packs: str | Path) -> tuple[list[str], tuple[Path, ...]]:
    """Return the names of packs that are named by their files or by name, and where to search.

    A pack is named by kind: a name, or a file: a `Path`, or text that ends like a YAML file.
    A pack's file comes before all others of its name; the folder of packs that it lies in comes
    next, so that the packs beside it are found, and then `paths`. Raise `PackError` for a file that
    is missing, or holds a pack of another kind.
    """
    names: list[str] = []
    files: list[Path] = []
    homes: list[Path] = []
    for kind, pack in packs.items():
        if isinstance(pack, str) and not pack.endswith(PACK_SUFFIXES):
            names.append(pack)
            continue
        path = Path(pack).absolute()
        whole = path.name == POSESET
        if not path.is_file():
            raise PackError(f"{path}: no such file; name a {kind}, or a YAML file")
        stated = _kind(path)
        if stated not in ("", kind) and (kind, stated) != ("character", "poseset"):
            raise PackError(f"{path}: holds a pack of kind {stated}, not a {kind}")
        if stated == "poseset" and not whole:
            raise PackError(f"{path}: a pose set is a file {POSESET} in a folder of its name")
        names.append(pack_name(path))
        files.append(path)
        above = path.parents[1] if whole else path.parent
        homes += [above.parent] if above.name in FOLDERS.values() else []
    return names, (*files, *homes, *folders_of(paths))


def pack_name(path: Path) -> str:
    """Return the name that a pack's file must state: that of its folder for a pose set."""
    return path.parent.name if path.name == POSESET else path.stem


def is_model(character: str | Path) -> bool:
    """Return true for the name of a model file, which may stand in place of a character."""
    return str(character).lower().endswith(MODEL_SUFFIXES)


def model_state(path: Path) -> list[int] | None:
    """Return the size and times of a model by which a change is noticed; None without the file.

    Models are large, so their bytes are not read for this.
    """
    try:
        there = path.stat()
    except (OSError, ValueError):
        return None
    return [there.st_size, there.st_mtime_ns, there.st_ctime_ns]


def beside(pack: Path, name: str, unsaved: Mapping[Path, bytes] = NONE_UNSAVED) -> Path | None:
    """Return the path of a file named by a pack, or None if it is missing.

    A file outside the folder above the pack's counts as missing: a pack may not read it.
    """
    path = pack.parent / name
    reached = is_reached(path, pack.parent.parent)
    return path if reached and _is_there(path, unsaved) else None


def model_beside(pack: Path, engine: str) -> str:
    """Return `NAME:FOLDER` of a pack with the folder that it means; a name stays as it is.

    A folder outside the one above the pack's is a PackError, and so is a file in it that is a link
    out of there: the pack may not read them, unless their folder was named by the user.
    """
    name, _, model = engine.partition(":")
    if not set(model) & set("/\\~"):
        return engine
    # an unknown user after "~" is no error here
    home, folder = pack.parent.parent, pack.parent / os.path.expanduser(model)  # noqa: PTH111
    if not is_contained(folder, home):
        raise PackError(
            f"{pack}: the model '{model}' leads outside {home}; copy it into {home}, or allow its "
            "folder once: --path FOLDER"
        )
    return f"{name}:{folder}"


def built_in() -> Path:
    """Return the folder of the built-in packs."""
    package = Path(__file__).resolve().parents[1]
    # a wheel carries the packs; in a clone they stand beside the package
    carried = package / "data"
    return carried if (carried / FOLDERS["language"]).is_dir() else package.parent


def location(entry_point: EntryPoint) -> Path | None:
    """Return the folder that an entry point names, or None; no code of it is run."""
    top, *rest = entry_point.value.split(":")[0].strip().split(".")
    try:
        spec = find_spec(top)
    except (ImportError, ValueError):
        return None
    if spec is None:
        return None
    folders = [Path(f) for f in spec.submodule_search_locations or ()]
    # a module in one file has no folders to search, and its packs lie beside it
    if not folders and spec.origin and not rest:
        folders = [Path(spec.origin).parent]
    found = (folder.joinpath(*rest) for folder in folders)
    return next((folder for folder in found if folder.is_dir()), None)


def entries(folder: Path, unsaved: Collection[Path] = ()) -> list[Path]:
    """List a folder in order of name, unsaved files too; a missing folder counts as empty."""
    within = {path for new in unsaved for path in (new, new.parent) if path.parent == folder}
    try:
        return sorted({*folder.iterdir(), *within})
    except OSError:
        return sorted(within)


def yaml_files(folder: Path, unsaved: Mapping[Path, bytes] = NONE_UNSAVED) -> dict[str, Path]:
    """Map names to the YAML files of a folder, in order of name."""
    files = (path for path in entries(folder, unsaved) if path.suffix == ".yaml")
    found = (path for path in files if _is_there(path, unsaved))
    return {path.stem: path for path in found if _PACK_NAME.fullmatch(path.stem)}


def _is_there(path: Path, unsaved: Mapping[Path, bytes]) -> bool:
    if path in unsaved:
        return bool(unsaved[path])
    return os.path.isfile(path)  # noqa: PTH113 names of any length


def _kind(path: Path, unsaved: Mapping[Path, bytes] = NONE_UNSAVED) -> str:
    """Return the kind that a pack's file states; empty if it states or is none."""
    # a pattern, since reading each file of a large folder as YAML takes seconds
    try:
        found = _KIND_FIELD.search(unsaved[path] if path in unsaved else read_bytes(path))
    except PackError:
        return ""
    return found[1].decode("ascii") if found else ""


# A look-up by tag searches the file of every language, and parsing them all would take too long.
_TAG_FIELD = re.compile(rb"^tag:[ \t]*[\"']?([A-Za-z0-9-]+)", re.MULTILINE)
_ALIASES = re.compile(
    rb"^aliases:[ \t]*(?P<listed>\[[^\]]*\]|(?:(?:[ \t]*#[^\n]*|[ \t\r]*)\n[ \t]*-[ \t][^\n]*)+)",
    re.MULTILINE,
)
_LIST_SIGNS = re.compile(r"[\[\],]|^[ \t]*-[ \t]", re.MULTILINE)
_TITLE_FIELD = re.compile(rb"^title:[ \t]*[\"']?([^\"'#\r\n]+)", re.MULTILINE)
_YAML_COMMENT = re.compile(rb"#[^\n]*")


def answers_of(path: Path) -> list[str]:
    """Return the tag and then the aliases of a language's file, folded; empty if unreadable.

    Aliases may be a list in brackets, on one line or several, or one item per line.
    """
    try:
        content = read_bytes(path)
    except PackError:
        return []
    tag, aliases = _TAG_FIELD.search(content), _ALIASES.search(content)
    listed = _YAML_COMMENT.sub(b"", aliases["listed"]).decode("utf-8", "ignore") if aliases else ""
    stated = [item.strip(" \t\r\n\"'") for item in _LIST_SIGNS.split(listed)]
    found = [*([tag[1].decode("ascii")] if tag else []), *filter(None, stated)]
    return list(dict.fromkeys(map(folded_language, found)))


def named_as(path: Path) -> list[str]:
    """Return the name, title, tag and aliases of a language's file, folded."""
    try:
        title = _TITLE_FIELD.search(read_bytes(path))
    except PackError:
        title = None
    stated = title[1].decode("utf-8", "ignore").strip() if title else ""
    names = [path.stem, *([stated] if stated else []), *answers_of(path)]
    return list(dict.fromkeys(map(folded_language, names)))
