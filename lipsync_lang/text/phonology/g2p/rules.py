"""Spelling to phonemes by ordered rewrites, which a language pack states itself.

At each place of a word the rules are tried in order, and the first that fits takes its letters:
its spelling stands here, its `after` matches what precedes, its `before` what follows. Where none
fits, the longest label of the notation that stands here is taken as it is, so that letters
that are labels need no rule. What still is not read is left over, and named.

Words are compared composed and in small letters. A context is a regular expression over the
word's own letters (see `contexts`): ``^`` in `after` is the start of the word, ``$`` in `before`
its end.

Readings, which a pack states syllable by syllable, count where their letters are whole words of a
text, and their contexts fit around them.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from functools import lru_cache
from itertools import accumulate, chain
from typing import NamedTuple

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.text.phonology.g2p.contexts import MAX_STEPS_PER_LETTER, Surroundings
from lipsync_lang.text.phonology.g2p.g2p_engines import (
    G2P_ENGINES,
    RESPELLERS,
    WHISPER,
    G2PEngine,
    Rule,
    Settings,
    SpokenWord,
    merged,
)
from lipsync_lang.text.phonology.g2p.tokens import plain, read_words
from lipsync_lang.text.phonology.labels import normalise

SLOW = "and those before it with the same first letter could take too long"
QUICKER = "use fewer rules for the letter, or fewer repeats in their contexts"

_LATIN_WORD = re.compile("[A-Za-zÀ-ɏ][A-Za-zÀ-ɏ'-]*")

CACHED_WORDS = 20_000
"""Maximum number of cached readings of words."""


class _CompiledRule(NamedTuple):
    number: int
    spelling: str
    to: tuple[str, ...]
    around: Surroundings

    def fits(self, word: str, at: int) -> bool:
        """Return True if the rule applies at a place of a word."""
        stop = at + len(self.spelling)
        return word.startswith(self.spelling, at) and self.around.fit(word, at, stop)


class Rewriter:
    """Compiled rules; raise `SpeechError` for a context that is unusable, or too slow."""

    def __init__(self, rules: Iterable[Rule], labels: Iterable[str] = ()) -> None:
        self._rules: dict[str, list[_CompiledRule]] = {}
        self._labels: dict[str, list[tuple[str, str]]] = {}
        rules = tuple(rules)
        for number in too_slow(rules):
            raise SpeechError(f"rule {number + 1} ('{rules[number].spelling}') {SLOW}; {QUICKER}")
        for number, rule in enumerate(rules):
            made = _compile(number, rule)
            self._rules.setdefault(made.spelling[:1], []).append(made)
        for label in labels:
            # a keyboard has `g`, and no `ɡ`
            for letters in filter(None, dict.fromkeys((plain(label), plain(normalise(label))))):
                self._labels.setdefault(letters[0], []).append((letters, label))
        for known in self._labels.values():
            known.sort(key=lambda pair: -len(pair[0]))
        self.read = lru_cache(CACHED_WORDS)(self._read)

    def _read(self, word: str) -> SpokenWord:
        """Return a word with its labels, and the characters left over."""
        steps = [*self.steps(word)]
        labels = tuple(label for _, made, _ in steps for label in made or ())
        left = (letters for _, made, letters in steps if made is None)
        return SpokenWord(word, labels, unread="".join(filter(str.isalnum, chain(*left))))

    def steps(self, word: str) -> Iterator[tuple[int | None, tuple[str, ...] | None, str]]:
        """Yield (number of the rule or None, labels or None, letters) along a word."""
        word = plain(word)
        at = 0
        while at < len(word):
            rule = next((one for one in self._rules.get(word[at], ()) if one.fits(word, at)), None)
            if rule is not None:
                yield rule.number, rule.to, rule.spelling
                at += len(rule.spelling)
                continue
            known = self._labels.get(word[at], ())
            found = next((one for one in known if word.startswith(one[0], at)), None)
            letters, label = found or (word[at], None)
            yield None, None if label is None else (label,), letters
            at += len(letters)


def _compile(number: int, rule: Rule) -> _CompiledRule:
    where = f"rule {number + 1} ('{rule.spelling}'): its context"
    around = Surroundings.compiled(rule.before, rule.after, where)
    return _CompiledRule(number, plain(rule.spelling), rule.to, around)


@G2P_ENGINES.register("rules")
def engine(settings: Settings) -> G2PEngine:
    """Read text with the rules of a pack."""
    rewriter = Rewriter(settings.rules, settings.labels)
    readings = Rewriter(settings.readings)
    respell = RESPELLERS.find(settings.respell, SpeechError) if settings.respell else None
    foreign = ForeignReader(settings)

    def read(texts: Sequence[str]) -> Iterator[tuple[SpokenWord, ...]]:
        if settings.foreign:
            latin = (word for text in texts for word in _LATIN_WORD.findall(text) if word[1:])
            whole = (word.lower() for word in latin if not foreign.spelled(word))
            foreign.ahead(whole if settings.readings else latin)
        for text in texts:
            yield tuple(_read(text))

    def _read_word(word: str) -> SpokenWord:
        # With readings, `_by_syllables` has asked the voice already.
        labels = () if settings.readings or len(word) == 1 else foreign(word)
        if labels and "-" in word:  # nag-upload
            return merged(word, [_read_word(part) for part in word.split("-") if part], word)
        return SpokenWord(word, labels) if labels else rewriter.read(word)

    def _read(text: str) -> Iterator[SpokenWord]:
        if respell is None:
            yield from read_words(text, _read_word)
            return
        for piece, respelled in respell(text):
            spelling = _by_syllables(piece, respelled, readings, foreign)
            words = read_words(spelling, _read_word)
            if any(word.labels for word in words):
                yield merged(piece, words, spelling.replace(WHISPER, ""))
            else:
                yield from (word._replace(text=piece) for word in words[:1])

    return read


class ForeignReader:
    """Reader of words in Latin letters: the labels of their sounds in another voice.

    A word has none if there is no such voice, or if it cannot say the word.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._rewriter = Rewriter(settings.foreign, settings.labels)
        self._native = Surroundings.compiled(f"(?:{settings.native})$", "", "`native`")
        self._known: dict[str, tuple[str, ...]] = {}
        vowels = re.escape(settings.vowels.upper())
        self.spelled = re.compile(f"[^a-z]{{,3}}|[^a-z{vowels}]+").fullmatch
        """Match capitals that are spelled: few, or without a vowel; `FAILED` is a word."""

    def __call__(self, word: str) -> tuple[str, ...]:
        """Return the labels of a word."""
        self.ahead([word])
        return self._known[word]

    def ahead(self, words: Iterable[str]) -> None:
        """Read words together: to start the voice takes longer than to say hundreds of them."""
        if len(self._known) > CACHED_WORDS:
            self._known.clear()
        unmet = [word for word in dict.fromkeys(words) if word not in self._known]
        self._known |= dict.fromkeys(unmet, ())
        self._say([word for word in unmet if self._is_foreign(word)])

    def _is_foreign(self, word: str) -> bool:
        parts = re.split("[-']", plain(word)) if self._settings.native else [""]
        native = any(parts) and all(self._native.fit(part, 0, 0) for part in parts)
        return bool(self._settings.foreign and _LATIN_WORD.fullmatch(word)) and not native

    def _say(self, words: Sequence[str]) -> None:
        voice = Settings(self._settings.language, self._settings.foreign_voice)
        try:
            said = [*G2P_ENGINES.find("espeak", SpeechError)(voice)(words)] if words else []
        except SpeechError:
            for word in words if len(words) > 1 else ():  # one of them may be at fault
                self._say([word])
            return
        for word, parts in zip(words, said, strict=True):
            found = self._rewriter.read("".join(label for one in parts for label in one.labels))
            self._known[word] = () if found.unread else found.labels


