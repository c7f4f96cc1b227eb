"""Performers and animations in other processes: pickles are whole and small, and change nothing."""

import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

import lipsync_lang as ll

SCHEDULES = [
    ll.Schedule(("HH", "AY", "M"), [0, 0.1, 0.3, 0.4]),  # no notation: it is recognised
    ll.Schedule(("M", "AA"), [0, 0.1, 0.3]),
]


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "facefx")


def again(value):
    """Pickle and unpickle."""
    return pickle.loads(pickle.dumps(value))  # noqa: S301 our own


def assert_alike(one, other):
    assert np.array_equal(one.weights, other.weights)
    assert np.array_equal(one.times, other.times)
    assert one.poses == other.poses
    assert one.explain(0.2) == other.explain(0.2)


def test_a_performer_that_recognised_a_notation_pickles(performer):
    before = [performer.perform(schedule) for schedule in SCHEDULES]
    copy = again(performer)
    assert (copy.unknown, copy.motion, copy.report) == ("error", performer.motion, performer.report)
    for schedule, animation in zip(SCHEDULES, before, strict=True):
        assert_alike(copy.perform(schedule), animation)


def test_an_animation_pickles_with_all_that_explains_it(performer):
    animation = performer.perform(SCHEDULES[0])
    animation.explain(0.1)
    assert_alike(again(animation), animation)


def test_a_pool_performs_many_lines(performer):
    expected = [performer.perform(schedule) for schedule in SCHEDULES]
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        found = list(pool.map(performer.perform, SCHEDULES))
    for one, other in zip(found, expected, strict=True):
        assert_alike(one, other)
    assert found[0].performer.compiled is found[1].performer.compiled, "one copy serves them all"


def test_pickles_stay_small(performer):
    fresh = ll.resolve("english", "facefx")
    size = len(pickle.dumps(fresh))
    for schedule in SCHEDULES:
        fresh.perform(schedule).explain(0.1)
    fresh.rigged(fresh.perform(SCHEDULES[0]))
    assert len(pickle.dumps(fresh)) == size, "what is worked out again is left out"
    assert size < performer.compiled.tables.curves.nbytes / 2


def test_what_is_read_only_stays_so(performer):
    warm = ll.resolve(performer.language, performer.character)
    copy = again(warm.perform(SCHEDULES[0]))
    with pytest.raises(ValueError, match="read-only"):
        copy.schedule.times[0] = 1
    assert not warm.compiled.tables.curves.flags.writeable
    assert not copy.performer.compiled.tables.curves.flags.writeable
