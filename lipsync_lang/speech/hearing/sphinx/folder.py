"""Locations of the installed pocketsphinx models, and their dictionary."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.util import find_spec
from pathlib import Path

from lipsync_lang.errors import SpeechError, did_you_mean
from lipsync_lang.extras import install_line
from lipsync_lang.speech.hearing.sphinx.acoustic_model import OUTSIDE, AcousticModel, read_model


@dataclass(frozen=True)
class Models:
    """An acoustic model with its dictionary and language models.

    Parameters
    ----------
    folder : model folder; the acoustic model is in a subfolder of the same name
    """

    folder: Path

    @property
    def acoustic(self) -> Path:
        """The folder of the acoustic model."""
        return self.folder / self.folder.name

    @property
    def dictionary(self) -> Path:
        """The pronunciation dictionary file."""
        return self.folder / f"cmudict-{self.folder.name}.dict"

    @cached_property
    def model(self) -> AcousticModel:
        """The acoustic model."""
        return read_model(self.acoustic)

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
                found.append(tuple(self.numbers[name] for name in phones.split()))
                spelling = f"{word}({len(found) + 1})"
            ways.append(tuple(found))
        return ways

    @cached_property
    def _entries(self) -> dict[str, str]:
        """Pronunciation by dictionary word; `WORD(2)` is a variant."""
        try:
            lines = self.dictionary.read_text("utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise SpeechError(f"{self.dictionary}: cannot be read: {error}") from None
        return {word: phones for word, _, phones in (line.partition(" ") for line in lines)}


@cache
def find_models(name: str | None) -> Models:
    """Find the models with a name.

    It is a `SpeechError` if pocketsphinx is not installed, or has no model of that name.
    """
    spec = find_spec("pocketsphinx")
    if spec is None or spec.origin is None:
        raise SpeechError(
            "recognising words needs pocketsphinx, which is not installed; "
            f"get it with: {install_line('audio')}"
        )
    folder = Path(spec.origin).parent / "model"
    known = sorted(p.name for p in folder.glob("*") if p.is_dir())
    if name is None:
        raise SpeechError(
            "pocketsphinx needs a model, and the language names none: state it in its pack as "
            f"`audio: {{model: ...}}`; {did_you_mean('', known)}"
        )
    if name not in known:
        raise SpeechError(f"pocketsphinx has no model '{name}'; {did_you_mean(name, known)}")
    return Models(folder / name)
