"""Promises of every animation, for any packs, schedule and settings."""

from dataclasses import replace
from importlib import import_module
from math import inf

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from lanes import full, swept
from strategies import RATES, Line, any_lines, lines, motions, random_curves, real, tables

from lipsync_lang import Schedule, resolve
from lipsync_lang.pipeline import kernel, kernel_plan
from lipsync_lang.pipeline.limit import envelope, lower_envelope, upper_envelope
from lipsync_lang.pipeline.motion import PRESETS, Motion
from lipsync_lang.pipeline.prepare import GIVEN, prepare
from lipsync_lang.pipeline.smooth import chord, closing, closing_within

EXACT = 1e-9
MOVED = 1e-6
LEAD = 0.25


IN_BOTH = {
    "test_weights_stay_between_0_and_1",
    "test_no_pose_passes_its_speed_limit_between_any_two_frames",
    "test_every_contact_is_seen_however_short_the_phoneme",
    "test_blocks_agree_with_the_whole",
}
"""Tests that are quick with both arithmetics; the others are quick only when compiled."""


def pytest_generate_tests(metafunc):
    quick = 2 if metafunc.function.__name__ in IN_BOTH else 1
    metafunc.parametrize("arithmetic", swept(("compiled", "numpy"), quick), indirect=True)


@pytest.fixture(autouse=True)
def arithmetic(request, monkeypatch):
    """Run the stages in the compiled kernel, if there is one, or in numpy."""
    if request.param == "numpy":
        monkeypatch.setattr(kernel, "compiled", None)


def weights_of(line, motion, fps):
    performance = line.perform(motion, fps)
    return performance, performance.weights()


@given(any_lines(), motions(), RATES)
def test_weights_stay_between_0_and_1(line, motion, fps):
    performance, weights = weights_of(line, motion, fps)
    assert weights.shape == (performance.frames.count, len(line.tables.priority))
    assert np.isfinite(weights).all()
    assert weights.min() >= 0
    assert weights.max() <= 1


def assert_constraints(tables, weights):
    poses = range(len(tables.priority))
    for low in poses:
        for high in poses:
            if tables.priority[high] > tables.priority[low]:
                over = weights[:, low] + weights[:, high] > tables.thresholds[low, high] + EXACT
                assert (weights[over, low] == 0).all(), (low, high)
    for pose, other in tables.at_most:
        assert (weights[:, pose] <= weights[:, other] + EXACT).all(), (pose, other)


@given(any_lines(), motions(), RATES)
def test_poses_make_room_for_those_that_outrank_them(line, motion, fps):
    performance, weights = weights_of(line, motion, fps)
    tables = performance.tables
    poses = range(len(tables.priority))
    for low in poses:
        for high in poses:
            if tables.priority[high] > tables.priority[low]:
                over = weights[:, low] + weights[:, high] > tables.thresholds[low, high] + EXACT
                assert (weights[over, low] <= EXACT).all(), (low, high)
    for pose, other in tables.at_most:
        assert (weights[:, pose] <= weights[:, other] + EXACT).all(), (pose, other)


@given(any_lines(), motions(), RATES)
def test_no_pose_passes_its_speed_limit_between_any_two_frames(line, motion, fps):
    _, weights = weights_of(line, motion, fps)
    step = motion.speed_limit / fps
    assert np.abs(np.diff(weights, axis=0)).max(initial=0) <= step + EXACT
    for stride in (2, 7):
        assert np.abs(weights[stride:] - weights[:-stride]).max(initial=0) <= stride * step + EXACT


@given(any_lines(), motions(hold=0, limit="before"), RATES)
def test_no_pose_accelerates_faster_than_its_kernel_lets_it(line, motion, fps):
    assert_acceleration(*weights_of(line, motion, fps))


