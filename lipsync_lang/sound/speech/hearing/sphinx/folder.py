"""Acoustic models by name or folder, with their phones in IPA, dictionary and language model."""

import struct
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cache, cached_property
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

from lipsync_lang.base.errors import SpeechError, did_you_mean
from lipsync_lang.base.extensions import Extensions
from lipsync_lang.base.extras import install_line
from lipsync_lang.sound.speech.hearing.sphinx.acoustic_model import OUTSIDE, AcousticModel
from lipsync_lang.sound.speech.hearing.sphinx.sphinx_files import read_sphinx

if TYPE_CHECKING:
    from lipsync_lang.resolver.nearest_phonemes import ModelPhones

MODEL_FOLDER = "models"
"""The folder of a project with its models, each a folder."""

WHISPER_FILE = "model.bin"
"""A file of Whisper's models, which may be in that folder, too, and of no acoustic model."""

MODEL_READERS: Extensions[Callable[[Path], AcousticModel]] = Extensions(
    "acoustic_models", "reader of acoustic models"
)
"""Readers of folders with acoustic models of other forms, by the file that tells the form."""

model_reader = MODEL_READERS.register
"""Decorator that registers a function as the reader of folders with a file."""

LICENCE_FILES = ("LICENSE*", "LICENCE*", "COPYING*", "README*")
"""Patterns of files with a model's terms, the most telling first."""


