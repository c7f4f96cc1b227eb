"""Engines that convert text to phonemes, and their common interface."""

import re
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.base.extensions import Extensions


class SpokenWord(NamedTuple):
    """A spoken word.

    `text` is the user's own spelling; `labels` are its phonemes, none for a pause, whose text is
    the punctuation. `respelled` is how a voice had best read it, where that is not `text`;
    `unread` are the characters of it that the engine could not read; `stress` is that of each
    label, as in a schedule, and empty where the labels themselves carry the marks.
    """

    text: str
    labels: tuple[str, ...]
    respelled: str = ""
    unread: str = ""
    stress: tuple[int | None, ...] = ()


def merged(text: str, words: Sequence[SpokenWord], respelled: str = "") -> SpokenWord:
    """Merge words into one, with this spelling of the user's and for a voice."""
    marks = tuple(mark for word in words for mark in word.stress or (None,) * len(word.labels))
    labels = tuple(label for word in words for label in word.labels)
    unread = "".join(word.unread for word in words)
    return SpokenWord(text, labels, respelled, unread, marks if any(marks) else ())


class Rule(NamedTuple):
    """A rewrite: letters, their labels, and the required text after and before them."""

    spelling: str
    to: tuple[str, ...]
    before: str = ""
    """A regular expression that must match what follows."""
    after: str = ""
    """A regular expression that must match what precedes."""


class Correction(NamedTuple):
    """A correction: labels of an engine, their replacements, and contexts."""

    labels: tuple[str, ...]
    to: tuple[str, ...]
    before: str = ""
    """A regular expression that must match the labels that follow."""
    after: str = ""
    """A regular expression that must match the labels that precede."""
    spelled: str = ""
    """A regular expression that must be found in the word as it is written."""
    timings: bool = False
    """True to correct labels of timings too, which no engine wrote."""
    next_word: str = ""
    """A regular expression that must match the first label of the next word, before any pause."""
    capital: bool = False
    """True for words that begin with a capital letter alone."""


class MissingReaderError(SpeechError):
    """The library of an engine is not installed."""


@dataclass(frozen=True)
class Settings:
    """A language pack's settings of its engine: `g2p` of the pack as plain data.

    `language` is the pack's name, for messages; `labels` are those of the notation that comes out.
    `respell` names one of `RESPELLERS`, and `otherwise` the engine that reads where the library of
    the first is not installed. `foreign_voice` says words in Latin letters that the engine does not
    read, and `foreign` turns its sounds into labels. Words like the expression `native` are read.
    Capitals without one of the letters `vowels` are spelled.
    `backend` is phonemizer's, and `column` that of a profile with the sounds. `whole` are the
    pack's words in a script without spaces, which are not cut, each with its spelling, if any.
    """

    language: str
    voice: str | None = None
    code: str | None = None
    file: Path | None = None
    backend: str = ""
    column: str = ""
    rules: tuple[Rule, ...] = ()
    corrections: tuple[Correction, ...] = ()
    readings: tuple[Rule, ...] = ()
    labels: Collection[str] = ()
    respell: str | None = None
    otherwise: str | None = None
    foreign_voice: str = ""
    foreign: tuple[Rule, ...] = ()
    native: str = ""
    vowels: str = ""
    whole: tuple[tuple[str, str], ...] = ()


TONED = re.compile(r"[a-zêü:]+[0-5](?: [a-zêü:]+[0-5])*")
"""Syllables with tone digits, such as ``han4``: a reading, and no text with numbers."""


G2PEngine = Callable[[Sequence[str]], Iterable[Sequence[SpokenWord]]]
"""Function from texts to the words and pauses of each, in order."""

Respeller = Callable[[str], list[tuple[str, str]]]
"""Function from a text to its pieces, each with the spelling to read."""

Make = Callable[[Settings], G2PEngine]

_HERE = __package__

G2P_ENGINES: Extensions[Make] = Extensions(
    "g2p_engines",
    "G2P engine",
    modules={
        "espeak": f"{_HERE}.espeak_g2p",
        "pypinyin": f"{_HERE}.pinyin",
        "ipa": f"{_HERE}.ipa_text",
        "lexicon": f"{_HERE}.lexicon",
        "rules": f"{_HERE}.rules",
    },
)
"""Functions that make an engine from its settings, by name; `G2P_ENGINES.register` adds one."""

WHISPER = "\u0325"
"""Mark in respelled text of a vowel without voice. Labels may hold it; no voice reads it."""

RESPELLERS: Extensions[Respeller] = Extensions("respellers", "respeller")
"""Functions that respell text, by name."""
