"""Label reader: detects the notation of a schedule and maps its labels to common phonemes.

Remarks tell noise, sounds that are read by their features, and doubtful notations.
"""

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Literal
from weakref import WeakKeyDictionary

import numpy as np

from lipsync_lang.base.arrays import Ints
from lipsync_lang.base.errors import ScheduleError, did_you_mean, shortlist
from lipsync_lang.packs.finding import IPA
from lipsync_lang.performing.effort import CONSONANT_MANNER, MANNERS, stresses_of
from lipsync_lang.performing.label_sounds import UNMARKED, LabelSounds, LabelTable, sounds_of
from lipsync_lang.schedules.schedule import SILENCE, Schedule
from lipsync_lang.text.phonology.g2p.tokens import plain
from lipsync_lang.text.phonology.labels import (
    MAX_TONE_SIGNS,
    TONE,
    Notation,
    Value,
    normalise,
    ready,
    recognise,
    toneless,
)

if TYPE_CHECKING:
    from lipsync_lang.resolver.compiled import CompiledPair
    from lipsync_lang.text.phonology.g2p.g2p_engines import Correction
    from lipsync_lang.text.phonology.nearest import Nearest, NearestPhonemes

_CAPITAL = re.compile("[A-Z]")
"""Letters that are absent from the IPA, but present in most other notations."""

Unknown = Literal["error", "rest", "nearest"]
"""Treatments of unmapped labels; `nearest` maps IPA by its features, with a remark."""

SURE_SHARE = 0.97
"""Share of the labels that a notation must contain to be used without a remark."""

MAX_UNLISTED = 8
"""Maximum number of labels outside the language with a remark each."""

FAST_SOUNDS, FAST_SECONDS = 8, 0.18
"""So many sounds in a row, in less time than this, are no speech: the fastest is half as fast."""

SHORTEST_SECONDS = 0.015
"""Mean length of the sounds of a word, below which the word was not said there."""


