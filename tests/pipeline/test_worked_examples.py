"""The paper's figures 5 to 10 in a few frames each, worked out by hand."""

from dataclasses import replace

import numpy as np
import pytest

from lipsync_lang import resolve
from lipsync_lang.pipeline.constrain import Cap, caps, constrain, together
from lipsync_lang.pipeline.curve import polyline
from lipsync_lang.pipeline.hold import Plateau, bounds, held_frames, hold
from lipsync_lang.pipeline.limit import lower_envelope, ramps, rest_at_ends, upper_envelope
from lipsync_lang.pipeline.motion import Motion
from lipsync_lang.pipeline.perform import perform
from lipsync_lang.pipeline.prepare import prepare
from lipsync_lang.pipeline.smooth import chord, closing, closing_within
from lipsync_lang.pipeline.tables import RESOLUTION, Contact, Tables
from lipsync_lang.pipeline.track import Track, lay_track
from lipsync_lang.pipeline.warp import locate, stitch, warp

SILENCE, A, P = 0, 1, 2
AT = np.linspace(0, 1, RESOLUTION + 1)


def make_tables(curves, contacts=(), thresholds=None, **rest):
    """Tables of as many poses as the curves have; `curves` maps pairs to (K, P)."""
    poses = next(iter(curves.values())).shape[1]
    pairs = np.zeros((3, 3), np.intp)
    for row, pair in enumerate(curves, start=1):
        pairs[pair] = row
    count = len(curves) + 1
    still = np.zeros((RESOLUTION + 1, poses))
    values = {
        "curves": np.stack([still, *curves.values()]).astype(np.float32),
        "boundary": np.full(count, 0.5),
        "free": np.zeros(count, bool),
        "priority": np.arange(poses, dtype=float),
        "softness": np.zeros(poses),
        "anticipate": np.zeros(poses),
        "highest": np.ones(poses),
        "opposed": np.zeros((3, poses), bool),
    }
    free = np.full((poses, poses), 2.0)
    values["paper"] = free
    return Tables(
        **(values | rest),
        pairs=pairs,
        silence=SILENCE,
        contacts=contacts,
        thresholds=free if thresholds is None else thresholds,
    )


def line(ids, times, made, motion):
    return lay_track(np.array(ids), np.array(times), np.arange(len(ids)), made, motion)


EVERY_PAIR = [(a, b) for a in range(3) for b in range(3) if a or b]
RAMP = make_tables(dict.fromkeys(EVERY_PAIR, AT[:, None]))
"""Bigrams whose curves show the normalised time."""


def positions(track, made, *times):
    ending, beginning = warp(made, track, locate(track, np.array(times)))
    return np.column_stack((ending[:, 0], beginning[:, 0]))


# Figure 6: bigrams on the timeline


def test_bigrams_span_two_phonemes_and_a_quarter_of_a_second_of_silence():
    track = line([A, P], [0, 0.2, 0.5], RAMP, Motion())
    assert track.ids.tolist() == [SILENCE, A, P, SILENCE]
    assert track.bounds == pytest.approx([-0.25, 0, 0.2, 0.5, 0.75])
    assert track.rows.tolist() == [RAMP.pairs[pair] for pair in ((0, A), (A, P), (P, 0))]


def test_the_anchored_warp_pins_the_middle_of_a_bigram_to_the_spoken_boundary():
    track = line([A, P], [0, 0.2, 0.5], RAMP, Motion())
    # half way through the silence: a quarter of (_, A)
    # half way through A: three quarters of (_, A), a quarter of (A, P)
    # half way through P: three quarters of (A, P), a quarter of (P, _)
    # a fifth into the silence after it (0.05 of 0.25 s): 0.5 + 0.5 / 5 of (P, _)
    found = positions(track, RAMP, -0.125, 0.1, 0.35, 0.55)
    assert found == pytest.approx(np.array([[0, 0.25], [0.75, 0.25], [0.75, 0.25], [0.6, 0]]))


