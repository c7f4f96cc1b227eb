"""Quality of an animation: known values, invariances, and findings."""

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from functools import cache
from itertools import pairwise
from operator import attrgetter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full, swept
from places import ROOT
from shipped import POSESETS
from strategies import any_lines  # noqa: F401 its profile is wanted

from lipsync_lang import LipsyncError, Schedule, resolve
from lipsync_lang.animations.animation import Animation
from lipsync_lang.packs.models.check_models import Checks
from lipsync_lang.performing.performer import PerformedLine, Performer
from lipsync_lang.reports.quality.baselines import BASELINES, HOLD_SECONDS, compare, held
from lipsync_lang.reports.quality.check_animation import (
    as_json,
    as_junit,
    as_text,
    check,
    check_all,
)
from lipsync_lang.reports.quality.face_columns import APERTURE
from lipsync_lang.reports.quality.figures import Figure, Finding, Quality
from lipsync_lang.reports.quality.measures import load_measures

RIGS = sorted(ROOT.glob("posesets/facefx/rigs/*.yaml"))
assert RIGS, "a sweep over nothing passes"

SOUNDS = (
    ("_", 0.8), ("P", 0.1), ("AA", 0.8), ("F", 0.1), ("AA", 0.4), ("S", 0.12), ("EH", 0.3),
    ("M", 0.12), ("AA", 0.3), ("_", 0.9),
)  # fmt: skip
MEASURES = load_measures()
assert MEASURES, "a sweep over nothing passes"


@cache
def performer(character="facefx"):
    return resolve("english", character, cache=False)


@cache
def line(at=0.0):
    times = at + np.concatenate(([0.0], np.cumsum([seconds for _, seconds in SOUNDS])))
    return Schedule(tuple(label for label, _ in SOUNDS), times, notation="arpabet")


@cache
def performed(character="facefx", fps=60):
    return performer(character).perform(line(), fps=fps)


def span(number):
    """Return the start and the end of a phoneme of the line."""
    return line().times[number], line().times[number + 1]


def changed(animation, pose, change):
    """Change the curve of a pose: ``(times, curve) -> curve``."""
    weights = animation.weights.copy()
    column = animation.poses.index(pose)
    weights[:, column] = change(animation.times, weights[:, column])
    return replace(animation, weights=weights)


def still(fps=60, seconds=2.0):
    """An animation without movement, over one long vowel between silences."""
    schedule = Schedule(("_", "AA", "_"), np.array([0.0, 0.5, 1.5, seconds]), notation="arpabet")
    times = np.arange(round(seconds * fps) + 1) / fps
    weights = np.zeros((len(times), len(performer().poses)))
    return Animation(
        times, performer().poses, weights, fps, schedule, PerformedLine(performer(), {})
    )


def tent(times, middle, height, speed):
    return np.maximum(0, height - speed * np.abs(times - middle))


def values(quality):
    return {figure.name: figure.value for figure in quality.figures}


def failed(quality):
    return {figure.name for figure in quality.failed}


# What every measure comes to on curves drawn by hand


def test_a_performance_keeps_every_limit():
    quality = check(performed())
    assert quality.passed
    assert failed(quality) == set()
    assert {figure.name.split()[0] for figure in quality.figures} == set(MEASURES)


def test_contacts_are_counted_and_a_missed_one_says_how_close_it_came():
    bad = changed(performed(), "PBM", lambda t, w: np.where(t < 1.2, w * 0.5, w))
    figure = check(bad)["contacts lips"]
    assert figure.value == 0.5
    assert dict(figure.parts) == {"made": 1, "missed": 1}
    (finding,) = figure.findings
    assert finding.at == 0.8
    assert finding.what.startswith("P brings PBM to 0.")
    assert "'lips' requires 0.7 or more" in finding.what


