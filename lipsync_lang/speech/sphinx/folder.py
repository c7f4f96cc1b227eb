"""Models that pocketsphinx brings: where they are, and how they spell words."""

import re
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.util import find_spec
from itertools import count, takewhile
from pathlib import Path

from lipsync_lang.errors import SpeechError, did_you_mean
from lipsync_lang.speech.sphinx.acoustic_model import OUTSIDE, AcousticModel, read_model

_VARIANT = re.compile(r"\(\d+\)$")


@dataclass(frozen=True)
class Models:
    """An acoustic model, the dictionary of its words, and what it expects to be said.

    Parameters
    ----------
    folder : where they are; the acoustic model is in a folder of the same name within it
    """

    folder: Path

    @property
    def acoustic(self) -> Path:
        """The folder of the acoustic model."""
        return self.folder / self.folder.name

    @property
    def dictionary(self) -> Path:
        """The file of words and their phonemes."""
        return self.folder / f"cmudict-{self.folder.name}.dict"

    @property
    def words(self) -> Path:
        """The file of which words follow which."""
        return self.folder / f"{self.folder.name}.lm.bin"

    @property
    def phones(self) -> Path:
        """The file of which phonemes follow which."""
        return self.folder / f"{self.folder.name}-phone.lm.bin"

    @cached_property
    def model(self) -> AcousticModel:
        """What the phonemes sound like."""
        return read_model(self.acoustic)

    @cached_property
    def numbers(self) -> dict[str, int]:
        """The number of each phoneme that is speech."""
        fillers = self.model.fillers
        return {name: n for n, name in enumerate(self.model.names) if n not in fillers}

    @cached_property
    def quiet(self) -> frozenset[int]:
        """The numbers of what is no speech."""
        return self.model.fillers | {OUTSIDE}

    def ways(self, word: str) -> tuple[tuple[int, ...], ...]:
        """Return the ways to say a word in plain spelling, as numbers of phonemes; none if unknown.

        Raises
        ------
        SpeechError
            The dictionary cannot be read.
        """
        spellings = (f"{word}({number})" if number > 1 else word for number in count(1))
        known = takewhile(self._entries.__contains__, spellings)
        return tuple(
            tuple(self.numbers[name] for name in self._entries[spelling].split())
            for spelling in known
        )

    @cached_property
    def _entries(self) -> dict[str, str]:
        """What follows each word in the dictionary; `WORD(2)` is another way to say it."""
        try:
            lines = self.dictionary.read_text("utf-8").splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise SpeechError(f"{self.dictionary}: cannot be read: {error}") from None
        return {word: phones for word, _, phones in (line.partition(" ") for line in lines)}


def without_variant(word: str) -> str:
    """Return a word of the dictionary without the number of its way to be said."""
    return _VARIANT.sub("", word)


@cache
def find_models(name: str | None) -> Models:
    """Return the models of a name.

    Raises
    ------
    SpeechError
        pocketsphinx is not installed, or has none of that name.
    """
    spec = find_spec("pocketsphinx")
    if spec is None or spec.origin is None:
        raise SpeechError(
            "hearing words needs pocketsphinx, which is not installed; "
            'get it with: pip install "lipsync-lang[audio]"'
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
