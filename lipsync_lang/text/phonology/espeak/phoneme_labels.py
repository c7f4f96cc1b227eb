"""Conversion of eSpeak NG's names of phonemes to labels."""

import re

_NAME_MARKS = "ˈˌ0123456789"
STRESS_LEVELS = {"ˈ": 1, "ˌ": 2}
"""Stress by mark: primary and secondary."""

_STRESSED = re.compile("([ˈˌ])")


def words_of(clause: str) -> list[tuple[str, ...]]:
    """Return the labels of each word of a clause, as events have them, after their stress marks.

    `clause` has phonemes joined by ``_`` and words by spaces.

    >>> words_of("h_ə_lˈoʊ w_ɜː_l_d")
    [('h', 'ə', 'l', 'ˈoʊ'), ('w', 'ɜː', 'l', 'd')]
    """
    words = []
    for word in clause.split():
        labels: list[str] = []
        for name in _STRESSED.sub(r"_\1", word).split("_"):
            label = label_of(name)
            if label and labels and modifies(label):
                labels[-1] += label
            elif label:
                labels.append(name[0] + label if name[0] in STRESS_LEVELS else label)
        if labels:
            words.append(tuple(labels))
    return words


def label_of(name: str) -> str:
    """Return the bare sound of a name; empty for flags and marks."""
    return "" if name.startswith("(") else name.strip(_NAME_MARKS)


def stress_of(name: str) -> int | None:
    """Return the stress that a name is marked with: 1, 2 or None."""
    return next((level for mark, level in STRESS_LEVELS.items() if mark in name), None)


def modifies(label: str) -> bool:
    """Return True for a label that is only a modifier letter or a combining mark."""
    return 0x2B0 <= ord(label[0]) <= 0x36F  # noqa: PLR2004 the two blocks in Unicode
