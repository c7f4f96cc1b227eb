"""Extreme lines and settings: every promise holds at the limits of packs."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full

import lipsync_lang as ll
from lipsync_lang import Schedule
from lipsync_lang.pipeline.hold import demands
from lipsync_lang.pipeline.perform import perform
from lipsync_lang.pipeline.prepare import GIVEN
from lipsync_lang.pipeline.track import lay_track

LABELS = ("_", "UW", "P", "AA", "F", "UW", "B", "_", "UW", "M", "IY")
RATES = st.sampled_from([12, 24, 60, 120])
FACES = st.sampled_from(["facefx", "arkit", "crab", "oculus", "mpeg4", "vrm", "sapi"])


def performance(performer, lengths, fps, tables=None):
    times = np.concatenate([[0], np.cumsum(lengths)])
    schedule = Schedule(LABELS[: len(lengths)], times, notation="arpabet")
    ids, times, source = performer.common_phonemes(schedule)
    tables = tables or performer.compiled.tables
    track = lay_track(ids, times, source, tables, performer.motion)
    return perform(tables, track, performer.motion, fps)


BESIDE_SECONDS = 0.25
"""Distance from a stronger contact at which an excluded one is promised, at any softness."""


def excludes(tables, stronger, contact):
    """Return True if a contact makes another yield."""
    return any(
        stronger.floor[cap.high] > 0
        and contact.floor[cap.low] > 0
        and stronger.floor[cap.high] + contact.floor[cap.low] > cap.threshold
        for cap in tables.caps
    )


def keeps_its_promises(made, speed, fps):
    """Check bounds, rest, speed and every contact of a performance."""
    weights, times = made.weights(), made.frames.times()
    assert weights.min() >= 0
    assert weights.max() <= 1
    assert np.abs(weights[[0, -1]]).max() <= 1e-5
    assert np.abs(np.diff(weights, axis=0)).max() <= speed / fps + 1e-9
    track = made.track
    for contact in made.tables.contacts:
        floor = contact.floor * (contact.floor > 0)
        stronger = [one for one in made.tables.contacts if excludes(made.tables, one, contact)]
        others = np.flatnonzero(
            sum((demands(one, track) for one in stronger), np.zeros(track.ids.shape))
        )
        for number in np.flatnonzero(demands(contact, track)):
            away = np.maximum(
                track.bounds[others] - track.bounds[number + 1],
                track.bounds[number] - track.bounds[others + 1],
            )
            if (away < BESIDE_SECONDS + 2 / fps).any():
                continue
            low, high = track.bounds[number : number + 2] + np.array([-0.5, 0.5]) / fps
            near = weights[(times >= low - 1e-6) & (times <= high + 1e-6)]
            up = (near >= floor - GIVEN - 1e-6).all(axis=1)
            down = (near <= contact.ceiling + GIVEN + 1e-6).all(axis=1)
            assert (up & down).any()


@full
@given(FACES, st.sampled_from([3.0, 4.0]), st.floats(0.001, 0.02), RATES)
def test_softening_wider_than_the_phrase(face, softness, seconds, fps):
    performer = ll.resolve("english", face, motion={"softness": softness})
    made = performance(performer, [seconds] * 3, fps)
    assert made.prepared.reach["soften"].back / fps > 3 * seconds
    keeps_its_promises(made, performer.motion.speed_limit, fps)


@full
@given(FACES, st.sampled_from([2.0, 4.0]), st.floats(0.001, 0.1), RATES)
def test_anticipation_longer_than_the_silence_before_a_line(face, factor, silence, fps):
    performer = ll.resolve("english", face, motion={"anticipate": factor})
    made = performance(performer, [silence, *[0.1] * 6, silence, *[0.1] * 3], fps)
    keeps_its_promises(made, performer.motion.speed_limit, fps)


@given(FACES, st.lists(st.sampled_from([0.001, 0.08, 10.0]), min_size=11, max_size=11), RATES)
def test_phones_of_a_millisecond_and_of_ten_seconds(face, lengths, fps):
    performer = ll.resolve("english", face)
    keeps_its_promises(performance(performer, lengths, fps), performer.motion.speed_limit, fps)


def with_contacts(tables, change):
    return replace(tables, contacts=tuple(change(contact) for contact in tables.contacts))


@given(st.floats(0.001, 0.3), RATES)
def test_a_floor_of_one(seconds, fps):
    performer = ll.resolve("english", "facefx")
    tables = with_contacts(
        performer.compiled.tables,
        lambda contact: replace(contact, floor=np.where(contact.floor >= 0.7, 1.0, contact.floor)),
    )
    keeps_its_promises(
        performance(performer, [seconds] * 11, fps, tables), performer.motion.speed_limit, fps
    )


@given(st.floats(0.001, 0.3), RATES)
def test_two_contacts_at_once(seconds, fps):
    performer = ll.resolve("english", "facefx")
    lips, teeth = (performer.poses.index(pose) for pose in ("PBM", "FV"))
    own = performer.compiled.tables
    thresholds = own.thresholds.copy()
    thresholds[[lips, teeth], [teeth, lips]] = 1.8
    own = replace(own, thresholds=thresholds)
    either = np.logical_or.reduce([contact.phonemes for contact in own.contacts])
    tables = with_contacts(own, lambda contact: replace(contact, phonemes=either))
    made = performance(performer, [seconds] * 11, fps, tables)
    keeps_its_promises(made, performer.motion.speed_limit, fps)
    assert made.weights()[:, [lips, teeth]].min(axis=1).max() >= 0.5 - GIVEN


@pytest.mark.parametrize("face", ["facefx", "arkit"])
def test_the_widest_settings_together(face):
    motion = {"softness": 4, "anticipate": 4, "silence_reach": 0, "stress": 4, "loudness": 2}
    performer = ll.resolve("english", face, motion=motion)
    for fps in (12, 60, 120):
        made = performance(performer, [0.001, 10, 0.001, 0.05, 0.001, 0.3, 0.02, 0.001], fps)
        keeps_its_promises(made, performer.motion.speed_limit, fps)