@given(lines(), motions(hold=0, limit="before", contacts="hold", thresholds="own"), RATES)
def test_only_a_pose_that_yields_to_a_contact_beyond_its_threshold_has_corners(line, motion, fps):
    """Constraints that are not convex: their thresholds are half the floor of the higher pose."""
    tables = line.tables
    thresholds = tables.thresholds.copy()
    for low, high in np.ndindex(thresholds.shape):
        lower = tables.priority[low] < tables.priority[high]
        if lower and tables.held[high] and not tables.held[low]:
            thresholds[[low, high], [high, low]] = tables.floors[high] / 2
    assume(motion.softness and not np.array_equal(thresholds, tables.thresholds))
    softness = tables.softness.clip(0.02)
    line = replace(line, tables=replace(tables, thresholds=thresholds, softness=softness))
    performance, weights = weights_of(line, motion, fps)
    assert not performance.prepared.convex
    assert_acceleration(performance, weights)


def assert_acceleration(performance, weights):
    motion, fps, tables = performance.motion, performance.frames.fps, performance.tables
    floors = tables.floors
    cornered = {cap.low for cap in tables.caps if cap.threshold < min(1, floors[cap.high])}
    cornered |= {pose for pose, other in tables.at_most if other in cornered}
    for poses, _ in performance.prepared.shared:
        half = motion.softness * tied(tables)[poses]
        most = 2 * motion.speed_limit / half * (1 + 1e-6)
        most[np.isin(poses, list(cornered))] = 2 * motion.speed_limit * fps
        faster = np.abs(np.diff(weights[:, poses], 2, axis=0)) * fps**2
        assert (faster <= most + EXACT * fps**2).all()


def tied(tables):
    """The narrowest half-width of the poses that constraints tie to each, (P,)."""
    half = tables.softness.copy()
    while True:
        before = half.copy()
        for one, other in [(cap.low, cap.high) for cap in tables.caps] + list(tables.at_most):
            half[[one, other]] = min(half[one], half[other])
        if np.array_equal(half, before):
            return half


@given(any_lines(), motions(), RATES)
def test_curves_start_and_end_at_rest(line, motion, fps):
    performance, weights = weights_of(line, motion, fps)
    times = performance.frames.times()
    assert np.abs(weights[[0, -1]]).max() <= 1e-5
    assert times[0] <= line.times[0] + EXACT
    assert times[-1] >= line.times[-1] - MOVED
    nearest = np.abs(times - line.times[0]).min()
    assert nearest <= EXACT, "a frame lies at the schedule's start"


@given(any_lines(), RATES, RATES)
def test_the_papers_curves_do_not_depend_on_the_frame_rate(line, fps, other):
    shown = [line.perform(PRESETS["paper"], rate) for rate in (fps, other)]
    weights = [one.weights() for one in shown]
    times = [one.frames.times() for one in shown]
    gap = np.abs(times[0][:, None] - times[1])
    here, there = (gap <= EXACT).nonzero()
    assert len(here), "both begin at the schedule's start"
    assert np.abs(weights[0][here] - weights[1][there]).max() <= 1e-3


@given(any_lines(), RATES)
def test_the_papers_curves_begin_and_end_with_the_phonemes(line, fps):
    times = line.perform(PRESETS["paper"], fps).frames.times()
    assert times[0] == line.times[0]
    assert line.times[-1] - EXACT <= times[-1] < line.times[-1] + 1 / fps


@given(any_lines(), st.floats(0.25, 100), RATES)
def test_a_long_reach_adds_no_silence(line, reach, fps):
    shown = [line.perform(Motion(silence_reach=one), fps).frames for one in (0.25, reach)]
    assert shown[0] == shown[1]


@pytest.mark.parametrize("preset", PRESETS)
@given(line=any_lines(), fps=RATES)
def test_a_lead_in_and_a_tail_last_a_quarter_of_a_second_at_most(preset, line, fps):
    motion = Motion() if preset == "default" else PRESETS[preset]
    times = line.perform(motion, fps).frames.times()
    # a contact is held for a whole frame: below 15 frames a second half of it may come on top
    longest = LEAD + (0.5 / fps if fps < 15 else 0) + MOVED
    assert times[0] >= line.times[0] - longest
    assert times[-1] <= line.times[-1] + longest


