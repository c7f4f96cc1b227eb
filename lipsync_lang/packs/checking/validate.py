"""Validate packs: all of a library, or given files and folders."""

from collections.abc import Callable, Collection, Sequence
from filecmp import cmp
from pathlib import Path
from typing import Any, TypeVar, cast

from pydantic import ValidationError

from lipsync_lang.base.errors import PackError
from lipsync_lang.base.files.reach import refuse_outside
from lipsync_lang.packs import finding, models
from lipsync_lang.packs.checking import pack_checks as checks
from lipsync_lang.packs.checking.ipa_checks import check_ipa
from lipsync_lang.packs.checking.language_checks import check_claims
from lipsync_lang.packs.checking.project_checks import check_characters, check_languages
from lipsync_lang.packs.checking.rig_checks import check_rig
from lipsync_lang.packs.checking.voices import check_voices
from lipsync_lang.packs.library import FileRequest, KnownPhonemes, Library, added_by
from lipsync_lang.packs.models import MODELS, Language, PackModel
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.project import FILE as PROJECT_FILE
from lipsync_lang.packs.project import PROJECT, check_paths, find_project, stated_mouth
from lipsync_lang.packs.splicing import ABSENT, put
from lipsync_lang.packs.yaml.faults import Fault, PackFaults
from lipsync_lang.packs.yaml.pack_files import shown
from lipsync_lang.packs.yaml.source import Loc, YamlSource
from lipsync_lang.text.phonology.language_names import folded_language

T = TypeVar("T")

DEFINING = {"poses", "phonemes", "base", "adds", "channels", "features", "terms", "letters"}
"""Fields with names that other entries use: dropping one of theirs would cause false faults."""

MAX_SALVAGE_ROUNDS = 5
"""Attempts: dropping one entry may make another faulty."""


def validate(library: Library, paths: Sequence[str | Path] | None = None) -> list[Fault]:
    """Return every fault of all packs, or of the given files and folders, in order.

    References from the given files are looked up in the library.
    """
    run = _Validation(library)
    if paths is None:
        run.check_library()
    else:
        for path in paths:
            run.check_path(Path(path))
    # at the end: one start of the engine answers for all languages
    run.faults.update(check_voices(run.spoken))
    return sorted(run.faults)