def too_slow(rules: Sequence[Rule]) -> Iterator[int]:
    """Yield each rule that brings the steps of its first letter above the limit."""
    steps: dict[str, int] = {}
    for number, rule in enumerate(rules):
        made = _compile(number, rule)
        letter = made.spelling[:1]
        before = steps.get(letter, 0)
        steps[letter] = before + sum(side.steps for side in made.around if side)
        if before <= MAX_STEPS_PER_LETTER < steps[letter]:
            yield number


def never_fire(rules: Sequence[Rule]) -> Iterator[tuple[int, int]]:
    """Yield (rule, earlier rule) for each rule that an earlier one always preempts.

    The earlier rule does so if its spelling is a prefix of the other's, and its contexts demand
    nothing that the other's do not.
    """
    first: dict[tuple[str, str, str], int] = {}
    for number, rule in enumerate(rules):
        spelling = plain(rule.spelling)
        wider = [(spelling[:end], "") for end in range(len(spelling) + 1)]
        found = [
            first[start, after, before]
            for start, before in (*wider, (spelling, rule.before))
            for after in ("", rule.after)
            if (start, after, before) in first
        ]
        if found:
            yield number, min(found)
        first.setdefault((spelling, rule.after, rule.before), number)


def _by_syllables(word: str, respelled: str, readings: Rewriter, foreign: ForeignReader) -> str:
    """Return the readings of a word that its respelling spells by letters; else the respelling.

    A word without readings has those of its sounds in another voice.
    Names of letters are longer than the word; they are kept if it is an abbreviation.
    """
    if len(respelled) <= len(word) or foreign.spelled(word):
        return respelled
    read = readings.read(word)
    if read.unread:
        read = readings.read("".join(foreign(word.lower())))
    return respelled if read.unread else "".join(read.labels) or respelled


class StatedReading(NamedTuple):
    """A stated reading: its letters, their syllables, and the contexts on both sides."""

    letters: str
    syllables: tuple[str, ...]
    around: Surroundings


def compiled_readings(readings: Sequence[Rule]) -> tuple[StatedReading, ...]:
    """Compile the readings of a pack, which have one syllable for each character."""
    made: list[StatedReading] = []
    for number, rule in enumerate(readings, start=1):
        where = f"reading {number} ('{rule.spelling}')"
        if len(rule.to) != len(rule.spelling):
            what = f"has {len(rule.to)} syllables for {len(rule.spelling)} characters"
            raise SpeechError(f"{where} {what}; state one for each")
        around = Surroundings.compiled(rule.before, rule.after, f"{where}:")
        made.append(StatedReading(rule.spelling, rule.to, around))
    return tuple(made)


def stated_syllables(
    text: str, phrases: Sequence[str], readings: Sequence[StatedReading]
) -> dict[int, str]:
    """Return the stated syllable of each character that has one, by its place."""
    ends = {0, *accumulate(map(len, phrases))}
    found: dict[int, str] = {}
    for letters, syllables, around in readings:
        for place in re.finditer(f"(?={re.escape(letters)})", text):
            start, stop = place.start(), place.start() + len(letters)
            if {start, stop} <= ends and start not in found and around.fit(text, start, stop):
                found |= dict(zip(range(start, stop), syllables, strict=True))
    return found
