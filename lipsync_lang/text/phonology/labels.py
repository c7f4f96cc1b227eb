"""Look-up of phoneme labels in tables, in any spelling.

Spellings of a label are equal in spite of these differences:

- Unicode composition, ligatures, tie bars and look-alike letters. `normalise` removes these from
  tables and labels.
- Stress, tone and length, and case in a notation with one case only. These are dropped one after
  the other, and only while the label is unknown: in SAMPA, digits and case distinguish phonemes.
- Invisible marks (`unseen`), as the last resort. Of the labels that differ in such marks only, the
  one with the most marks in common is chosen.

A label missing from the table has no value, unless the notation has a `nearest` function.
`Notation.suggest` names the nearest label of the table.
"""

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Any
from unicodedata import combining, normalize

from lipsync_lang.base.errors import PackError, did_you_mean
from lipsync_lang.base.grouping import grouped

Value = tuple[tuple[str, float], ...]
"""Common phonemes in sequence, each with its share of the label's time."""

TIES = "\u035c\u0361\u203f\u200b\u200c\u200d\ufeff"
"""Tie bars over and under letters, and invisible joiners."""

LIGATURES = {"ʣ": "dz", "ʤ": "dʒ", "ʥ": "dʑ", "ʦ": "ts", "ʧ": "tʃ", "ʨ": "tɕ"}
"""Letters for affricates that the IPA has withdrawn."""

LOOKALIKES = {"\u0261": "g", "\u02d0": ":", "\u04d9": "ə", "\u03b5": "ɛ", "\u2019": "'"}
"""Look-alike characters and their replacements: two forms of g, of the length mark, ..."""

SAME = str.maketrans({**dict.fromkeys(TIES), **LIGATURES, **LOOKALIKES})

STRESS = "ˈˌ'\"%"
"""Marks before a stressed sound: IPA's, ASCII's, and SAMPA's two."""

SECONDARY = "ˌ%"
"""Marks of secondary stress; the others are of primary stress."""

LENGTH_MARKS = ":ˑ"
TONE = "0123456789⁰¹²³⁴⁵⁶⁷⁸⁹˥˦˧˨˩"
"""Stress digits of ARPAbet, tone digits and IPA tone letters; never the whole label."""

MAX_TONE_SIGNS = 4
"""Maximum number of signs of one tone, as in `˨ˀ˥` and `2142`; more are a number."""


@lru_cache(maxsize=4096)  # lines share their labels
def normalise(label: str) -> str:
    """Return the canonical spelling of a label; equal spellings always mean the same sound."""
    return normalize("NFC", normalize("NFC", label).translate(SAME).strip())


def toneless(label: str) -> str:
    """Return a normalised label without its tone."""
    bare = label[:1] + label[1:].rstrip(TONE)
    return bare if len(label) - len(bare) <= MAX_TONE_SIGNS else label


def looser(label: str) -> Iterator[str]:
    """Yield a normalised label, then without stress, tone, length, and tone and length."""
    plain = label.lstrip(STRESS) or label
    even = toneless(plain)
    yield from (label, plain, even)
    yield plain.rstrip(LENGTH_MARKS) or plain
    yield toneless(even.rstrip(LENGTH_MARKS) or even)


def bare(label: str, unseen: Mapping[str, str]) -> tuple[str, Counter[str]]:
    """Return a normalised label without invisible marks, and those marks.

    `unseen` are marks, each with the letters on which it is visible all the same.
    """
    kept, letter = "", ""
    marks: Counter[str] = Counter()
    for sign in normalize("NFD", label):
        seen_on = unseen.get(sign)
        if seen_on is not None and (not seen_on or (letter and letter not in seen_on)):
            marks[sign] += 1
            continue
        kept += sign
        letter = letter if combining(sign) else sign
    return kept, marks


