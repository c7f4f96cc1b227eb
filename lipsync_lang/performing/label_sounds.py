"""Label sounds: converts the labels of many schedules at once, in a few array operations.

Conventions: times are seconds; (n,) is labels, (m,) their sounds; a label can have several sounds.
A mark of stress is -1 for no mark.
"""

from collections.abc import Callable, Mapping, Sequence
from threading import Lock
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.text.phonology.labels import Notation, Value

UNKNOWN, UNMARKED = -1, -1
"""Number of a label without a value, and mark of a label without stress."""


class LabelSounds(NamedTuple):
    """The sounds of a schedule."""

    ids: Ints
    """(m,) common phonemes."""
    times: Floats
    """(m + 1,) boundaries."""
    source: Ints
    """(m,) index of the label of each common phoneme."""
    marks: Ints
    """(n,) mark of stress of each label; (0,) if no label in the batch has one."""

    def firsts(self, count: int) -> Ints:
        """Return the first common phoneme of each of `count` labels; silence, 0, for a mute one."""
        firsts = np.zeros(count, np.intp)
        # backwards: of several sounds to a label, the first is written last, and stays
        firsts[self.source[::-1]] = self.ids[::-1]
        return firsts


class ValueTable:
    """Values of labels by number, and their sounds as arrays.

    Parameters
    ----------
    numbers : number of each common phoneme
    """

    def __init__(self, numbers: Mapping[str, int]) -> None:
        self._numbers = numbers
        self._known: dict[Value, int] = {}
        self._lock = Lock()
        self._arrays: tuple[Ints, Ints, Ints, Floats] = self._flat()

    def number(self, value: Value) -> int:
        """Return the number of a value."""
        found = self._known.get(value)
        if found is None:
            with self._lock:
                # a thread that waited for the lock finds the number that the other one gave
                found = self._known.setdefault(value, len(self._known))
                self._arrays = self._flat()
        return found

    def _flat(self) -> tuple[Ints, Ints, Ints, Floats]:
        # made anew for each new value: they are few, and reading needs no lock then
        counts = np.array([len(value) for value in self._known], np.intp)
        sounds = [sound for value in self._known for sound in value]
        ids = np.array([self._numbers[name] for name, _ in sounds], np.intp)
        shares = np.array([share for _, share in sounds], np.float64)
        # an exclusive running sum: the place at which the sounds of each value begin
        return counts, np.cumsum(counts) - counts, ids, shares

    def sounds(
        self, values: Ints, marks: Ints, times: Sequence[Floats]
    ) -> list[LabelSounds | None]:
        """Return the sounds of schedules; None for one without any.

        Parameters
        ----------
        values : (n,) numbers of values of all labels, one schedule after the other
        marks : (n,) their marks of stress
        times : boundaries of each schedule
        """
        # one read of the tuple: another thread may replace it between two reads
        counts, firsts, ids, shares = self._arrays
        # an empty array tells later steps at once that nothing in the batch is marked
        marks = marks if marks.max() >= 0 else marks[:0]
        count, first = counts[values], firsts[values]
        # most notations: the boundaries of the labels serve as they are, without arithmetic
        if (count == 1).all():
            return list(_single(ids[first], marks, times))
        ends = np.cumsum(count)
        source = np.repeat(np.arange(len(values)), count)
        # 0, 1, 2, ... within each label, from one count over all sounds of the batch
        within = np.arange(len(source)) - (ends - count)[source]
        at = np.concatenate([one[:-1] for one in times])[source]
        length = np.concatenate([one[1:] - one[:-1] for one in times])[source]
        # an index into the flat values for every sound: of the first sound of its value
        begins = first[source]
        for passed in range(int(count.max()) - 1):  # as far as the longest value, one by one
            later = within > passed
            # adding share by share rounds as a loop over one label does; a running sum
            # over the batch would let a line depend on the lines before it
            at[later] += shares[begins[later] + passed] * length[later]
        found = ids[begins + within]
        out: list[LabelSounds | None] = []
        label = sound = 0
        for own in times:
            past = label + len(own) - 1
            # `ends` counts sounds of the whole batch, so it tells where this schedule stops
            stop = int(ends[past - 1])
            if stop == sound:
                out.append(None)
            else:
                bounds = np.append(at[sound:stop], own[-1])
                # mute labels at the start have no sounds; the first sound takes their time
                bounds[0] = own[0]
                here = source[sound:stop] - label
                out.append(LabelSounds(found[sound:stop], bounds, here, marks[label:past]))
            label, sound = past, stop
        return out


def _single(ids: Ints, marks: Ints, times: Sequence[Floats]) -> "list[LabelSounds]":
    """Return the sounds of schedules in which each label has one sound."""
    out, label = [], 0
    # one range for all schedules, which share views of it
    source = np.arange(max(map(len, times)) - 1)
    for own in times:
        past = label + len(own) - 1
        here = source[: past - label]
        out.append(LabelSounds(ids[label:past], own, here, marks[label:past]))
        label = past
    return out


class LabelTable:
    """Labels of a notation by number, each with its value and its mark of stress.

    Each label is looked up in the notation only once.
    """

    def __init__(self, notation: Notation, values: ValueTable) -> None:
        self._notation, self._values = notation, values
        self._lock = Lock()
        self._known = _LabelNumbers(self._add)
        self._rows: list[tuple[int, int]] = []
        self._arrays = np.empty((0, 2), np.intp)

    def read(self, labels: Sequence[str]) -> tuple[Ints, Ints]:
        """Return numbers of the value and the mark of each label, (n,); `UNKNOWN` for no value."""
        # `__missing__` runs only for new labels, so known ones are looked up in C alone
        at = np.fromiter(map(self._known.__getitem__, labels), np.intp, len(labels))
        # the array is made anew only after new labels, not with each of them
        if len(self._arrays) < len(self._rows):
            self._arrays = np.array(self._rows, np.intp)
        found = self._arrays[at]
        return found[:, 0], found[:, 1]

    def _add(self, label: str) -> int:
        value, mark = self._notation.find(label), self._notation.stress(label)
        row = (
            UNKNOWN if value is None else self._values.number(value),
            UNMARKED if mark is None else mark,
        )
        # the number of a row is its place, so no other thread may append in between
        with self._lock:
            self._rows.append(row)
            return len(self._rows) - 1


class _LabelNumbers(dict[str, int]):
    """Numbers of labels; a missing label gets a new number."""

    def __init__(self, add: Callable[[str], int]) -> None:
        super().__init__()
        self._add = add

    def __missing__(self, label: str) -> int:
        return self.setdefault(label, self._add(label))