@dataclass(frozen=True, eq=False)
class LabelReader:
    """The notations of a resolved language, for reading any schedule.

    Parameters
    ----------
    compiled : compiled language-character pair
    unknown : treatment of unmapped labels: `error`, `rest`, or `nearest` (IPA only, else an error)
    paths : folders with priority in pack searches, for message hints
    shades : True to tell shades from their parents
    """

    compiled: "CompiledPair"
    unknown: Unknown = "nearest"
    paths: tuple[Path, ...] = ()
    shades: bool = True
    _rivals: dict[tuple[int, str], tuple[set[str], set[str]]] = field(
        default_factory=dict, init=False, repr=False
    )
    """Results of `rivals`, by the identity of the notation."""
    _tables: dict[int, LabelTable] = field(default_factory=dict, init=False, repr=False)
    """Labels of each notation, by its identity."""
    _heard: WeakKeyDictionary[Schedule, LabelSounds] = field(
        default_factory=WeakKeyDictionary, init=False, repr=False
    )
    """Sounds of schedules: a line that is performed and judged is read three times."""
    _recognised: WeakKeyDictionary[Schedule, str] = field(
        default_factory=WeakKeyDictionary, init=False, repr=False
    )

    def read(self, schedules: Sequence[Schedule]) -> list[LabelSounds]:
        """Map the labels of schedules to common phonemes.

        Raises
        ------
        ScheduleError
            A label is in no notation of the language, or no label of a schedule has a sound; or
            one is no schedule.
        """
        for one in schedules:
            if not isinstance(one, Schedule):
                raise ScheduleError(
                    f"{one!a:.60} is no schedule: pass ll.speak(TEXT, LANGUAGE), "
                    "ll.align(RECORDING, TEXT, LANGUAGE) or ll.read_schedule(FILE)"
                )
        known = self._heard
        return [known.get(one) or known.setdefault(one, self._sounds(one)) for one in schedules]

    def _sounds(self, schedule: Schedule) -> LabelSounds:
        """Map the labels of a schedule."""
        notation = self.notation(schedule)
        table, labels = self._table(notation), self._labels(schedule, notation)
        ids, marks = table.read(labels)
        if schedule.stress:
            marks = np.array([UNMARKED if one is None else one for one in schedule.stress])
        own = self._has_own_words(schedule)
        if ids is not None and not own:
            return LabelSounds(ids, schedule.times, np.arange(len(ids)), marks)
        values = [value for label in labels if (value := table.found[label]) is not None]
        if own or len(values) < len(labels):
            values = self.values(schedule)
        sounds = sounds_of(values, schedule.times, marks, self.numbers)
        if sounds is None:
            raise ScheduleError(
                f"{schedule.source}: none of its labels has a sound; "
                "check the labels and their notation"
            )
        return sounds

    def _labels(self, schedule: Schedule, notation: Notation) -> tuple[str, ...]:
        """Return the labels of a schedule as the language reads them beside each other."""
        written = self.notations.get(self.compiled.manner["notation"])
        if not self._corrections or notation is not written:
            return schedule.labels
        from lipsync_lang.text.phonology.g2p.corrections import corrector
        from lipsync_lang.text.phonology.g2p.g2p_engines import SpokenWord

        bare = tuple(toneless(normalise(label)) for label in schedule.labels)
        said = corrector(self._corrections)(SpokenWord("", bare)).labels
        pairs = zip(schedule.labels, bare, said, strict=True)
        return tuple(label if one == other else other for label, one, other in pairs)

    @cached_property
    def _corrections(self) -> "tuple[Correction, ...]":
        """Corrections that hold for labels of timings."""
        if not self.compiled.manner["settings"]["corrections"]:
            return ()
        from lipsync_lang.text.phonology.manner import Manner

        settings = Manner.from_plain(self.compiled.manner).settings
        return tuple(one for one in settings.corrections if one.timings)

    def _table(self, notation: Notation) -> LabelTable:
        table = self._tables.get(id(notation))
        if table is None:
            table = self._tables.setdefault(id(notation), LabelTable(notation, self.numbers))
        return table

    def automatic(self, schedule: Schedule) -> "dict[str, Nearest]":
        """Return the labels mapped only by phonetic features, without duplicates.

        Each value holds the common phonemes with their shares, the features that are not shown, and
        the phonetic distance. The result is empty for a language with a complete mapping.
        """
        notation = self.notation(schedule)
        unmapped = [one for one in dict.fromkeys(schedule.labels) if notation.stated(one) is None]
        if notation.nearest is None:
            unmapped = [one for one in unmapped if self.unlisted(notation, one) is not None]
        near = self._features if unmapped else None
        if near is None:
            return {}
        found = {label: near.nearest(notation.text(label) or label) for label in unmapped}
        return {label: nearest for label, nearest in found.items() if not nearest.unknown}

    def unlisted(self, notation: Notation, label: str) -> Value | None:
        """Return the value by features of a label outside a notation; None if it has none.

        Only a label of a single IPA sound has such a value, and only if `unknown` is `nearest`.
        """
        if self.unknown != "nearest" or notation.find(label) is not None:
            return None
        spelled = bool(notation.signs) or notation is self.notations.get(IPA)
        near, text = self._features if spelled else None, notation.text(label)
        if near is None or text is None:
            return None
        if not any(map(str.isalpha, text)) or _CAPITAL.search(text):
            return None  # signs alone, such as ??, or another notation
        if sum(sign in TONE for sign in label) > MAX_TONE_SIGNS:
            return None  # a number
        from lipsync_lang.text.phonology.ipa import is_one_sound

        return near.value(text) if is_one_sound(near.read(text).sounds) else None

    def by_features(self, schedule: Schedule) -> dict[str, Value]:
        """Return the values of the labels of a schedule that its notation does not list."""
        notation = self.notation(schedule)
        unknown = [one for one in dict.fromkeys(schedule.labels) if notation.find(one) is None]
        tried = {label: self.unlisted(notation, label) for label in unknown}
        return {label: value for label, value in tried.items() if value is not None}

    def values(self, schedule: Schedule) -> list[Value]:
        """Return the value of each label; whole-word entries of the language take precedence.

        The labels of a word that a person relabelled stand.
        """
        notation = self.notation(schedule)
        values = [notation.find(label) for label in self._labels(schedule, notation)]
        if None in values:
            unlisted = self.by_features(schedule)
            both = zip(schedule.labels, values, strict=True)
            values = [unlisted.get(label) if one is None else one for label, one in both]
        own = self.compiled.words
        for word in schedule.words if self._has_own_words(schedule) else ():
            sounds = own.get(plain(word.text))
            if sounds and not word.relabelled:
                values[word.first : word.stop] = _spread(sounds, word.stop - word.first)
        known = [value for value in values if value is not None]
        if len(known) == len(values):
            return known
        unknown = [i for i, value in enumerate(values) if value is None]
        if self.unknown != "rest":
            raise ScheduleError(self._unknown(schedule, unknown, notation))
        rest: Value = ((self.compiled.phonemes[0], 1.0),)
        return [rest if value is None else value for value in values]

    def _has_own_words(self, schedule: Schedule) -> bool:
        """Return True if entries of the language may take precedence over labels."""
        compiled = self.compiled
        return bool(compiled.words and schedule.words) and schedule.language == compiled.language

    def classes(self, sounds: LabelSounds, count: int) -> list[str]:
        """Return the sound class of the first sound of each label; empty for silence."""
        return [self.kinds[number] for number in sounds.firsts(count).tolist()]

    def stresses(self, sounds: LabelSounds) -> Ints:
        """Return the stress of each vowel: 0 for none, 1 or 2; empty if nothing marks any.

        A mark before a consonant belongs to the vowel after it, as the IPA writes stress. If
        some vowels are marked, the others have no stress.

        Returns
        -------
        (n,) with -1 for labels that are not vowels, or (0,)
        """
        marks = sounds.marks
        if not marks.size or marks.max() < 0:
            return marks[:0]
        # one read of the pair: another thread may replace it
        known, found = self._stressed[0]
        if known is not sounds:
            found = stresses_of(marks, self.manners[sounds.firsts(len(marks))])
            self._stressed[0] = sounds, found
        return found

    def notation(self, schedule: Schedule) -> Notation:
        """Return the notation of the schedule: as stated, or the most likely one."""
        name = schedule.notation
        if name is None:
            name = self._recognised.get(schedule)
        if name is None:
            own = self.own_notations
            name = recognise(schedule.labels, own)
            labels, known, ipa = dict.fromkeys(schedule.labels), own.get(name), own.get(IPA)
            if known and ipa and any(known.find(one) is None for one in labels):
                # sounds of the IPA that no notation lists still tell that the labels are IPA
                sounds = all(
                    ipa.find(one) is not None or self.unlisted(ipa, one) is not None
                    for one in labels
                )
                name = IPA if sounds else name
            self._recognised[schedule] = name
        if name not in self.notations:
            raise ScheduleError(
                f"{schedule.source}: {self.compiled.language} has no notation '{name}'; "
                f"{did_you_mean(name, self.notations)}"
            )
        return self.notations[name]

    def rivals(self, notation: Notation, label: str) -> tuple[set[str], set[str]]:
        """Return the other notations that spell a label, and those in which it is another sound."""
        if (id(notation), label) not in self._rivals:
            stated, others = notation.stated(label), self.own_notations.items()
            spelling = {name for name, one in others if one is not notation and one.spells(label)}
            differing = {name for name, one in others if one.stated(label) != stated}
            self._rivals[id(notation), label] = spelling, differing
        return self._rivals[id(notation), label]

    @cached_property
    def _stressed(self) -> list[tuple[LabelSounds | None, Ints]]:
        """The line whose stresses were read last: the dial and the gestures both ask for them."""
        return [(None, np.zeros(0, np.intp))]

    @cached_property
    def own_notations(self) -> dict[str, Notation]:
        """Notations of sounds, by name: those that can be recognised by labels."""
        shapes = self.compiled.visemes.keys() - self.compiled.notations.keys()
        return {name: one for name, one in self.notations.items() if name not in shapes}

    @cached_property
    def notations(self) -> dict[str, Notation]:
        """Notations of the language and of mouth shapes, by name."""
        silence: Value = ((self.compiled.phonemes[0], 1.0),)
        near = self.near.value if self.near is not None else None
        tables = {**self.compiled.visemes, **self.compiled.notations}
        spelling, silences = self.compiled.spelling, self.compiled.silences
        digits = self.compiled.manner["stress_digits"]
        return ready(tables, silences, silence, IPA, spelling, near, digits)

    @cached_property
    def near(self) -> "NearestPhonemes | None":
        """Nearest phonemes by features; None for a language with a complete mapping."""
        if self.compiled.nearest is None:
            return None
        from lipsync_lang.text.phonology.nearest import NearestPhonemes

        return NearestPhonemes.from_plain(self.compiled.nearest)

    @cached_property
    def _features(self) -> "NearestPhonemes | None":
        """Nearest phonemes for labels that no notation lists; loaded only for such labels."""
        from lipsync_lang.resolver.nearest_phonemes import among_shared

        return self.near or among_shared(self.compiled.phonemes[1:], self.paths)

    @cached_property
    def kinds(self) -> list[str]:
        """Sound class of each common phoneme; empty for silence, the first."""
        kinds = self.compiled.manner["kinds"]
        return ["", *(kinds.get(name) or "sound" for name in self.compiled.phonemes[1:])]

    @cached_property
    def manners(self) -> Ints:
        """(N,) of each common phoneme: 0 for silence, 2 for a vowel, 1 for other sounds."""
        return np.array([MANNERS.get(kind, CONSONANT_MANNER) for kind in self.kinds], np.intp)

    @cached_property
    def noises(self) -> frozenset[str]:
        """Labels of noise, as `normalise` spells them, in small letters."""
        return frozenset(normalise(label).casefold() for label in self.compiled.noises)

    @cached_property
    def numbers(self) -> dict[str, int]:
        """Number of each common phoneme."""
        return self.compiled.numbers(shades=self.shades)

    def _hint(self, label: str, notation: str) -> str:
        """Return a hint for an unknown label: a similar label, or the nearest IPA phoneme."""
        known = self.notations[notation]
        hints = [known.suggest(label)] if known.table else []
        near = self._features if notation == IPA else None
        found = near.nearest(label) if near is not None else None
        if found is not None and found.unknown:
            hints.append(f"not IPA: {' '.join(found.unknown)}")
        elif found is not None and found.value:
            hints.append(f"nearest by its features: {' '.join(n for n, _ in found.value)}")
        return "; ".join(hints)

    def _unknown(self, schedule: Schedule, at: list[int], notation: Notation) -> str:
        name = next(name for name, known in self.notations.items() if known is notation)
        lines = [
            f"{schedule.place(i)}: phoneme {i} ({schedule.labels[i]!r}, {schedule.times[i]:g} to "
            f"{schedule.times[i + 1]:g} s) is not in the {name} of {self.compiled.language}; "
            f"{self._hint(schedule.labels[i], name)}"
            for i in at[:8]
        ]
        more = f"\n... and {len(at) - 8} more" if len(at) > 8 else ""  # noqa: PLR2004 a screenful
        mend = (
            f"\nAdd the labels to {self.compiled.language}'s notations, name their notation "
            "(`notation='NAME'`), or perform unknown labels as rest (`unknown='rest'`)"
        )
        features = name == IPA and self.unknown == "error"
        mend += " or by their features (`unknown='nearest'`)" if features else ""
        return "\n".join(lines) + more + mend


