"""Gestures in a stream are those of the whole line, however it comes, at the stated delay."""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full
from strategies import RATES

import lipsync_lang as ll
from lipsync_lang.base.errors import LipsyncError, ScheduleError
from lipsync_lang.schedules.schedule import Word

SPOKEN = [
    ("M AA1 M AH0", "mama"), ("T IY1", "no"), ("S OW1 D AH0", "yes"), ("K AA1 R", "where"),
    ("_", None), ("_", None),
]  # fmt: skip
LENGTHS = st.sampled_from([0.05, 0.05, 0.1, 0.1, 0.12, 0.3, 0.7, 2.0])
EVERY = ("arkit", *(pytest.param(name, marks=full) for name in ("vrm", "crab", "facefx")))


@cache
def resolved(name):
    return ll.resolve("english", name)


@st.composite
def lines(draw):
    """A line with words and pauses, and with emphasis here and there; or labels alone."""
    labels, words = [], []
    worded = draw(st.booleans())
    for sounds, text in draw(st.lists(st.sampled_from(SPOKEN), min_size=1, max_size=30)):
        first = len(labels)
        labels += sounds.split()
        if text and worded:
            emphasis = draw(st.sampled_from([0.0, 0.0, 0.0, 1.0]))
            words.append(Word(text, first, len(labels), emphasis))
    labels += ["AA1", "_"]
    lengths = draw(st.lists(LENGTHS, min_size=len(labels) - 1, max_size=len(labels) - 1))
    start = draw(st.sampled_from([0.0, -1.0, 3.3]))
    times = start + np.cumsum([0.0, *lengths, draw(st.sampled_from([0.3, 1.0]))])
    return ll.Schedule(labels, times, words, notation="arpabet")


def part(line, first, stop):
    words = [
        Word(one.text, one.first - first, one.stop - first, one.emphasis)
        for one in line.words
        if first <= one.first < stop
    ]
    return ll.Schedule(line.labels[first:stop], line.times[first : stop + 1], words,
                       notation="arpabet")  # fmt: skip


def fed(stream, line, draw):
    """Feed a line in drawn parts that divide no word, and return all frames.

    The silence before the first word comes with it.
    """
    found = []
    inside = {at for one in line.words for at in range(one.first + 1, one.stop)}
    inside |= {*range(line.words[0].first + 1)} if line.words else set()
    cuts = [at for at in range(1, len(line.labels)) if at not in inside and draw(st.booleans())]
    for first, stop in pairwise([0, *cuts, len(line.labels)]):
        if line.words:
            stream.feed(part(line, first, stop))
        else:
            for at in range(first, stop):
                end = line.times[at + 1] if draw(st.booleans()) else None
                stream.feed(line.labels[at], line.times[at], end)
        if draw(st.booleans()):
            found.append(stream.frames(draw(st.one_of(st.none(), st.floats(-3, 10)))))
    stream.known_until(line.end)
    stream.finish()
    found.append(stream.frames())
    return [np.concatenate(parts) for parts in zip(*found, strict=True)]


def opened(name, fps=60, gestures="all", **how):
    return resolved(name).stream(fps, notation="arpabet", stress=True, emphasis=True,
                                 gestures=gestures, **how)  # fmt: skip


@pytest.mark.parametrize("name", EVERY)
@given(st.data(), lines(), RATES)
def test_gestures_of_a_stream_are_those_of_the_whole_line(name, data, line, fps):
    gestures = data.draw(st.sampled_from(["all", "blink", "all,blink:2"]))
    performer = resolved(name)
    whole = performer.perform(line, fps, gestures=gestures)
    stream = opened(name, fps, gestures)
    if data.draw(st.booleans()):
        stream.ends_at(line.end)
    times, weights = fed(stream, line, data.draw)
    assert stream.poses == whole.poses
    assert np.array_equal(times, whole.times)
    assert np.abs(weights - whole.weights).max() <= 1e-6
    moved = weights[:, -len(performer.gesture_set.poses) :]
    assert (moved >= performer.gesture_set.low - 1e-9).all()
    assert (moved <= performer.gesture_set.high + 1e-9).all()
    assert (np.abs(np.diff(moved, axis=0)) <= performer.gesture_set.speed / fps + 1e-9).all()


WORDY = [("M", "AA1", "M", "AH0"), ("T", "IY1"), ("S", "OW1", "D", "AH0"), ("K", "AA1", "R")] * 12
LABELS = [label for word in WORDY for label in word]
LONG = ll.Schedule(LABELS, np.arange(len(LABELS) + 1) * 0.1, notation="arpabet")


def given_frames(stream, line):
    found = []
    for label, start, end in zip(line.labels, line.times, line.times[1:], strict=False):
        stream.feed(label, start, end)
        found.append(stream.frames())
        # the newest phoneme begins 0.1 s before its end, and may be followed by a silence
        if stream.final_until is not None:
            assert stream.final_until >= start - stream.delay - 2 / stream.fps
    return found


