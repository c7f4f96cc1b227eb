"""Phonemes that a person changed, counted in the schedule without changes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lipsync_lang as ll
from lipsync_lang.schedules.phoneme_changes import composed, misfit, with_changes

LINE = ll.Schedule(
    ("M", "AA", "_", "B", "IY"), np.array([0, 0.1, 0.3, 0.35, 0.4, 0.6]),
    words=(ll.Word("ma", 0, 2), ll.Word("be", 3, 5)), notation="arpabet",
)  # fmt: skip


@pytest.mark.parametrize(
    ("change", "labels", "words"),
    [((1, ["AA"], ["AE"]), "M AE _ B IY", [(0, 2), (3, 5)]),
     ((1, ["AA"], ["AA", "T"]), "M AA T _ B IY", [(0, 3), (4, 6)]),
     ((3, ["B", "IY"], ["IY"]), "M AA _ IY", [(0, 2), (3, 4)]),
     ((3, ["B", "IY"], ["B"]), "M AA _ B", [(0, 2), (3, 4)]),
     ((1, ["AA", "_"], ["AA"]), "M AA B IY", [(0, 2), (2, 4)]),
     ((2, ["_", "B"], ["B"]), "M AA B IY", [(0, 2), (2, 4)]),
     ((1, ["AA", "_", "B"], ["L", "N"]), "M L N IY", [(0, 2), (2, 4)])],
)  # fmt: skip
def test_phonemes_change_and_words_keep_theirs(change, labels, words):
    made = with_changes(LINE, [change])
    assert " ".join(made.labels) == labels
    assert [(one.first, one.stop) for one in made.words] == words
    assert (made.start, made.end) == (LINE.start, LINE.end)


def test_phonemes_share_the_time_of_those_before():
    made = with_changes(LINE, [(1, ["AA"], ["AA", "T"]), (3, ["B", "IY"], ["B"])])
    assert made.times == pytest.approx([0, 0.1, 0.2, 0.3, 0.35, 0.6])


def test_stress_stays_with_its_label():
    marked = replace(LINE, stress=(None, 1, None, None, 0), lines=(1, 2, 3, 4, 5))
    made = with_changes(marked, [(0, ["M", "AA"], ["AA"]), (4, ["IY"], ["EY"])])
    assert (made.stress, made.lines) == ((1, None, None, 0), (1, 3, 4, 5))


def test_a_word_without_phonemes_is_refused():
    with pytest.raises(ll.LipsyncError, match="word 'be' would have no phoneme left"):
        with_changes(LINE, [(2, ["_", "B", "IY"], ["_"])])


def test_other_phonemes_than_those_before_are_told():
    assert not misfit(LINE, [(1, ["AA"], ["AE"])])
    assert misfit(LINE, [(1, ["AE"], ["AA"])]) == "phoneme 1 was 'AE', and is 'AA' now"
    assert misfit(LINE, [(4, ["IY", "T"], ["AA"])]) == "phoneme 5 was 'T', and is missing now"
    assert misfit(LINE, [(1, ["AA"], ["T"]), (1, ["AA"], ["B"])]) == "phoneme 1 is changed twice"


NEW = st.lists(st.sampled_from("AB"), min_size=1, max_size=3)
STEP = st.tuples(st.floats(0, 1), st.integers(1, 3), NEW)


@given(st.text("AB", min_size=1, max_size=8), st.lists(STEP, max_size=8))
def test_changes_one_after_the_other_are_one_list(text, steps):
    line = ll.Schedule(tuple(text), np.arange(len(text) + 1))
    labels, changes = tuple(text), []
    for place, count, new in steps:
        first = min(int(place * len(labels)), len(labels) - 1)
        stop = min(first + count, len(labels))
        changes = composed(line, changes, (first, stop), new)
        labels = (*labels[:first], *new, *labels[stop:])
        assert not misfit(line, changes)
        assert with_changes(line, changes).labels == labels
