"""Words of a script that most deserve an entry in the pack: those that a reader may misread.

A word is named if it has a letter that the texts of the pack never have, if it is a name, or if two
engines of the language read it differently. A capital within a sentence makes a name, unless the
script writes many other words so, as German does with its nouns, or writes the same word small.
"""

from collections.abc import Iterable
from dataclasses import replace

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.models.language_models import Language
from lipsync_lang.reports.coverage.report import EntryWord
from lipsync_lang.reports.coverage.scripts import script
from lipsync_lang.reports.coverage.tally_counter import TallyCounter
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.lines import Line
from lipsync_lang.text.phonology.g2p.tokens import pieces, plain

MAX_NAMES_SHARE = 0.15
"""Largest share of words with a capital within sentences; above it, a capital makes no name."""

MIN_JUDGED_WORDS = 50
"""Number of words within sentences from which on that share counts."""

MAX_COMPARED_WORDS = 2000
"""Number of words that two engines read for a comparison, the most frequent ones."""


def letters_of(language: Language) -> frozenset[str]:
    """Return the small letters that the texts of a pack have."""
    text = language.text
    written = [test.text for test in language.tests]
    written += [*language.examples.values(), *language.asides]
    written += [*(text.abbreviations.values() if text else ())]
    return frozenset(plain(" ".join(written)))


class EntryWords:
    """Counts of the words of lines that deserve an entry; none if `letters` are unknown."""

    def __init__(self, speaker: Speaker, letters: Iterable[str]) -> None:
        self._speaker = speaker
        self._letters = frozenset(letters)
        self._scripts = frozenset(map(script, self._letters)) - {""}
        self._foreign, self._names, self._all = TallyCounter(), TallyCounter(), TallyCounter()
        self._small: set[str] = set()
        self._within = 0

    def add(self, lines: Iterable[Line]) -> None:
        """Count the words of lines."""
        for line in lines if self._letters else ():
            within = False
            for piece in pieces(line.text):
                if piece.kind == "word" and not any(map(str.isdigit, piece.text)):
                    self._count(piece.text, line.place, within=within)
                within = piece.kind == "word"

    def _count(self, word: str, place: str, *, within: bool) -> None:
        folded = plain(word)
        self._within += within
        if folded == word:
            self._small.add(folded)
        if len(word) < len("Bo") or self._speaker.has_entry(word):
            return
        self._all.add(folded, place)
        strange = set(folded) - self._letters
        if any(script(letter) in self._scripts for letter in strange):
            self._foreign.add(word, place)
        elif within and word[0].isupper() and not word.isupper():
            self._names.add(word, place)

    def tallies(self) -> tuple[EntryWord, ...]:
        """Return the words with the reason of each, most frequent first."""
        names = [one for one in self._names.tallies() if plain(one.what) not in self._small]
        share = sum(one.count for one in names) / max(self._within, MIN_JUDGED_WORDS)
        if share > MAX_NAMES_SHARE:
            names = []
        found = [(one, "letters") for one in self._foreign.tallies()]
        found += [(one, "name") for one in names]
        named = {plain(one.what) for one, _ in found}
        differing = self._differing() - named
        found += [(one, "engines") for one in self._all.tallies() if one.what in differing]
        told = (EntryWord(**one.model_dump(), why=why) for one, why in found)
        return tuple(sorted(told, key=lambda one: (-one.count, one.what)))

    def _differing(self) -> frozenset[str]:
        """Words that the two engines of the language read differently; none if it has one."""
        manner = self._speaker.manner
        if manner.settings.otherwise in (None, manner.engine):
            return frozenset()
        settings = replace(manner.settings, otherwise=None)
        words = [one.what for one in self._all.tallies()[:MAX_COMPARED_WORDS]]
        heard = []
        for engine in (manner.engine, manner.settings.otherwise):
            other = type(self._speaker)(
                replace(manner, engine=engine, settings=settings), self._speaker.notations
            )
            try:
                heard.append([one.phonemes for one in other.transcribe(words)])
            except LipsyncError:
                return frozenset()  # the library of one engine is not installed
        pairs = zip(words, *heard, strict=True)
        return frozenset(word for word, one, another in pairs if one != another)
