"""Keyframes: the error of the lines between them, and the points that they must keep."""

from dataclasses import replace
from io import BytesIO

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from small_models import glb

import lipsync_lang as ll
from lipsync_lang.animations.animation import ExportSettings
from lipsync_lang.animations.keys import DECIMAL_ROUNDING, ERROR, curves, keyframes, needed
from lipsync_lang.animations.readers.glb import read_glb
from lipsync_lang.animations.writers.glb import write_glb

FLOAT = 1e-12
FASTEST = 20.0
"""Speed in weights per second, faster than any pose set allows."""

ERRORS = st.sampled_from([0.0, DECIMAL_ROUNDING, 1e-3, ERROR, 0.05, 0.5])
RATES = st.sampled_from([12.0, 24000 / 1001, 25.0, 30.0, 60.0, 120.0, 1000.0])


@st.composite
def tracks(draw):
    """Return times and one curve: noise, steps, ramps, runs that hold, and mixtures of them."""
    count = draw(st.integers(1, 60))
    level = st.sampled_from([0.0, 0.0, 0.1, 0.25, 0.5, 0.9, 1.0])
    value = st.one_of(level, st.floats(0, 1, width=32), st.floats(-1e3, 1e3, width=32))
    values = draw(arrays.arrays(np.float64, count, elements=value))
    if draw(st.booleans()):
        values = np.interp(np.arange(count) / 3, np.arange(count), values)
    begin = draw(st.sampled_from([0.0, -0.25, 3600.0]))
    return begin + np.arange(count) / draw(RATES), values


def between(times, values, frames):
    """Return the values of straight lines between keys at every frame."""
    return np.interp(times, times[frames], values[frames])


@given(tracks(), ERRORS)
def test_no_frame_strays_by_more_than_the_error(track, error):
    times, values = track
    frames = keyframes(times, values, error)
    strays = np.abs(between(times, values, frames) - values).max()
    assert strays <= error + FLOAT * max(1.0, np.abs(values).max())


@given(st.lists(st.floats(-1, 1), min_size=1, max_size=60), RATES, st.sampled_from([1e-3, ERROR]))
@example([6.125e-7, 0.0062499, -0.0062499], 25.0, ERROR)
def test_files_that_round_stay_within_the_error(steps, fps, error):
    """Times and weights have six decimals, and the curve is as fast as speech can be."""
    values = np.cumsum(np.array(steps) * FASTEST / fps).clip(0, 1)
    times = np.arange(len(values)) / fps
    frames = keyframes(times, values, error)
    written = np.interp(times, times[frames].round(6), values[frames].round(6))
    assert np.abs(written - values).max() <= error


@given(tracks(), ERRORS)
def test_the_first_and_last_frames_are_keys_and_frames_rise(track, error):
    times, values = track
    frames = keyframes(times, values, error)
    assert frames[0] == 0
    assert frames[-1] == len(times) - 1
    assert (np.diff(frames) > 0).all()


@given(tracks(), ERRORS)
def test_what_holds_is_held_from_its_first_frame_to_its_last(track, error):
    times, values = track
    frames = keyframes(times, values, error)
    shown = between(times, values, frames)
    held = np.flatnonzero(np.diff(values) == 0)
    np.testing.assert_array_equal(shown[held], values[held])
    np.testing.assert_array_equal(shown[held + 1], values[held + 1])
    starts = [n for n in held if n == 0 or values[n - 1] != values[n]]
    ends = [n + 1 for n in held if n + 2 == len(values) or values[n + 2] != values[n + 1]]
    assert {*starts, *ends} <= set(frames)


@given(tracks())
def test_without_error_only_straight_lines_are_thinned(track):
    times, values = track
    shown = between(times, values, keyframes(times, values, 0.0))
    np.testing.assert_allclose(shown, values, rtol=0, atol=FLOAT * max(1, np.abs(values).max()))


@given(tracks(), ERRORS)
def test_every_channel_finds_its_keys_among_those_that_all_share(track, error):
    times, values = track
    weights = np.column_stack([values, values[::-1]])
    shared = needed(times, weights, error)
    assert (np.diff(shared) > 0).all()
    for column in weights.T:
        assert set(keyframes(times, column, error)) <= set(shared)
        strays = np.abs(between(times, column, shared) - column).max()
        assert strays <= error + FLOAT * max(1.0, np.abs(values).max())