@pytest.mark.parametrize("ended", [True, False])
def test_a_frame_is_final_by_the_stated_delay(ended):
    stream = opened("arkit")
    if ended:
        stream.ends_at(LONG.end)
        assert 1 < stream.delay < 1.6
    assert sum(stream.delays.values()) == pytest.approx(stream.delay)
    assert sum(len(one.times) for one in given_frames(stream, LONG)) > 0
    assert stream.final_until >= LONG.times[-2] - stream.delay - 2 / 60


def test_a_character_scales_gestures_of_a_stream_and_has_no_words_there(tmp_path):
    (tmp_path / "characters").mkdir()

    def blinking(stated):
        text = f"kind: character\nformat: 1\nname: anna\nposeset: arkit\n{stated}\n"
        (tmp_path / "characters/anna.yaml").write_text(text, "utf-8")
        performer = ll.resolve("english", "anna", paths=[tmp_path], cache=False)
        stream = performer.stream(60, gestures="blink")
        stream.feed("_", 0, 20)
        stream.finish()
        return stream.frames()[1].max()

    assert blinking("gestures: {blink: 0.5}") == pytest.approx(blinking("") / 2)
    with pytest.raises(LipsyncError, match=r"dials: jaw has points .* give jaw a single level"):
        blinking("dials: {jaw: [[0, 0.5], [1, 0.5]]}")


def test_only_long_gestures_need_the_end_of_the_line():
    blinks, every = opened("arkit", gestures="blink"), opened("arkit")
    before = blinks.delay, every.delay
    for stream in (blinks, every):
        stream.ends_at(9.0)
    assert before[0] == blinks.delay < every.delay < before[1]


def test_the_same_line_has_the_same_bytes():
    one, other = (given_frames(opened("arkit"), LONG) for _ in range(2))
    assert [a.weights.tobytes() for a in one] == [b.weights.tobytes() for b in other]


def test_what_gestures_depend_on_is_not_revised():
    stream, again = opened("arkit"), opened("arkit")
    found = []
    for one in (stream, again):
        one.ends_at(11.0)
        one.feed(part(LONG, 0, 100))
        found = [one.frames()]
    shown = found[0].times[-1]
    with pytest.raises(LipsyncError, match="depend on the phonemes"):
        stream.revise(shown + 0.5)
    changed = shown + stream.delay + 0.05
    again.revise(changed)
    again.feed("S", changed, 10.5)
    again.known_until(11.0)
    again.finish()
    found.append(again.frames())
    kept = int(np.searchsorted(LONG.times, changed))
    times = [*LONG.times[:kept], changed, 10.5, 11.0]
    line = ll.Schedule((*LONG.labels[:kept], "S", "_"), times, notation="arpabet")
    whole = resolved("arkit").perform(line, gestures="all").weights
    assert np.abs(np.concatenate([one.weights for one in found]) - whole).max() <= 1e-6


def test_hours_of_gestures_need_no_more_memory_than_seconds():
    stream, sizes = opened("arkit", 24), []
    pattern = [*zip(("M", "AA1", "S", "IY1", "_"), (0.1, 0.2, 0.1, 0.2, 0.4), strict=True)]
    at = 0.0
    for number in range(1500):
        label, length = pattern[number % len(pattern)]
        stream.feed(label, at, at + length)
        at += length
        stream.frames()
        sizes.append(stream.held)
    assert max(sizes[750:]) <= max(sizes[100:750])


def test_a_line_that_does_not_end_as_stated_is_refused():
    stream = opened("arkit")
    stream.ends_at(2.0)
    stream.feed("AA1", 0, 1.9)
    for end in (1.9, 2.0):  # the second one has too short a silence
        stream.known_until(end)
        with pytest.raises(LipsyncError, match=f"ends at {end:g} s, but was stated to end at 2 s"):
            stream.finish()
    stream.revise(1.5)
    stream.known_until(2.0)
    stream.finish()
    assert stream.frames().times[-1] >= 2.0
    with pytest.raises(LipsyncError, match="finished"):
        stream.ends_at(2.0)
    with pytest.raises(ScheduleError, match="finite"):
        opened("arkit").ends_at(float("nan"))
    twice = opened("arkit")
    twice.ends_at(2.0)
    with pytest.raises(LipsyncError, match="was stated as 2 s already"):
        twice.ends_at(3.0)


def test_faulty_gestures_of_a_stream_are_refused():
    with pytest.raises(LipsyncError, match="unknown gesture 'blinc'"):
        opened("arkit", gestures="blinc")
    bare = opened("arkit", gestures="none")
    assert bare.poses == resolved("arkit").poses
    assert "gestures" not in bare.delays