def demanded(line, contact, track):
    """Return the spans of the phonemes of a line that demand a contact."""
    for place, index in enumerate(track.source):
        waived = line.free[track.rows[max(place - 1, 0) : place + 1]].any()
        if contact.phonemes[track.ids[place]] and not waived:
            yield line.times[index], line.times[index + 1]


# contacts of the built-in pair may be too close for both: `test_extremes.py` keeps them apart
@given(lines(), motions(contacts="hold", limit="before", hold=0), RATES)
def test_every_contact_is_seen_however_short_the_phoneme(line, motion, fps):
    performance, weights = weights_of(line, motion, fps)
    times = performance.frames.times()
    for contact in line.tables.contacts:
        up = (weights >= 0.9 * contact.floor - EXACT).all(axis=1)
        down = (weights <= contact.ceiling + GIVEN + EXACT).all(axis=1)
        for start, end in demanded(line, contact, performance.track):
            near = (times >= start - 0.5 / fps - MOVED) & (times <= end + 0.5 / fps + MOVED)
            assert (near & up & down).any(), (start, end)


@given(lines(), motions(contacts="hold", limit="before", hold=0), RATES)
def test_floors_are_reached_in_full_for_42_ms_or_a_frame(line, motion, fps):
    performance, weights = weights_of(line, motion, fps)
    times = performance.frames.times()
    for contact in line.tables.contacts:
        for start, end in demanded(line, contact, performance.track):
            reach = max(0.042, 1 / fps) / 2
            middle = (start + end) / 2
            low, high = min(start + 0.03, middle - reach), max(end - 0.03, middle + reach)
            held = (times >= low) & (times <= high)
            given = GIVEN if softened(line, motion) else 0
            assert (weights[held] >= contact.floor - given - EXACT).all()
            assert (weights[held] <= contact.ceiling + given + EXACT).all()


@given(st.one_of(any_lines(), lines(loose=True)), st.sampled_from([0.02, 0.07]), RATES)
def test_drawings_are_shown_one_at_a_time_and_the_last_contact_wins(line, hold, fps):
    motion = Motion(hold=hold, speed_limit=1000, smooth="none")
    performance, weights = weights_of(line, motion, fps)
    assert ((weights > 0).sum(axis=1) <= 1).all()
    inner = slice(1, -1)  # at rest at both ends
    if line.tables.contacts and line.tables.contacts[-1].raised:
        shown = weights[inner, line.tables.contacts[-1].floor.argmax()]
        assert (shown[performance.held[-1][1][inner]] > 0).all()


@st.composite
def lone_contacts(draw):
    """A short phoneme with a contact, between sounds without one that hold other poses high."""
    made = draw(tables(loose=True))
    some = np.any([contact.phonemes for contact in made.contacts], axis=0)
    assume(made.contacts and some.any() and not some.all())
    made = replace(made, curves=np.maximum(made.curves, draw(st.sampled_from([0, 0.8, 1]))))
    made.curves[0] = 0
    short, beside = (draw(st.sampled_from(np.flatnonzero(which))) for which in (some, ~some))
    lengths = [0.2, draw(st.floats(0.005, 0.1)), 0.2]
    return Line(made, np.array([beside, short, beside]), np.cumsum([0, *lengths]))


@given(lone_contacts(), motions(contacts="hold", limit="before", hold=0), RATES)
def test_a_contact_far_from_others_is_met_whatever_they_forbid(line, motion, fps):
    performance, weights = weights_of(line, motion, fps)
    near = np.abs(performance.frames.times() - line.times[1:3].mean()) <= max(0.021, 0.5 / fps)
    given = EXACT + (GIVEN if softened(line, motion) else 0)
    for contact in line.tables.contacts:
        for _ in demanded(line, contact, performance.track):
            assert (weights[near] >= contact.floor - given).all()
            assert (weights[near] <= contact.ceiling + given).all()


def dilate(mask, ahead, back):
    """Return the frames with a frame of the mask within some frames after or before them."""
    out = mask.copy()
    for at in np.flatnonzero(mask):
        out[max(0, at - ahead) : at + back + 1] = True
    return out


def softened(line, motion):
    return motion.softness > 0 and not motion.hold and line.tables.softness.any()