@dataclass(frozen=True)
class Models:
    """An acoustic model with its dictionary and language models.

    Parameters
    ----------
    folder : model folder; the files of the acoustic model are in it, or in a subfolder of its name
    given : an acoustic model in place of that in the folder
    """

    folder: Path
    given: AcousticModel | None = None

    @property
    def acoustic(self) -> Path:
        """The folder of the acoustic model."""
        inner = self.folder / self.folder.name
        return inner if inner.is_dir() else self.folder

    @property
    def dictionary(self) -> Path | None:
        """The pronunciation dictionary file; None without one, or with several."""
        return self._only("*.dict", "*.dic")

    @property
    def language_model(self) -> Path | None:
        """The model of the order of words; None without one."""
        path = self.folder / f"{self.folder.name}.lm.bin"
        return path if path.is_file() else None

    @property
    def licence(self) -> Path | None:
        """The file with the terms of the model."""
        places = dict.fromkeys((self.acoustic, self.folder))
        found = (one for name in LICENCE_FILES for place in places for one in place.glob(name))
        return next(found, None)

    def _only(self, *patterns: str) -> Path | None:
        found = [path for pattern in patterns for path in self.folder.glob(pattern)]
        return found[0] if len(found) == 1 else None

    @cached_property
    def model(self) -> AcousticModel:
        """The acoustic model; phones that `phones.yaml` calls no speech are fillers in it."""
        if self.given is not None:
            return self.given
        model, known = read_model(self.acoustic), self.phones
        letters = known.nearest.candidates if known else {}
        mute = [n for n, name in enumerate(model.names) if not letters.get(name, True)]
        return replace(model, fillers=model.fillers | {*mute}) if mute else model

    @cached_property
    def phones(self) -> "ModelPhones | None":
        """The model's phones in IPA: those of its folder, or of the pack of the IPA; or None."""
        from lipsync_lang.resolver.nearest_phonemes import model_phones, phones_beside

        model = read_model(self.acoustic)
        speech = [name for n, name in enumerate(model.names) if n not in model.fillers]
        beside = phones_beside(self.acoustic, speech)
        known = None if beside else model_phones()
        named = known is not None and {*speech} <= {*known.nearest.candidates}
        return beside or (known if named else None)

    @cached_property
    def numbers(self) -> dict[str, int]:
        """The numbers of speech phonemes by name."""
        fillers = self.model.fillers
        return {name: n for n, name in enumerate(self.model.names) if n not in fillers}

    @cached_property
    def quiet(self) -> frozenset[int]:
        """The numbers of non-speech phonemes."""
        return self.model.fillers | {OUTSIDE}

    def ways(self, words: Iterable[str]) -> list[tuple[tuple[int, ...], ...]]:
        """Return the pronunciations of each word as phoneme numbers; none of an unknown word.

        An unreadable dictionary is a `SpeechError`.
        """
        ways: list[tuple[tuple[int, ...], ...]] = []
        for word in words:
            found: list[tuple[int, ...]] = []
            spelling = word
            while (phones := self._entries.get(spelling)) is not None:
                names = phones.split()
                if unknown := [name for name in names if name not in self.numbers]:
                    raise SpeechError(
                        f"{self.dictionary}: '{spelling}' has '{unknown[0]}', which is no phone of "
                        "the model; take the dictionary away, or mend it"
                    )
                found.append(tuple(self.numbers[name] for name in names))
                spelling = f"{word}({len(found) + 1})"
            ways.append(tuple(found))
        return ways

    @cached_property
    def _entries(self) -> dict[str, str]:
        """Pronunciation by dictionary word; `WORD(2)` is a variant."""
        if self.dictionary is None:
            return {}
        try:
            lines = self.dictionary.read_text("utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise SpeechError(f"{self.dictionary}: cannot be read: {error}") from None
        return {word: phones for word, _, phones in (line.partition(" ") for line in lines)}


@cache
def read_model(folder: Path) -> AcousticModel:
    """Read the acoustic model in a folder, of CMU Sphinx or of a form that a plug-in reads.

    A file that is missing, truncated or of another kind is a `SpeechError`.
    """
    try:
        other = next((name for name in MODEL_READERS if (folder / name).is_file()), None)
        return MODEL_READERS[other](folder) if other else read_sphinx(folder)
    except OSError as error:
        raise SpeechError(f"{folder}: no acoustic model: {error.strerror or error}") from None
    except (struct.error, ValueError, IndexError, KeyError) as error:
        raise SpeechError(
            f"{folder}: not an acoustic model that can be read ({error}); install it again, or "
            "name another"
        ) from None


@cache
def models_in(folder: Path) -> Models:
    """Return the models in a folder, which are read once."""
    return Models(folder)


def own_folder(name: str) -> Path | None:
    """Return the folder of a model that the user brought, named by its path or in the project."""
    if any(sign in name for sign in "/\\~"):
        return Path(name).expanduser().absolute()
    path = _model_folder() / name
    return path if name and path.is_dir() else None


def find_models(name: str | None) -> Models:
    """Find the models in a folder, or with a name in the project or in pocketsphinx.

    It is a `SpeechError` if there is no such folder, or pocketsphinx is not installed, or has no
    model of that name.
    """
    folder = own_folder(name or "")
    if folder is not None:
        if not folder.is_dir():
            raise SpeechError(f"{name}: no such folder; name the folder of an acoustic model")
        return models_in(folder)
    spec = find_spec("pocketsphinx")
    if spec is None or spec.origin is None:
        raise SpeechError(
            "recognising words needs pocketsphinx, which is not installed; "
            f"get it with: {install_line('audio')}"
        )
    known = {one.folder.name: one for one in installed_models()}
    if name is None:
        raise SpeechError(
            "pocketsphinx needs a model, and the language names none: state it in its pack as "
            f"`audio: {{model: ...}}`; {did_you_mean('', known)}"
        )
    if name not in known:
        raise SpeechError(
            f"pocketsphinx has no model '{name}'; {did_you_mean(name, known)}; a folder is named "
            f"by its path: ./{name}"
        )
    return known[name]


def installed_models() -> Iterator[Models]:
    """Yield the models with a name: those of the project, and then those of pocketsphinx."""
    spec = find_spec("pocketsphinx")
    yield from (models_in(path) for path in project_models() if not is_whisper(path))
    if spec and spec.origin:
        yield from map(models_in, _folders(Path(spec.origin).parent / "model"))


def project_models() -> list[Path]:
    """Return the folders of all models of the project, or in the current folder without one."""
    return _folders(_model_folder())


def is_whisper(folder: Path) -> bool:
    """Return True for a folder with a model of Whisper."""
    return (folder / WHISPER_FILE).is_file()


def _model_folder() -> Path:
    from lipsync_lang.packs.project import find_project

    project = find_project()
    return (project.parent if project else Path().absolute()) / MODEL_FOLDER


def _folders(place: Path) -> list[Path]:
    return [path for path in sorted(place.glob("*")) if path.is_dir()]
