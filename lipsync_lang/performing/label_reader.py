"""Labels of a schedule, read: their notation, and the common phonemes that they stand for."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Literal
from weakref import WeakKeyDictionary

import numpy as np

from lipsync_lang.errors import ScheduleError, did_you_mean
from lipsync_lang.packs.finding import IPA
from lipsync_lang.phonology.g2p.tokens import plain
from lipsync_lang.phonology.labels import Notation, Value, recognise
from lipsync_lang.phonology.notations import ready
from lipsync_lang.pipeline.arrays import Floats, Ints
from lipsync_lang.schedules.schedule import Schedule

if TYPE_CHECKING:
    from lipsync_lang.phonology.nearest import Nearest, NearestPhonemes
    from lipsync_lang.resolver.compiled import Compiled

Unknown = Literal["error", "rest", "nearest"]
"""Ways to treat labels that no notation maps; the `nearest` are those of IPA by their features."""


@dataclass(frozen=True, eq=False)
class LabelReader:
    """The notations of a resolved language, ready to read any schedule.

    Parameters
    ----------
    compiled : the language-character pair
    unknown : an `error` for labels that no notation maps, `rest`, or, of IPA, the `nearest`
    paths : folders to search for packs before all others, where a message needs some
    """

    compiled: "Compiled"
    unknown: Unknown = "error"
    paths: tuple[Path, ...] = ()

    def common_phonemes(self, schedule: Schedule) -> tuple[Ints, Floats, Ints]:
        """Map a schedule's labels to common phonemes.

        Returns
        -------
        (m,) numbers of common phonemes, (m + 1,) boundaries in seconds, (m,) the index of the
        scheduled phoneme each came from
        """
        values = self._values(schedule)
        if all(len(value) == 1 for value in values):
            numbers = np.array([self._numbers[value[0][0]] for value in values])
            return numbers, schedule.times, np.arange(len(numbers))
        ids: list[int] = []
        starts: list[float] = []
        source: list[int] = []
        times = schedule.times.tolist()
        for index, value in enumerate(values):
            at, length = times[index], times[index + 1] - times[index]
            for name, share in value:
                ids.append(self._numbers[name])
                starts.append(at)
                source.append(index)
                at += share * length
        if not ids:
            raise ScheduleError(
                f"{schedule.source}: all its labels are mute; there is no sound in it"
            )
        starts[0] = times[0]
        return np.array(ids), np.array([*starts, times[-1]]), np.array(source)

    def automatic(self, schedule: Schedule) -> "dict[str, Nearest]":
        """Return what features alone made of a schedule's labels: each that no pack maps, once.

        The common phonemes with their shares, what of the label is not shown, and how far it is
        from what is. Empty for a language that maps all its labels itself.
        """
        notation, near = self.notation(schedule), self.near
        if near is None or notation.nearest is None:
            return {}
        unmapped = (label for label in schedule.labels if notation.stated(label) is None)
        found = {label: near.nearest(notation.text(label) or label) for label in unmapped}
        return {label: nearest for label, nearest in found.items() if not nearest.unknown}

    def _values(self, schedule: Schedule) -> list[Value]:
        """Return what each label stands for, words of the language's own said its way."""
        notation = self.notation(schedule)
        values = self._found(schedule, notation)
        own = self.compiled.words if schedule.language == self.compiled.language else {}
        for word in schedule.words if own else ():
            sounds = own.get(plain(word.text))
            if sounds:
                values[word.first : word.stop] = _spread(sounds, word.stop - word.first)
        unknown = [i for i, value in enumerate(values) if value is None]
        if unknown and self.unknown != "rest":
            raise ScheduleError(self._unknown(schedule, unknown, notation))
        rest: Value = ((self.compiled.phonemes[0], 1.0),)
        return [rest if value is None else value for value in values]

    def classes(self, schedule: Schedule) -> list[str]:
        """Return the class of each label's first sound; nothing for silence."""
        kinds, silence = self.compiled.manner["kinds"], self.compiled.phonemes[0]
        firsts = [value[0][0] if value else silence for value in self._values(schedule)]
        return ["" if name == silence else kinds.get(name) or "sound" for name in firsts]

    def _found(self, schedule: Schedule, notation: Notation) -> list[Value | None]:
        """Return what the notation says of each label, and of unknown IPA what is asked for."""
        values = [notation.find(label) for label in schedule.labels]
        wanted = self.unknown == "nearest" and notation is self.notations.get(IPA)
        near = self._hints if wanted and None in values else None
        if near is None:
            return values
        return [
            near.value(label) if value is None else value
            for label, value in zip(schedule.labels, values, strict=True)
        ]

    def notation(self, schedule: Schedule) -> Notation:
        """Return the notation of a schedule's labels: the one it states, else the likeliest."""
        name = schedule.notation
        if name is None:
            name = self._recognised.get(schedule)
        if name is None:
            shapes = self.compiled.visemes.keys() - self.compiled.notations.keys()
            own = {one: n for one, n in self.notations.items() if one not in shapes}
            name = recognise(schedule.labels, own)
            self._recognised[schedule] = name
        if name not in self.notations:
            raise ScheduleError(
                f"{schedule.source}: {self.compiled.language} has no notation '{name}'; "
                f"{did_you_mean(name, self.notations)}"
            )
        return self.notations[name]

    @cached_property
    def notations(self) -> dict[str, Notation]:
        """The notations of the language and of mouth shapes, by name."""
        silence: Value = ((self.compiled.phonemes[0], 1.0),)
        near = self.near.value if self.near is not None else None
        tables = {**self.compiled.visemes, **self.compiled.notations}
        spelling, silences = self.compiled.spelling, self.compiled.silences
        return ready(tables, silences, silence, IPA, spelling, near)

    @cached_property
    def near(self) -> "NearestPhonemes | None":
        """The nearest phonemes by features; None for a language that maps its labels itself."""
        from lipsync_lang.phonology.nearest import NearestPhonemes

        data = self.compiled.nearest
        return None if data is None else NearestPhonemes.from_plain(data)

    @cached_property
    def _hints(self) -> "NearestPhonemes | None":
        """What finds the nearest for messages alone: it is read only once something is wrong."""
        from lipsync_lang.resolver.nearest_phonemes import among_shared

        return self.near or among_shared(self.compiled.phonemes[1:], self.paths)

    @cached_property
    def _numbers(self) -> dict[str, int]:
        return {name: number for number, name in enumerate(self.compiled.phonemes)}

    @cached_property
    def _recognised(self) -> "WeakKeyDictionary[Schedule, str]":
        return WeakKeyDictionary()

    def _hint(self, label: str, notation: str) -> str:
        """Say which label may be meant, what one of the IPA is nearest to, or why it is none."""
        known = self.notations[notation]
        hints = [known.suggest(label)] if known.table else []
        near = self._hints if notation == IPA else None
        found = near.nearest(label) if near is not None else None
        if found is not None and found.unknown:
            hints.append(f"no IPA: {' '.join(found.unknown)}")
        elif found is not None and found.value:
            hints.append(f"nearest by its features: {' '.join(n for n, _ in found.value)}")
        return "; ".join(hints)

    def _unknown(self, schedule: Schedule, at: list[int], notation: Notation) -> str:
        name = next(n for n, known in self.notations.items() if known is notation)
        lines = [
            f"{schedule.place(i)}: phoneme {i} ({schedule.labels[i]!r}, {schedule.times[i]:g} to "
            f"{schedule.times[i + 1]:g} s) is not in the {name} of {self.compiled.language}; "
            f"{self._hint(schedule.labels[i], name)}"
            for i in at[:8]
        ]
        more = f"\n... and {len(at) - 8} more" if len(at) > 8 else ""  # noqa: PLR2004 a screenful
        mend = (
            f"\nAdd them to {self.compiled.language}'s notations, name the notation they are in "
            "(`notation='NAME'`), or ask for unknown labels at rest (`unknown='rest'`)"
        )
        mend += " or by their features (`unknown='nearest'`)" if name == IPA else ""
        return "\n".join(lines) + more + mend


def _spread(sounds: tuple[str, ...], count: int) -> list[Value]:
    """Share a word's common phonemes out over the labels it was given, in order.

    A sound that lasts over several labels is stated at the first; the others add their time to it.
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
