"""Loudness shapes the mouth: louder sounds open it wider, and every promise is kept."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import RATES, undisturbed

import lipsync_lang as ll
from lipsync_lang import Schedule
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.checking.validate import validate
from lipsync_lang.packs.library import Library
from lipsync_lang.performing import effort
from lipsync_lang.performing.effort import FULL_SCALE, levels
from lipsync_lang.pipeline.prepare import GIVEN
from lipsync_lang.schedules.schedule import SILENCE, Audio

RATE = 8000
LABELS = ("P", "AA", "T", "IY", "M", "UW", "F", "AA", "L", SILENCE)


USUAL = -24.0
"""Level of a hum of amplitude 3000 in dBFS."""


def line(gains, seconds=0.12, *, labels=LABELS):
    """A line with a hum of a given amplitude in each phoneme."""
    times = np.arange(len(labels) + 1) * seconds
    at = np.minimum((np.arange(int(times[-1] * RATE)) / RATE / seconds).astype(int), len(gains) - 1)
    wave = np.sin(np.arange(len(at)) * 0.3) * np.array(gains, float)[at]
    return Schedule(labels, times, notation="arpabet", audio=Audio(wave.astype(np.int16), RATE))


@pytest.mark.parametrize("kernel", [effort.kernel.compiled, None])
@given(data=st.data())
def test_energies_are_exact_sums_in_blocks(kernel, data):
    count = data.draw(st.integers(0, 300))
    sound = np.random.default_rng(count).integers(-(2**15), 2**15, count).astype(np.int16)
    cuts = np.sort(np.array(data.draw(st.lists(st.integers(0, count))), np.intp))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(effort, "BLOCK_SAMPLES", data.draw(st.integers(1, 100)))
        patch.setattr(effort.kernel, "compiled", kernel)
        found = effort.energies(sound, cuts)
    assert found.tolist() == [sum(int(x) ** 2 for x in sound[:at]) for at in cuts]


def spoken(schedule):
    """True for the labels of a line that are no silence."""
    return np.array(schedule.labels) != SILENCE


EVEN = line([3000] * 9 + [0])
VARIED = line([1500, 350, 1500, 1500, 1500, 1500, 1500, 6000, 6000, 0])


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "facefx")


def level(performer, schedule, **how):
    (dial,) = performer.performance(schedule, 60, **how).dials
    return dial.level


def test_no_intensity_changes_nothing_and_needs_no_sound(performer):
    silent = Schedule(EVEN.labels, EVEN.times, notation="arpabet")
    plain = performer.perform(silent).weights
    assert np.array_equal(performer.perform(silent, intensity=0).weights, plain)


def test_an_even_voice_moves_the_mouth_as_usual(performer):
    assert level(performer, EVEN, intensity=1).values == pytest.approx(1, abs=0.03)


def test_a_louder_vowel_opens_the_jaw_wider_and_a_softer_one_less():
    performer = ll.resolve("english", "crab")
    wide = performer.poses.index("mouthOpen")
    usual = performer.perform(VARIED, intensity=0).weights[:, wide]
    shaped = performer.perform(VARIED, intensity=1)
    times, change = shaped.times, shaped.weights[:, wide] - usual
    soft = (times > 0.12) & (times < 0.24)
    loud = (times > 0.84) & (times < 0.96)
    assert change[soft].mean() < -0.02
    assert change[loud].mean() > 0.02


def hum(loudness):
    """A line of an even voice at a level in dBFS."""
    return line(np.array([*[2**0.5 * FULL_SCALE * 10 ** (loudness / 20)] * 9, 0]))


@pytest.mark.parametrize(
    ("loudness", "value"),
    [(-60, 0.6), (-35, 1 - 0.4 * 3 / 4.5), (-31, 1), (-21, 1), (-17, 1 + 0.4 * 3 / 4.5), (-6, 1.4)],
)
def test_a_line_far_from_ordinary_speech_is_small_or_wide_throughout(performer, loudness, value):
    assert level(performer, hum(loudness)).values == pytest.approx(value, abs=0.03)


def test_the_jaw_follows_the_energy_within_a_sound(performer):
    """A vowel that dies away: its first half opens the jaw wider than its second."""
    labels, seconds = ("M", "AA", "M", SILENCE), 0.3
    schedule = line([1000, 6000, 1000, 0], seconds, labels=labels)
    times = np.arange(len(schedule.audio.samples)) / RATE
    fade = np.interp(times, [0.3, 0.5, 0.6, 0.7], [1, 0.05, 0.05, 1])
    samples = (schedule.audio.samples * fade).astype(np.int16)
    found = level(performer, replace(schedule, audio=replace(schedule.audio, samples=samples)))
    assert found.at(np.array([0.36]))[0] > found.at(np.array([0.54]))[0] + 0.1


def test_a_shouted_line_looks_shouted_and_a_whispered_one_small():
    for poseset in ("facefx", "arkit"):
        performer = ll.resolve("english", poseset)
        jaw = performer.compiled.regions["jaw"]
        whisper, usual, shout = (
            performer.perform(hum(loudness)).weights[:, jaw].max() for loudness in (-50, -26, -6)
        )
        assert whisper < 0.75 * usual
        assert shout > 1.25 * usual


def test_a_project_states_another_reference(performer):
    quiet = performer.with_motion({"reference_level": -50.0})
    assert level(quiet, hum(-50)).values == pytest.approx(1, abs=0.03)


def test_a_voice_that_states_its_own_level_is_held_against_that(performer):
    loud = hum(-8)
    voice = replace(loud, audio=replace(loud.audio, usual_level=-8.0))
    assert level(performer, voice).values == pytest.approx(1, abs=0.03)


def test_loudness_counts_where_there_is_sound_unless_it_is_turned_off(performer):
    silent = Schedule(VARIED.labels, VARIED.times, notation="arpabet")
    plain = performer.perform(silent).weights
    shaped = performer.perform(VARIED).weights
    assert not np.array_equal(shaped, plain)
    assert np.array_equal(shaped, performer.perform(VARIED, intensity=1).weights)
    off = performer.with_motion({"loudness": 0})
    assert np.array_equal(off.perform(VARIED).weights, plain)
    assert np.array_equal(performer.perform(VARIED, intensity=0).weights, plain)
    paper = performer.with_motion("paper")
    assert np.array_equal(paper.perform(VARIED).weights, paper.perform(silent).weights)


def test_a_pose_set_that_says_nothing_of_it_ignores_the_sound():
    mouths = ll.resolve("english", "three-mouths")
    silent = Schedule(VARIED.labels, VARIED.times, notation="arpabet")
    assert np.array_equal(mouths.perform(VARIED).weights, mouths.perform(silent).weights)


@pytest.mark.parametrize("poseset", ["facefx", "arkit"])
def test_a_dial_of_two_visibly_opens_the_jaw(poseset):
    performer = ll.resolve("english", poseset)
    jaw = performer.compiled.regions["jaw"]
    usual, twice = (
        performer.perform(EVEN, dials={"jaw": dial}).weights[:, jaw].max() for dial in (1, 2)
    )
    assert twice > 1.35 * usual


def test_vowels_louder_than_stops_change_nothing():
    """Vowels are ten times as loud as stops in any voice, which is not stress."""
    schedule = line([300, 3000] * 5, labels=("P", "AA") * 5)
    found = levels(schedule, np.ones(10, bool), 1.0, (0.5, 1.5), USUAL)
    assert found.values == pytest.approx(1, abs=0.03)


def test_a_shouted_end_of_a_calm_line_looks_shouted():
    schedule = line([3000] * 20 + [28000] * 20, labels=("P", "AA") * 20)
    found = levels(schedule, np.ones(40, bool), 1.0, (0.6, 1.4), USUAL)
    calm, shouted = found.at(np.array([0.6, 4.2]))
    assert calm == pytest.approx(1, abs=0.03)
    assert shouted == pytest.approx(1.4, abs=0.01)


def test_intensity_is_in_proportion_and_stays_within_its_limits(performer):
    voice = line([10, 10, 10, 300, 3000, 300, 3000, 30000, 30000, 0], seconds=0.5)
    half, full, twice = (level(performer, voice, intensity=x).values - 1 for x in (0.5, 1, 2))
    assert half * 2 == pytest.approx(full)
    assert full * 2 == pytest.approx(twice)
    assert full.min() >= -0.4 - 1e-9
    assert full.max() <= 0.4 + 1e-9
    assert np.ptp(full) > 0.4


@given(st.lists(st.integers(0, 30000), min_size=10, max_size=10), st.floats(0, 2))
def test_the_level_has_no_steps(gains, intensity):
    schedule = line(gains)
    found = levels(schedule, spoken(schedule), intensity, (0.6, 1.4), USUAL)
    times = np.linspace(-0.2, schedule.end + 0.2, 3000)
    steps = np.abs(np.diff(found.at(times)))
    steepest = 0.8 * 2 / 0.12  # from least to most, twice over, between two middles
    assert steps.max() <= steepest * (times[1] - times[0]) + 1e-9
    assert found.at(times).min() >= 0


def test_a_pause_takes_nothing_from_the_sounds_beside_it():
    schedule = line([12000, 0, 12000, 0, 12000], labels=("AA", SILENCE) * 2 + ("AA",))
    even = line([12000] * 5, labels=("AA",) * 5)
    found, same = (levels(one, spoken(one), 1.0, (0.6, 1.4), USUAL) for one in (schedule, even))
    assert found.values == pytest.approx(same.values[::2], abs=0.01)
    assert found.values.min() > 1.1


def test_a_soft_voice_closes_the_mouth_and_never_turns_it_round():
    schedule = line([10] * 9 + [0])
    found = levels(schedule, spoken(schedule), 2.0, (0.0, 1.0), USUAL)
    assert found.values.min() == 0


def test_it_multiplies_with_the_dials_that_are_given(performer):
    both = performer.performance(VARIED, 60, intensity=1, dials={"jaw": 0.5}).dials
    times = np.linspace(0, 1.2, 50)
    product = both[0].level.at(times) * both[1].level.at(times)
    assert np.array_equal(both[0].poses, both[1].poses)
    assert product == pytest.approx(level(performer, VARIED, intensity=1).at(times) / 2)


@given(
    st.lists(st.integers(0, 30000), min_size=10, max_size=10),
    st.floats(0.01, 2),
    st.floats(0.03, 0.3),
    RATES,
    st.sampled_from(["facefx", "arkit", "crab", "oculus"]),
)
def test_every_promise_is_kept_however_loud(gains, intensity, seconds, fps, poseset):
    performer = ll.resolve("english", poseset)
    performance = performer.performance(line(gains, seconds), fps, intensity=intensity)
    weights, tables = performance.weights(), performer.compiled.tables
    assert weights.min() >= 0
    assert weights.max() <= 1
    assert np.abs(np.diff(weights, axis=0)).max() <= performer.motion.speed_limit / fps + 1e-9
    for low, high in np.argwhere(tables.priority[:, None] < tables.priority):
        over = weights[:, low] + weights[:, high] > tables.thresholds[low, high] + 1e-9
        assert (weights[over, low] <= 1e-9).all()
    for pose, other in tables.at_most:
        assert (weights[:, pose] <= weights[:, other] + 1e-9).all()
    for contact, frames in undisturbed(performance):
        up = (weights >= 0.9 * contact.floor - 1e-9).all(axis=1)
        down = (weights <= contact.ceiling + GIVEN + 1e-9).all(axis=1)
        starts = np.flatnonzero(np.diff(frames, prepend=False, append=False))
        for start, stop in starts.reshape(-1, 2):
            assert (up & down)[start:stop].any()


def test_what_explains_a_frame_counts_loudness_too(performer):
    animation = performer.perform(VARIED, intensity=2)
    assert "loudness x 0." in str(animation.explain(0.2))


@pytest.mark.parametrize("number", [-0.1, 2.1, float("nan")])
def test_a_number_out_of_range_is_told(performer, number):
    with pytest.raises(LipsyncError, match=r"intensity .*: give a number from 0 to 2"):
        performer.perform(EVEN, intensity=number)


def test_a_line_without_sound_is_told(performer):
    silent = Schedule(EVEN.labels, EVEN.times, notation="arpabet")
    with pytest.raises(LipsyncError, match="schedule has no recording, whose loudness"):
        performer.perform(silent, intensity=1)


def test_a_pose_set_that_says_nothing_of_it_is_told_what_to_add():
    mouths = ll.resolve("english", "three-mouths")
    with pytest.raises(LipsyncError, match=r"add `intensity: \{regions: \[mouth\]\}` to the pose"):
        mouths.perform(EVEN, intensity=1)


def test_a_region_that_is_none_is_a_fault(tmp_path):
    folder = tmp_path / "posesets/mini"
    folder.mkdir(parents=True)
    file = folder / "poseset.yaml"
    file.write_text(
        "kind: poseset\nformat: 1\nname: mini\nposes: {open: {region: jaw}}\n"
        "intensity: {regions: [jaws]}\n", "utf-8",
    )  # fmt: skip
    found = validate(Library([tmp_path], project=None), [file])
    told = [(f.code, f.line, f.hint) for f in found if f.code == "P230"]
    assert told == [("P230", 5, "did you mean 'jaw'?")]


def test_the_command_line_asks_for_it(cli, tmp_path):
    schedule = tmp_path / "line.json"
    schedule.write_text('{"phonemes": [{"label": "AA", "start": 0, "end": 0.3}]}', "utf-8")
    ended = cli("run", "--schedule", schedule, "-l", "english", "-c", "facefx", "--intensity", "1")
    assert ended.code == 2
    assert "has no recording, whose loudness" in ended.err


def test_one_sound_with_other_times_or_settings_has_other_levels(performer):
    def fresh(schedule):
        return replace(schedule, audio=replace(schedule.audio))

    moved = replace(VARIED, times=VARIED.times * 0.9)
    for schedule, how in ((VARIED, {}), (moved, {}), (moved, {"intensity": 0.5}), (VARIED, {})):
        again = performer.perform(schedule, **how)
        assert np.array_equal(again.weights, performer.perform(fresh(schedule), **how).weights)
    assert not np.array_equal(level(performer, VARIED).values, level(performer, moved).values)
