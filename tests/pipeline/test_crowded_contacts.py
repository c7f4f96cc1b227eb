"""Contacts that exclude each other: each is kept where the speed of poses leaves room for both."""

import numpy as np
import pytest
from hypothesis import given
from lanes import swept
from strategies import FREE, RATES, Line, lines, motions

from lipsync_lang.pipeline import kernel
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.prepare import GIVEN
from lipsync_lang.pipeline.tables import RESOLUTION, Contact, Tables

EXACT = 1e-9
SHARP = motions(contacts="hold", limit="before", hold=0, softness=0)
SOFT = motions(contacts="hold", limit="before", hold=0)


def pytest_generate_tests(metafunc):
    metafunc.parametrize("arithmetic", swept(("compiled", "numpy")), indirect=True)


@pytest.fixture(autouse=True)
def arithmetic(request, monkeypatch):
    """Run the stages in the compiled kernel, if there is one, or in numpy."""
    if request.param == "numpy":
        monkeypatch.setattr(kernel, "compiled", None)


def demanded(tables):
    """Yield the least and the greatest weight of each pose that a contact asks for, (P,) each.

    A pose that yields to another can have its floor only while that one stays below what their
    threshold leaves.
    """
    for contact in tables.contacts:
        least = np.where(contact.floor > 0, contact.floor, -np.inf)
        most = np.where(contact.ceiling < 1, contact.ceiling, np.inf)
        for low, high, threshold in tables.caps:
            if contact.floor[low] > 0:
                most[high] = min(most[high], threshold - contact.floor[low])
        yield least, most


def has_room(performance, demands):
    """Return True if every pose gets from each demand to each other one at its speed."""
    count = performance.frames.count
    away = np.abs(np.subtract.outer(np.arange(count), np.arange(count))) * performance.prepared.step
    least, most = (np.full((len(performance.tables.priority), count), x) for x in (-np.inf, np.inf))
    for (_, held), (low, high) in zip(performance.held, demands, strict=True):
        least[:, held] = np.maximum(least[:, held], low[:, None])
        most[:, held] = np.minimum(most[:, held], high[:, None])
    pairs = zip(least, most, strict=True)
    return all((np.subtract.outer(low, high) <= away + EXACT).all() for low, high in pairs)


def keeps_all(performance, given):
    """Return True if every contact holds in all of its frames, within some weight."""
    weights = performance.weights()
    return all(
        (weights[held] >= contact.floor - given - EXACT).all()
        and (weights[held] <= contact.ceiling + given + EXACT).all()
        for contact, (_, held) in zip(performance.tables.contacts, performance.held, strict=True)
    )


@given(lines(loose=True), SHARP, RATES)
def test_without_softness_all_contacts_are_kept_if_any_slow_curve_keeps_them(line, motion, fps):
    """A curve of limited speed goes through points if each two are far enough apart for it."""
    performance = line.perform(motion, fps)
    kept = keeps_all(performance, 0)
    assert kept == has_room(performance, demanded(performance.tables))


@given(lines(loose=True), SOFT, RATES)
def test_with_softness_all_contacts_are_kept_if_their_widened_levels_have_room(line, motion, fps):
    performance = line.perform(motion, fps)
    if has_room(performance, [levels[:, :, 0] for levels in performance.prepared.levels]):
        assert keeps_all(performance, GIVEN)


RESTING, STRONG, WEAK = range(3)
"""Common phonemes: silence, one that holds a pose at 1, and one that holds another at 0.1."""


def weak_beside_strong(seconds, softness):
    """A sound of some seconds, whose pose yields above 0.12 to the pose of the sound before it."""
    strong, weak = (np.arange(3) == sound for sound in (STRONG, WEAK))
    contacts = (
        Contact(strong, np.array([0, 1.0]), np.ones(2)),
        Contact(weak, np.array([0.1, 0]), np.ones(2)),
    )
    thresholds = np.array([[FREE, 0.12], [0.12, FREE]])
    bigrams = np.zeros((10, RESOLUTION + 1, 2), np.float32)
    pairs = np.array([[0, 1, 2], [3, 4, 5], [6, 7, 8]])
    made = Tables(
        bigrams, np.full(10, 0.5), np.zeros(10, bool), pairs, RESTING, contacts, thresholds,
        thresholds, np.array([0.0, 1]), np.full(2, softness), np.zeros(2), np.ones(2),
        np.zeros((3, 2), bool),
    )  # fmt: skip
    return Line(made, np.array([STRONG, WEAK]), np.cumsum([0, 0.15, seconds]))


@pytest.mark.parametrize(("fps", "softness"), [(24, 0.04), (60, 0.05), (120, 0.15)])
@pytest.mark.parametrize("seconds", [0.03, 0.06, 0.2])
def test_a_low_floor_is_kept_beside_a_pose_held_far_above_their_threshold(fps, softness, seconds):
    performance = weak_beside_strong(seconds, softness).perform(Motion(), fps)
    assert not performance.prepared.convex
    weights, (_, held) = performance.weights(), performance.held[1]
    assert weights[held, 0].min() >= 0.1 - GIVEN - EXACT