LOCAL = st.sampled_from(["closing", "none"]).flatmap(lambda smooth: motions(smooth=smooth, hold=0))


@given(any_lines(), LOCAL, RATES, st.data())
def test_changing_a_bigram_changes_only_what_is_near_it(line, motion, fps, data):
    performance, before = weights_of(line, motion, fps)
    track = performance.track
    rows = sorted({int(row) for row in track.rows if row})
    assume(rows)
    row = data.draw(st.sampled_from(rows))
    curves = line.tables.curves.copy()
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    curves[row] = random_curves(rng, curves.shape[-1])
    tables = replace(line.tables, curves=curves)
    after = replace(line, tables=tables).perform(motion, fps).weights()

    times = performance.frames.times()
    occurs = np.zeros(len(times), bool)
    for at in np.flatnonzero(track.rows == row):
        start = track.bounds[at + 1] - track.reach[at]
        end = track.bounds[at + 1] + track.reach[at + 1]
        occurs |= (times >= start - MOVED) & (times <= end + MOVED)
    changed = (np.abs(after - before) > EXACT).any(axis=1)
    looks = performance.prepared.reach.values()
    ahead, back = (int(sum(look[side] for look in looks)) for side in (1, 0))
    assert not changed[~dilate(occurs, ahead, back)].any()


@given(any_lines(), RATES)
def test_what_each_stage_says_of_its_reach_is_little(line, fps):
    reach = prepare(line.tables, Motion(), fps).reach
    late = 0.05 * 2 + 2 / fps
    told = {name: max(look) / fps for name, look in reach.items() if name != "rest"}
    assert told.pop("anticipate", 0) <= line.tables.anticipate.max() + EXACT
    assert sum(told.values()) <= late + 1 / 15 + 0.05 + 3 / fps


def foreign(folder):
    """A language of the same phonemes in other letters, and one phoneme more."""
    phonemes = real().compiled.phonemes[1:]
    (folder / "languages").mkdir()
    labels = "".join(f"    q{i}: {name}\n" for i, name in enumerate(phonemes))
    (folder / "languages" / "foreign.yaml").write_text(
        "kind: language\nformat: 1\nname: foreign\ntag: qaa\nadds: [yu]\n"
        f"notations:\n  letters:\n    q: yu\n{labels}",
        encoding="utf-8",
    )
    return resolve("foreign", "facefx", paths=[folder], cache=False)


@pytest.fixture(scope="module")
def speakers(tmp_path_factory):
    return real(), foreign(tmp_path_factory.mktemp("foreign"))


@given(data=st.data(), fps=RATES, motion=motions())
def test_the_same_phonemes_look_the_same_in_every_language(speakers, data, fps, motion):
    english, other = speakers
    line = data.draw(lines(english.compiled.tables))
    names = [english.compiled.phonemes[i] for i in line.ids]
    numbers = np.array([other.compiled.phonemes.index(name) for name in names])
    ours = line.perform(motion, fps).weights()
    theirs = replace(line, tables=other.compiled.tables, ids=numbers).perform(motion, fps).weights()
    assert np.array_equal(ours, theirs)


def test_the_same_phonemes_look_the_same_through_either_notation(speakers):
    english, other = speakers
    times = np.cumsum([0, 0.2, 0.08, 0.11, 0.07, 0.3, 0.09, 0.2])
    ours = ("_", "HH", "AH1", "L", "OW", "B", "_")
    letters = {v: f"q{i}" for i, v in enumerate(english.compiled.phonemes[1:])}
    theirs = ("_", *(letters[name] for name in ("h", "ah", "l", "ow", "bmp")), "_")
    one = english.perform(Schedule(ours, times, notation="arpabet"), fps=50)
    two = other.perform(Schedule(theirs, times, notation="letters"), fps=50)
    assert np.array_equal(one.weights, two.weights)


def stitched(performance):
    return performance.stages(0, performance.frames.count)[0].curves