def test_a_bigram_may_pin_another_place_than_its_middle():
    made = make_tables(dict.fromkeys(EVERY_PAIR, AT[:, None]), boundary=np.full(9, 0.8))
    track = line([A, P], [0, 0.2, 0.5], made, Motion())
    # half way through A: 0.8 + 0.2 / 2 of (_, A), 0.8 / 2 of (A, P)
    assert positions(track, made, 0.1) == pytest.approx(np.array([[0.9, 0.4]]))


def test_the_linear_warp_is_the_papers():
    track = line([A, P], [0, 0.2, 0.5], RAMP, Motion(warp="linear"))
    # (_, A) runs from -0.25 to 0.2, (A, P) from 0 to 0.5, (P, _) from 0.2 to 0.75
    found = positions(track, RAMP, 0.1, 0.35)
    wanted = [[0.35 / 0.45, 0.1 / 0.5], [0.35 / 0.5, 0.15 / 0.55]]
    assert found == pytest.approx(np.array(wanted))


def test_the_mouth_rests_in_the_middle_of_a_long_pause():
    track = line([A, SILENCE, P], [0, 0.2, 1.2, 1.4], RAMP, Motion())
    # (A, _) uses 0.2 to 0.45, (_, P) uses 0.95 to 1.2
    found = positions(track, RAMP, 0.325, 0.7, 1.075)
    assert found == pytest.approx(np.array([[0.75, 0], [0, 0], [0, 0.25]]))


def test_a_short_pause_is_shared_by_both_bigrams():
    track = line([A, SILENCE, P], [0, 0.2, 0.3, 0.5], RAMP, Motion())
    assert positions(track, RAMP, 0.25) == pytest.approx(np.array([[0.75, 0.25]]))


def test_a_long_sound_is_reached_at_once_and_held():
    track = line([A, P], [0, 2, 2.2], RAMP, Motion(sound_reach=0.4))
    # 0.2 s to the middle of A, held there until 0.2 s before its end
    found = positions(track, RAMP, 0.1, 0.2, 1.0, 1.8, 1.9)
    middle = [0.75, 0.25]
    assert found == pytest.approx(
        np.array([[0.625, 0.125], middle, middle, middle, [0.875, 0.375]])
    )


def test_silences_in_a_row_are_one():
    track = line([A, SILENCE, SILENCE, P], [0, 0.2, 0.25, 0.3, 0.5], RAMP, Motion())
    assert track.ids.tolist() == [SILENCE, A, SILENCE, P, SILENCE]
    assert track.bounds == pytest.approx([-0.25, 0, 0.2, 0.3, 0.5, 0.75])
    assert track.source.tolist() == [-1, 0, 1, 3, -1]


# Figure 7: stitching


def test_the_larger_of_two_overlapping_curves_is_retained():
    ending, beginning = np.array([[0.8], [0.4], [0.1]]), np.array([[0.2], [0.4], [0.6]])
    track = line([A], [0, 1], RAMP, Motion(sound_reach=1))
    place = locate(track, np.array([0.25, 0.5, 0.75]))
    assert stitch(ending, beginning, place, "max").tolist() == [[0.8, 0.4, 0.6]]
    # 0.75 * 0.8 + 0.25 * 0.2, both 0.4, 0.25 * 0.1 + 0.75 * 0.6
    assert stitch(ending, beginning, place, "crossfade") == pytest.approx(
        np.array([[0.65, 0.4, 0.475]])
    )


# Figure 8: smoothing

PEAKS = np.array([[0, 0.5, 0, 0, 1, 0]])


def test_a_chord_joins_maxima_within_the_window_and_not_beyond():
    # three frames apart: 0.5, 0.5 + 0.5 / 3, 0.5 + 1 / 3, 1
    joined = [[0, 0.5, 2 / 3, 5 / 6, 1, 0]]
    assert chord(PEAKS, 3) == pytest.approx(np.array(joined))
    assert chord(PEAKS, 2.9).tolist() == PEAKS.tolist()


def test_a_flat_top_counts_by_its_two_ends():
    # tops: frames 1 and 3 are the ends of one, 5 is the other; 3 and 5 are joined at 0.75
    curve = np.array([[0, 1, 1, 1, 0, 0.5, 0]])
    assert chord(curve, 2).tolist() == [[0, 1, 1, 1, 0.75, 0.5, 0]]


