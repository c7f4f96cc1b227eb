"""Convert eSpeak NG's names of phonemes to labels."""

import re

_MARKS = "ˈˌ0123456789"
_STRESSED = re.compile("([ˈˌ])")


def words_of(clause: str) -> list[tuple[str, ...]]:
    """Return the labels of each word of a clause, as events have them.

    `clause` has phonemes joined by ``_`` and words by spaces.
    """
    words = []
    for word in clause.split():
        labels: list[str] = []
        for name in _STRESSED.sub(r"_\1", word).split("_"):
            label = label_of(name)
            if label and labels and modifies(label):
                labels[-1] += label
            elif label:
                labels.append(label)
        if labels:
            words.append(tuple(labels))
    return words


def label_of(name: str) -> str:
    """Return the bare sound of a name; empty for flags and marks, which have none."""
    return "" if name.startswith("(") else name.strip(_MARKS)


def modifies(label: str) -> bool:
    """Return True for a label that is only a modifier letter or a combining mark."""
    return 0x2B0 <= ord(label[0]) <= 0x36F  # noqa: PLR2004 the two blocks in Unicode
