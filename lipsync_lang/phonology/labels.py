"""Phoneme labels: one sound, many spellings.

Two spellings of a label are the same when they differ in what carries no sound:

- Unicode composition, ligatures and tie bars, and which of two look-alike letters is typed:
  `normalise`, done to the tables and to what is looked up.
- Stress, tone and length, and upper or lower case where the notation uses one case only.
  These are dropped one after the other, and only while the label as it stands is unknown:
  in SAMPA digits and case tell phonemes apart.
- Marks that are not seen, in a notation that was told which those are (`unseen`), and only where
  all else fails: of the labels that differ in nothing else, the one of most such marks in common
  is meant.

What the tables lack has no value, unless the notation was given what finds the `nearest`;
`Notation.suggest` names the nearest label.
"""

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from unicodedata import combining, normalize

from lipsync_lang.errors import PackError, did_you_mean

Value = tuple[tuple[str, float], ...]
"""Common phonemes in sequence, each with its share of the label's time."""

TIES = "\u035c\u0361\u203f\u200b\u200c\u200d\ufeff"
"""Tie bars over and under, and what joins letters invisibly."""

LIGATURES = {"ʣ": "dz", "ʤ": "dʒ", "ʥ": "dʑ", "ʦ": "ts", "ʧ": "tʃ", "ʨ": "tɕ"}
"""Letters for affricates that the IPA gave up."""

LOOKALIKES = {"\u0261": "g", "\u02d0": ":", "\u04d9": "ə", "\u03b5": "ɛ", "\u2019": "'"}
"""What is typed for one another, towards ASCII: two forms of g, of the length mark, ..."""

SAME = str.maketrans({**dict.fromkeys(TIES), **LIGATURES, **LOOKALIKES})

STRESS = "ˈˌ'\"%"
"""Marks before a stressed sound: IPA's, ASCII's, and SAMPA's two."""

LENGTH = ":ˑ"
TONE = "0123456789⁰¹²³⁴⁵⁶⁷⁸⁹˥˦˧˨˩"
"""Stress digits of ARPAbet, tone digits and IPA tone letters; never the whole label."""


def normalise(label: str) -> str:
    """Return the one spelling of a label among those that cannot mean different sounds."""
    return normalize("NFC", normalize("NFC", label).translate(SAME).strip())


def _toneless(label: str) -> str:
    return label[:1] + label[1:].rstrip(TONE)


def looser(label: str) -> Iterator[str]:
    """Yield ever looser spellings of a normalised label, itself first."""
    plain = label.lstrip(STRESS) or label
    toneless = _toneless(plain)
    yield from (label, plain, toneless)
    yield plain.rstrip(LENGTH) or plain
    yield _toneless(toneless.rstrip(LENGTH) or toneless)


def bare(label: str, unseen: Mapping[str, str]) -> tuple[str, Counter[str]]:
    """Return a normalised label without the marks that are not seen, and those marks.

    Parameters
    ----------
    unseen : marks, each with the letters on which it is seen all the same
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
    table : for each label, the common phonemes it stands for
    silences : spellings of silence, in any case; the table's own labels come first
    silence : what those stand for
    nearest : answers for labels that the table lacks; None for those it cannot read
    unseen : marks that may be dropped, each with the letters on which it is seen all the same
    """

    table: Mapping[str, Value]
    silences: Collection[str] = ()
    silence: Value = ()
    nearest: Callable[[str], Value | None] | None = None
    unseen: Mapping[str, str] = field(default_factory=dict)
    _exact: dict[str, Value] = field(init=False, repr=False, default_factory=dict)
    _folded: dict[str, Value] = field(init=False, repr=False, default_factory=dict)
    _silent: frozenset[str] = field(init=False, repr=False, default=frozenset())
    _seen: dict[str, Value | None] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        for label, value in self.table.items():
            self._exact.setdefault(normalise(label), value)
        if one_case(self._exact):
            for label, value in self._exact.items():
                self._folded.setdefault(label.casefold(), value)
        silent = frozenset(normalise(label).casefold() for label in self.silences)
        object.__setattr__(self, "_silent", silent)

    def find(self, label: str) -> Value | None:
        """Return what a label stands for; None if nobody knows it."""
        known = self.stated(label)
        return self.likely(label) if known is None else known

    def text(self, label: str) -> str | None:
        """Return a label as the table spells it; None where it cannot be spelled so."""
        return label

    def likely(self, label: str) -> Value | None:
        """Return what a label stands for that the table does not state; None if nobody knows."""
        return self._seen_alike(label) if self.nearest is None else self.nearest(label)

    def _seen_alike(self, label: str) -> Value | None:
        """Return what the label stands for that looks the same and shares most marks."""
        kept, marks = bare(normalise(label).lstrip(STRESS), self.unseen)
        alike = self._bare.get(kept, ()) if kept else ()
        return min(alike, key=lambda one: _apart(marks, one[0]), default=(marks, None))[1]

    @cached_property
    def _bare(self) -> dict[str, list[tuple[Counter[str], Value]]]:
        """The labels by what is seen of them, each with its other marks."""
        alike: dict[str, list[tuple[Counter[str], Value]]] = {}
        for label, value in self._exact.items() if self.unseen else ():
            kept, marks = bare(label, self.unseen)
            alike.setdefault(kept, []).append((marks, value))
        return alike

    def stated(self, label: str) -> Value | None:
        """Return what the table says a label stands for; None if it does not know it."""
        try:
            return self._seen[label]
        except KeyError:
            return self._seen.setdefault(label, self._stated(label))

    def _stated(self, label: str) -> Value | None:
        if label in self.table:
            return self.table[label]
        whole = normalise(label)
        own = whole in self._exact or whole.casefold() in self._folded
        if not own and self.is_silence(whole):
            return self.silence
        for spelling in looser(whole):
            if spelling in self._exact:
                return self._exact[spelling]
            if spelling.casefold() in self._folded:
                return self._folded[spelling.casefold()]
        return None

    def is_silence(self, label: str) -> bool:
        """Whether a label is one of the spellings of silence."""
        return normalise(label).casefold() in self._silent

    def suggest(self, label: str) -> str:
        """Return a hint for a label the table does not know."""
        return did_you_mean(normalise(label), self.table)

    def conflicts(self) -> list[tuple[str, str]]:
        """Return the pairs of labels that are one spelling but stand for different things.

        Of each pair the first wins, except where the second is spelled out exactly.
        """
        first: dict[str, str] = {}
        return [
            (first[same], label)
            for label, value in self.table.items()
            if first.setdefault(same := normalise(label), label) != label
            and self.table[first[same]] != value
        ]


def _apart(marks: Counter[str], others: Counter[str]) -> int:
    return ((marks - others) + (others - marks)).total()


def one_case(labels: Iterable[str]) -> bool:
    """Whether all labels are plain ASCII in one case, so that case tells nothing apart."""
    letters = "".join(labels)
    return letters.isascii() and (letters.islower() or letters.isupper())


def recognise(labels: Iterable[str], notations: Mapping[str, Notation]) -> str:
    """Return the name of the notation that knows most of the labels; of equals, the first.

    What tables state comes before what is only nearest. Silence counts for nothing: every
    notation knows it.
    """
    spoken = list(labels)
    if not notations:
        raise PackError("there is no notation to recognise labels by: the language has none")

    def known(name: str) -> tuple[int, int]:
        notation = notations[name]
        sounds = [label for label in spoken if not notation.is_silence(label)]
        stated = sum(notation.stated(label) is not None for label in sounds)
        return stated, sum(notation.find(label) is not None for label in sounds)

    return max(notations, key=known)
