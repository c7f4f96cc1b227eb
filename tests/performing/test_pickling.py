"""Performers and animations in other processes: pickles are whole and small, and change nothing."""

import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from packs_tree import BANK, plant, put

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
    assert (copy.unknown, copy.motion, copy.report) == (
        "nearest",
        performer.motion,
        performer.report,
    )
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
    tables = [one.source.performer.compiled.tables for one in found]
    assert tables[0] is tables[1], "one copy serves them all"


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
    there, here = warm.compiled.tables, copy.source.performer.compiled.tables
    for name in ("curves", "boundary", "free", "pairs", "thresholds", "priority"):
        assert not getattr(here, name).flags.writeable
        assert getattr(here, name).flags.aligned
        assert np.array_equal(getattr(here, name), getattr(there, name))
    assert (here.silence, here.at_most) == (there.silence, there.at_most)


def test_contacts_and_styles_pickle_too(tmp_path):
    bank = BANK.replace("name: common", "name: angry\nstyle: angry")
    put(plant(tmp_path), "posesets/face/banks/angry.yaml", bank)
    performer = ll.resolve("parent", "face", paths=tmp_path)
    schedule = ll.Schedule(("P", "2", "no"), [0, 0.1, 0.3, 0.5], notation="first")
    animation = performer.perform(schedule, styles={"angry": 0.5})
    copy = again(performer)
    assert [len(copy.compiled.tables.contacts), len(copy.compiled.tables.styles)] == [2, 1]
    assert np.array_equal(copy.perform(schedule, styles={"angry": 0.5}).weights, animation.weights)