def test_a_ceiling_is_part_of_a_contact():
    bad = changed(performed(), "W", lambda t, w: np.where(t < 1.2, 0.4, w))
    finding = check(bad)["contacts lips"].findings[0]
    assert "brings W to 0.40" in finding.what
    assert "0.2 or less" in finding.what
    near = changed(performed(), "W", lambda t, w: np.where(t < 1.2, 0.24, w))
    assert check(near)["contacts lips"].value == 0


def test_a_contact_without_a_frame_is_missed():
    late = replace(performed(), times=performed().times + 5)
    assert "has no frame" in check(late)["contacts lips"].findings[0].what


def lips_and_teeth(*seconds):
    """A p, an f and vowels around them, with the given durations of the p and the f."""
    times = np.cumsum([0, 0.3, 0.12, *seconds, 0.12, 0.3])
    return Schedule(("_", "AA", "P", "F", "AA", "_"), times, notation="arpabet")


def test_two_contacts_that_exclude_each_other_are_not_both_half_made():
    made = performer().perform(lips_and_teeth(0.08, 0.08), fps=60)
    assert check(made)["clashes"].value <= 0.02
    both = made
    for pose, weight in (("PBM", 0.45), ("FV", 0.4)):
        both = changed(both, pose, lambda t, w, h=weight: np.where((t > 0.4) & (t < 0.6), h, w))
    figure = check(both)["clashes"]
    assert figure.value == pytest.approx(0.18, abs=0.02)
    assert not figure.passed
    assert figure.findings[0].at == pytest.approx(0.4, abs=0.02)
    assert figure.findings[0].what.startswith("AA P F AA half makes both 'teeth' and 'lips' for 0.")
    assert check(both)["constraints"].value == 0


def test_contacts_clash_only_where_a_pose_set_lets_them_exclude_each_other():
    for name in ("arkit", "crab"):
        assert "exclude" in check(performed(name))["clashes"].why


@pytest.mark.parametrize("fps", [30, 60, 120])
def test_a_short_f_beside_a_p_yields_and_is_told(fps):
    performed = performer().perform(lips_and_teeth(0.08, 0.03), fps=fps)
    made = changed(performed, "FV", lambda _, w: np.minimum(w, 0.4))
    quality = check(made)
    figure = quality["contacts teeth"]
    assert figure.passed
    assert dict(figure.parts) == {"made": 0, "missed": 0, "yielded": 1}
    assert "F brings FV to 0." in str(quality)
    assert "it yields to its neighbour" in str(quality)
    assert quality["contacts lips"].parts["missed"] == 0


@pytest.mark.parametrize("fps", [30, 60, 120])
@pytest.mark.parametrize("seconds", [0.06, 0.08, 0.12])
def test_an_f_beside_a_p_has_its_contact_in_its_middle_from_60_ms(seconds, fps):
    schedule = lips_and_teeth(0.08, seconds)
    made = performer().perform(schedule, fps=fps)
    middle = schedule.times[3:5].mean()
    assert np.interp(middle, made.times, made["FV"]) >= 0.9 * 0.5
    weak = changed(made, "FV", lambda _, w: np.minimum(w, 0.4))
    assert failed(check(weak)) == {"contacts teeth"}


def test_a_contact_in_the_middle_of_another_sound_is_false():
    middle = sum(span(2)) / 2
    bad = changed(performed(), "PBM", lambda t, w: np.maximum(w, tent(t, middle, 1, 10)))
    bad = changed(
        bad, "open", lambda t, w: np.minimum(w, 10 * np.maximum(0, abs(t - middle) - 0.1))
    )
    figure = check(bad)["false_contacts lips"]
    assert figure.value == pytest.approx(1 / 6)
    assert figure.findings == (Finding(span(2)[0], "AA makes 'lips'"),)


@pytest.mark.parametrize("seconds", [-0.2, -0.05, 0.1, 0.2])
def test_closures_are_as_late_as_the_animation_is_moved(seconds):
    there, moved = check(performed()), replace(performed(), times=performed().times + seconds)
    here = check(moved)
    assert here["closure_offset"].parts["closures"] == 3
    before = there["closure_offset"].parts["median"]
    assert here["closure_offset"].parts["median"] == pytest.approx(before + seconds, abs=0.001)
    worst = "closure_late" if seconds > 0 else "closure_early"
    assert here[worst].value == pytest.approx(there[worst].value + abs(seconds), abs=0.001)


