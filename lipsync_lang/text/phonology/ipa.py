"""IPA as features of the mouth: labels taken apart into letters, and letters into features.

What letters and marks do is data (`kind: ipa`); here it is only looked up. Conventions:

- Labels are compared as `labels.normalise` leaves them: composition, tie bars and look-alike
  letters make no difference. Of several keys the longest wins; a composed letter that is not a key
  is read as its parts.
- A mark belongs to the letter before it; marks that stand first, to the letter after them.
- Features are numbers from 0 to 1, in the order of `Features.names`; None where a letter has none.
- Unknown characters are skipped and reported; no label causes an error.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from itertools import groupby, pairwise
from typing import Any, NamedTuple
from unicodedata import decomposition, normalize

from lipsync_lang.text.phonology.labels import normalise

CARRIER = "\u25cc"
"""The dotted circle on which data writes a mark that needs a carrier."""

VOICE, VOICELESS = "voice", "without-voice"
"""An audible but invisible property, and the word for letters without it."""

Numbers = tuple[float | None, ...]
"""Features of one sound, in order; None where they do not apply."""

FeatureWords = frozenset[str]
"""The words that describe a letter."""

_SOUND_KINDS = (
    ("G", {"glide"}),
    ("S", {"stop", "click"}),
    ("N", {"nasal"}),
    ("F", {"fricative"}),
    ("R", {"rhotic"}),
    ("C", {"trill", "tap", "approximant"}),
)
"""Codes of letters by the words that describe them; any other letter is a vowel, V."""

_ONE_SOUND = re.compile(
    r"G?V{1,3}[GR]?"  # a vowel, or several in a row: ɛ, aɪ, jaʊ, ɔɹ
    r"|N?S{1,2}F?G?"  # a stop with nose, another stop, friction or a glide: t, ⁿd, k͡p, tʃ, kw
    r"|[NFRC]?G"
    r"|[NFRC]"
)


class LetterSound(NamedTuple):
    """A letter of a label, with the effect of its marks."""

    letter: str
    words: FeatureWords
    features: Numbers
    time: float = 1.0

    @property
    def kind(self) -> str:
        """Its code in `_SOUND_KINDS`."""
        return next((code for code, some in _SOUND_KINDS if self.words & some), "V")

    @property
    def is_vowel(self) -> bool:
        """True for a vowel."""
        return self.kind == "V"


class LabelReading(NamedTuple):
    """A label as its sounds in order, its invisible properties, and its unknown characters."""

    sounds: tuple[LetterSound, ...]
    losses: tuple[str, ...]
    unknown: tuple[str, ...]


class Case(NamedTuple):
    """Effect of a mark on letters that fit."""

    on: tuple[FeatureWords, ...]
    set: tuple[tuple[int, float], ...]
    add: tuple[tuple[int, float], ...]
    then: str
    time: float
    lost: str

    def fits(self, sound: LetterSound) -> bool:
        """Return True if a letter fits the description and has a feature that changes."""
        return _described(sound.words, self.on) and (
            not (self.set or self.add) or bool(self.changes(sound.features))
        )

    def changes(self, features: Numbers) -> dict[int, float]:
        """Return the features that a letter has and the mark sets or moves, by number."""
        changed = {number: value for number, value in self.set if features[number] is not None}
        for number, more in self.add:
            before = changed.get(number, features[number])
            if before is not None:
                changed[number] = min(1.0, max(0.0, before + more))
        return changed

    def change(self, sound: LetterSound) -> LetterSound:
        """Return a letter with the mark's effect."""
        values = list(sound.features)
        for number, value in self.changes(sound.features).items():
            values[number] = value
        return sound._replace(features=tuple(values), time=sound.time * self.time)


class Join(NamedTuple):
    """A rule for two adjacent letters: which of them are visible."""

    first: tuple[FeatureWords, ...]
    second: tuple[FeatureWords, ...]
    keep: str
    lost: str


