"""Measures of motion beside captured faces: known values, conditions, and failures."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lipsync_lang import Schedule, resolve
from lipsync_lang.animations.animation import Animation
from lipsync_lang.performing.performer import PerformedLine
from lipsync_lang.reports.quality import curve_statistics as statistics
from lipsync_lang.reports.quality.baselines import BASELINES
from lipsync_lang.reports.quality.check_animation import check
from lipsync_lang.reports.quality.face_columns import face_of
from lipsync_lang.reports.quality.measured_scene import scene_of

LINES = {
    "nobody": (
        "n:73 oʊ:96 b:55 ɑː:78 d:49 i:77 n:64 oʊ:113 z:96 ð:46 ə:101 t:70 ɹ:58 ʌ:67 b:55 əl:96 "
        "aɪ:85 h:63 æ:75 v:76 s:73 iː:194 n:103 _:150 n:96 oʊ:145 b:55 ɑː:78 d:49 i:67 b:64 ʌ:127 "
        "t:45 j:64 uː:79 _:7"
    ),
    "peter": (
        "_:49 p:33 iː:99 ɾ:41 ɚ:123 p:33 aɪ:166 p:33 ɚ:126 p:33 ɪ:125 k:94 t:40 ɐ:109 p:33 ɛ:149 "
        "k:46 ʌ:67 v:121 p:33 ɪ:129 k:46 əl:84 d:135 p:33 ɛ:190 p:33 ɚ:102 z:86 _:7"
    ),
    "where": (
        "w:84 ɛɹ:120 w:81 ɜː:55 j:58 uː:55 w:78 ɛ:38 n:82 ð:46 ə:64 l:67 aɪ:142 t:45 s:73 w:78 "
        "ɛ:38 n:112 t:40 aʊ:174 t:40 ɪ:58 n:105 dʒ:35 ɔːɹ:200 dʒ:70 ə:77 _:7"
    ),
}  # fmt: skip
"""Sounds and their milliseconds, as a voice speaks the lines."""

TWO = "_:300 t:90 uː:160 _:400 s:120 uː:160 _:400 k:90 uː:170 d:80 ɪ:120 n:90 s:100 _:300"

OLD = {"softness": 0, "anticipate": 0, "smooth": "closing", "thresholds": "paper"}
"""Motion settings without rounded curves."""

MOTION = {"jerk", "high_power", "shelves", "lead_missing", "shut_vowels", "opening_lag"}
"""The measures with a limit."""


@cache
def performer(character="facefx"):
    return resolve("english", character, cache=False)


@cache
def line(name):
    parts = [part.split(":") for part in LINES.get(name, name).split()]
    times = np.concatenate(([0.0], np.cumsum([float(ms) / 1000 for _, ms in parts])))
    return Schedule(tuple(label for label, _ in parts), times, notation="ipa")


def failed(quality):
    return {figure.name for figure in quality.failed} & MOTION


def moving(curve, fps=60, label="AA", *, seconds=None, who="facefx"):
    """An animation in which only the jaw moves, over many short vowels or one long one."""
    end = (len(curve) - 1) / fps
    count = max(1, round(end / seconds)) if seconds else 1
    schedule = Schedule((label,) * count, np.linspace(0, end, count + 1), notation="arpabet")
    poses = performer(who).poses
    weights = np.zeros((len(curve), len(poses)))
    weights[:, poses.index("open" if who == "facefx" else "jawOpen")] = curve
    return Animation(
        np.arange(len(curve)) / fps,
        poses,
        weights,
        fps,
        schedule,
        PerformedLine(performer(who), {}),
    )


def wave(hertz, seconds=6, fps=60):
    return 0.5 + 0.3 * np.sin(2 * np.pi * hertz * np.arange(seconds * fps + 1) / fps)


# Statistics of one curve


@pytest.mark.parametrize(("hertz", "most", "least"), [(3, 0.001, 0), (10, 1, 0.999)])
def test_power_is_above_8_hz_or_below(hertz, most, least):
    assert least <= statistics.high_share(wave(hertz, fps=30), 30) <= most


def test_a_curve_that_stands_still_has_no_power():
    assert statistics.high_share(np.full(60, 0.4), 30) == pytest.approx(0, abs=1e-6)


def test_a_sine_turns_twice_in_a_period_and_a_tremble_below_the_threshold_never():
    assert statistics.turns(wave(3)) == pytest.approx(36, abs=1)
    assert statistics.turns(0.5 + 0.005 * np.sin(np.arange(100))) == 0


def test_derivatives_are_those_of_the_curve():
    times = np.arange(50) / 30
    assert statistics.derivative(times**3, 30, 3) == pytest.approx(np.full(47, 6), rel=1e-6)


def test_a_shelf_is_still_and_a_peak_is_not():
    shelf = np.concatenate((np.linspace(0, 1, 11), np.ones(8), np.linspace(1, 0, 11)))
    opened, still = statistics.open_frames(shelf)
    assert opened.sum() == 26
    assert still.sum() == 8
    assert (
        statistics.open_frames(np.concatenate((np.linspace(0, 1, 11), np.zeros(3))))[1].sum() == 0
    )


def test_a_rise_begins_where_the_last_valley_ends():
    curve = np.array([0.5, 0.0, 0.05, 0.3, 0.6, 1.0, 0.2])
    assert statistics.rise(curve, 5, 7, 0.1) == 3
    assert statistics.rise(curve[3:], 1, 4, 0.1) == 0
    assert statistics.rise(np.zeros(4), 1, 3, 0.1) is None


# Roles come from the pack


def test_roles_are_read_off_the_pose_set():
    scene = scene_of([performer().perform(line("nobody"))], performer())
    roles, poses = scene.face.roles, performer().poses
    names = performer().compiled.phonemes
    assert [pose for pose, opens in zip(poses, roles.opening, strict=True) if opens] == ["open"]
    assert {poses[n] for n in np.flatnonzero(roles.ahead)} == {"W", "ShCh"}
    opens = {name for name, wide in zip(names, roles.opens, strict=True) if wide}
    assert {"aa", "eh", "ih", "ow"} <= opens
    assert not opens & {"_", "s", "w", "f", "bmp", "d"}
    rounding = poses.index("W")
    blocked = {name for name, is_ in zip(names, roles.blocks[:, rounding], strict=True) if is_}
    assert {"ih", "bmp", "w", "s"} <= blocked
    assert not blocked & {"_", "d", "kg", "h"}


def test_a_pose_set_that_states_no_opening_is_not_judged():
    mute = replace(performer().compiled, intensity=None)
    quality = check(
        performer().perform(line("nobody")), performer=replace(performer(), compiled=mute)
    )
    assert quality["jerk"].value is None
    assert "`intensity`" in quality["shut_vowels"].why


# Known motion


def test_a_smooth_jaw_passes_and_a_square_one_fails():
    smooth = check(moving(wave(3), seconds=0.15))
    assert not failed(smooth)
    assert smooth["turns"].value == pytest.approx(6, abs=0.2)
    square = check(moving(np.where(wave(3) > 0.5, 0.8, 0.2), seconds=0.15))
    assert failed(square) == {"jerk", "high_power", "shelves"}


@pytest.mark.parametrize("fps", [30, 60, 120])
def test_figures_are_those_of_the_captures_rate(fps):
    quality = check(moving(wave(2.5, fps=fps), fps, seconds=0.2))
    peak = 0.8
    jerk = 0.3 / peak * (2 * np.pi * 2.5) ** 3
    assert quality["jerk"].value == pytest.approx(jerk, rel=0.08)
    assert quality["turns"].value == pytest.approx(5, abs=0.3)


def test_a_long_vowel_may_hold_its_shape_and_a_short_one_may_not():
    shelf = np.minimum(1, np.maximum(0, 3 - np.abs(np.arange(361) / 60 - 3)))
    assert check(moving(shelf))["shelves"].value == 0
    short = check(moving(shelf, seconds=0.2))["shelves"]
    assert not short.passed
    assert "stands still in AA" in short.findings[0].what
    sounds = [int(one.at / 0.2) for one in short.findings]
    assert len(sounds) == len(set(sounds)) > 1


def test_rounding_that_starts_with_its_sound_is_late():
    animation = performer().perform(line(TWO))
    assert check(animation)["lead_missing"].value < 0.03
    weights = animation.weights.copy()
    lips = performer().poses.index("W")
    weights[:, lips] = np.interp(animation.times - 0.1, animation.times, weights[:, lips])
    figure = check(replace(animation, weights=weights))["lead_missing"]
    assert not figure.passed
    assert figure.parts["sounds"] >= 3
    assert "begins 0.0" in figure.findings[0].what


def test_vowels_beside_labials_that_stay_shut_are_found():
    animation = performer().perform(line("peter"))
    assert check(animation)["shut_vowels"].passed
    times = line("peter").times
    inside = (animation.times > times[5]) & (animation.times < times[7])
    weights = animation.weights.copy()
    weights[inside, performer().poses.index("open")] = 0
    figure = check(replace(animation, weights=weights))["shut_vowels"]
    assert figure.parts["never"] == 1
    assert any(one.what.startswith("aɪ keeps the mouth closed for 0.1") for one in figure.findings)


def test_a_jaw_that_opens_late_after_labials_lags():
    animation = performer().perform(line("peter"))
    there = check(animation)["opening_lag"]
    assert there.passed
    late = animation.weights.copy()
    jaw = performer().poses.index("open")
    late[:, jaw] = np.interp(animation.times - 0.05, animation.times, late[:, jaw])
    here = check(replace(animation, weights=late))["opening_lag"]
    assert not here.passed
    assert "opens the mouth 0.0" in here.findings[0].what
    # The crossing of the level, read backwards from the widest frame of each sound.
    aperture = np.maximum(0, late @ face_of(animation, performer()).seen.gains[0])
    level, times = 0.1 * statistics.peak(aperture), animation.times
    for one in here.findings:
        sound = animation.schedule.times.round(4).tolist().index(one.at)
        within = (times >= one.at - 1e-3) & (times < animation.schedule.times[sound + 1])
        top = np.flatnonzero(within)[aperture[within].argmax()]
        low = np.flatnonzero(aperture[:top] <= level)[-1]
        crossed = np.interp(level, aperture[low : low + 2], times[low : low + 2])
        assert f" {crossed - animation.schedule.times[sound]:.3f} s late" in one.what
    open_before = np.maximum(late, 0.9 * (np.arange(len(performer().poses)) == jaw))
    assert check(replace(animation, weights=open_before))["opening_lag"].value == 0


# The motion of today passes, that of yesterday does not


@pytest.mark.parametrize("character", ["facefx", "arkit"])
@pytest.mark.parametrize("name", LINES)
def test_default_motion_passes(character, name):
    assert not failed(check(performer(character).perform(line(name))))


@pytest.mark.parametrize("character", ["facefx", "arkit"])
@pytest.mark.parametrize("name", LINES)
def test_older_motion_fails(character, name):
    one = performer(character).with_motion(OLD)
    assert failed(check(one.perform(line(name))))


@pytest.mark.parametrize("name", ["nobody", "peter"])
def test_the_motion_of_the_paper_fails_beside_labials(name):
    assert failed(check(performer().with_motion("paper").perform(line(name))))


def test_plain_methods_fail():
    for make in BASELINES.values():
        assert check(make(performer(), line("nobody")), performer=performer()).failed


def test_visemes_have_limits_of_their_own():
    for name in LINES:
        assert not failed(check(performer("oculus").perform(line(name))))


# Who cannot be judged


def test_a_short_line_gives_no_statistics():
    short = check(moving(wave(3, seconds=1), seconds=0.15))
    for name in ("jerk", "high_power", "shelves", "turns"):
        assert short[name].value is None
        assert "1.0 s of speech are too short; statistics need 2 s" in short[name].why
    assert short["lead_missing"].why == "fewer than 3 sounds allow the anticipation of a pose"
    assert short["opening_lag"].why == "fewer than 3 sounds after a contact open the mouth"


def test_a_silent_line_is_not_judged():
    silent = check(moving(np.zeros(300), label="_"))
    for name in MOTION - {"lead_missing"}:
        assert silent[name].why == "the mouth does not open"


def test_a_coarse_rate_is_not_judged():
    coarse = check(moving(wave(3, fps=24), 24, seconds=0.15))
    assert "fewer than the 30 frames per second of captures" in coarse["jerk"].why


def test_poses_shown_one_at_a_time_are_not_judged():
    quality = check(performer("rhubarb").perform(line("nobody")))
    assert all(quality[name].value is None for name in MOTION)
    assert quality["jerk"].why == "poses are shown one at a time"


# Cost: counted, never timed


@given(arrays(float, st.integers(1, 60), elements=st.floats(-2, 2)), st.sampled_from([50, 95, 99]))
def test_percentiles_are_those_of_numpy_to_the_last_bit(values, per_cent):
    assert statistics.percentile(values, per_cent) == float(np.percentile(values, per_cent))


def test_columns_are_derived_once_for_all_lines_of_a_performer():
    first = scene_of([performer().perform(line("nobody"))], performer())
    second = scene_of([performer().perform(line("peter"), fps=24)], performer())
    assert first.face is second.face
    other = resolve("english", "facefx", cache=False)
    assert scene_of([other.perform(line("nobody"))], other).face is not first.face


def test_a_line_is_performed_for_no_figure(monkeypatch):
    animation = performer().perform(line("nobody"))
    expected = check(animation)
    monkeypatch.setattr(type(performer()), "performance", None)
    assert check(animation) == expected