@given(
    any_lines(pauses=False, steady=True),
    motions(warp="anchored", sound_reach=inf),
    RATES,
    st.floats(0.2, 5),
)
def test_stretching_a_schedule_stretches_the_stitched_curves(line, motion, fps, factor):
    times = line.times[0] + (line.times - line.times[0]) * factor
    assume(np.diff(times).min() > 1e-4)
    one = line.perform(motion, fps)
    two = replace(line, times=times).perform(motion, fps / factor)
    assert two.motion is one.motion
    # frame k of the one lies where frame k of the other does, once stretched
    count = int((line.times[-1] - line.times[0]) * fps)
    frames = np.arange(1, count)
    on = (line.times - line.times[0]) * fps
    frames = frames[np.abs(frames[:, None] - on).min(axis=1, initial=np.inf) > 1e-4]
    a = stitched(one)[:, frames - one.frames.first]
    b = stitched(two)[:, frames - two.frames.first]
    assert np.abs(a - b).max(initial=0) <= MOVED


@given(
    any_lines(),
    motions(hold=0),
    RATES,
    st.one_of(st.sampled_from([0.1, -0.3, 1, 1000.1]), st.floats(-100, 5000)),
)
def test_moving_a_schedule_moves_the_curves(line, motion, fps, seconds):
    one, before = weights_of(line, motion, fps)
    two, after = weights_of(replace(line, times=line.times + seconds), motion, fps)
    assert (one.frames.first, one.frames.count) == (two.frames.first, two.frames.count)
    assert np.abs(two.frames.times() - one.frames.times() - seconds).max() <= EXACT
    assert np.abs(after - before).max() <= MOVED


@full
@pytest.mark.parametrize("fps", [50, 60, 100])
def test_rounding_never_chooses_the_phoneme_of_a_frame_on_a_boundary(fps):
    rng = np.random.default_rng(1)
    tables = real().compiled.tables
    curves = np.stack([random_curves(rng, 9) for _ in tables.curves])  # they need not end at rest
    curves[0] = 0
    tables = replace(tables, curves=curves)
    for _ in range(40):
        lengths = rng.choice([0.05, 0.1, 0.15, 0.2], 10)
        ids = rng.integers(0, len(tables.pairs), 10)
        ids[4], lengths[4] = tables.silence, 1  # where bigrams end and begin in the middle
        edits = tuple((first, first % 9, first) for first in range(0, 10, 3))
        line = Line(tables, ids, np.concatenate(([0], np.cumsum(lengths))), edits)
        before = line.perform(Motion(), fps).weights()
        for seconds in (0.1, 0.3, 1000.1):
            after = replace(line, times=line.times + seconds).perform(Motion(), fps).weights()
            assert np.abs(after - before).max() <= MOVED


module = import_module("lipsync_lang.pipeline.perform")


