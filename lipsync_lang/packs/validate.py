"""Every fault of every pack, at once."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeVar, cast

from lipsync_lang.errors import PackError, did_you_mean
from lipsync_lang.packs import checks
from lipsync_lang.packs.extending import extended
from lipsync_lang.packs.faults import Fault, PackFaults, shown
from lipsync_lang.packs.finding import (
    COMMON,
    FOLDERS,
    PARTS,
    POSESET,
    beside,
    entries,
    tag_of,
)
from lipsync_lang.packs.library import Library, Pack
from lipsync_lang.packs.models import Language
from lipsync_lang.packs.salvage import salvaged
from lipsync_lang.packs.source import Source

if TYPE_CHECKING:
    from lipsync_lang.packs import models

T = TypeVar("T")

YAML = (".yaml", ".yml")
"""Suffixes of YAML files; packs have the first."""


class File(NamedTuple):
    """A pack file, and the kind and name that belong where it lies; None where any does."""

    path: Path
    kind: str | None
    name: str | None


def validate(library: Library, paths: Sequence[str | Path] | None = None) -> list[Fault]:
    """Return every fault of every pack found, or of the files and folders given, in order.

    What the given files speak of is looked up in the library.
    """
    run = _Run(library)
    if paths is None:
        run.check_library()
    else:
        for path in paths:
            run.check_path(Path(path))
    return sorted(run.faults)


class _Run:
    """One validation: what it has loaded, and what was wrong."""

    def __init__(self, library: Library) -> None:
        self.library = library
        self.faults: set[Fault] = set()
        self.common = _quietly(library.common)
        self.added: dict[str, set[str]] = {}
        for name in sorted({found.name for found in library.names("language")}):
            language = _quietly(lambda name=name: library.language(name))  # type: ignore[misc]
            self.added[name] = set(language.model.adds) if language is not None else set()

    def check_library(self) -> None:
        """Check every pack that the library finds, shadowed ones included."""
        self.faults.update(f for f in self.library.faults if f.code == "W304")
        if self.common is None:
            self._try(self.library.common)
        for root in self.library.roots:
            for folder in FOLDERS.values():
                self.check_folder(root.path / folder)
        self._tags()

    def check_path(self, path: Path) -> None:
        """Check a file, or all below a folder."""
        path = path.absolute()
        if path.is_dir():
            parts = [path / f for f in FOLDERS.values() if (path / f).is_dir()]
            for folder in parts or [path]:
                self.check_folder(folder)
        else:
            self.check_file(_placed(path))

    def check_folder(self, folder: Path) -> None:
        """Check all below a folder."""
        for path in sorted(p for p in folder.rglob("*") if p.suffix in YAML and p.is_file()):
            if path.suffix == YAML[0]:
                self.check_file(_placed(path))
            else:
                self._warn(path, "W303", "is not read: packs are `.yaml`", "rename it")
        if folder.name == FOLDERS["poseset"]:
            for entry in entries(folder):
                parts = [POSESET, *PARTS]
                if entry.is_dir() and not any((entry / part).exists() for part in parts):
                    self._warn(entry, "W303", f"has no {POSESET}", "write one, or delete it")

    def check_file(self, file: File) -> None:
        """Check one file: its form, and what it says of others."""
        try:
            model, source, faults = self.library.inspect(*file)
        except PackError as error:
            self._note(Fault(shown(file.path), 1, 1, "P001", str(error), "check the path"))
            return
        self.faults.update(faults)
        if model is not None:
            self._compare(Pack(model, (source,)))
        elif source.data is not None:
            self._rest(source, file.kind)

    def _rest(self, source: Source, kind: str | None) -> None:
        """Check what is sound of an unsound file, so that its other faults come at once."""
        model = salvaged(source, kind)
        if model is None:
            return
        before = set(self.faults)
        if isinstance(model, Language):
            if model.extends is None and self.common is not None:
                pack = Pack(model, (source,))
                self.faults.update(checks.check_language(pack, self.common.model))
        else:
            self._compare(Pack(model, (source,)))
        # what is only probably not meant may come of what was left out
        self.faults = before | {f for f in self.faults if f.severity == "fault"}

    def _compare(self, pack: "Pack[Any]") -> None:
        act: dict[str, Callable[[Pack[Any]], None]] = {
            "phonemes": lambda pack: self.faults.update(checks.check_phonemes(pack)),
            "language": self._language,
            "poseset": self._poseset,
            "bank": self._bank,
            "rig": self._rig,
            "character": self._character,
        }
        act[pack.model.kind](pack)

    def _language(self, pack: "Pack[models.Language]") -> None:
        whole = self._try(lambda: extended(self.library, pack.path))
        if whole is not None and self.common is not None:
            self.faults.update(checks.check_language(whole, self.common.model))

    def _poseset(self, pack: "Pack[models.PoseSet]") -> None:
        phonemes = self._phonemes()
        if phonemes is not None:
            self.faults.update(checks.check_poseset(pack, phonemes))

    def _bank(self, pack: "Pack[models.Bank]") -> None:
        poseset = self._poseset_of(pack)
        phonemes = self._phonemes(pack.model.language)
        if poseset is not None and phonemes is not None:
            self.faults.update(checks.check_bank(pack, poseset, phonemes, self.added))

    def _rig(self, pack: "Pack[models.Rig]") -> None:
        poseset = self._poseset_of(pack)
        if poseset is not None:
            self.faults.update(checks.check_rig(pack, poseset))

    def _character(self, pack: "Pack[models.Character]") -> None:
        poseset = self._poseset_of(pack)
        phonemes = self._phonemes()
        if poseset is None or phonemes is None:
            return
        rigs = {path.stem for path in self.library.rigs_of(pack.model.poseset)}
        self.faults.update(checks.check_character(pack, poseset, phonemes, rigs))
        for file in pack.model.banks:
            path = beside(pack.path, file)
            if path is not None:
                self.check_file(File(path, "bank", path.stem))

    def _poseset_of(self, pack: "Pack[Any]") -> "models.PoseSet | None":
        """Return the pose set that a pack lies in or names; one that is unsound counts as none."""
        beside = pack.path.parent.parent / POSESET
        if pack.path.parent.name in PARTS and beside.is_file():
            model, _, _ = self.library.inspect(beside, "poseset", beside.parent.name)
            return cast("models.PoseSet | None", model)
        name = pack.model.poseset
        try:
            return self.library.poseset(name).model
        except PackFaults:
            return None
        except PackError:
            known = {found.name for found in self.library.names("poseset")}
            what, hint = f"unknown pose set '{name}'", did_you_mean(name, known)
            self._note(pack.fault(("poseset",), "P203", what, hint))
            return None

    def _phonemes(self, language: str | None = None) -> set[str] | None:
        """Return the phonemes of a language, or all there are; None where nobody can tell."""
        if self.common is None:
            return None
        model = self.common.model
        if language in self.added:
            return {*model.base, model.silence, *self.added[language]}
        return {*model.phonemes, model.silence}.union(*self.added.values())

    def _tags(self) -> None:
        first: dict[str, str] = {}
        for found in self.library.names("language"):
            tag = tag_of(found.path)
            if (
                tag
                and found.shadowed_by is None
                and first.setdefault(tag, found.name) != found.name
            ):
                model, source, _ = self.library.inspect(found.path, "language", found.name)
                if model is not None:
                    what = f"tag '{tag}' is that of language '{first[tag]}' already"
                    hint = f"only '{first[tag]}' answers to it"
                    fault = source.fault(("tag",), "W305", what, hint)
                    self._note(replace(fault, severity="warning"))

    def _warn(self, path: Path, code: str, what: str, hint: str) -> None:
        self._note(Fault(shown(path), 1, 1, code, f"'{path.name}' {what}", hint, "warning"))

    def _note(self, fault: Fault) -> None:
        self.faults.add(fault)

    def _try(self, load: Callable[[], T]) -> T | None:
        try:
            return load()
        except PackFaults as error:
            self.faults.update(error.faults)
        except PackError as error:
            self._note(Fault(f"{FOLDERS['language']}/{COMMON}.yaml", 1, 1, "P001", str(error)))
        return None


def _quietly(load: Callable[[], T]) -> T | None:
    """Load what is reported elsewhere when it is unsound."""
    try:
        return load()
    except PackError:
        return None


def _placed(path: Path) -> File:
    """Tell from where a file lies what belongs there."""
    folder = path.parent.name
    if path.name == POSESET:
        return File(path, "poseset", folder)
    kind = PARTS.get(folder)
    if folder == FOLDERS["language"]:
        kind = "phonemes" if path.stem == COMMON else "language"
    return File(path, kind, path.stem)