class Features:
    """Effects of every IPA letter and mark on the mouth, from the data of a pack of kind `ipa`.

    Attributes
    ----------
    names, weights : the features, and how much each counts
    fights_from : the weight of a feature that no mapping should miss
    told_from : the difference from which a feature is told as lost
    another : what one more mouth shape in a label costs
    later : how much letters after the first count in a run
    prefer : letters, and those that are taken instead
    aside : by common phoneme, letters it names that are passed over
    joins : which letters are seen beside which
    alone : the letters that marks stand for where there is no letter
    """

    def __init__(self, data: Mapping[str, Any]) -> None:
        features: dict[str, dict[str, float]] = data["features"]

        def sound(letter: str, description: str) -> LetterSound:
            words = description.split()
            stated = {name: v for word in words for name, v in data["terms"][word].items()}
            values = (stated.get(name, f.get("otherwise")) for name, f in features.items())
            return LetterSound(letter, frozenset(words), tuple(values))

        def keyed(field: str) -> dict[str, Any]:
            return {key(sign): value for sign, value in data.get(field, {}).items()}

        self.names = tuple(features)
        self.weights = tuple(feature["weight"] for feature in features.values())
        self.fights_from: float = data["fights_from"]
        self.told_from: float = data["told_from"]
        self.another: float = data["another"]
        self.later: float = data["later"]
        self.prefer = {letter: key(other["as"]) for letter, other in keyed("prefer").items()}
        aside = data.get("aside", {}).items()
        self.aside = {name: frozenset(map(key, letters)) for name, letters in aside}
        self.joins = [
            Join(
                _phrases(j.get("first")), _phrases(j.get("second")), j["keep"], j.get("lost") or ""
            )
            for j in data.get("joins", ())
        ]
        self.alone = {mark: key(letter) for mark, letter in keyed("alone").items()}
        self._letters = {letter: sound(letter, words) for letter, words in keyed("letters").items()}
        self._spellings = {sign: key(text) for sign, text in keyed("spellings").items()}
        self._marks = {
            mark: tuple(
                _case(case, self.names)
                for case in (cases if isinstance(cases, (list, tuple)) else (cases,))
            )
            for mark, cases in keyed("marks").items()
        }
        self._ignored = {key(sign) or sign for sign in data.get("ignored", ())}
        keys = (*self._letters, *self._spellings, *self._marks, *self._ignored)
        self._longest = max(map(len, keys), default=1)

    def read(self, label: str, own: Iterable[str] = ()) -> LabelReading:
        """Read a label, which may be any text, as letters; `prefer` does not replace its `own`."""
        tokens, unknown = self._tokens(key(label))
        kept = frozenset(own)
        sounds: list[LetterSound] = []
        losses: list[str] = []
        alone = [token for token in tokens if token in self.alone]
        groups: list[tuple[str, list[str], list[str]]] = []  # letter, marks before and after it
        first: list[str] = []
        for token in tokens:
            if token in self._letters:
                groups.append((token, [] if groups else first, []))
            else:
                (groups[-1][2] if groups else first).append(token)
        for letter, before, after in groups:
            seen = letter if letter in kept else self.prefer.get(letter, letter)
            # Marks go by the letter as it is written, even if it looks like another.
            sound = self._letters[letter]._replace(features=self._letters[seen].features)
            sounds += self._marked(sound, before, after, losses)
        if not sounds:
            sounds = [self._letters[self.alone[mark]] for mark in alone]
            silent = (mark for mark in tokens if mark not in self.alone)
            losses += (self._marks[mark][-1].lost for mark in silent)
        shown = tuple(self._joined(sounds, losses))
        lost = tuple(dict.fromkeys(filter(None, losses)))
        return LabelReading(shown, lost, tuple(dict.fromkeys(unknown)))

    def unseen(self) -> dict[str, str]:
        """Return the marks that hardly show, each with the letters on which it shows.

        A letter and its mark that are a letter by themselves, as in č, show as that.
        """
        every = "".join(self._letters)
        shown = {  # many marks do the same
            cases: "".join(s.letter for s in self._letters.values() if self._shows(s, cases))
            for cases in {*self._marks.values()}
            if any(case.then or case.set or case.add for case in cases)
        }
        seen = {mark: shown.get(cases, "") for mark, cases in self._marks.items()}
        for text in (*self._letters, *self._spellings):
            for letter, mark in pairwise(normalize("NFD", text)):
                if mark in seen:
                    seen[mark] += letter
        return {mark: letters for mark, letters in seen.items() if letters != every}

    def _shows(self, sound: LetterSound, cases: Sequence[Case]) -> bool:
        """Test whether a mark adds a letter, or changes a feature enough to be named as lost."""
        case = next((case for case in cases if case.fits(sound)), None)
        if case is None or case.then:
            return case is not None
        changes = case.changes(sound.features).items()
        return any(abs(value - (sound.features[n] or 0)) >= self.told_from for n, value in changes)

    def _marked(
        self, sound: LetterSound, before: Sequence[str], after: Sequence[str], losses: list[str]
    ) -> list[LetterSound]:
        """Return a letter with its marks' effects, and the letters that the marks add."""
        follow: list[LetterSound] = []
        lead: list[LetterSound] = []
        for mark, beside in (*((m, lead) for m in before), *((m, follow) for m in after)):
            case = next((case for case in self._marks[mark] if case.fits(sound)), None)
            if case is None:
                continue
            sound = case.change(sound)
            losses.append(case.lost)
            if case.then:
                beside.append(self._letters[case.then])
        return [*lead, sound, *follow]

    def _tokens(self, text: str) -> tuple[list[str], list[str]]:
        """Cut text into letters and marks, longest first; return them and unknown characters."""
        tokens: list[str] = []
        unknown: list[str] = []
        start = 0
        while start < len(text):
            for stop in range(min(len(text), start + self._longest), start, -1):
                part = text[start:stop]
                if part in self._spellings:
                    tokens += self._tokens(self._spellings[part])[0]
                elif part in self._letters or part in self._marks:
                    tokens.append(part)
                elif part not in self._ignored:
                    continue
                break
            else:
                codes = decomposition(text[start]).split()
                if codes and not codes[0].startswith("<"):  # a letter composed with a mark
                    parts = "".join(chr(int(code, 16)) for code in codes)
                    text = text[:start] + parts + text[start + 1 :]
                    continue
                stop = start + 1
                unknown.append(text[start])
            start = stop
        return tokens, unknown

    def _joined(self, sounds: Sequence[LetterSound], losses: list[str]) -> list[LetterSound]:
        """Drop letters that a neighbour hides, and merge a doubled letter into one long one."""
        left: list[LetterSound] = []
        for sound in sounds:
            left.append(sound)
            # A letter that goes leaves new neighbours.
            while len(left) > 1:
                first, second = left[-2:]
                if first.letter == second.letter and first.features == second.features:
                    left[-2:] = [second._replace(time=first.time + second.time)]
                    continue
                fitting = [
                    join
                    for join in self.joins
                    if _described(first.words, join.first) and _described(second.words, join.second)
                ]
                if not fitting or fitting[0].keep == "both":
                    break
                losses.append(fitting[0].lost)
                del left[-1 if fitting[0].keep == "first" else -2]
        return left


