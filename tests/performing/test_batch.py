"""Many schedules at once give the same curves as each alone."""

from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import swept

import lipsync_lang as ll
from lipsync_lang import LipsyncError, Schedule, Word
from lipsync_lang.base.errors import ScheduleError
from lipsync_lang.performing.effort import StressMarks, stresses_of

PAIRS = swept(["english on facefx", "korean on crab", "german on arkit", "mandarin on facefx"], 2)


@pytest.fixture(scope="module", params=PAIRS)
def performer(request):
    return ll.resolve(*request.param.split(" on "), unknown="rest")


def mute(performer, schedule):
    return not any(performer.labels.values(schedule))


@st.composite
def schedules(draw, performer):
    """Labels of one notation: some with several sounds, some marked, some mute or unknown."""
    name = draw(st.sampled_from(sorted(performer.labels.notations)))
    table = sorted(performer.labels.notations[name].table)
    assert table, "a notation without labels says nothing"
    label = st.one_of(st.sampled_from(table), st.sampled_from(table), st.sampled_from(["_", "?!"]))
    labels = draw(st.lists(label, min_size=1, max_size=12))
    count = len(labels)
    lengths = draw(st.lists(st.floats(0.01, 0.4), min_size=count, max_size=count))
    marks = st.lists(st.sampled_from([None, None, 0, 1, 2]), min_size=count, max_size=count)
    cuts = sorted(draw(st.sets(st.integers(0, count), max_size=4)))
    emphasis = st.sampled_from([0.0, 0.0, 1.0])
    texts = st.sampled_from(["text", *sorted(performer.compiled.words)[:5]])
    words = [Word(draw(texts), a, b, draw(emphasis)) for a, b in pairwise(cuts)]
    return Schedule(
        labels,
        draw(st.sampled_from([0.0, -1.2, 40.0])) + np.concatenate(([0.0], np.cumsum(lengths))),
        tuple(words),
        notation=draw(st.sampled_from([name, name, None])),
        language=draw(st.sampled_from([None, performer.language])),
        stress=tuple(draw(st.one_of(st.just([]), marks))),
    )


@pytest.mark.usefixtures("arithmetic")
@given(data=st.data(), fps=st.sampled_from([60, 24, 23.976]))
def test_a_batch_is_each_of_its_schedules_to_the_bit(performer, data, fps):
    drawn = data.draw(st.lists(schedules(performer), min_size=1, max_size=6))
    said = [schedule for schedule in drawn if not mute(performer, schedule)]
    for schedule, one in zip(said, performer.perform_many(said, fps), strict=True):
        alone = performer.perform(schedule, fps)
        assert one.schedule is schedule
        assert one.times.tobytes() == alone.times.tobytes()
        assert one.weights.tobytes() == alone.weights.tobytes()
        assert (one.poses, one.fps, one.source) == (alone.poses, alone.fps, alone.source)


@given(data=st.data())
def test_a_performed_animation_is_one_that_its_class_would_make(performer, data):
    schedule = data.draw(schedules(performer).filter(lambda one: not mute(performer, one)))
    made = performer.perform(schedule)
    remade = replace(made)
    for field in fields(made):
        assert getattr(remade, field.name) is getattr(made, field.name)


@given(data=st.data())
def test_an_animation_is_the_performance_that_explains_it(performer, data):
    schedule = data.draw(schedules(performer).filter(lambda one: not mute(performer, one)))
    made = performer.perform(schedule)
    performance = performer.performance(schedule, 60)
    assert np.array_equal(made.times, performance.frames.times())
    assert np.array_equal(made.weights, performance.weights())


@given(data=st.data())
def test_labels_share_their_time_among_their_sounds(performer, data):
    schedule = data.draw(schedules(performer))
    values = performer.labels.values(schedule)
    ids, starts, source = [], [], []
    for index, value in enumerate(values):
        at, length = schedule.times[index], schedule.times[index + 1] - schedule.times[index]
        for name, share in value:
            ids.append(performer.labels.numbers[name])
            starts.append(at)
            source.append(index)
            at += share * length
    if not ids:
        with pytest.raises(ScheduleError, match="none of its labels has a sound"):
            performer.common_phonemes(schedule)
        return
    found = performer.common_phonemes(schedule)
    assert found[0].tolist() == ids
    assert found[1].tolist() == [schedule.times[0], *starts[1:], schedule.times[-1]]
    assert found[2].tolist() == source


@given(st.lists(st.tuples(st.sampled_from([-1, 0, 1, 2]), st.integers(0, 2)), min_size=1))
def test_stress_is_read_at_once_as_label_by_label(labels):
    marks, manners = np.array(labels).T
    reading = StressMarks()
    wanted = [
        reading.of(None if mark < 0 else mark, ("", "stop", "vowel")[manner])
        for mark, manner in labels
    ]
    found = stresses_of(marks, manners)
    assert found.tolist() == [-1 if stress is None else stress for stress in wanted]


def test_lines_are_named_for_each_schedule_or_for_none():
    performer = ll.resolve("english", "facefx")
    line = Schedule(("M", "AA"), [0, 0.1, 0.3], notation="arpabet")
    assert performer.perform_many([]) == []
    assert len(performer.perform_many(iter([line, line]), lines=[None, None])) == 2
    with pytest.raises(LipsyncError, match="1 lines for 2 schedules; give one line per schedule"):
        performer.perform_many([line, line], lines=[None])
    with pytest.raises(LipsyncError, match="no edits for line 'x'"):
        performer.perform_many([line, line], lines=[None, "x"])
    with pytest.raises(LipsyncError, match="0 frames per second"):
        performer.perform_many([line], 0)


def test_the_labels_of_a_line_are_read_once(monkeypatch):
    performer = ll.resolve("english", "facefx")
    schedule = Schedule(("M", "AA", "P"), [0, 0.1, 0.3, 0.4])
    reader, read = type(performer.labels), []
    real = reader._sounds  # noqa: SLF001 the one place that reads them
    monkeypatch.setattr(reader, "_sounds", lambda self, one: read.append(one) or real(self, one))
    ll.check(performer.perform(schedule))
    performer.common_phonemes(schedule)
    assert read == [schedule]