def _spread(sounds: tuple[str, ...], count: int) -> list[Value]:
    """Distribute the common phonemes of a word over its labels, in order.

    If a sound spans several labels, the first label holds it, and the others extend it.
    """
    cuts = [round(i * len(sounds) / count) for i in range(count + 1)]
    spread: list[Value] = []
    last = -1
    for low, high in pairwise(cuts):
        here = range(low, high) if low < high else range(min(low, len(sounds) - 1), low + 1)
        new = [n for n in here if last < n < len(sounds)]
        spread.append(tuple((sounds[n], 1 / len(new)) for n in new))
        last = max(last, *here)
    return spread


def label_remarks(reader: LabelReader, schedule: Schedule) -> tuple[str, ...]:
    """Return remarks on doubtful labels and their treatment; empty if there are none."""
    return (
        *_noise(reader, schedule),
        *_by_features(reader, schedule),
        *_notation(reader, schedule),
        *_pace(schedule),
    )


def _pace(schedule: Schedule) -> Iterator[str]:
    """Yield a remark on sounds that follow each other faster than anyone speaks."""
    lengths = schedule.times[1:] - schedule.times[:-1]
    if lengths.min() > FAST_SECONDS / FAST_SOUNDS:  # no sound alone is so fast
        return
    sounds = np.array([label != SILENCE for label in schedule.labels])
    starts, lengths = schedule.times[:-1][sounds], lengths[sounds]
    ends = np.concatenate(([0.0], np.cumsum(lengths)))
    spans = ends[FAST_SOUNDS:] - ends[:-FAST_SOUNDS]
    at = np.flatnonzero(spans < FAST_SECONDS)
    fast = [f"{FAST_SOUNDS} sounds in {spans[n]:.2f} s, at {starts[n]:.2f} s" for n in at]
    for word in () if fast else schedule.words:
        start, end = schedule.times[[word.first, word.stop]]
        if end - start < (word.stop - word.first) * SHORTEST_SECONDS:
            fast.append(f"'{word.text}' at {start:.2f} s, in {end - start:.2f} s")
    if fast:
        yield (
            f"{schedule.source}: nobody speaks so fast: {shortlist(fast, 1)}; check its times, and "
            "their unit (`rate`)"
        )


