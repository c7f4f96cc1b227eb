"""Which engines turn text into phonemes, and what all of them take and give."""

from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import NamedTuple, cast

from lipsync_lang.errors import SpeechError, did_you_mean


class Said(NamedTuple):
    """A word as it is said.

    `text` is the user's own spelling; `labels` are its phonemes, none for a pause, whose text is
    the punctuation. `respelled` is how a voice had best read it, where that is not `text`;
    `unread` are the characters of it that the engine could not read.
    """

    text: str
    labels: tuple[str, ...]
    respelled: str = ""
    unread: str = ""


class Rule(NamedTuple):
    """A rewrite: letters, the labels they become, and what must stand after and before them."""

    spelling: str
    to: tuple[str, ...]
    before: str = ""
    """A regular expression that must match what follows."""
    after: str = ""
    """A regular expression that must match what precedes."""


@dataclass(frozen=True)
class Settings:
    """What a language pack says of its engine.

    Parameters
    ----------
    language : the pack's name, for messages
    voice, code : the engine's names of the language, where it has some
    file : a lexicon
    rules : rewrites, in order
    labels : the labels of the notation that comes out
    respell : the name in `RESPELLERS` of what spells text anew before it is read
    """

    language: str
    voice: str | None = None
    code: str | None = None
    file: Path | None = None
    rules: tuple[Rule, ...] = ()
    labels: Collection[str] = ()
    respell: str | None = None


Engine = Callable[[Sequence[str]], Iterable[Sequence[Said]]]
"""Texts in; for each, its words and pauses in order."""

Respeller = Callable[[str], list[tuple[str, str]]]
"""Text in; pieces of it that make it up again, each with the spelling to read it by."""

ENGINES: dict[str, str] = {
    "espeak": "lipsync_lang.phonology.g2p.espeak_g2p:engine",
    "pypinyin": "lipsync_lang.phonology.g2p.pinyin:engine",
    "epitran": "lipsync_lang.phonology.g2p.epitran:engine",
    "lexicon": "lipsync_lang.phonology.g2p.lexicon:engine",
    "rules": "lipsync_lang.phonology.g2p.rules:engine",
}
"""Engines by name: where the function is that makes one of its `Settings`."""

RESPELLERS: dict[str, str] = {"kana": "lipsync_lang.phonology.g2p.kana:respell"}
"""Respellers by name: where the function is."""


def engine(name: str, settings: Settings) -> Engine:
    """Make the engine of a language.

    Raises
    ------
    SpeechError
        There is no such engine, it is not installed, or it does not have the language.
    """
    if name not in ENGINES:
        raise SpeechError(f"no G2P engine '{name}'; {did_you_mean(name, ENGINES)}")
    make = cast("Callable[[Settings], Engine]", _named(ENGINES[name]))
    return make(settings)


def respeller(name: str) -> Respeller:
    """Return what spells text anew.

    Raises
    ------
    SpeechError
        There is no such respeller, or it is not installed.
    """
    if name not in RESPELLERS:
        raise SpeechError(f"nothing respells as '{name}'; {did_you_mean(name, RESPELLERS)}")
    return cast("Respeller", _named(RESPELLERS[name]))


def _named(place: str) -> object:
    module, _, name = place.partition(":")
    return getattr(import_module(module), name)
