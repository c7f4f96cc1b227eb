"""Sounds that follow each other faster than anyone speaks."""

import pytest

import lipsync_lang as ll
from lipsync_lang.performing.label_reader import label_remarks


def told(labels, times, words=()):
    performer = ll.resolve("english", "facefx")
    schedule = ll.Schedule(labels, times, words, notation="arpabet", source="line.json")
    return [one for one in label_remarks(performer.labels, schedule) if "nobody speaks" in one]


@pytest.mark.parametrize(("seconds", "fast"), [(0.003, True), (0.02, True), (0.03, False)])
def test_many_sounds_in_no_time_are_told(seconds, fast):
    labels = ("M", "AA1") * 8
    found = told(labels, [at * seconds for at in range(17)])
    assert bool(found) == fast
    if fast:
        assert f"8 sounds in {8 * seconds:.2f} s, at 0.00 s and 8 more; check its times" in found[0]


def test_a_word_of_no_time_is_told():
    labels, times = ("_", "M", "AE1", "P", "S", "_"), [0, 0.5, 0.51, 0.52, 0.53, 0.54, 1]
    (found,) = told(labels, times, (ll.Word("maps", 1, 5),))
    assert "'maps' at 0.50 s, in 0.04 s" in found
    assert not told(labels, [0, 0.5, 0.55, 0.6, 0.65, 0.7, 1], (ll.Word("maps", 1, 5),))


def test_a_pause_between_them_does_not_make_sounds_slow():
    labels = ("M", "AA1", "_") * 5
    times = [n // 3 * 0.5 + (0, 0.01, 0.02)[n % 3] for n in range(16)]
    assert told(labels, times)
