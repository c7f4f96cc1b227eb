"""Text to IPA with the models of g2p2, for scripts without vowels.

Its models are small, and come as packages (`g2p2-group-...`). They are read from there: g2p2 itself
would download a model that is missing, which nothing here does.

Words with vowel points are read by the rules of the pack, or by the engine that it names as
`otherwise`: the models know no points. That engine reads words of another script, too.
"""

import lzma
import pkgutil
import re
from collections.abc import Iterator, Sequence
from functools import cache, lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING
from unicodedata import category, name

from lipsync_lang.errors import SpeechError
from lipsync_lang.extras import install_line, package_line
from lipsync_lang.phonology.g2p.epitran import segments
from lipsync_lang.phonology.g2p.g2p_engines import (
    G2P_ENGINES,
    G2PEngine,
    MissingReaderError,
    Settings,
    SpokenWord,
    merged,
)
from lipsync_lang.phonology.g2p.rules import CACHED_WORDS
from lipsync_lang.phonology.g2p.tokens import plain, read_words
from lipsync_lang.phonology.labels import normalise

if TYPE_CHECKING:
    from g2p2 import Model

GROUP_PACKAGE_PREFIX = "g2p2_group_"
"""Start of the names of the packages that hold models."""

_PREFIX = re.compile("-(.)")
"""A hyphen, as it parts a prefix and a foreign word."""


@G2P_ENGINES.register("g2p2")
def engine(settings: Settings) -> G2PEngine:
    """Read text with the g2p2 model of the language's code, from an installed package."""
    model = _model(settings.code or "", settings.language)
    known = frozenset(map(normalise, settings.labels))
    scripts = {_script(letter) for rule in settings.rules for letter in rule.spelling}

    def pointed(word: str) -> bool:
        return any(category(sign) == "Mn" for sign in plain(word))

    def foreign(word: str) -> bool:
        """Return True for a word with a letter of a script that the rules do not have."""
        return bool(scripts) and any(c.isalpha() and _script(c) not in scripts for c in word)

    def parted(hyphen: re.Match[str]) -> str:
        return f" {hyphen[1]}" if foreign(hyphen[1]) else hyphen[0]

    others = [
        (belongs, G2P_ENGINES.find(reader, SpeechError)(settings))
        for belongs, reader in (
            (pointed, "rules" if settings.rules else settings.otherwise),
            (foreign, settings.otherwise),
        )
        if reader
    ]

    @lru_cache(CACHED_WORDS)
    def read_word(word: str) -> SpokenWord:
        labels = segments(model.phonemize(plain(word)), known)
        return SpokenWord(word, labels, unread="" if labels else word)

    def read(texts: Sequence[str]) -> Iterator[tuple[SpokenWord, ...]]:
        plainly = [read_words(_PREFIX.sub(parted, text), read_word) for text in texts]
        texts_of_words = {word.text for words in plainly for word in words}
        found: dict[str, SpokenWord] = {}
        for belongs, other in others:
            picked = sorted(filter(belongs, texts_of_words))
            for text, words in zip(picked, other(picked), strict=True):
                found[text] = merged(text, words)._replace(stress=())  # as for words of the model
        for words in plainly:
            yield tuple(found.get(word.text, word) for word in words)

    return read


def _script(letter: str) -> str:
    return name(letter, "").partition(" ")[0]


@cache
def _model(code: str, language: str) -> "Model":
    try:
        from g2p2 import Model
    except ImportError:
        raise MissingReaderError(
            f"{language} is read by g2p2, which is not installed; "
            f"get it with: {install_line('g2p2')}"
        ) from None
    for module in pkgutil.iter_modules():
        if module.name.startswith(GROUP_PACKAGE_PREFIX):
            packed = files(module.name) / f"{code}.g2p.xz"
            if packed.is_file():
                return Model.from_bytes(lzma.decompress(packed.read_bytes()))
    raise SpeechError(
        f"no installed package has a g2p2 model of '{code}'; get the family of {language}, "
        f"as in: {package_line('g2p2-group-semitic')}"
    )