def test_chords_go_from_each_maximum_to_the_next_only():
    # the maxima 1, 0.2 and 1 lie two apart each: the low one between is no valley
    curve = np.array([[1, 0, 0.2, 0, 1]])
    assert chord(curve, 4) == pytest.approx(np.array([[1, 0.6, 0.2, 0.6, 1]]))


def test_closing_fills_a_valley_narrower_than_its_window_to_its_lower_side():
    # two frames of valley: a window of three fills them, one of two does not
    assert closing(PEAKS, 3).tolist() == [[0, 0.5, 0.5, 0.5, 1, 0]]
    assert closing(PEAKS, 2).tolist() == PEAKS.tolist()
    assert closing(PEAKS, 1).tolist() == PEAKS.tolist()


def test_closing_leaves_what_is_next_to_rest_alone():
    # nothing lies outside: an edge is no valley
    assert closing(np.array([[0.1, 0.9, 0.4]]), 9).tolist() == [[0.1, 0.9, 0.4]]


def test_closing_within_runs_leaves_the_vowel_between_open():
    curve = np.array([[1, 0.2, 0.1, 0.3, 1, 0.4, 1]])
    inside = np.array([[True, True, False, True, True, True, True]])
    # the run of frames 3 to 6 has a valley of one frame; 1 and 3 fall towards the vowel
    wanted = [[1, 0.2, 0.1, 0.3, 1, 1, 1]]
    assert closing_within(curve, inside, 5).tolist() == wanted
    assert closing(curve, 5).tolist() == [[1] * 7]


# Figure 9: constraints. Pose 1 outranks pose 0, together at most 0.5

ONE_PAIR = together(caps(np.array([[2, 0.5], [0.5, 2]]), np.array([0.0, 1.0])))


@pytest.mark.parametrize(
    ("high", "low", "left"),
    [
        (0.1, 0.4, 0.4),  # together exactly 0.5: nothing happens
        (0.3, 0.4, 0.2),  # 0.5 - 0.3
        (0.5, 0.4, 0.0),
        (0.8, 0.4, 0.0),  # 0.5 - 0.8 is below rest
        (0.0, 0.9, 0.5),  # so that one alone never passes the threshold either
    ],
)
def test_the_lower_pose_makes_room(high, low, left):
    out = constrain(np.array([[low], [high]]), ONE_PAIR)
    assert out == pytest.approx(np.array([[left], [high]]))


def test_the_papers_sign_would_raise_what_it_means_to_lower():
    high, low, threshold = 0.3, 0.4, 0.5
    printed = low - (threshold - high - low)  # 0.4 - (0.5 - 0.3 - 0.4) = 0.6
    meant = low + (threshold - high - low)  # 0.4 + (0.5 - 0.3 - 0.4) = 0.2
    assert printed > low > meant
    assert constrain(np.array([[low], [high]]), ONE_PAIR)[0, 0] == pytest.approx(meant)


def test_from_the_highest_priority_down_one_pass_is_enough():
    thresholds = np.array([[2, 1, 2], [1, 2, 1], [2, 1, 2.0]])
    chain = together(caps(thresholds, np.array([0.0, 1.0, 2.0])))
    # pose 2 leaves 1 - 0.7 = 0.3 to pose 1, which then leaves 1 - 0.3 = 0.7 to pose 0
    out = constrain(np.array([[0.9], [0.6], [0.7]]), chain)
    assert out == pytest.approx(np.array([[0.7], [0.3], [0.7]]))


def test_a_tie_leaves_both_alone():
    assert caps(np.array([[2, 0.5], [0.5, 2]]), np.array([1.0, 1.0])) == ()
    assert caps(np.array([[2, 0.5], [0.5, 2]]), np.array([np.inf, np.inf])) == ()