@dataclass(frozen=True, eq=False)
class Notation:
    """A table of labels that finds a label in any of its spellings.

    Parameters
    ----------
    table : the common phonemes of each label
    silences : spellings of silence, in any case; the table's own labels take precedence
    silence : the value of these spellings
    nearest : returns a value for a label missing from the table, or None
    unseen : marks that may be dropped, each with the letters on which it is visible all the same
    digits : True if a digit at the end of a label is its stress, as in ``AH0``
    signs : signs that spell the labels of the table, as in X-SAMPA; without any, labels are its own
    """

    table: Mapping[str, Value]
    silences: Collection[str] = ()
    silence: Value = ()
    nearest: Callable[[str], Value | None] | None = None
    unseen: Mapping[str, str] = field(default_factory=dict)
    digits: bool = False
    signs: Mapping[str, str] = field(default_factory=dict)
    _exact: dict[str, Value] = field(init=False, repr=False, default_factory=dict)
    _folded: dict[str, Value] = field(init=False, repr=False, default_factory=dict)
    _silent: frozenset[str] = field(init=False, repr=False, default=frozenset())
    _quiet: dict[str, bool] = field(init=False, repr=False, default_factory=dict)
    _seen: dict[str, Value | None] = field(init=False, repr=False, default_factory=dict)
    _alike: dict[str, Value | None] = field(init=False, repr=False, default_factory=dict)
    _marked: dict[str, int | None] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        for label, value in self.table.items():
            self._exact.setdefault(normalise(label), value)
        letters = "".join(self._exact)
        if letters.isascii() and (letters.islower() or letters.isupper()):  # case says nothing
            for label, value in self._exact.items():
                self._folded.setdefault(label.casefold(), value)
        silent = frozenset(normalise(label).casefold() for label in self.silences)
        # The class is frozen, and this follows from its fields.
        object.__setattr__(self, "_silent", silent)

    def find(self, label: str) -> Value | None:
        """Return the value of a label, from the table or by likeness; None if unknown."""
        known = self._seen[label] if label in self._seen else self.stated(label)
        if known is not None:
            return known
        if label not in self._alike:
            self._alike[label] = self.by_likeness(label)
        return self._alike[label]

    def text(self, label: str) -> str | None:
        """Return a label in the table's spelling, longest sign first; None for an unknown sign."""
        if not self.signs:
            return label
        longest = max(map(len, self.signs))
        text, rest = "", label.strip()
        while rest:
            sign = next((rest[:n] for n in range(longest, 0, -1) if rest[:n] in self.signs), "")
            if not sign:
                return None
            text, rest = text + self.signs[sign], rest[len(sign) :]
        return text

    def by_likeness(self, label: str) -> Value | None:
        """Return the value of the most similar label of the table; None if none is similar."""
        text = self.text(label)
        if text is None or sum(sign in TONE for sign in text) > MAX_TONE_SIGNS:
            return None  # a number
        if self.nearest is not None:
            return self.nearest(text)
        # Of the labels that look the same, the one that shares the most marks.
        kept, marks = bare(normalise(text).lstrip(STRESS), self.unseen)
        alike = self._bare.get(kept, ()) if kept else ()
        return min(
            alike,
            key=lambda one: ((marks - one[0]) + (one[0] - marks)).total(),
            default=(marks, None),
        )[1]

    @cached_property
    def _bare(self) -> dict[str, list[tuple[Counter[str], Value]]]:
        """Visible part of labels -> (invisible marks, value) of each label."""
        exact = self._exact.items() if self.unseen else ()
        bared = ((*bare(label, self.unseen), value) for label, value in exact)
        return grouped((kept, (marks, value)) for kept, marks, value in bared)

    def stated(self, label: str) -> Value | None:
        """Return the value of a label in the table; None if it is missing."""
        if label not in self._seen:
            self._seen[label] = self._stated(label)
        return self._seen[label]

    def spells(self, label: str) -> bool:
        """Return True if the table has a label, with its stress, tone and length."""
        text = self.text(label)
        return text is not None and self._has(normalise(text))

    def _has(self, whole: str) -> bool:
        return whole in self._exact or whole.casefold() in self._folded

    def _stated(self, label: str) -> Value | None:
        text = self.text(label)
        if text is not None:
            if text in self.table:
                return self.table[text]
            whole = normalise(text)
            if not self._has(whole) and self.is_silence(whole):
                return self.silence
            for spelling in looser(whole):
                if spelling in self._exact:
                    return self._exact[spelling]
                if spelling.casefold() in self._folded:
                    return self._folded[spelling.casefold()]
        return self.silence if self.is_silence(label) else None

    def stress(self, label: str) -> int | None:
        """Return the stress that a label is marked with; None for a label without a mark.

        Labels of the table are taken as they are: their signs are not marks of stress.
        """
        if label in self._marked:
            return self._marked[label]
        whole, level = normalise(self.text(label) or ""), None
        if len(whole) >= len("ˈa") and not self._has(whole):
            if whole[0] in STRESS:
                level = 2 if whole[0] in SECONDARY else 1
            elif self.digits and whole[-1] in "012":
                level = int(whole[-1])
        self._marked[label] = level
        return level

    def is_silence(self, label: str) -> bool:
        """Return True if a label is a spelling of silence."""
        if label not in self._quiet:
            self._quiet[label] = normalise(label).casefold() in self._silent
        return self._quiet[label]

    def suggest(self, label: str) -> str:
        """Return a hint for a label missing from the table."""
        if not self.signs:
            return did_you_mean(normalise(label), self.table)
        text = self.text(label)
        return "a sign of it is unknown" if text is None else f"it is read as '{text}'"