def test_a_closure_for_another_sound_is_not_taken_for_a_missing_one():
    bad = changed(performed(), "PBM", lambda t, w: np.where(t > 2, 0, w))
    quality = check(bad)
    assert quality["closure_offset"].parts["closures"] == 2
    assert quality["closure_late"].value < 0.045


def test_where_rest_makes_the_contact_a_closure_is_off_only_by_the_middle_it_misses():
    quality = check(performed("crab"))
    assert quality["closure_late"].value == quality["closure_early"].value == 0
    moved = replace(performed("crab"), times=performed("crab").times + 0.1)
    assert check(moved)["closure_late"].value > 0.045


def test_rules_say_by_how_much_they_are_missed():
    start, end = span(5)
    middle = (start + end) / 2
    bad = changed(
        performed(), "open", lambda t, w: np.maximum(w, tent(t, middle, 2, 6).clip(0, 0.5))
    )
    figure = check(bad)["rules sibilants"]
    assert figure.value == 1
    assert figure.limit == 0.1
    assert figure.findings[0].what == "S misses the rule by 0.14 of aperture"


def test_a_constraint_is_broken_in_the_frames_where_it_is():
    base = still()
    over = changed(base, "open", lambda t, _: np.where((t > 0.9) & (t < 1.1), 0.7, 0.0))
    over = changed(over, "FV", lambda t, _: np.where((t > 0.9) & (t < 1.1), 0.5, 0.0))
    figure = check(over)["constraints"]
    assert figure.value == pytest.approx(11 / len(base.times))
    assert dict(figure.parts) == {"open + FV": pytest.approx(0.2)}
    small = changed(over, "FV", lambda _, w: np.minimum(w, 0.305))
    assert check(small)["constraints"].value == 0


def test_the_lower_pose_alone_answers_for_a_constraint():
    full = changed(still(), "FV", lambda t, _: np.full_like(t, 0.85))
    assert check(full)["constraints"].value == 0


def test_speed_is_that_of_the_fastest_pose_and_limited_by_the_motion():
    ramp = changed(still(), "tBack", lambda t, _: np.clip((t - 1) * 8, 0, 1))
    figure = check(ramp)["speed"]
    assert figure.value == pytest.approx(8)
    assert figure.limit == performer().motion.speed_limit
    assert figure.passed
    slower = performer().with_motion({"speed_limit": 7})
    assert not check(ramp, performer=slower)["speed"].passed


def test_jitter_counts_what_is_there_and_back_at_once():
    pulses = {0.8, 1.0, 1.2}

    def frames(t, _):
        return 0.2 * np.isin(np.round(t, 3), list(pulses))

    assert check(changed(still(), "wide", frames))["jitter"].value == pytest.approx(3)
    small = changed(still(), "wide", lambda t, w: frames(t, w) * 0.2)
    assert check(small)["jitter"].value == 0
    slow = changed(still(), "wide", lambda t, _: tent(t, 1.0, 0.5, 5))
    assert check(slow)["jitter"].value == 0


def test_changes_and_short_holds_are_of_the_strongest_pose():
    def first(t, _):
        return 0.5 * ((t > 0.495) & (t < 0.795)) + 0.5 * (t > 0.845)

    mixed = changed(still(), "wide", first)
    mixed = changed(mixed, "tBack", lambda t, _: 0.4 * (t > 0.6))
    quality = check(mixed)
    assert quality["changes"].value == pytest.approx(2)
    assert quality["short_holds"].value == 1
    assert quality["short_holds"].parts["shortest"] == pytest.approx(0.05)
    assert quality["short_holds"].limit is None
    assert not check(mixed, limits={"short_holds": 0.5})["short_holds"].passed


