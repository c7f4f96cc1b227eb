"""Spellings of labels in a table of a notation."""

from lipsync_lang.text.phonology.labels import normalise


def spelling_conflicts(table):
    """The pairs of labels with equal spellings but different values."""
    first = {}
    return [
        (first[same], label)
        for label, value in table.items()
        if first.setdefault(same := normalise(label), label) != label
        and table[first[same]] != value
    ]