def test_at_most_follows_a_pose_that_has_already_made_room():
    # pose 0 falls to 0.5 - 0.4 = 0.1, and pose 2 is never above it
    three = caps(np.array([[2, 0.5, 2], [0.5, 2, 2], [2, 2, 2]]), np.array([0.0, 1.0, 2.0]))
    out = constrain(np.array([[0.6], [0.4], [0.3]]), together(three), [(2, 0)])
    assert out == pytest.approx(np.array([[0.1], [0.4], [0.1]]))


def test_pairs_in_which_one_pose_yields_at_one_threshold_are_joined():
    pairs = [Cap(0, 3, 1.0), Cap(0, 2, 0.5), Cap(0, 1, 1.0), Cap(1, 3, 1.0)]
    found = {(low, threshold): high.tolist() for low, high, threshold in together(pairs)}
    assert found == {(0, 1.0): [3, 1], (0, 0.5): [2], (1, 1.0): [3]}


def test_a_pose_makes_room_for_the_strongest_of_several():
    # at 1 with poses 1 and 2, of which pose 2 leaves the least: 1 - 0.7; pose 3 leaves 0.5 - 0.3
    pairs = [Cap(0, 3, 0.5), Cap(0, 2, 1.0), Cap(0, 1, 1.0)]
    weights = np.array([[0.9, 0.9], [0.4, 0.4], [0.7, 0.7], [0.0, 0.3]])
    assert constrain(weights, together(pairs))[0] == pytest.approx([0.3, 0.2])


def test_the_built_in_constraints_are_the_papers():
    performer = resolve("english", "facefx", cache=False)
    names, made = performer.poses, performer.compiled.tables
    found = {(names[cap.low], names[cap.high]): cap.threshold for cap in made.papers.caps}
    assert found == {("open", "FV"): 0.5, ("open", "PBM"): 0.5, ("open", "ShCh"): 0.5}
    order = sorted(
        ("W", "wide", "ShCh", "FV", "PBM", "open"), key=lambda p: made.priority[names.index(p)]
    )
    assert order == ["open", "W", "wide", "ShCh", "FV", "PBM"]
    assert performer.motion.speed_limit == 15


# Figure 10: speed. 15 per second at 60 frames per second is a quarter a frame

SPIKE = np.array([[0, 0, 0, 1, 0, 0.0]])


def test_the_lower_envelope_slows_a_curve_by_taking_away():
    assert lower_envelope(SPIKE, 0.25).tolist() == [[0, 0, 0, 0.25, 0, 0]]
    plateau = np.array([[0, 1, 1, 1, 1, 0.0]])
    assert lower_envelope(plateau, 0.25).tolist() == [[0, 0.25, 0.5, 0.5, 0.25, 0]]


def test_the_upper_envelope_keeps_the_peak_and_widens_its_flanks():
    assert upper_envelope(SPIKE, 0.25).tolist() == [[0.25, 0.5, 0.75, 1, 0.75, 0.5]]


def test_a_slow_curve_stays_as_it_is():
    slow = np.array([[0, 0.25, 0.5, 0.25, 0.25, 0]])
    assert lower_envelope(slow, 0.25).tolist() == slow.tolist()
    assert upper_envelope(slow, 0.25).tolist() == slow.tolist()


def test_an_animation_starts_and_ends_within_reach_of_rest():
    ones = np.ones((1, 10))
    ramp = [0, 0.25, 0.5, 0.75]
    both = rest_at_ends(ones, ramps(0.25, np.array([0])), head=True, tail=True)
    assert both.tolist() == [[*ramp, 1, 1, *ramp[::-1]]]
    head = rest_at_ends(ones, ramps(0.25, np.array([0])), head=True, tail=False)
    assert head.tolist() == [[*ramp, 1, 1, 1, 1, 1, 1]]
    late = rest_at_ends(ones, ramps(0.25, np.array([2])), head=True, tail=False)
    assert late.tolist() == [[0, 0, *ramp, 1, 1, 1, 1]]


# Contacts


def held(spans, fps, count):
    """The frames that are held for phonemes that all demand a contact, in silence."""
    times = [0.0, *spans, spans[-1] + 1]
    wanted = np.array([False, *[True] * (len(spans) - 1), False])
    many = np.zeros(len(wanted))
    track = Track(many, np.array(times), *[many] * 6, 0.0, times[-1], many)
    return np.flatnonzero(held_frames(wanted, track, 0.0, fps, count)).tolist()