def weights_in_blocks(performance, block):
    """Return the weights of a performance in blocks of some frames."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "BLOCK", block)
        patch.setattr(kernel_plan, "block_of", lambda _: block)
        vars(performance.prepared).pop("_plan", None)
        weights = performance.weights()
        vars(performance.prepared).pop("_plan", None)
        return weights


@given(any_lines(longest=40), motions(), RATES, st.integers(1, 200))
def test_blocks_agree_with_the_whole(line, motion, fps, block):
    performance = line.perform(motion, fps)
    block = max(block, performance.frames.count // 40)
    whole = weights_in_blocks(performance, performance.frames.count)
    parts = weights_in_blocks(performance, block)
    assert np.abs(whole - parts).max() <= MOVED


@pytest.mark.parametrize("smooth", ["closing", "chord", "none"])
def test_blocks_agree_with_the_whole_over_ten_minutes(smooth):
    tables = real().compiled.tables
    rng = np.random.default_rng(7)
    ids = rng.integers(0, len(tables.pairs), 6000)
    times = np.concatenate(([0], np.cumsum(rng.uniform(0.03, 0.17, 6000))))
    performance = Line(tables, ids, times).perform(Motion(smooth=smooth), 60)
    assert performance.frames.count > 3 * module.BLOCK
    usual = performance.weights()
    whole = weights_in_blocks(performance, performance.frames.count)
    assert np.abs(whole - usual).max() <= MOVED
    step = performance.motion.speed_limit / 60
    assert np.abs(np.diff(usual, axis=0)).max() <= step + EXACT


@given(any_lines(), motions(), RATES)
def test_a_line_said_twice_is_the_same(line, motion, fps):
    first = line.perform(motion, fps).weights()
    assert np.array_equal(first, line.perform(motion, fps).weights())


@given(st.deferred(lambda: lines(real().compiled.tables)), RATES)
def test_tables_are_never_written_to(line, fps):
    kept = line.tables.curves.copy()
    line.perform(Motion(), fps).weights()
    line.perform(PRESETS["paper"], fps).weights()
    assert np.array_equal(kept, line.tables.curves)


CURVES = st.tuples(st.integers(1, 3), st.integers(1, 60), st.integers(0, 2**32 - 1)).map(
    lambda drawn: np.random.default_rng(drawn[2]).random(drawn[:2]).round(drawn[2] % 3 + 1)
)
FRAMES = st.integers(1, 40)


@given(CURVES, FRAMES)
def test_closing_takes_nothing_away_and_a_second_time_does_nothing(curves, frames):
    closed = closing(curves, frames)
    assert (closed >= curves).all()
    assert np.array_equal(closing(closed, frames), closed)
    assert (closed.max(axis=1) == curves.max(axis=1)).all()


@given(CURVES, FRAMES, st.floats(0, 0.5), st.integers(0, 2**32 - 1))
def test_closing_never_magnifies_a_change(curves, frames, size, seed):
    other = curves + np.random.default_rng(seed).uniform(-size, size, curves.shape)
    other = np.maximum(other, 0)
    change = np.abs(other - curves).max()
    assert np.abs(closing(other, frames) - closing(curves, frames)).max() <= change + 1e-12


@given(CURVES, FRAMES, st.integers(0, 2**32 - 1))
def test_closing_within_runs_is_closing_each_run_alone(curves, frames, seed):
    inside = np.random.default_rng(seed).random(curves.shape) < 0.7
    found = closing_within(curves, inside, frames)
    wanted = curves.copy()
    for pose, mask in enumerate(inside):
        edges = np.flatnonzero(np.diff(mask, prepend=False, append=False))
        for a, b in zip(edges[::2], edges[1::2], strict=True):
            wanted[pose, a:b] = closing(curves[pose : pose + 1, a:b], frames)[0]
    assert np.array_equal(found, wanted)
    assert np.array_equal(closing_within(found, inside, frames), found)


@given(CURVES, FRAMES)
def test_chords_never_leave_the_range_of_the_curve(curves, frames):
    joined = chord(curves, frames)
    assert (joined.min(axis=1) >= curves.min(axis=1) - EXACT).all()
    assert (joined.max(axis=1) <= curves.max(axis=1) + EXACT).all()


STEP = st.floats(0.01, 1.5)


@given(CURVES, STEP)
def test_envelopes_are_the_nearest_slow_curves(curves, step):
    count = curves.shape[1]
    reach = step * np.abs(np.arange(count)[:, None] - np.arange(count))
    above, below = upper_envelope(curves, step), lower_envelope(curves, step)
    assert np.abs(above - (curves[:, :, None] - reach).max(axis=1)).max() <= EXACT
    assert np.abs(below - (curves[:, :, None] + reach).min(axis=1)).max() <= EXACT
    which = np.arange(len(curves)) % 2 == 0
    mixed = envelope(curves, step, upper=which)
    assert np.array_equal(mixed[which], above[which])
    assert np.array_equal(mixed[~which], below[~which])


@given(STEP, st.integers(0, 2**32 - 1))
def test_envelopes_stay_in_the_range_of_the_curve_over_any_length(step, seed):
    rng = np.random.default_rng(seed)
    curves = (rng.random((2, 4000)) < 0.3) * rng.choice([1.0, 0.3, 0.7], (2, 4000))
    for bound in (upper_envelope, lower_envelope):
        slow = bound(curves, step)
        assert (slow.max(axis=1) <= curves.max(axis=1)).all()
        assert (slow.min(axis=1) >= curves.min(axis=1)).all()
