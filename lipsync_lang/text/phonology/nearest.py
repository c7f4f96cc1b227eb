"""The common phonemes nearest to a segment of the IPA, by features of the mouth.

A label is cut into pieces, each of which becomes one common phoneme: single letters, or runs of
letters that a common phoneme itself names, such as diphthongs. Of all ways to cut, the one whose
pieces cost least is taken:

    cost = sum over pieces of (distance + another)

without `another` for a piece that becomes what the one before it became. The distance of two
letters is the weighted sum of the differences of their features. In that of two runs the letters
after the first count less, and how they move from letter to letter is added. Of equal costs the
fewer pieces win, and of equal distances the phoneme that is named first.

A piece becomes a shade of its phoneme if it is nearer to that than to the phoneme's other letters.
A letter that a shade names, in spite of small marks, is that shade whatever phoneme it is like.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain, pairwise
from math import inf
from operator import attrgetter, itemgetter
from typing import Any, NamedTuple, Self

from lipsync_lang.text.phonology.ipa import Features, LabelReading, Numbers, key
from lipsync_lang.text.phonology.labels import Value

CLEAR_DIFFERENCE = 0.9
"""Minimum visible difference in a feature."""

SMALL_MARK = 0.35
"""Distance within which a letter with marks is still the letter itself: a nasal vowel, say."""


class Nearest(NamedTuple):
    """The common phonemes that look most like a label."""

    value: Value
    """Common phonemes in sequence with their shares; empty if nothing of the label is visible."""
    losses: tuple[str, ...]
    """Properties of the label that are not shown."""
    distance: float
    """Distance from the label to its value; 0 if a common phoneme names the label."""
    unknown: tuple[str, ...]
    """Characters that are not IPA; they are skipped."""


class Exemplar(NamedTuple):
    """A letter or a run of letters that a common phoneme names."""

    phoneme: str
    run: tuple[Numbers, ...]


class LabelPiece(NamedTuple):
    """Letters of a label that become one common phoneme."""

    distance: float
    exemplar: Exemplar
    start: int
    stop: int


class ShadeLabels(NamedTuple):
    """A shade: its parent, and the labels that it names."""

    parent: str
    labels: Sequence[str]


class _Cut(NamedTuple):
    """A possible first sound of a label."""

    cost: float
    size: int
    pieces: tuple[LabelPiece, ...]


@dataclass(frozen=True, eq=False)
class NearestPhonemes:
    """Finds the nearest among the common phonemes of one language.

    Parameters
    ----------
    features : the IPA
    candidates : for each common phoneme, the labels it names, most typical first
    shades : shades of the candidates by name; without them every answer is a candidate
    """

    features: Features
    candidates: Mapping[str, Sequence[str]]
    shades: Mapping[str, ShadeLabels] = field(default_factory=dict)
    _runs: dict[int, list[Exemplar]] = field(init=False, repr=False, default_factory=dict)
    _own: set[str] = field(init=False, repr=False, default_factory=set)
    _near: dict[tuple[Numbers, ...], tuple[float, Exemplar]] = field(
        init=False, repr=False, default_factory=dict
    )
    """The nearest exemplar of the same length, by run; in a tie, the first."""
    _seen: dict[str, Nearest] = field(init=False, repr=False, default_factory=dict)

    def __post_init__(self) -> None:
        for label, exemplar in self._exemplars(self._named()):
            self._runs.setdefault(len(exemplar.run), []).append(exemplar)
            self._own.add(label)
        self._own.update(key(label) for told in self.shades.values() for label in told.labels)

    def _named(self) -> Iterator[tuple[str, str]]:
        """Yield (common phoneme, label that it names), in order."""
        for phoneme, labels in self.candidates.items():
            passed = self.features.aside.get(phoneme, frozenset())
            yield from ((phoneme, label) for label in map(key, labels) if label not in passed)

    def _exemplars(self, named: Iterable[tuple[str, str]]) -> Iterator[tuple[str, Exemplar]]:
        """Yield the labels of phonemes that can be read, each with its exemplar."""
        for phoneme, label in named:
            sounds = self.features.read(label, own=(label,)).sounds
            if sounds:
                yield label, Exemplar(phoneme, tuple(sound.features for sound in sounds))

    @classmethod
    def from_plain(cls, data: Mapping[str, Any]) -> Self:
        """Make it of the data of the IPA and candidates, as JSON holds them."""
        shades = {name: ShadeLabels(*told) for name, told in data.get("shades", {}).items()}
        return cls(Features(data["features"]), data["candidates"], shades)

    def value(self, label: str) -> Value | None:
        """Return the nearest common phonemes; None if the label is not IPA, or none is near."""
        found = self.nearest(label)
        return None if found.unknown or found.distance == inf else found.value

    def nearest(self, label: str) -> Nearest:
        """Return the common phonemes nearest to a label; the same for the same label."""
        if label not in self._seen:
            self._seen[label] = self._nearest(self.read(label))
        return self._seen[label]

    def read(self, label: str) -> LabelReading:
        """Read a label as letters with features; those that a common phoneme names stay."""
        return self.features.read(label, own=self._own)

    def fights(self, label: str, phonemes: Sequence[str]) -> list[str]:
        """Return the conspicuous features of a label that common phonemes contradict.

        A label has a feature if any of its letters has it. A common phoneme has the features of
        the first label it names.
        """
        sounds = [sound.features for sound in self.read(label).sounds]
        shown = [run for name in phonemes for run in self._typical.get(name, ())]
        if not sounds or not shown:
            return []
        weighed = enumerate(zip(self.features.names, self.features.weights, strict=True))
        return [
            name
            for number, (name, weight) in weighed
            if weight >= self.features.fights_from
            and abs(_most(sounds, number) - _most(shown, number)) >= CLEAR_DIFFERENCE
        ]

    @cached_property
    def _typical(self) -> dict[str, tuple[Numbers, ...]]:
        """Common phoneme -> the letters of the first label it names."""
        typical: dict[str, tuple[Numbers, ...]] = {}
        for exemplar in chain(*self._runs.values(), self._shaded):
            typical.setdefault(exemplar.phoneme, exemplar.run)
        return typical

    def _nearest(self, reading: LabelReading) -> Nearest:
        runs = tuple(sound.features for sound in reading.sounds)
        cut = self._cut(runs)
        if cut is None:
            return Nearest((), reading.losses, inf, reading.unknown)
        pieces = [self._finer(piece, runs[piece.start : piece.stop]) for piece in cut]
        losses = list(reading.losses)
        times: list[tuple[str, float]] = []
        for piece in pieces:
            time = sum(sound.time for sound in reading.sounds[piece.start : piece.stop])
            name = piece.exemplar.phoneme
            if times and times[-1][0] == name:
                time += times.pop()[1]
            times.append((name, time))
            run = runs[piece.start : piece.stop]
            for sound, shown in zip(run, piece.exemplar.run, strict=True):
                losses += [
                    feature
                    for feature, a, b in zip(self.features.names, sound, shown, strict=True)
                    if a is not None and b is not None and abs(a - b) >= self.features.told_from
                ]
        whole = sum(time for _, time in times)
        value = tuple((name, time / whole) for name, time in times)
        far = sum((piece.distance for piece in pieces), 0.0)
        return Nearest(value, tuple(dict.fromkeys(losses)), far, reading.unknown)

    def _cut(self, runs: tuple[Numbers, ...]) -> tuple[LabelPiece, ...] | None:
        """Cut a label into the cheapest pieces by dynamic programming; None if impossible.

        The state is the end of the cut and the last phoneme: repeating it costs nothing extra.
        """
        cheapest = attrgetter("cost", "size")
        best: list[dict[str, _Cut]] = [{"": _Cut(0.0, 0, ())}]
        for stop in range(1, len(runs) + 1):
            best.append({})
            for length in (n for n in sorted(self._runs) if n <= stop):
                run = runs[stop - length : stop]
                if run not in self._near:
                    # Sums differ in their last digits by their order; rounded, a tie is a tie.
                    known = ((self.distance(run, e.run), e) for e in self._runs[length])
                    self._near[run] = min(known, key=lambda d: round(d[0], 9))
                found = self._near[run]
                piece = LabelPiece(*found, stop - length, stop)
                name = piece.exemplar.phoneme
                for last, (cost, size, before) in best[stop - length].items():
                    another = 0.0 if last == name else self.features.another
                    far = round(cost + piece.distance + another, 9)
                    cut = _Cut(far, size + 1, (*before, piece))
                    best[-1][name] = min(best[-1].get(name, cut), cut, key=cheapest)
        return min(best[-1].values(), key=cheapest).pieces if best[-1] else None

    def _finer(self, piece: LabelPiece, run: tuple[Numbers, ...]) -> LabelPiece:
        """Return a piece as the nearest shade of its phoneme, else as it is."""
        phoneme = piece.exemplar.phoneme
        known = [
            (round(self.distance(run, one.run), 9), one.phoneme, one)
            for one in self._shaded
            if len(one.run) == len(run)
        ]
        nearness = itemgetter(0, 1)  # exemplars cannot be compared
        found = min(known, key=nearness, default=None)
        if found is None or found[1] not in self.shades or found[0] > SMALL_MARK:
            own = {phoneme, *(name for name, told in self.shades.items() if told.parent == phoneme)}
            found = min((one for one in known if one[1] in own), key=nearness, default=None)
        if found is None or found[1] == phoneme:
            return piece
        return piece._replace(distance=found[0], exemplar=found[2])

    @cached_property
    def _shaded(self) -> list[Exemplar]:
        """Exemplars of shades, and of the phonemes beside them.

        A letter that features keep from the parent of a shade is kept from the shade.
        """
        aside = self.features.aside
        named = [
            (shade, label)
            for shade, (parent, labels) in self.shades.items()
            for label in map(key, labels)
            if label not in aside.get(parent, ())
        ]
        taken = {label for _, label in named}
        rest = [(p, label) for p, label in self._named() if named and label not in taken]
        return [exemplar for _, exemplar in self._exemplars((*named, *rest))]

    def distance(self, run: Sequence[Numbers], other: Sequence[Numbers]) -> float:
        """Return the distance between two runs of equal length."""
        far = 0.0
        for number, (one, two) in enumerate(zip(run, other, strict=True)):
            far += self._differ(one, two) * (self.features.later if number else 1.0)
        for (a, b), (c, d) in zip(pairwise(run), pairwise(other), strict=True):
            far += self._differ(_move(a, b), _move(c, d))
        return far

    def _differ(self, one: Numbers, other: Numbers) -> float:
        return sum(
            weight * abs(a - b)
            for weight, a, b in zip(self.features.weights, one, other, strict=True)
            if a is not None and b is not None
        )


def _most(sounds: Iterable[Numbers], number: int) -> float:
    """Return the largest value of a feature among the sounds."""
    return max(sound[number] or 0.0 for sound in sounds)


def _move(one: Numbers, other: Numbers) -> Numbers:
    """Return the change of each feature from one letter to the next."""
    return tuple(None if a is None or b is None else b - a for a, b in zip(one, other, strict=True))