class _Validation:
    """A run of validation, which collects faults."""

    def __init__(self, library: Library) -> None:
        self.library = library
        self.faults: set[Fault] = set()
        self.common = _quietly(library.common)
        self.spoken: list[Pack[Language]] = []
        self.languages = sorted({found.name for found in library.names("language")})

    def check_library(self) -> None:
        """Check every pack of the library, shadowed packs included."""
        # all others are found again below, with their files
        self.faults.update(f for f in self.library.faults if f.code == "W304")
        if self.common is None:
            self._try(self.library.common)
        for root in self.library.roots:
            for folder in finding.FOLDERS.values():
                self.check_folder(root.path / folder)
        project = self.library.project
        found = None if project is None else find_project(project)
        if found is not None:
            refuse_outside(found, found.parent)
            self.check_file(*_placed(found))
        self._tags()
        self._replacing()

    def check_path(self, path: Path) -> None:
        """Check a file, or all packs below a folder."""
        path = path.absolute()
        if path.is_dir():
            parts = [path / f for f in finding.FOLDERS.values() if (path / f).is_dir()]
            for folder in parts or [path]:
                self.check_folder(folder)
        else:
            self.check_file(*_placed(path))
        self._tags(path)
        self._replacing(path)

    def check_folder(self, folder: Path) -> None:
        """Check all packs below a folder; warn of files that are never read."""
        found = (p for p in folder.rglob("*") if p.suffix in finding.PACK_SUFFIXES and p.is_file())
        for path in sorted(found):
            if path.suffix == finding.PACK_SUFFIXES[0]:
                self.check_file(*_placed(path))
            else:
                self._warn(path, "is not read, because packs end in `.yaml`", "rename it")
        # a folder without its file would be passed over, as nothing in it is checked
        if folder.name == finding.FOLDERS["poseset"]:
            for entry in finding.entries(folder):
                parts = [finding.POSESET, *finding.PART_FOLDERS]
                if entry.is_dir() and not any((entry / part).exists() for part in parts):
                    self._warn(entry, f"has no {finding.POSESET}", "write one, or delete it")

    def check_file(self, path: Path, kind: str | None, name: str | None) -> None:
        """Check one file against its model, then against other packs."""
        try:
            model, source, faults = self.library.inspect(path, kind, name)
        except PackError as error:
            self.faults.add(Fault(shown(path), 1, 1, "P001", str(error), "check the path"))
            return
        self.faults.update(faults)
        if model is not None:
            self._compare(Pack(model, (source,)))
        elif source.data is not None:
            self._rest(source, kind)

    def _rest(self, source: YamlSource, kind: str | None) -> None:
        """Check the sound entries of a faulty file, so that one run reports all faults."""
        model = _salvaged(source, kind)
        if model is None:
            return
        before = set(self.faults)
        if not isinstance(model, Language):
            self._compare(Pack(model, (source,)))
        # labels of a parent are unknown here, and would seem to be missing
        elif model.extends is None and self.common is not None:
            found = checks.check_language(Pack(model, (source,)), self.common.model)
            self.faults.update(found)
        # Drop warnings: they may be caused by the entries left out.
        self.faults = before | {f for f in self.faults if f.severity == "fault"}

    def _compare(self, pack: "Pack[Any]") -> None:
        """Check a pack against those that it names; a read-out names none."""
        kind, common, phonemes = pack.model.kind, self.common, self._phonemes()
        if kind in {"language", "bank", "rig", "character"}:
            getattr(self, f"_{kind}")(pack)
        elif kind == "phonemes":
            self.faults.update(checks.check_phonemes(pack))
        elif kind == finding.IPA and common is not None:
            self.faults.update(check_ipa(pack, common.model))
        elif kind == "poseset" and phonemes is not None:
            model = None if common is None else common.model
            alone = pack.model.extends is None
            whole = pack if alone else self._try(lambda: self.library.whole_face(pack.path))
            if whole is not None:
                found = checks.check_poseset(whole, phonemes, self._banks(whole), model)
                self.faults.update(found)
        elif kind == PROJECT:
            for check in (check_languages, check_characters):
                self.faults.update(check(pack, self.library))
            self.faults.update(check_paths(pack))

    def _language(self, pack: Pack[models.Language]) -> None:
        whole = self._try(lambda: self.library.extended(pack.path))
        if whole is not None and self.common is not None:
            self.faults.update(checks.check_language(whole, self.common.model))
            self.faults.update(check_claims(whole, self.common.model))
            self.spoken.append(whole)

    def _bank(self, pack: Pack[models.BankPack]) -> None:
        poseset = self._poseset_of(pack)
        phonemes = self._phonemes(pack.model.language)
        if poseset is not None and phonemes is not None:
            self.faults.update(checks.check_bank(pack, poseset, phonemes, self.languages))

    def _rig(self, pack: Pack[models.RigPack]) -> None:
        poseset = self._poseset_of(pack)
        if poseset is not None:
            sets = {found.name for found in self.library.names("poseset")}
            to = pack.model.to
            driven = _quietly(lambda: self.library.poseset(to).model) if to in sets else None
            self.faults.update(check_rig(pack, poseset, sets, driven))

    def _character(self, pack: Pack[models.Character]) -> None:
        poseset = self._poseset_of(pack)
        phonemes = self._phonemes()
        if poseset is None or phonemes is None:
            return
        rigs = {path.stem for path in self.library.rigs_of(pack.model.poseset)}
        shared = _quietly(lambda: self.library.banks(pack.model.poseset)) or []
        own = _quietly(lambda: self.library.character_banks(pack)) or []
        styles = {bank.model.style for bank in (*shared, *own)}
        found = checks.check_character(
            pack, poseset, phonemes, rigs=rigs, languages=self.languages, styles=styles
        )
        self.faults.update(found)
        mouth = stated_mouth(self.library.project)
        self.faults.update(checks.idle_mouths(pack, poseset, mouth))
        for file in pack.model.banks:
            path = finding.beside(pack.path, file)
            if path is not None:
                self.check_file(path, "bank", path.stem)

    def _banks(self, pack: Pack[models.PoseSet]) -> list[models.BankPack] | None:
        """Return the banks beside a pose set and those of other folders; None if one is faulty."""
        name, own = pack.model.name, finding.yaml_files(pack.path.parent / "banks").values()
        found = [self.library.inspect(path, "bank", path.stem)[0] for path in own]
        # the file may lie in a folder that the library does not search
        if self.library.lookup("poseset", name):
            joined = _quietly(lambda: self.library.banks(name))
            found += [bank.model for bank in joined] if joined is not None else [None]
        return None if None in found else cast("list[models.BankPack]", found)

    def _poseset_of(self, pack: "Pack[Any]") -> models.PoseSet | None:
        """Return the pose set that a pack lies in or names; None if it is missing or faulty."""
        # a folder that is checked by its path may hold a pose set that another shadows
        beside = pack.path.parent.parent / finding.POSESET
        if pack.path.parent.name in finding.PART_FOLDERS and beside.is_file():
            whole = _quietly(lambda: self.library.whole_face(beside))
            return None if whole is None else whole.model
        name = pack.model.poseset
        try:
            return self.library.poseset(name).model
        except PackFaults:
            return None
        except PackError:
            known = {found.name for found in self.library.names("poseset")}
            self.faults.add(pack.unknown(("poseset",), "P203", "pose set", name, known))
            return None

    def _phonemes(self, language: str | None = None) -> Collection[str] | None:
        """Return the phonemes of a language, or of all; None without the common pack."""
        if self.common is None:
            return None
        model = self.common.model
        if language in self.languages:
            added = added_by(self.library, language)
            return checks.with_shades({*model.base, model.silence, *added}, model)
        return KnownPhonemes(self.library, {*model.phonemes, model.silence, *model.shades})

    def _tags(self, within: Path | None = None) -> None:
        """Warn of tags and aliases that two languages state, one of them there."""
        found = [f for f in self.library.names("language") if f.shadowed_by is None]
        first = {folded_language(one.name): one.name for one in found}
        for one in found:
            for answer in finding.answers_of(one.path):
                other = first.setdefault(answer, one.name)
                if other == one.name or (within and not one.path.is_relative_to(within)):
                    continue
                model, source, _ = self.library.inspect(one.path, "language", one.name)
                if isinstance(model, Language):
                    aliases = [a for a in model.aliases if folded_language(a) == answer]
                    tagged = not aliases or folded_language(model.tag) == answer
                    loc: Loc = ("tag",) if tagged else ("aliases", aliases[0])
                    what = f"{'tag' if tagged else 'alias'} '{answer}' already belongs to language"
                    hint = f"only '{other}' answers to it"
                    pack = Pack(model, (source,))
                    self.faults.add(pack.warning(loc, "W305", f"{what} '{other}'", hint))

    def _replacing(self, within: Path | None = None) -> None:
        """Warn of packs there in place of built-in ones, unless they extend or equal these."""
        for kind in finding.FOLDERS:
            for found in self.library.names(kind):
                by, shipped = found.shadowed_by, found.root.origin == "built-in"
                if by is None or not shipped or cmp(by, found.path, shallow=False):
                    continue
                model, source, _ = self.library.inspect(by, kind, found.name)
                there = within is None or by.is_relative_to(within)
                if there and model is not None and getattr(model, "extends", None) != found.name:
                    what = f"this pack replaces the built-in '{found.name}'"
                    hint = "choose another name, unless you mean to"
                    self.faults.add(Pack(model, (source,)).warning(("name",), "W323", what, hint))

    def _warn(self, path: Path, what: str, hint: str) -> None:
        self.faults.add(Fault(shown(path), 1, 1, "W303", f"'{path.name}' {what}", hint, "warning"))

    def _try(self, load: Callable[[], T]) -> T | None:
        try:
            return load()
        except PackFaults as error:
            self.faults.update(error.faults)
        except PackError as error:
            place = f"{finding.FOLDERS['language']}/{finding.COMMON}.yaml"
            self.faults.add(Fault(place, 1, 1, "P001", str(error)))
        return None


