"""Words of a corpus to look at: those in other scripts, and those that a reader may misread.

The scripts of a language are those of its pack's own tests. A voice reads a word in another script
as a word of another language, or it spells the word. A comparison of the sounds of the word with
those of its letters distinguishes the two. Actors do not spell, so spelled words are not counted; a
pronunciation in the pack or the character states their sounds.

A word deserves an entry in the pack if it has a letter that the texts of the pack never have, if it
is a name, or if two engines of the language read it differently. A capital within a sentence makes
a name, unless the script writes many other words so, as German does with its nouns, or writes the
same word small.
"""

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from difflib import SequenceMatcher
from functools import cache
from itertools import chain
from unicodedata import category, name, normalize

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.models.language_models import Language
from lipsync_lang.reports.coverage.report import EntryWord, OtherScript, Tally
from lipsync_lang.sound.speech.speaking.speaker import Speaker
from lipsync_lang.text.lines import Line
from lipsync_lang.text.phonology.g2p.tokens import PAUSES, counts, pieces, plain

MAX_TALLY_NAMES = 10_000
"""Maximum number of distinct names; later ones are dropped."""

MAX_JUDGED_PHRASES = 10_000
"""Maximum number of phrases to remember as spelled or not."""

TextSpans = list[tuple[int, int]]
"""Start and stop of each part of a text."""

LETTER_CATEGORIES = frozenset(("Lu", "Ll", "Lt", "Lo"))

SPELLED_SIMILARITY = 0.9
"""Minimum similarity of a spelled phrase to its letters; voices slur the names of letters."""

MAX_PHRASE_CHARS = 40
"""Maximum length of the judged start of a phrase, and of the named start of a word."""

_PHRASE = re.compile(r"([^- m])(?:(?:\1|[ m])*\1)?m*")
"""Pattern of a phrase in one other script, over the classes of characters.

Each other script has its own class; marks are `m`, ends are `-`, all else is a space.
"""

MAX_NAMES_SHARE = 0.15
"""Largest share of words with a capital within sentences; above it, a capital makes no name."""

MIN_JUDGED_WORDS = 50
"""Number of words within sentences from which on that share counts."""

MAX_COMPARED_WORDS = 2000
"""Number of words that two engines read for a comparison, the most frequent ones."""


class TallyCounter:
    """Count and first place of each name."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self._places: dict[str, str] = {}

    def add(self, what: str, place: str) -> None:
        """Count an occurrence."""
        if what in self._places or len(self._places) < MAX_TALLY_NAMES:
            self._counts[what] += 1
            self._places.setdefault(what, place)

    def tallies(self) -> tuple[Tally, ...]:
        """Return the counts, most frequent first."""
        order = sorted(self._counts.items(), key=lambda item: (-item[1], item[0]))
        return tuple(Tally(what=what, count=n, place=self._places[what]) for what, n in order)


@cache
def script(character: str) -> str:
    """Return the script of a letter from its Unicode name; empty for other characters.

    The script is the first word of that name; other widths and styles count as the plain letter.
    """
    if category(character) not in LETTER_CATEGORIES:
        return ""
    # NFKC, since the names of full-width and mathematical letters begin with their style.
    return name(normalize("NFKC", character)[0], "").partition(" ")[0]


def scripts_of(language: Language) -> frozenset[str]:
    """Return the scripts of a pack's own tests."""
    return frozenset(script(c) for test in language.tests for c in test.text) - {""}