def test_a_key_of_one_channel_does_not_make_another_stray():
    times = np.arange(9) / 30
    bow = np.array([0, 0.009, 0.009, 0.0, -0.009, -0.009, 0, 0.5, 1])
    step = np.array([0, 0, 0, 0, 0, 1, 0, 0, 0.0])
    weights = np.column_stack([bow, step])
    shared = needed(times, weights, 0.01)
    assert np.abs(between(times, bow, shared) - bow).max() <= 0.01
    generator = np.random.default_rng(4)
    noise = np.cumsum(generator.normal(0, 0.01, (400, 6)), axis=0)
    times = np.arange(400) / 60
    shared = needed(times, noise, 0.02)
    for column in noise.T:
        assert np.abs(between(times, column, shared) - column).max() <= 0.02


@pytest.mark.parametrize(
    ("values", "frames"),
    [
        ([0.5], [0]),
        ([0, 1], [0, 1]),
        ([0, 0, 0, 0], [0, 3]),
        ([0, 0, 1, 1, 0, 0], [0, 1, 2, 3, 4, 5]),  # steps
        ([0, 0.25, 0.5, 0.75, 1], [0, 4]),
        ([0, 0.5, 1, 0.5, 0], [0, 2, 4]),
        ([0, 0, 0.9, 0, 0], [0, 1, 2, 3, 4]),  # a contact of one frame
        ([0, 0.002, 0.004, 0.002, 0], [0, 4]),  # nothing that is seen
    ],
)
def test_keys_stand_where_a_curve_bends(values, frames):
    found = keyframes(np.arange(len(values)) / 30, np.array(values, float), ERROR)
    assert found.tolist() == frames


def test_a_curve_says_what_it_is_of_and_when():
    times, weights = np.arange(5) / 10, np.array([[0, 0, 1, 0, 0], [0.5] * 5]).T
    up, flat = curves(("up", "flat"), times, weights)
    assert (up.name, flat.name) == ("up", "flat")
    np.testing.assert_array_equal(flat.frames, [0, 4])
    np.testing.assert_array_equal(up.times, times[up.frames])
    np.testing.assert_array_equal(up.values, weights[up.frames, 0])


@pytest.fixture(scope="module")
def animation(tmp_path_factory):
    labels = ["HH", "AH0", "L", "OW1", "_", "P", "AA1", "M", "S", "UW1"]
    schedule = ll.Schedule(tuple(labels), np.arange(len(labels) + 1) / 9, notation="arpabet")
    animation = ll.resolve("english", "facefx").perform(schedule)
    model = glb(tmp_path_factory.mktemp("model") / "face.glb", *animation.poses)
    return replace(animation, model=model)


def test_speech_needs_a_fraction_of_its_frames(animation):
    keys = sum(len(curve.frames) for curve in animation.keyframes(ERROR))
    assert keys < animation.weights.size / 3


def test_the_error_of_an_animation_comes_before_that_of_a_format(animation):
    def count(error, suits):
        kept = replace(animation, export=ExportSettings(key_error=error, key_lines=True)).keyframes(
            suits
        )
        return sum(len(curve.frames) for curve in kept)

    assert count(None, 0.1) == count(0.1, ERROR)
    assert count(0.0, 0.1) > count(ERROR, 0.1) > count(0.1, 0.0)


@pytest.mark.parametrize("error", [None, 0.0, 1e-3, ERROR, 0.05])
def test_a_model_keeps_to_the_error_of_lines_with_fewer_keys(error, animation):
    out = BytesIO()
    write_glb(replace(animation, export=ExportSettings(key_error=error, key_lines=True)), out)
    path = animation.model.with_name("written.glb")
    path.write_bytes(out.getvalue())
    there = read_glb(path, b"")
    assert there.names == animation.poses
    for name, values in zip(there.names, there.values.T, strict=True):
        shown = np.interp(animation.times, there.times, values)
        assert np.abs(shown - animation[name]).max() <= (error or 0) + 1e-6
    if error is not None:
        assert len(there.times) < len(animation.times)
    else:
        np.testing.assert_allclose(there.times, animation.times, atol=1e-6)