def test_of_equal_poses_the_first_is_the_strongest():
    def pulse(t, _):
        return 0.5 * ((t > 0.795) & (t < 0.845))

    both = changed(changed(still(), "wide", pulse), "tBack", pulse)
    first = min(("wide", "tBack"), key=both.poses.index)
    assert [one.what.split()[0] for one in check(both)["short_holds"].findings] == [first]


def test_movement_in_silence_is_judged_far_from_sounds():
    schedule = Schedule(("_", "AA", "_"), np.array([0.0, 2, 2.5, 5]), notation="arpabet")
    times = np.arange(301) / 60
    quiet = replace(still(), schedule=schedule, times=times, weights=np.zeros((301, 9)))
    assert check(quiet)["silence"].value == 0
    near = changed(quiet, "wide", lambda t, _: tent(t, 2.6, 0.2, 2))
    assert check(near)["silence"].value == 0
    far = changed(quiet, "wide", lambda t, _: tent(t, 4, 0.3, 1))
    assert check(far)["silence"].value == pytest.approx(0.3, abs=0.01)
    assert failed(check(far)) == {"silence", "rules opens", "unopened"}


def test_saturation_and_stillness_are_shares_of_the_frames_of_speech():
    base = still()
    assert check(base)["still"].value == 1
    assert check(base)["still"].parts["longest"] == pytest.approx(1, abs=0.02)
    half = changed(base, "tBack", lambda t, _: np.where(t < 0.999, 1.0, (t - 1) * 0.5))
    quality = check(half)
    assert quality["saturation"].value == pytest.approx(0.5, abs=0.02)
    assert quality["saturation"].parts["tBack"] == pytest.approx(0.5, abs=0.02)
    assert quality["still"].value == pytest.approx(0.5, abs=0.02)


def test_a_line_of_silence_is_judged_for_what_can_be():
    schedule = Schedule(("_",), np.array([0.0, 2.0]), notation="arpabet")
    quality = check(replace(still(), schedule=schedule))
    assert quality.passed
    assert quality["jitter"].value is None
    assert quality["silence"].value == 0


# A broken animation is noticed by the right measure


def shaking(t, w):
    inside = (t > 1.2) & (t < 1.6)
    return w + np.where(inside, 0.1 * (-1.0) ** np.arange(len(t)), 0)


def jumping(t, w):
    return np.where((t > 1.3) & (t < 2.0), 0.6, w)


def fidgeting(t, w):
    return np.maximum(w, tent(t, 3.8, 0.2, 1))


def shut(t, w):
    start, end = span(4)
    return np.where((t > start - 0.1) & (t < end + 0.1), np.minimum(w, 0), w)