def _by_features(reader: LabelReader, schedule: Schedule) -> Iterator[str]:
    """Yield a remark on each label that the language lacks, with the phonemes in its place."""
    found = reader.by_features(schedule)
    for label, value in [*found.items()][:MAX_UNLISTED]:
        times, shown = schedule.labels.count(label), " ".join(name for name, _ in value)
        often = f" ({times} times)" if times > 1 else ""
        yield (
            f"{schedule.source}: {label!r}{often} is not a sound of {reader.compiled.language}; it "
            f"is performed as {shown or 'nothing'}, the nearest by phonetic features"
        )
    if len(found) > MAX_UNLISTED:
        more = len(found) - MAX_UNLISTED
        yield (f"{schedule.source}: {more} more labels are performed by their phonetic features")


def _noise(reader: LabelReader, schedule: Schedule) -> Iterator[str]:
    """Yield a remark on labels of noise and of speech that an aligner could not read."""
    notation = reader.notation(schedule)
    noise = {
        label
        for label in {*schedule.labels}
        if notation.find(label) == notation.silence and normalise(label).casefold() in reader.noises
    }
    if not noise:
        return
    counts = Counter(label for label in schedule.labels if label in noise)
    both = zip(schedule.labels, np.diff(schedule.times).tolist(), strict=True)
    seconds = sum(length for label, length in both if label in noise)
    named = (f"{label!r} ({n})" for label, n in counts.items())
    yield (
        f"{schedule.source}: noise or unreadable speech, during which the mouth rests for "
        f"{seconds:.1f} s: {shortlist(named)}"
    )


def _notation(reader: LabelReader, schedule: Schedule) -> Iterator[str]:
    """Yield a remark on a notation that was recognised by its labels, unless it is certain."""
    if schedule.notation is not None:
        return
    known, chosen = reader.own_notations, reader.notation(schedule)
    name = next(n for n, one in known.items() if one is chosen)
    labels = {one for one in {*schedule.labels, SILENCE} if not chosen.is_silence(one)} - {SILENCE}
    stated = {one for one in labels if chosen.stated(one) is not None}
    rivals = [reader.rivals(chosen, label) for label in stated]
    spelling = set(known).intersection(*(names for names, _ in rivals))
    other = spelling & set[str]().union(*(names for _, names in rivals))
    alike = [one for one in known if one in other]
    share = len(stated) / len(labels) if labels else 1.0
    if share >= SURE_SHARE and not alike:
        return
    told = f"{schedule.source}: labels are read as {name}, a notation with {share:.0%} of them"
    if alike:
        told += f"; they can also be {shortlist(alike)} (`notation={alike[0]!r}`)"
    yield told