def _quietly(load: Callable[[], T]) -> T | None:
    """Load a pack, or return None for a faulty one, which another check reports."""
    try:
        return load()
    except PackError:
        return None


def _placed(path: Path) -> FileRequest:
    """Return a file with the kind and name that its place requires."""
    folder = path.parent.name
    if path.name == PROJECT_FILE:
        return path, PROJECT, None
    kind = "poseset" if path.name == finding.POSESET else finding.PART_FOLDERS.get(folder)
    if folder == finding.FOLDERS["language"]:
        kind = finding.SHARED.get(path.stem, "language")
    return path, kind, finding.pack_name(path)


def _salvaged(source: YamlSource, kind: str | None) -> PackModel | None:
    """Return a file's pack without its faulty entries; None if too little is left."""
    data = source.data
    stated = data.get("kind") if isinstance(data, dict) else None
    if not isinstance(stated, str) or stated not in MODELS or kind not in (None, stated):
        return None
    for _ in range(MAX_SALVAGE_ROUNDS):
        try:
            return MODELS[stated].model_validate(data)
        except ValidationError as error:
            reports = error.errors(include_url=False)
            faulty = {_entry(data, report["loc"]) for report in reports}
            if any(not entry or entry[0] in DEFINING for entry in faulty):
                return None
            for entry in faulty:
                data = put(data, entry, ABSENT)
    return None


def _entry(data: Any, loc: Loc) -> tuple[Any, ...]:
    """Return the path of the innermost named entry that contains `loc`."""
    path: list[Any] = []
    for step in loc:
        if not isinstance(data, dict) or step not in data:
            break
        path.append(step)
        data = data[step]
    return tuple(path)