BROKEN = {
    "lips that do not meet": ("PBM", lambda _, w: w * 0.6, {"contacts lips"}),
    "teeth that do not touch": ("FV", lambda _, w: w * 0.5, {"contacts teeth"}),
    "a trembling tongue": ("tBack", shaking, {"jitter"}),
    "a jump": ("tBack", jumping, {"speed"}),
    "a fidget": ("wide", fidgeting, {"silence"}),
    "too wide": (
        "open",
        lambda _, w: np.minimum(w * 2, 1),
        {"constraints", "shelves"},
    ),
    "a mouth that stays shut": (
        "open",
        lambda t, w: np.minimum(w, shut(t, w)),
        {"rules opens", "shut_vowels"},
    ),
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_broken_is_noticed_by_its_own_measure(name):
    pose, change, noticed = BROKEN[name]
    bad = changed(performed(), pose, change)
    found = failed(check(bad, limits={"speed": 40} if pose == "open" else None))
    assert found == noticed


def test_an_animation_that_is_late_is_late():
    late = replace(performed(), times=performed().times + 0.07)
    found = failed(check(late))
    assert {"closure_late", "closure_offset"} <= found
    assert found <= {"closure_late", "closure_offset", "contacts lips", "contacts teeth",
                     "rules sibilants", "rules opens", "opening_lag"}  # fmt: skip


@pytest.mark.parametrize("name", swept(POSESETS, quick=4))
def test_a_face_that_does_not_open_fails_in_every_pose_set(name):
    there = performed(name)
    opened = check(there)["unopened"]
    assert opened.parts["closed"] == 0
    assert opened.parts["opened"] >= 2
    flat = check(replace(there, weights=np.zeros_like(there.weights)))
    assert "unopened" in failed(flat)
    assert flat["unopened"].value == 1.0
    assert flat.summary.startswith(f"{sum(one.verdict == 'ok' for one in flat.figures)} of ")


def test_a_face_without_any_open_vowel_fails_by_all_of_its_vowels():
    there = performer()
    mute = {APERTURE: {performer().poses[0]: 1e-6}}
    face = Performer(replace(there.compiled, measures=mute, model=None), there.motion)
    assert check(face.perform(line()))["unopened"].parts == {"opened": 0, "closed": 4}


# What does not change the figures


@given(st.floats(-50, 50))
def test_moving_a_line_in_time_changes_nothing(seconds):
    there = performed()
    schedule = replace(there.schedule, times=there.schedule.times + seconds)
    moved = replace(there, times=there.times + seconds, schedule=schedule)
    before, after = values(check(there)), values(check(moved))
    assert before.keys() == after.keys()
    for name, value in before.items():
        frame = 1.01 / there.fps if name.startswith("closure") else 0.02
        assert after[name] == pytest.approx(value, abs=frame), name


@pytest.mark.parametrize("character", ["facefx", "crab", "rhubarb"])
@pytest.mark.parametrize("fps", [30, 48, 60])
def test_twice_the_frames_change_the_figures_little(character, fps):
    once, twice = (check(performed(character, rate)) for rate in (fps, 2 * fps))
    assert failed(once) == failed(twice)
    for name, value in values(once).items():
        if value is None or name in ("speed", "jitter", "changes", "short_holds", "jerk", "turns"):
            continue
        assert values(twice)[name] == pytest.approx(value, abs=1.1 / fps + 0.03), name


@given(st.integers(1, 4))
def test_frames_between_frames_change_no_count(more):
    there = performed()
    times = np.linspace(there.times[0], there.times[-1], (len(there.times) - 1) * more + 1)
    weights = np.column_stack([np.interp(times, there.times, w) for w in there.weights.T])
    finer = replace(there, times=times, weights=weights, fps=there.fps * more)
    before, after = values(check(there)), values(check(finer))
    for name in ("contacts lips", "contacts teeth", "speed", "jitter"):
        assert after[name] == pytest.approx(before[name], abs=1e-6), name


@pytest.mark.parametrize("name", swept(POSESETS, quick=4))
def test_every_pose_set_keeps_the_limits_it_states(name):
    quality = check(performed(name))
    assert failed(quality) == set(), str(quality)


@pytest.mark.parametrize("fps", [24, 30, 60, 120])
def test_contacts_are_made_at_every_rate(fps):
    quality = check(performed("facefx", fps))
    assert quality["contacts lips"].value == quality["contacts teeth"].value == 0


# Limits


def test_every_measure_can_be_limited_in_a_pack():
    assert set(Checks.model_fields) == set(MEASURES)


def test_every_measure_says_what_it_is_and_its_formula():
    for measure in MEASURES.values():
        assert "value = " in measure.told, measure.name
        assert measure.told.strip().splitlines()[0].endswith((".", ":"))


def test_a_call_limits_over_the_packs():
    assert check(performed(), limits={"changes": 3})["changes"].passed is False
    with pytest.raises(LipsyncError, match="unknown measure 'jiter'; did you mean 'jitter'"):
        check(performed(), limits={"jiter": 3})
    with pytest.raises(LipsyncError, match="at least 0"):
        check(performed(), limits={"jitter": float("nan")})


def test_a_character_limits_over_its_pose_set(tmp_path):
    folder = tmp_path / "characters"
    folder.mkdir()
    rule = "{phonemes: [aa], measure: protrusion, at_least: 0.9}"
    (folder / "ann.yaml").write_text(
        "kind: character\nformat: 1\nname: ann\nposeset: facefx\n"
        f"checks:\n  still: 0.02\n  rules:\n    pout: {rule}\n",
        "utf-8",
    )
    ann = resolve("english", "ann", paths=[tmp_path])
    again = resolve("english", "ann", paths=[tmp_path])  # from the cache
    for one in (ann, again):
        shelves = one.with_motion({"smooth": "closing", "window": 0.1, "softness": 0})
        assert "still" in failed(check(shelves.perform(line())))
        moving = one.with_motion({"sound_reach": 10})  # else the middles of long sounds are still
        quality = check(moving.perform(line()))
        assert failed(quality) == {"rules pout"}
        assert "rules sibilants" in values(quality)


@full
def test_a_bigram_that_waives_its_contact_is_not_missed(tmp_path):
    folder = tmp_path / "characters"
    folder.mkdir()
    free = "{contact: free, curves: {open: [[0, 0], [1, 0.4]]}}"
    (folder / "ann.yaml").write_text(
        f"kind: character\nformat: 1\nname: ann\nposeset: facefx\nbigrams: {{_-bmp: {free}}}\n",
        "utf-8",
    )
    animation = resolve("english", "ann", paths=[tmp_path]).perform(line())
    assert dict(check(animation)["contacts lips"].parts) == {"made": 1, "missed": 0}


# Who may be judged


def test_an_animation_of_nobody_needs_a_performer():
    nobody = replace(performed(), source=None)
    with pytest.raises(LipsyncError, match="give a performer"):
        check(nobody)
    assert check(nobody, performer=performer()).passed


def test_another_face_is_refused():
    with pytest.raises(LipsyncError, match="are not the poses of crab"):
        check(performed(), performer=performer("crab"))


@pytest.mark.parametrize("frames", [0, 1])
def test_too_few_frames_are_refused(frames):
    short = replace(
        performed(), times=performed().times[:frames], weights=performed().weights[:frames]
    )
    with pytest.raises(LipsyncError, match="fewer than two frames"):
        check(short)


def test_numbers_that_are_none_are_refused():
    bad = changed(performed(), "open", lambda _, w: np.where(w == w.max(), np.nan, w))
    with pytest.raises(LipsyncError, match="weights that are not finite"):
        check(bad)


@pytest.fixture
def rigged(tmp_path):
    folder = tmp_path / "characters"
    folder.mkdir()
    text = "kind: character\nformat: 1\nname: max\nposeset: facefx\nrig: facefx-to-arkit\n"
    (folder / "max.yaml").write_text(text, "utf-8")
    return resolve("english", "max", paths=[tmp_path])


def test_channels_of_a_rig_are_judged_too(rigged):
    animation = rigged.rigged(rigged.perform(line()))
    quality = check(animation)
    assert quality.passed, str(quality)
    assert quality["contacts lips"].parts["made"] == 2
    assert quality["rules opens"].value is None
    assert quality["unopened"].parts["closed"] == 0
    gaping = changed(animation, "jawOpen", lambda _, w: np.maximum(w, 0.5))
    assert not check(gaping, performer=rigged)["contacts lips"].passed


@pytest.mark.parametrize("rig", RIGS, ids=attrgetter("stem"))
def test_a_rig_whose_mouth_stays_shut_fails(rig, tmp_path):
    (tmp_path / "characters").mkdir()
    text = f"kind: character\nformat: 1\nname: max\nposeset: facefx\nrig: {rig.stem}\n"
    (tmp_path / "characters" / "max.yaml").write_text(text, "utf-8")
    there = resolve("english", "max", paths=[tmp_path])
    animation = there.rigged(there.perform(line()))
    assert check(animation, performer=there)["unopened"].parts == {"opened": 4, "closed": 0}
    (wide,) = there.held_channels(np.eye(len(there.poses))[[there.poses.index("open")]])
    # without data of the rig's own, a lowered lip counts as a mouth that opens
    still = wide == wide.max() if there.compiled.rig["measures"] else wide > 0
    shut = replace(animation, weights=np.where(still, 0, animation.weights))
    assert "unopened" in failed(check(shut, performer=there))


# Plain methods


def test_held_shapes_are_held_one_at_a_time():
    animation = held(performer(), line(), fps=240)
    assert ((animation.weights > 0).sum(axis=1) <= 1).all()
    shown = animation.weights.argmax(axis=1) + 1
    shown[animation.weights.max(axis=1) == 0] = 0
    starts = animation.times[np.flatnonzero(np.diff(shown)) + 1]
    assert min(b - a for a, b in pairwise(starts)) >= HOLD_SECONDS - 1 / 240
    assert animation["PBM"].max() == 0.85
    assert animation.weights[0].max() == animation.weights[-1].max() == 0


def test_methods_are_compared_on_one_line():
    found = compare(performer(), line(), fps=30)
    assert list(found) == ["performed", *BASELINES]
    assert found["performed"].passed
    assert all(not found[name].passed for name in BASELINES)
    assert found["held"]["still"].value > found["performed"]["still"].value


# How it is told


QUALITY = Quality(
    "a line",
    (
        Figure("speed", 20.0, "per second", 15.0, {"jaw": 20.0}, (Finding(0.5, "jaw < moves"),)),
        Figure("changes", 4.0, "per second"),
        Figure("rules", None, "of sounds", why="the pose set has no rules"),
        Figure("jitter", 15.01, "per second", 15.0),
    ),
    ("a remark",),
)


def test_text_tells_what_is_past_its_limit_and_where():
    assert str(QUALITY).splitlines() == [
        "a line",
        "  a remark",
        "  FAIL  speed    20 per second, at most 15 (jaw 20)",
        "          0.500 s: jaw < moves",
        "  -     changes  4 per second",
        "  -     rules    not judged: the pose set has no rules",
        "  ok    jitter   15 per second, at most 15",
        "1 of 2 limits met, 1 not judged",
    ]
    beside = as_text({"performed": QUALITY, "held": replace(QUALITY, figures=())})
    assert "speed    20 FAIL    -" in beside
    assert QUALITY["jitter"].passed
    with pytest.raises(LipsyncError, match="unknown figure 'jiter'; did you mean 'jitter'"):
        QUALITY["jiter"]


def test_json_tells_the_same():
    data = json.loads(as_json({"performed": QUALITY}))["performed"]
    assert data["passed"] is False
    assert data["figures"][0]["findings"] == [{"at": 0.5, "what": "jaw < moves"}]
    assert [row["passed"] for row in data["figures"]] == [False, True, True, True]
    json.loads(as_json({"performed": check(performed())}))


def test_junit_has_a_case_for_each_figure():
    root = ET.fromstring(as_junit({"performed": QUALITY}))  # noqa: S314 our own
    suite = root.find("testsuite")
    assert dict(suite.attrib) == {
        "name": "performed", "tests": "4", "failures": "1", "skipped": "2",
    }  # fmt: skip
    (failure,) = suite.iter("failure")
    assert failure.text == "0.500 s: jaw < moves"


# The command


PAIR = ("-l", "english", "-c", "facefx")


@pytest.fixture
def schedule(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = [
        {"label": label, "start": round(a, 4), "end": round(b, 4)}
        for label, (a, b) in zip(line().labels, pairwise(line().times.tolist()), strict=True)
    ]
    (tmp_path / "line.json").write_text(json.dumps({"phonemes": rows}), "utf-8")
    return ("--schedule", "line.json")


def test_check_prints_figures_and_fails_where_a_limit_is_missed(cli, schedule):
    ended = cli("check", *PAIR, *schedule)
    assert (ended.code, ended.err) == (0, "")
    assert "ok    contacts lips" in ended.out
    bad = cli("check", *PAIR, *schedule, "--limit", "changes=1")
    assert bad.code == 1
    assert "FAIL  changes" in bad.out
    refused = cli("check", *PAIR, *schedule, "--limit", "changes")
    assert refused.code == 2
    assert "--limit changes=2" in refused.err


def test_check_tells_machines_and_writes_files(cli, schedule, tmp_path):
    ended = cli("check", *PAIR, *schedule, "--baseline", "--format", "json")
    assert ended.code == 0
    assert list(json.loads(ended.out)) == ["performed", *BASELINES]
    assert re.fullmatch(r"(\d+) of \1 limits met, \d+ not judged\n", ended.err)
    written = cli(
        "check", *PAIR, *schedule, "--set", "motion.contacts=free", "--set", "motion.softness=0",
        "--set", "motion.smooth=closing", "--set", "motion.window=0.5",
        "--limit", "jitter=0", "--limit", "still=0", "-o", "q.xml", "-o", "q.txt",
    )  # fmt: skip
    assert written.code == 1
    assert written.out == ""
    assert "missed: " in written.err
    ET.fromstring((tmp_path / "q.xml").read_text("utf-8"))  # noqa: S314 our own
    assert "FAIL  " in (tmp_path / "q.txt").read_text("utf-8")


def test_check_judges_a_file_against_the_schedule(cli, schedule):
    assert cli("run", *PAIR, *schedule, "-o", "a.csv", "-o", "b.json").code == 0
    ended = cli("check", *PAIR, *schedule, "--animation", "a.csv", "--baseline")
    assert ended.code == 0, ended.out
    assert "keyframes" in ended.out
    assert cli("check", *PAIR, "--animation", "b.json").code == 0
    untold = cli("check", *PAIR, "--animation", "a.csv")
    assert untold.code == 2
    assert "has no spoken text" in untold.err


def test_run_can_check_what_it_writes(cli, schedule, tmp_path):
    ended = cli("run", *PAIR, *schedule, "--check", "-o", "a.csv")
    assert (ended.code, ended.out) == (0, "")
    assert "ok    contacts lips" in ended.err
    assert (tmp_path / "a.csv").is_file()


def test_channels_need_a_rig(cli, schedule):
    ended = cli("check", *PAIR, *schedule, "--channels")
    assert ended.code == 2
    assert "has no rig" in ended.err


# Many lines at once


def test_lines_that_are_judged_at_once_have_the_figures_of_each_alone():
    schedules = [
        line(),
        line(0.3),
        Schedule(("_", "AA", "_"), [0, 0.5, 1.5, 2], notation="arpabet"),
        Schedule(("_",), [0, 1.5], notation="arpabet"),
        Schedule(("P", "AA", "P"), [0, 0.02, 0.03, 0.05], notation="arpabet"),
        Schedule(("K", "AA", "T", "IY", "S", "OW", "F"), np.arange(8) * 0.13, notation="arpabet"),
    ]
    for name in POSESETS:
        face = performer(name)
        made = [face.perform(one, fps) for one in schedules for fps in (24, 60)]
        made.append(replace(made[1], times=made[1].times + 5, weights=np.roll(made[1].weights, 1)))
        # parts of a line begin and end within its sounds
        made += [
            replace(made[1], times=made[1].times[a:b], weights=made[1].weights[a:b])
            for a, b in ((20, 50), (0, 40), (30, 32), (25, 45))
        ]
        # the wrong poses, so that most measures find something, and not the same in all lines
        made += [replace(one, weights=np.roll(one.weights, 1, axis=1)) for one in made]
        assert check_all(made, face) == [check(one) for one in made]


def test_no_movement_goes_on_from_line_to_line():
    rises = changed(still(), "wide", lambda t, _: 0.2 * (t == t[-1]))
    # Alone, this rises too little to be seen before it falls.
    falls = changed(still(), "wide", lambda t, _: np.select([t == t[0], t == t[1]], [0.17, 0.2]))
    for pair in ([rises, falls], [falls, rises]):
        assert [one["jitter"].value for one in check_all(pair, performer())] == [0, 0]


def test_no_line_is_judged_at_once():
    assert check_all([], performer()) == []