class OtherScripts:
    """Words of lines in other scripts, read or spelled; none if `own` scripts are unknown."""

    def __init__(self, speaker: Speaker, own: Iterable[str]) -> None:
        self._speaker = speaker
        self._own = frozenset(own)
        self._classes: dict[str, str] = {}
        self._spells: dict[str, bool] = {}
        self._read, self._spelled = TallyCounter(), TallyCounter()

    def spelled(self, lines: Sequence[Line]) -> list[TextSpans]:
        """Count the words of lines in other scripts; return the spans of spelled words."""
        spans: list[TextSpans] = []
        for line in lines:
            foreign = self._own and any(map(self._foreign, set(line.text)))
            shape = "".join(map(self._class, line.text)) if foreign else ""
            spans.append([match.span() for match in _PHRASE.finditer(shape)])
        pairs = [(line, span) for line, found in zip(lines, spans, strict=True) for span in found]
        self._judge({_judged(line.text[slice(*span)]) for line, span in pairs})
        spelled_spans: list[TextSpans] = [[] for _ in lines]
        for line, found, spelled in zip(lines, spans, spelled_spans, strict=True):
            for span in found:
                phrase = line.text[slice(*span)]
                is_spelled = self._spells[_judged(phrase)]
                spelled.extend([span] if is_spelled else [])
                for word in (piece.text for piece in pieces(phrase)):
                    if any(map(script, word)) and not self._speaker.has_entry(word):
                        short = len(word) <= MAX_PHRASE_CHARS
                        what = word if short else word[: MAX_PHRASE_CHARS - 1] + "…"
                        (self._spelled if is_spelled else self._read).add(what, line.place)
        return spelled_spans

    def tallies(self) -> tuple[OtherScript, ...]:
        """Return the words, most frequent first."""
        found = []
        for counter in (self._read, self._spelled):
            for tally in counter.tallies():
                own = next(filter(None, map(script, tally.what)))
                stated = {"script": own, "counted": counter is self._read}
                found.append(OtherScript(**tally.model_dump(), **stated))
        return tuple(sorted(found, key=lambda one: (-one.count, one.what)))

    def _foreign(self, character: str) -> bool:
        return script(character) not in ("", *self._own)

    def _class(self, character: str) -> str:
        if self._foreign(character):
            return self._classes.setdefault(script(character), chr(0xE000 + len(self._classes)))
        if script(character) or character in PAUSES:
            return "-"
        return "m" if counts(character) and not character.isdigit() else " "

    def _judge(self, phrases: set[str]) -> None:
        """Remember whether the voice spells each phrase."""
        if len(self._spells) > MAX_JUDGED_PHRASES:
            self._spells.clear()
        unmet = sorted(phrases - self._spells.keys())
        letters = sorted({c for phrase in unmet for c in phrase if counts(c)})
        heard = iter(self._speaker.transcribe((*unmet, *letters)) if unmet else ())
        said = [next(heard).phonemes for _ in unmet]
        names = {letter: next(heard).phonemes for letter in letters}
        for phrase, sounds in zip(unmet, said, strict=True):
            spelled = [sound for c in phrase for sound in names.get(c, ())]
            # `autojunk` would ignore frequent sounds of phrases of 200 and more.
            like = SequenceMatcher(None, sounds, spelled, autojunk=False).ratio()
            self._spells[phrase] = like >= SPELLED_SIMILARITY


def _judged(phrase: str) -> str:
    """Return the start of a phrase in lower case, because voices may spell capitals."""
    return phrase[:MAX_PHRASE_CHARS].lower()


def letters_of(language: Language) -> frozenset[str]:
    """Return the small letters that the texts of a pack have."""
    text = language.text
    written = [one.text for one in language.tests] + [*language.examples.values(), *language.asides]
    if text:
        said = chain.from_iterable(words.values() for words in text.lists.values())
        written += [*text.abbreviations.values(), *text.ranks.values(), *filter(None, said)]
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
        # At the end, because the same word may be written small after its first capital.
        names = [one for one in self._names.tallies() if plain(one.what) not in self._small]
        share = sum(one.count for one in names) / max(self._within, MIN_JUDGED_WORDS)
        if share > MAX_NAMES_SHARE:
            names = []
        found = [(one, "letters") for one in self._foreign.tallies()]
        found += [(one, "name") for one in names]
        differing = self._differing() - {plain(one.what) for one, _ in found}
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
            other = replace(manner, engine=engine, settings=settings)
            try:
                speaker = type(self._speaker)(other, self._speaker.notations)
                heard.append([one.phonemes for one in speaker.transcribe(words)])
            except LipsyncError:
                return frozenset()  # the library of one engine is not installed
        pairs = zip(words, *heard, strict=True)
        return frozenset(word for word, one, another in pairs if one != another)
