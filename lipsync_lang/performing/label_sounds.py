"""Label sounds: the common phonemes of the labels of a schedule, with their times.

Conventions: times are seconds; (n,) is labels, (m,) their sounds; a label can have several sounds.
A mark of stress is -1 for no mark.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from lipsync_lang.base.arrays import Floats, Ints
from lipsync_lang.pipeline import kernel
from lipsync_lang.text.phonology.labels import Notation, Value

MARK = 1 << 16
"""Unit of the mark in the code of a label; the rest of the code is its common phoneme."""

SEVERAL, UNMARKED = MARK - 1, -1
"""Code of a label that has not one sound, and mark of a label without stress."""


class LabelSounds(NamedTuple):
    """The sounds of a schedule."""

    ids: Ints
    """(m,) common phonemes."""
    times: Floats
    """(m + 1,) boundaries."""
    source: Ints
    """(m,) index of the label of each common phoneme."""
    marks: Ints
    """(n,) mark of stress of each label, or (0,) if no label has one."""

    def firsts(self, count: int) -> Ints:
        """Return the first common phoneme of each of `count` labels; silence, 0, for a mute one."""
        firsts = np.zeros(count, np.intp)
        # backwards: of several sounds to a label, the first is written last, and stays
        firsts[self.source[::-1]] = self.ids[::-1]
        return firsts


def sounds_of(
    values: Sequence[Value], times: Floats, marks: Ints, numbers: Mapping[str, int]
) -> LabelSounds | None:
    """Return the sounds of a schedule by the value of each label; None without any.

    Parameters
    ----------
    times : (n + 1,) boundaries of the labels
    numbers : number of each common phoneme
    """
    ids, bounds, source, at = list[int](), list[float](), list[int](), times.tolist()
    # a loop, because most lines are short: for some tens of labels arrays take longer
    for label, value in enumerate(values):
        start, length = at[label], at[label + 1] - at[label]
        for name, share in value:
            ids.append(numbers[name])
            bounds.append(start)
            source.append(label)
            start += share * length
    if not ids:
        return None
    # mute labels at the start have no sounds; the first sound takes their time
    bounds[0] = at[0]
    bounds.append(at[-1])
    return LabelSounds(np.array(ids, np.intp), np.array(bounds), np.array(source, np.intp), marks)


class LabelTable(dict[str, int]):
    """Codes of the labels of a notation: each its common phoneme and its mark of stress.

    Each label is looked up in the notation only once; `found` has its values.
    """

    def __init__(self, notation: Notation, numbers: Mapping[str, int]) -> None:
        super().__init__()
        self._notation, self._numbers = notation, numbers
        self.found: dict[str, Value | None] = {}

    def __missing__(self, label: str) -> int:
        value, mark = self._notation.find(label), self._notation.stress(label)
        self.found[label] = value
        number = SEVERAL if value is None or len(value) != 1 else self._numbers[value[0][0]]
        return self.setdefault(label, number if mark is None else number + (mark + 1) * MARK)

    def read(self, labels: tuple[str, ...]) -> tuple[Ints | None, Ints]:
        """Return the common phoneme of each label, (n,), and its mark, or (0,) if none has one.

        The first is None unless each label has one sound.
        """
        if kernel.compiled is not None:
            both = np.empty((2, len(labels)), np.intp)
            marked = kernel.compiled.look_up(self, labels, both, MARK)
            if marked >= 0:
                return both[0], both[1, :marked]
        # `__missing__` runs only for new labels, so known ones are looked up in C alone
        codes = np.array(list(map(self.__getitem__, labels)), np.intp)
        ids, marks = codes % MARK, codes // MARK + UNMARKED
        return None if ids.max() == SEVERAL else ids, marks if marks.max() >= 0 else marks[:0]