def test_a_contact_is_held_but_for_30_ms_at_each_side():
    # 0.1 to 0.2 s less 30 ms: 0.13 to 0.17 s
    assert held([0.1, 0.2], 100, 40) == [13, 14, 15, 16, 17]


def test_a_long_m_stays_shut():
    assert held([0.1, 1.1], 100, 140) == list(range(13, 108))


def test_a_short_contact_is_held_for_42_ms():
    # 0.10 to 0.12 s, about 0.11 s: 0.089 to 0.131 s
    assert held([0.1, 0.12], 100, 40) == [9, 10, 11, 12, 13]


def test_a_short_contact_is_held_for_one_frame():
    # 0.101 to 0.106 s at 12 frames per second: 0.1035 +- 0.0417 s holds frame 1 at 0.0833 s
    assert held([0.101, 0.106], 12, 12) == [1]


def test_contacts_in_a_row_are_held_through_their_boundary():
    # 0.1 to 0.3 s less 30 ms at the two ends only
    assert held([0.1, 0.2, 0.3], 100, 40) == list(range(13, 28))


def test_holding_raises_to_the_floor_and_lowers_to_the_ceiling():
    curves = np.array([[0.2, 0.2, 1.0], [0.6, 0.6, 0.05]])
    levels = bounds([Plateau(0, 0.9)], [Plateau(1, 0.1)], 2)
    out = hold(curves, *levels, np.array([False, True, True]))
    assert out.tolist() == [[0.2, 0.9, 1.0], [0.6, 0.1, 0.05]]


def test_a_contact_pose_leaves_room_for_the_floor_of_one_that_it_outranks():
    # both poses stand at 1 throughout; together at most 1.5, and pose 0 has to reach 0.7
    ones = np.ones((RESOLUTION + 1, 2))
    made = make_tables(
        dict.fromkeys(EVERY_PAIR, ones),
        contacts=(
            Contact(np.array([False, True, False]), np.array([0.7, 0]), np.ones(2)),
            Contact(np.array([False, False, True]), np.array([0, 0.8]), np.ones(2)),
        ),
        thresholds=np.array([[2, 1.5], [1.5, 2]]),
    )
    assert prepare(made, Motion(), 20).tops.tolist() == pytest.approx([1, 0.8])
    track = line([P, A], [0, 0.5, 1], made, Motion())
    performance = perform(made, track, Motion(), 20)
    weights = performance.weights()[-performance.frames.first :]
    # pose 1 gives way to 1.5 - 0.7 wherever it is, and pose 0 takes what is left
    assert weights[:21] == pytest.approx(np.tile([0.7, 0.8], (21, 1)))


# Figure 5: the whole chain, at 20 frames per second: 0.75 a frame


def humps(**poses):
    """A bigram's curves: a tent of some height over its first or its second half."""
    first, second = (
        polyline(np.array([[(x, 0), (x + 0.25, 1), (x + 0.5, 0)]]), AT)[0] for x in (0, 0.5)
    )
    return np.column_stack([poses.get(f"{name}1", 0) * first + poses.get(f"{name}2", 0) * second
                            for name in ("open", "PBM")])  # fmt: skip


CHAIN = make_tables(
    {
        (SILENCE, A): humps(open2=0.8),
        (A, P): humps(open1=0.8, PBM2=0.6),
        (P, A): humps(PBM1=0.6, open2=0.8),
        (A, SILENCE): humps(open1=0.8),
    },
    contacts=(Contact(np.array([False, False, True]), np.array([0, 0.9]), np.array([0.1, 1])),),
    thresholds=np.array([[2, 0.5], [0.5, 2]]),
)
APA = ([A, P, A], [0, 0.2, 0.3, 0.5])
"""Frames 0 to 4 are in the first A, 4 and 5 in the P, 6 to 10 in the second A."""