def recognise(labels: Iterable[str], notations: Mapping[str, Notation]) -> str:
    """Return the name of the notation that knows the most labels; in a tie, the first.

    Labels stated in tables count before labels found by likeness. Silence does not count, because
    every notation has it.
    """
    spoken = Counter(labels)
    if not notations:
        raise PackError("there is no notation to recognise labels by: the language has none")

    def known(name: str) -> tuple[int, int]:
        notation = notations[name]
        sounds = [(label, n) for label, n in spoken.items() if not notation.is_silence(label)]
        stated = sum(n for label, n in sounds if notation.stated(label) is not None)
        return stated, sum(n for label, n in sounds if notation.find(label) is not None)

    mute = [*spoken]
    for one in notations.values():  # after the first, hardly any is left
        mute = [*filter(one.is_silence, mute)]
    most = spoken.total() - sum(spoken[label] for label in mute)
    found: dict[str, tuple[int, int]] = {}
    for name in notations:
        found[name] = known(name)
        if found[name] == (most, most):  # none after it knows more
            return name
    return max(found, key=found.__getitem__)


def ready(  # noqa: PLR0913, PLR0917 the tables of a language
    tables: Mapping[str, Mapping[str, Value]],
    silences: Collection[str],
    silence: Value,
    ipa: str,
    spelling: Mapping[str, Any],
    nearest: Callable[[str], Value | None] | None = None,
    stress_digits: Collection[str] = (),
) -> dict[str, Notation]:
    """Return tables as notations, followed by other spellings of the IPA, if any.

    The signs of notations such as X-SAMPA, and the invisible marks, come from the IPA pack:
    `{"spelled": {notation: {sign: IPA}}, "unseen": {mark: letters on which it is visible}}`.
    A table named as a way to spell the IPA is taken instead of that. `ipa` names the table of the
    IPA, for whose unknown labels `nearest` answers.
    """
    made = {
        name: Notation(table, silences, silence, digits=name in stress_digits)
        for name, table in tables.items()
    }
    if ipa in tables:
        rest = (tables[ipa], silences, silence, nearest, spelling["unseen"])
        made[ipa] = Notation(*rest)
        for name, signs in spelling["spelled"].items():
            made.setdefault(name, Notation(*rest, signs=signs))
    return made