def is_one_sound(letters: Sequence[LetterSound]) -> bool:
    """Return True if letters are one sound of a language; those that are doubled count once.

    Most words and many codes can be read as IPA, letter by letter. The letters of one sound go
    together: a vowel or vowels in a row, a stop with its release, a glide at an edge.
    """
    alike = groupby(letters, key=lambda sound: sound.letter)
    kinds = "".join(next(sounds).kind for _, sounds in alike)
    return _ONE_SOUND.fullmatch(kinds) is not None


def key(text: str) -> str:
    """Return a label or key in the form used for comparison."""
    return normalise(text.replace(CARRIER, ""))


def _described(words: FeatureWords, phrases: tuple[FeatureWords, ...]) -> bool:
    """Return True if one of the phrases fits a letter; an empty list fits every letter."""
    return not phrases or any(phrase <= words for phrase in phrases)


def _phrases(stated: Iterable[str] | None) -> tuple[FeatureWords, ...]:
    return tuple(frozenset(phrase.split()) for phrase in stated or ())


def _case(case: Mapping[str, Any] | str, names: tuple[str, ...]) -> Case:
    if isinstance(case, str):
        case = {"lost": case}

    def numbered(values: Mapping[str, float] | None) -> tuple[tuple[int, float], ...]:
        return tuple((names.index(name), value) for name, value in (values or {}).items())

    return Case(
        on=_phrases(case.get("on")),
        set=numbered(case.get("set")),
        add=numbered(case.get("add")),
        then=key(case.get("then") or ""),
        time=case.get("time") or 1.0,
        lost=case.get("lost") or "",
    )


def by_ear(data: Mapping[str, Any]) -> dict[str, Any]:
    """Return the data of the IPA, weighed as its section on hearing says, with voice."""
    hearing = data["hearing"]
    weights, silent = hearing["weights"], frozenset(hearing["voiceless"].split())
    seen = {
        name: feature | {"weight": weights.get(name, 0.0)}
        for name, feature in data["features"].items()
    }
    of_the_eye: dict[str, Any] = {"prefer": {}, "aside": {}, "joins": []}
    return {
        **data,
        **of_the_eye,
        "features": seen | {VOICE: {"weight": hearing["voice"], "otherwise": 1.0}},
        "terms": data["terms"] | {VOICELESS: {VOICE: 0.0}},
        "marks": data["marks"]
        | {mark: {"then": data["alone"][mark]} for mark in hearing["heard"].split()},
        "letters": {
            letter: f"{words} {VOICELESS}" if letter in silent else words
            for letter, words in data["letters"].items()
        },
        "another": hearing["another"],
        "later": hearing["later"],
    }
