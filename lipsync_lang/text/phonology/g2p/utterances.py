"""Reading of texts in parts, cut at interjections, stutters, abbreviations and similar forms.

An engine reads the parts of a text that are ordinary words; the rest has its sounds from the pack,
or from the word that a stutter repeats. All words come back in the user's spelling.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from itertools import groupby
from typing import NamedTuple
from unicodedata import name

from lipsync_lang.base.errors import SpeechError
from lipsync_lang.text.phonology.g2p.abbreviation_keys import Expansions, is_spaced
from lipsync_lang.text.phonology.g2p.censored import uncensored
from lipsync_lang.text.phonology.g2p.drawn_out import (
    MAX_STUTTER_CHARS,
    SYLLABIC,
    ElongatedWord,
    IsVowel,
    begins,
    drawn_out,
    lengthened,
    ordinary_spellings,
    respelled_start,
    spelled_out,
    start_labels,
    starts_of,
)
from lipsync_lang.text.phonology.g2p.g2p_engines import SpokenWord, merged
from lipsync_lang.text.phonology.g2p.own_words import OwnWords
from lipsync_lang.text.phonology.g2p.rare_letters import RareLetters
from lipsync_lang.text.phonology.g2p.spoken_forms import OwnWord, SpokenForms
from lipsync_lang.text.phonology.g2p.tokens import (
    PAUSES,
    Replacement,
    TextPiece,
    pieces,
    plain,
    respelled,
)

_LEAD = frozenset((*PAUSES, *" \t\r\n\u00a0\u202f\u3000-·"))
"""Characters at the start of a part that only part it from the one before."""

_STUTTER_SIGN = re.compile(r"[-\u2010\u2011…]|\.\.|(\w)\1\1", re.IGNORECASE)
"""Signs of a stutter or of a word drawn out."""

_LONE_LETTER = re.compile(r"(?<![\w'’])[^\W\d_](?=[ \u00a0]$)")
"""A word of one letter, such as the Russian `в`, at the end of a part."""

MAX_HALTS = 10
"""Maximum number of starts of a word, each with an ellipsis."""

SpokenWords = tuple[SpokenWord, ...]
ReadTexts = Callable[[Sequence[str]], Sequence[SpokenWords | SpeechError]]
"""Read texts at once: for each its words, or its error."""


class UtterancePart(NamedTuple):
    """A part of a text: an interjection, or words for the engine with a first word of its own.

    `replacements` are parts of it that are read by another spelling, `starts` the repeated starts
    of the first word, each with the pause after it.
    """

    text: str
    replacements: tuple[Replacement, ...] = ()
    said: SpokenWord | None = None
    starts: tuple[tuple[str, str], ...] = ()
    drawn: ElongatedWord | None = None


class _PartStart(NamedTuple):
    """A place where a part begins: the part without its text, and where its text ends at most."""

    start: int
    stop: int
    part: UtterancePart


class Utterances:
    """A reader of texts with interjections, stutters and abbreviations.

    `words` have a pronunciation of their own, and are not interjections. `rare` are letters that
    the engine lacks.
    """

    def __init__(
        self,
        forms: SpokenForms,
        words: Mapping[str, object],
        is_vowel: IsVowel,
        rare: RareLetters | None = None,
    ) -> None:
        self._forms, self._words, self._is_vowel = forms, words, is_vowel
        self._interjections = Interjections(forms.interjections, is_vowel, forms.vowels)
        self._expansions = Expansions(forms)
        self._rare = rare
        self._capital_i = "İ" if "ı" in "".join(forms.abbreviations.values()) else "I"
        self._own = OwnWords(forms)
        self._ordinary = ordinary_spellings(forms.doubled)
        self._hyphenated = frozenset(map(plain, forms.hyphenated))

    def read(self, texts: Sequence[str], read: ReadTexts) -> list[SpokenWords | SpeechError]:
        """Read texts; the engine reads their ordinary parts at once."""
        cut = [self.cut(text) for text in texts]
        plainly = [
            text if _is_whole(parts, text) else part_text(part)
            for text, parts in zip(texts, cut, strict=True)
            for part in parts
        ]
        unmet = [text for text in dict.fromkeys(plainly) if text]
        found = dict(zip(unmet, read(unmet), strict=True)) if unmet else {}
        return [
            found.get(text, ()) if _is_whole(parts, text) else self._joined(parts, found)
            for text, parts in zip(texts, cut, strict=True)
        ]

    def has_entry(self, word: str) -> bool:
        """Return True for a word that the pack reads its own way."""
        own = self._own.found_in(word, pieces(word))
        return bool(own.said or own.respelled)

    def ordinary(self, text: str) -> bool:
        """Return True for a text that the engine reads without changes."""
        return _is_whole(self.cut(text), text)

    def cut(self, text: str) -> list[UtterancePart]:
        """Cut a text into parts; together they are the text."""
        tokens = list(pieces(text))
        own = self._own.found_in(text, tokens)
        expanded = _apart(list(uncensored(text, self._forms)), self._expansions.find(text))
        # Expansions may have words of the pack in them.
        expanded = [one._replace(read=self._own.respelled(one.read)) for one in expanded]
        said, expanded = _beside_said(own.said, expanded)
        replaced = _apart(own.respelled, expanded)
        if self._rare is not None:
            replaced = _apart(replaced, list(self._rare.found_in(text)))
        replaced = _as_loud(text, replaced, self._capital_i) if text.isupper() else replaced
        parts: list[UtterancePart] = []
        at, open_part = 0, UtterancePart("")
        for start, stop, part in self._cuts(text, tokens, replaced, said):
            if start > at:
                parts += _filled(open_part, text, at, start, replaced)
            at, open_part = start, part
            if part.said is not None:
                last = parts[-1] if parts else open_part
                lone = _LONE_LETTER.search(last.text)
                covered = max((one.stop for one in last.replacements), default=0)
                if lone and covered <= lone.start() and is_spaced(lone[0]):
                    # an engine would name a letter without a word or a hyphen behind it
                    hyphen = Replacement(lone.end(), lone.end(), "\u2010")
                    parts[-1] = last._replace(replacements=(*last.replacements, hyphen))
                parts.append(part)
                at, open_part = stop, UtterancePart("")
        if at < len(text) or not parts:
            parts += _filled(open_part, text, at, len(text), replaced)
        return parts or [UtterancePart(text)]

    def _cuts(
        self,
        text: str,
        tokens: Sequence[TextPiece],
        replaced: Sequence[Replacement],
        own: Mapping[int, SpokenWord],
    ) -> Iterator[_PartStart]:
        shouted = text.upper() == text
        within = {p for one in replaced for p in range(one.start, one.stop)}
        odd = bool(_STUTTER_SIGN.search(text))
        done = 0
        for number, token in enumerate(tokens):
            said = [at for at in own if 0 <= at - token.start < len(token.text)]
            for at in said:
                done = at + len(own[at].text)
                yield _PartStart(at, done, UtterancePart(own[at].text, said=own[at]))
            if said:
                continue
            if not (odd or self._interjections.possible(token.text)):
                continue
            if token.kind != "word" or token.start < done or token.start in within:
                continue
            if self._words and plain(token.text) in self._words:
                continue
            found = self._cut_at(tokens, number, shouted=shouted)
            # the `III` of 路易XVIII and `a III-a` is no sound drawn out
            numeral = found and found.part.drawn and not within.isdisjoint(range(*found[:2]))
            if found is not None and not numeral:
                yield found
                done = found.stop

    def _cut_at(
        self, tokens: Sequence[TextPiece], number: int, *, shouted: bool
    ) -> _PartStart | None:
        """Return the part that begins with a word; None if the word is ordinary."""
        token = tokens[number]
        start, stop = token.start, token.start + len(token.text)
        # Letters behind a number are a unit: `5 mm` is no "mm".
        counted = number and tokens[number - 1].text[-1].isdigit() and not token.text[0].isdigit()
        if not counted and (said := self._interjections.find(token.text, shouted=shouted)):
            return _PartStart(start, stop, UtterancePart(token.text, said=said))
        if starts := starts_of(token.text, self._forms.vowels, self._hyphenated):
            length = sum(len(one) + 1 for one in starts)
            gone = Replacement(0, length, "")
            part = UtterancePart("", (gone,), starts=tuple((s, "") for s in starts))
            return _PartStart(start, stop, part)
        if halting := tuple(self._halting(tokens[number : number + 2 * MAX_HALTS + 1])):
            word = tokens[number + 2 * len(halting)].start
            gone = Replacement(0, word - start, "")
            return _PartStart(start, word, UtterancePart("", (gone,), starts=halting))
        if drawn := drawn_out(token.text, self._ordinary):
            instead = Replacement(0, len(token.text), drawn.word)
            return _PartStart(start, stop, UtterancePart("", (instead,), drawn=drawn))
        return None

    def _halting(self, tokens: Sequence[TextPiece]) -> list[tuple[str, str]]:
        """Return the starts before an ellipsis that the word after it repeats: `B... but`."""
        starts: list[tuple[str, str]] = []
        token = tokens[0]
        if len(tokens) < len("b…b") or len(token.text) > MAX_STUTTER_CHARS:
            return starts
        for pause, word in zip(tokens[1::2], tokens[2::2], strict=False):
            ellipsis = pause.kind == "pause" and set(pause.text) <= set(".…") and pause.text != "."
            if not (ellipsis and word.kind == "word" and begins(token.text, word.text)):
                return []
            starts.append((token.text, pause.text))
            if len(token.text) < len(word.text):
                return starts if spelled_out(token.text, self._forms.vowels) else []
            token = word
        return []

    def _joined(
        self, parts: Sequence[UtterancePart], found: Mapping[str, SpokenWords | SpeechError]
    ) -> SpokenWords | SpeechError:
        """Join the words of the parts of a text."""
        out: list[SpokenWord] = []
        for part in parts:
            words = found.get(part_text(part), ())
            if isinstance(words, SpeechError):
                return words
            marks = list(pieces(part.text))
            # the dots of `.com` and `5. ` are words
            spoken = {end for one in part.replacements for end in (one.start, one.stop)}
            lead = [mark for mark in marks[:1] if mark.kind == "pause" and 0 not in spoken]
            tail = [mark for mark in marks[1:][-1:] if mark.kind == "pause"]
            tail = [] if len(part.text.rstrip()) in spoken else tail
            first, last = ([SpokenWord(one.text, ()) for one in side] for side in (lead, tail))
            for word in (*first, *self._words_of(part, words), *last):
                if word.labels or word.unread or not (out and _is_pause(out[-1])):
                    out.append(word)
        while out and _is_pause(out[-1]):
            out.pop()
        return tuple(out)

    def _words_of(self, part: UtterancePart, words: SpokenWords) -> Iterator[SpokenWord]:
        if part.said is not None:
            yield part.said
            return
        mapped = _original(part, words)
        first = next((n for n, word in enumerate(mapped) if word.labels), None)
        if first is None:
            yield from mapped
            return
        vowels = self._forms.vowels
        # a sign that is read, such as `=`, is no word
        word = next((one.text for one in pieces(part_text(part)) if one.kind == "word"), "")
        yield from mapped[:first]
        for start, pause in part.starts:
            labels = start_labels(start, word, mapped[first].labels, self._is_vowel, vowels)
            say = respelled_start(start, word, vowels)
            yield SpokenWord(start + "-" * (not pause), labels, say)
            yield from [SpokenWord(pause, ())] if pause else []
        if part.drawn is not None:
            mapped[first] = lengthened(mapped[first], part.drawn, self._is_vowel, vowels)
        yield from mapped[first:]


def _is_whole(parts: Sequence[UtterancePart], text: str) -> bool:
    """Return True for a text that is one ordinary part."""
    return len(parts) == 1 and parts[0] == UtterancePart(text)


def part_text(part: UtterancePart) -> str:
    """Return the text of a part for the engine; empty for interjections and for pauses alone."""
    if part.said is not None:
        return ""
    read = respelled(part.text, part.replacements)
    return read if any(piece.kind != "pause" for piece in pieces(read)) else ""


def _filled(
    part: UtterancePart, text: str, start: int, stop: int, replaced: Sequence[Replacement]
) -> Iterator[UtterancePart]:
    """Yield a part with its text and the replacements in it.

    Pauses at its start are a part of their own: a voice would say "comma".
    """
    read = {one.start for one in replaced}
    lead = next((n for n in range(start, stop) if text[n] not in _LEAD or n in read), stop)
    lead = lead if start else start
    if lead > start:
        yield UtterancePart(text[start:lead])
    inside = tuple(
        Replacement(one.start - lead, one.stop - lead, one.read)
        for one in replaced
        if lead <= one.start and one.stop <= stop
    )
    if lead < stop:
        yield part._replace(text=text[lead:stop], replacements=(*part.replacements, *inside))


def _apart(own: list[Replacement], others: list[Replacement]) -> list[Replacement]:
    """Return all replacements in order; one gives way to an own word unless it holds more."""
    taken = {place: one for one in own for place in range(one.start, one.stop)}
    kept = set(own)
    for one in others:
        touched = {taken[place] for place in range(one.start, one.stop) if place in taken}
        if all(mine.stop - mine.start < one.stop - one.start for mine in touched):
            kept -= touched
            kept.add(one)
    return sorted(kept)


def _as_loud(text: str, replaced: list[Replacement], capital_i: str) -> list[Replacement]:
    """Return the replacements in capitals if they stand beside other words in capitals.

    An engine would spell `ΤΟ` between small letters.
    """
    if not respelled(text, [one._replace(read="") for one in replaced]).isupper():
        return replaced
    return [one._replace(read=one.read.replace("i", capital_i).upper()) for one in replaced]


def _beside_said(
    said: Mapping[int, SpokenWord], others: Sequence[Replacement]
) -> tuple[dict[int, SpokenWord], list[Replacement]]:
    """Return words with labels and the replacements beside them: `2 Jobs` is `zwei` and `Jobs`.

    A longer replacement that does not keep such a word at its end or start takes its place.
    """
    kept, apart = dict(said), list(others)
    for at, word in said.items():
        end = at + len(word.text)
        for n, (start, stop, read) in enumerate(apart):
            if not (start <= at and end <= stop and end - at < stop - start):
                continue
            if end == stop and read.endswith(word.text):
                apart[n] = Replacement(start, at, read.removesuffix(word.text))
            elif start == at and read.startswith(word.text):
                apart[n] = Replacement(end, stop, read.removeprefix(word.text))
            else:
                del kept[at]
    return kept, apart


def _is_pause(word: SpokenWord) -> bool:
    return not word.labels and not word.unread


def _original(part: UtterancePart, words: SpokenWords) -> list[SpokenWord]:
    """Return words in the user's spelling; the words of one replacement are one."""
    if not part.replacements:
        return list(words)
    read = part_text(part)
    origin: list[tuple[int, int]] = []  # start and stop of each read character in the user's text
    at = 0
    for one in part.replacements:
        origin += [(n, n + 1) for n in range(at, one.start)]
        origin += [(one.start, one.stop)] * len(one.read)
        at = one.stop
    origin += [(n, n + 1) for n in range(at, len(part.text))]
    out: list[SpokenWord] = []
    at = begin = end = 0
    for word in words:
        place = -1 if _is_pause(word) else read.find(word.text, at)
        if place < 0:
            out.append(word)
            continue
        at = place + len(word.text)
        start, stop = origin[place][0], origin[at - 1][1]
        if start < end and any(not _is_pause(one) for one in out):
            while _is_pause(out[-1]):
                out.pop()
            spoken = " ".join(one.respelled or one.text for one in (out[-1], word))
            out[-1] = merged(part.text[begin : max(end, stop)], (out[-1], word), spoken)
        else:
            begin, text = start, part.text[start:stop]
            spoken = word.respelled or word.text
            out.append(word if text == word.text else word._replace(text=text, respelled=spoken))
        end = max(end, stop)
    return out


