"""Load packs by name, and validate each against its model.

The library records every look-up and every file it reads. The cache of compiled pairs is valid
as long as both are unchanged.
"""

import logging
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, reduce
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

from lipsync_lang.base.errors import PackError
from lipsync_lang.packs import finding
from lipsync_lang.packs.finding import FOLDERS, Finder, Kind, Paths, pack_name
from lipsync_lang.packs.pack import Pack
from lipsync_lang.packs.yaml.faults import Fault, PackFaults
from lipsync_lang.packs.yaml.pack_files import read_bytes, shown
from lipsync_lang.packs.yaml.source import YamlSource

if TYPE_CHECKING:
    from lipsync_lang.packs import models

_log = logging.getLogger(__name__)

FileRequest = tuple[Path, str | None, str | None]
"""A file with the kind and the name that it must have; None for any."""


class Library(Finder):
    """The packs in all folders searched: a finder that reads, and remembers what it looked up.

    A library that came `earlier` lends its packs where their content is the same.

    Attributes
    ----------
    lookups : (kind, name) -> files found, in order; a `Finder` can repeat a look-up
    files : path -> SHA-256 of the bytes read
    model_states : path -> `model_state` of each model whose shapes decided targets
    faults : every fault found so far, in order
    sound : languages that were checked, and are sound with the common phonemes
    """

    def __init__(
        self,
        paths: Paths = (),
        project: Path | None = Path(),
        *,
        unsaved: Mapping[Path, bytes] = finding.NONE_UNSAVED,
        earlier: "Library | None" = None,
    ) -> None:
        super().__init__(paths, project, unsaved)
        self.lookups: dict[tuple[str, str], tuple[str, ...]] = {}
        self.files: dict[str, str] = {}
        self.model_states: dict[str, list[int] | None] = {}
        self.faults: list[Fault] = []
        for entry in self.missing:
            what = f"'{entry.dist}' offers packs in '{entry.value}', which is gone"
            place, hint = "installed distributions", "install it again, or remove it"
            self.faults.append(Fault(place, 1, 1, "W304", what, hint, "warning"))
        self._loaded: dict[FileRequest, _LoadedFile] = {}
        self._whole: dict[Path, Pack[models.Language]] = {}
        self.sound: set[Pack[models.Language]] = set()
        self._earlier = {} if earlier is None else earlier.by_content()

    def lookup(self, kind: str, name: str) -> tuple[str, ...]:
        """Return the files found for a name as `Finder.lookup` does, and record the look-up."""
        found = self.lookups[kind, name] = super().lookup(kind, name)
        return found

    def common(self) -> "Pack[models.Phonemes]":
        """Load the common phonemes."""
        return cast("Pack[models.Phonemes]", self._shared(finding.COMMON))

    def ipa(self) -> "Pack[models.Ipa]":
        """Load the features of the IPA."""
        return cast("Pack[models.Ipa]", self._shared(finding.IPA))

    def language(self, name: str) -> "Pack[models.Language]":
        """Load a language merged with its parents; a name ENGINE:CODE needs no pack."""
        from lipsync_lang.packs.automatic import HOW, automatic, unpacked

        found = self.lookup("language", name)
        if found:
            return self.extended(Path(found[0]))
        made = automatic(name, self.common)
        if made is None:
            if (code := unpacked(name)) is not None:
                raise PackError(f"no pack has the language '{name}'; '{code}' works without one")
            raise PackError(f"{self.unknown(name, 'language')}; {HOW}")
        return made

    def extended(self, path: Path) -> "Pack[models.Language]":
        """Load a language with all that it inherits; raise `PackFaults` for an unsound parent."""
        from lipsync_lang.packs.extending import merge

        if path not in self._whole:
            line = self._line(path, "language")
            model = reduce(merge, (pack.model for pack in reversed(line)))
            self._whole[path] = Pack(model, tuple(pack.source for pack in line))
        return self._whole[path]

    def _usual(self, stated: "Pack[models.Language]") -> "Pack[models.Language]":
        """Return a language with its usual mapping: a bare label means that, not the parent's."""
        from lipsync_lang.packs.extending import with_alike, with_usual

        pack, faults = with_usual(stated, self.common)
        if faults:
            raise self.failing(*faults)
        return with_alike(pack, self.common)

    def _line(self, path: Path, kind: Kind) -> "list[Pack[Any]]":
        """Load a pack and all that it extends, the child first."""
        from lipsync_lang.packs.automatic import automatic

        line: list[Pack[Any]] = []
        word, languages = finding.KIND_WORDS[kind], kind == "language"
        while True:
            pack: Pack[Any] = self.load(path, kind, pack_name(path))
            line.append(self._usual(pack) if languages else pack)
            parent, found = pack.model.extends, None
            if parent is None:
                return line
            if not languages and parent.endswith(".yaml"):
                found = finding.beside(pack.path, parent, self.unsaved)
            elif self.lookup(kind, parent):
                found = self.find(kind, parent)
            elif languages and (made := automatic(parent, self.common)) is not None:
                return [*line, made]
            if found is None:
                known = {one.name for one in self.names(kind)}
                raise self.failing(pack.unknown(("extends",), "P210", word, parent, known))
            path = found
            if pack_name(path) == pack_name(pack.path):
                # A pack that extends its own name extends the one that it shadows.
                under = self.lookup(finding.BENEATH, str(pack.path))
                if not under:
                    what = f"there is no other {word} '{parent}' to extend"
                    hint = f"name another {word}, or leave `extends` out"
                    raise self.failing(pack.fault(("extends",), "P210", what, hint))
                path = Path(under[0])
            if path in {member.path for member in line}:
                names = " -> ".join([*(member.model.name for member in line), pack_name(path)])
                what = f"{word}s extend each other in a circle: {names}"
                hint = "one of them must not extend another"
                raise self.failing(pack.fault(("extends",), "P211", what, hint))

    def poseset(self, name: str) -> "Pack[models.PoseSet]":
        """Load a pose set merged with its parents."""
        return self.whole_face(self.find("poseset", name))

    def whole_face(self, path: Path) -> "Pack[models.PoseSet]":
        """Load a pose set with all that it inherits; raise `PackFaults` for an unsound parent."""
        from lipsync_lang.packs.extending import merged_face

        line = self._line(path, "poseset")
        model, faults = merged_face(line)
        if faults:
            raise self.failing(*faults)
        return Pack(model, tuple(pack.source for pack in line))

    def banks(self, poseset: str) -> "list[Pack[models.BankPack]]":
        """Load every bank of a pose set, in the order of their file names."""
        return cast("list[Pack[models.BankPack]]", self._load_all(self.banks_of(poseset), "bank"))

    def rigs(self, poseset: str) -> "list[Pack[models.RigPack]]":
        """Load every rig of a pose set, in the order of their file names."""
        return cast("list[Pack[models.RigPack]]", self._load_all(self.rigs_of(poseset), "rig"))

    def banks_of(self, poseset: str) -> list[Path]:
        """List the bank files of a pose set."""
        self.find("poseset", poseset)
        return [Path(path) for path in self.lookup("banks", poseset)]

    def rigs_of(self, poseset: str) -> list[Path]:
        """List the rig files of a pose set."""
        self.find("poseset", poseset)
        return [Path(path) for path in self.lookup("rigs", poseset)]

    def character(self, name: str) -> "Pack[models.Character]":
        """Load a character; the name of a pose set gives a character without edits."""
        found = self.lookup("character", name)
        if found:
            path = Path(found[0])
            return cast("Pack[models.Character]", self.load(path, "character", path.stem))
        if finding.is_model(name):
            raise PackError(
                f"{name}: is a model; make a character of it with `lipsync-lang characters new`"
            )
        if not self.lookup("poseset", name):
            raise self.unknown(name, "character", "poseset")
        from lipsync_lang.packs.models import Character

        poseset = self.poseset(name)
        title, own = poseset.model.title, poseset.model.name
        bare = Character.model_construct(
            kind="character", format=1, name=own, poseset=own, title=title
        )
        return Pack(bare, poseset.sources)

    def character_banks(self, character: "Pack[models.Character]") -> "list[Pack[models.BankPack]]":
        """Load a character's own bank files, in the order stated."""
        paths = []
        for number, name in enumerate(character.model.banks):
            path = finding.beside(character.path, name, self.unsaved)
            if path is None:
                what = f"there is no file '{name}'"
                hint = f"it belongs in {shown(character.path.parent)}"
                raise self.failing(character.fault(("banks", number), "P213", what, hint))
            paths.append(path)
        return cast("list[Pack[models.BankPack]]", self._load_all(paths, "bank"))

    def load(
        self, path: Path, kind: str | None = None, name: str | None = None
    ) -> "Pack[models.PackModel]":
        """Load one file; `kind` and `name`, if given, must match. Raise `PackFaults` for faults."""
        model, source, faults = self.inspect(path, kind, name)
        if faults or model is None:
            raise PackFaults(faults)
        return Pack(model, (source,))

    def inspect(
        self, path: Path, kind: str | None = None, name: str | None = None
    ) -> "_LoadedFile":
        """Return the model (None if faulty), source and faults of a file, which is read once."""
        key = path, kind, name
        if key not in self._loaded:
            self.refuse_outside(path)
            content = self.unsaved[path] if path in self.unsaved else read_bytes(path)
            digest = self.files[str(path)] = sha256(content).hexdigest()
            # models are immutable, so that libraries can share them
            found = self._earlier.get((key, digest))
            if found is None:
                from lipsync_lang.packs.models.validation import validated
                from lipsync_lang.packs.yaml.building import scan

                _log.debug("reading %s", path)
                source = scan(path, content)
                model, faults = validated(source, kind=kind, name=name)
                found = _LoadedFile(model, source, faults)
            self.faults.extend(found.faults)
            self._loaded[key] = found
        return self._loaded[key]

    def by_content(self) -> "dict[tuple[FileRequest, str], _LoadedFile]":
        """Return the files loaded so far, by what was asked for and the digest of the content."""
        return {(key, self.files[str(key[0])]): found for key, found in self._loaded.items()}

    def scanned(self, path: Path, content: bytes) -> YamlSource:
        """Return a file as data; content that was loaded already is not scanned once more.

        Raise `PackFaults` for content that is not sound YAML.
        """
        from lipsync_lang.packs.yaml.building import read_yaml

        digest = sha256(content).hexdigest()
        loaded = (one.source for (_, own), one in self.by_content().items() if own == digest)
        found = next(loaded, None)
        return read_yaml(path, content) if found is None else replace(found, path=path)

    def failing(self, *faults: Fault) -> PackFaults:
        """Record faults, and return an error that carries them."""
        self.faults.extend(faults)
        return PackFaults(faults)

    def _shared(self, name: str) -> "Pack[models.PackModel]":
        """Load a file of `languages` that is not a language."""
        found = self.lookup(finding.SHARED[name], name)
        if not found:
            raise PackError(f"no {FOLDERS['language']}/{name}.yaml is in any folder searched")
        return self.load(Path(found[0]), finding.SHARED[name], name)

    def _load_all(self, paths: Sequence[Path], kind: str) -> "list[Pack[models.PackModel]]":
        packs: list[Pack[models.PackModel]] = []
        faults: list[Fault] = []
        for path in paths:
            try:
                packs.append(self.load(path, kind, path.stem))
            except PackFaults as error:
                faults.extend(error.faults)
        if faults:
            raise PackFaults(faults)
        return packs


class _LoadedFile(NamedTuple):
    """A file with its model, its data and its faults."""

    model: "models.PackModel | None"
    source: YamlSource
    faults: tuple[Fault, ...]


class KnownPhonemes(Collection[str]):
    """Some common phonemes, and those that any language of a library adds.

    Loading every language is slow, so `in` does so only for a label missing from `common`.
    """

    def __init__(self, library: Library, common: set[str]) -> None:
        self._library, self._common = library, common

    @cached_property
    def _whole(self) -> set[str]:
        names = {found.name for found in self._library.names("language")}
        return self._common.union(*(added_by(self._library, name) for name in sorted(names)))

    def __contains__(self, name: object) -> bool:
        return name in self._common or name in self._whole

    def __iter__(self) -> Iterator[str]:
        return iter(self._whole)

    def __len__(self) -> int:
        return len(self._whole)


def added_by(library: Library, language: str) -> set[str]:
    """Return the phonemes that a language adds; empty if its pack is faulty."""
    try:
        return set(library.language(language).model.adds)
    except PackError:
        return set()
