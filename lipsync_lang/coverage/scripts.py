"""Words in a script that a language is not written in.

Which scripts a language is written in, its pack's own tests tell. What else stands in a line its
voice reads as another language's words, or it spells them, letter by letter. Which of the two is
found by asking for the letters alone. What is spelled, nobody would say that way; if somebody does,
a pronunciation of the pack's or the character's own says how.
"""

import re
from collections.abc import Iterable, Sequence
from difflib import SequenceMatcher
from functools import cache
from typing import TYPE_CHECKING
from unicodedata import category, name, normalize

from lipsync_lang.coverage.kinds import KINDS, Kinds
from lipsync_lang.coverage.report import OtherScript
from lipsync_lang.phonology.g2p.tokens import PAUSES, counts, pieces, plain

if TYPE_CHECKING:
    from lipsync_lang.lines import Line
    from lipsync_lang.packs.models.language_models import Language
    from lipsync_lang.speech.speaking import Speaker

Spans = list[tuple[int, int]]
"""Where parts of a text start and stop."""

LETTERS = frozenset(("Lu", "Ll", "Lt", "Lo"))

SPELLED = 0.9
"""How like its letters a phrase sounds at least where it is spelled: their names may be worn."""

JUDGED = 40
"""Characters by which a phrase is judged, and of a word that are named."""

_PHRASE = re.compile(r"([^- m])(?:(?:\1|[ m])*\1)?m*")
"""Over the classes of characters: one for each other script, `m` for marks, `-` for an end."""


@cache
def script(character: str) -> str:
    """Return the script of a letter, by the first word of its Unicode name; of others, nothing.

    A letter of another width or style is of the plain one's script.
    """
    if category(character) not in LETTERS:
        return ""
    return name(normalize("NFKC", character)[0], "").partition(" ")[0]


def scripts_of(language: "Language") -> frozenset[str]:
    """Return the scripts that a pack's own tests are written in."""
    return frozenset(script(c) for test in language.tests for c in test.text) - {""}


class OtherScripts:
    """The words in other scripts that lines have, and which of them are spelled.

    Parameters
    ----------
    speaker : who reads the lines
    own : the scripts that its language is written in; where none is known, there are no others
    """

    def __init__(self, speaker: "Speaker", own: Iterable[str]) -> None:
        self._speaker = speaker
        self._own = frozenset(own)
        self._classes: dict[str, str] = {}
        self._spells: dict[str, bool] = {}
        self._read, self._spelled = Kinds(), Kinds()

    def spelled(self, lines: "Sequence[Line]") -> list[Spans]:
        """Name the words of lines that are in other scripts; return where they are spelled."""
        spans = [self._phrases(line.text) for line in lines]
        self._judge(
            {
                _judged(line.text[slice(*span)])
                for line, found in zip(lines, spans, strict=True)
                for span in found
            }
        )
        return [
            [span for span in found if self._named(line.text[slice(*span)], line.place)]
            for line, found in zip(lines, spans, strict=True)
        ]

    def tallies(self) -> tuple[OtherScript, ...]:
        """Return the words, most frequent first."""
        found = [
            OtherScript(
                **tally.model_dump(),
                script=next(filter(None, map(script, tally.what))),
                counted=counted,
            )
            for kinds, counted in ((self._read, True), (self._spelled, False))
            for tally in kinds.tallies()
        ]
        return tuple(sorted(found, key=lambda one: (-one.count, one.what)))

    def _phrases(self, text: str) -> Spans:
        """Return where a text is in another script, with what lies between such words."""
        if not self._own or not any(map(self._foreign, set(text))):
            return []
        shape = "".join(map(self._class, text))
        return [found.span() for found in _PHRASE.finditer(shape)]

    def _foreign(self, character: str) -> bool:
        return script(character) not in ("", *self._own)

    def _class(self, character: str) -> str:
        if self._foreign(character):
            return self._classes.setdefault(script(character), chr(0xE000 + len(self._classes)))
        if script(character) or character in PAUSES:
            return "-"
        return "m" if counts(character) and not character.isdigit() else " "

    def _judge(self, phrases: set[str]) -> None:
        """Find out which phrases are spelled."""
        if len(self._spells) > KINDS:
            self._spells.clear()
        unmet = sorted(phrases - self._spells.keys())
        letters = sorted({c for phrase in unmet for c in phrase if counts(c)})
        heard = iter(self._speaker.transcribe((*unmet, *letters)) if unmet else ())
        said = [next(heard).phonemes for _ in unmet]
        names = {letter: next(heard).phonemes for letter in letters}
        for phrase, sounds in zip(unmet, said, strict=True):
            spelled = [sound for c in phrase for sound in names.get(c, ())]
            like = SequenceMatcher(None, sounds, spelled, autojunk=False).ratio()
            self._spells[phrase] = like >= SPELLED

    def _named(self, phrase: str, place: str) -> bool:
        """Name the words of a phrase, and tell whether it is spelled."""
        spelled = self._spells[_judged(phrase)]
        kinds = self._spelled if spelled else self._read
        for piece in pieces(phrase):
            if any(map(script, piece.text)) and plain(piece.text) not in self._speaker.manner.words:
                short = len(piece.text) <= JUDGED
                kinds.add(piece.text if short else piece.text[: JUDGED - 1] + "…", place)
        return spelled


def _judged(phrase: str) -> str:
    """Return what a phrase is judged by: small letters, for capitals may be meant to be spelled."""
    return phrase[:JUDGED].lower()