def chain(motion):
    track = line(*APA, CHAIN, motion)
    performance = perform(CHAIN, track, motion, 20)
    assert performance.frames.first == -5  # a quarter of a second before
    assert performance.frames.count == 5 + 11 + 5
    stages = performance.stages(0, performance.frames.count)
    assert pytest.approx(stages[-1].curves) == performance.weights().T
    for stage in stages:
        assert not stage.curves[:, :5].any(), "the lead-in rests"
        assert not stage.curves[:, 16:].any(), "so does the tail"
    return {stage.name: stage.curves[:, 5:16] for stage in stages}


def test_the_whole_chain():
    stages = chain(Motion(smooth="closing", window=0.2))
    assert list(stages) == ["stitch", "smooth", "rest", "hold", "limit", "constrain"]
    # Both bigrams over an A say the same tent, 0.8 at its middle; the P's middle is frame 5
    open_ = [0, 0.4, 0.8, 0.4, 0, 0, 0, 0.4, 0.8, 0.4, 0]
    pbm = [0, 0, 0, 0, 0, 0.6, 0, 0, 0, 0, 0]
    assert stages["stitch"] == pytest.approx(np.array([open_, pbm]), abs=1e-6)
    # 0.2 s are 4 frames: the 3 frames of valley fill to the 0.4 beside them
    open_ = [0, 0.4, 0.8, 0.4, 0.4, 0.4, 0.4, 0.4, 0.8, 0.4, 0]
    assert stages["smooth"] == pytest.approx(np.array([open_, pbm]), abs=1e-6)
    assert stages["rest"] == pytest.approx(stages["smooth"])
    # 0.23 to 0.27 s, widened to a frame: 0.225 to 0.275 s, frame 5. The ceiling of open is left to
    # the constraint: it keeps 0.5 - 0.9 there, which is less
    pbm[5] = 0.9
    assert stages["hold"] == pytest.approx(np.array([open_, pbm]), abs=1e-6)
    # PBM may move by 0.75: 0.9 - 0.75 on both sides; open is slow enough
    pbm[4] = pbm[6] = 0.15
    assert stages["limit"] == pytest.approx(np.array([open_, pbm]), abs=1e-6)
    # open keeps 0.5 - 0.15 beside the contact, nothing within, and 0.5 anywhere
    open_ = [0, 0.4, 0.5, 0.4, 0.35, 0, 0.35, 0.4, 0.5, 0.4, 0]
    assert stages["constrain"] == pytest.approx(np.array([open_, pbm]), abs=1e-6)


def test_the_chain_without_contacts_in_the_papers_order():
    motion = Motion(window=0.3, smooth="chord", contacts="free", limit="after", speed_limit=6)
    stages = chain(motion)
    assert list(stages) == ["stitch", "smooth", "rest", "constrain", "limit"]
    # the maxima of open, frames 2 and 8, are 0.3 s apart: their chord is level
    open_ = [0, 0.4, 0.8, 0.8, 0.8, 0.8, 0.8, 0.8, 0.8, 0.4, 0]
    pbm = [0, 0, 0, 0, 0, 0.6, 0, 0, 0, 0, 0]
    assert stages["smooth"] == pytest.approx(np.array([open_, pbm]), abs=1e-6)
    assert stages["rest"] == pytest.approx(stages["smooth"])
    # 0.5 - 0.6 is below rest
    open_ = [0, 0.4, 0.5, 0.5, 0.5, 0, 0.5, 0.5, 0.5, 0.4, 0]
    assert stages["constrain"] == pytest.approx(np.array([open_, pbm]), abs=1e-6)
    # 6 per second: 0.3 a frame, up from rest and down to it
    open_ = [0, 0.3, 0.5, 0.5, 0.3, 0, 0.3, 0.5, 0.5, 0.3, 0]
    pbm[5] = 0.3
    assert stages["limit"] == pytest.approx(np.array([open_, pbm]), abs=1e-6)


def test_a_contact_that_is_waived_is_as_weak_as_its_curve():
    free = np.array([False, False, True, False, False])
    made = replace(CHAIN, free=free)
    track = line(*APA, made, Motion())
    weights = perform(made, track, Motion(), 20).weights()
    assert weights[:, 1].max() == pytest.approx(0.6)