class _Pattern(NamedTuple):
    """A shortest spelling as an expression with a group for each letter; or one for a part."""

    whole: re.Pattern[str]
    part: re.Pattern[str] | None
    runs: tuple[int, ...]
    interjection: OwnWord


class Interjections:
    """A finder of interjections (`Mmm`, `Hahaha`) by their shortest spelling.

    A letter may be repeated, and its sound lasts longer then; one part twice (`haha`), as a whole.
    `vowels` are letters.
    """

    def __init__(self, known: Mapping[str, OwnWord], is_vowel: IsVowel, vowels: str) -> None:
        self._is_vowel, self._vowels = is_vowel, vowels
        self._known: dict[str, list[tuple[str, OwnWord]]] = {}
        self._starts: set[str] = set()
        # The longest first: `hmm` is no `hm` drawn out.
        for spelling, interjection in sorted(known.items(), key=lambda item: -len(item[0])):
            folded = plain(spelling)
            self._known.setdefault(folded[0], []).append((folded, interjection))
            letters = [letter for letter, _ in groupby(folded)]
            # A first letter that is drawn out stands there twice.
            self._starts |= {folded[0] * 2, "".join(letters[:2])}

    def possible(self, token: str) -> bool:
        """Return False for a word without hyphens that is surely no interjection."""
        return token[:2].casefold() in self._starts

    def find(self, token: str, *, shouted: bool = False) -> SpokenWord | None:
        """Return a word read as an interjection; None for any other word.

        Capitals alone are an abbreviation, unless the whole text is `shouted` in capitals.
        """
        word = plain(token)
        if "-" in word:
            parts = [self.find(part) for part in word.split("-") if part]
            said = [one for one in parts if one is not None]
            if said and len(said) == len(parts):
                return merged(token, said, " ".join(one.respelled for one in said))
        for spelling in dict.fromkeys((word, word.replace("-", ""))):
            for known in self._known.get(spelling[:1], ()):
                pattern = _pattern(*known)
                found = pattern.whole.fullmatch(spelling)
                if not found:
                    continue
                drawn = [len(one) - n for one, n in zip(found.groups(), pattern.runs, strict=True)]
                if token.isupper() and len(token) > 1 and not (shouted or any(drawn)):
                    continue
                return self._said(token, spelling, pattern, drawn)
        return None

    def _said(self, token: str, spelling: str, pattern: _Pattern, drawn: list[int]) -> SpokenWord:
        labels, say = pattern.interjection
        said = SpokenWord(token, labels, say or re.sub(r"(.)\1{2,}", r"\1", spelling))
        if pattern.part is not None:
            count = len(pattern.part.findall(spelling))
            return said._replace(labels=labels[: len(labels) // 2] * count)
        runs = tuple((place, more) for place, more in enumerate(drawn) if more)
        word = "".join(letter for letter, _ in groupby(spelling))
        return lengthened(said, ElongatedWord(word, runs), self._is_vowel, self._vowels)


@cache  # few texts need them
def _pattern(spelling: str, interjection: OwnWord) -> _Pattern:
    half = spelling[: len(spelling) // 2]
    syllable = name(half[:1] or spelling, "").startswith(SYLLABIC)
    if half * 2 == spelling and (len(set(half)) > 1 or syllable):
        more = "" if syllable else "+"  # a syllable again is said again
        unit = "".join(f"{re.escape(letter)}{more}" for letter, _ in groupby(half))
        whole = re.compile(f"(?:{unit}){{2,}}(?:{re.escape(half[0])}+)?")
        return _Pattern(whole, re.compile(unit), (), interjection)
    runs = [(letter, len(list(run))) for letter, run in groupby(spelling)]
    whole = re.compile("".join(f"({re.escape(letter)}{{{n},}})" for letter, n in runs))
    return _Pattern(whole, None, tuple(n for _, n in runs), interjection)
