"""Resampling of sound in parts: tones, lengths, and any parts."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang.sound.listening.listener import Resampler

RATES = (8_000, 11_025, 16_000, 22_050, 24_000, 32_000, 44_100, 48_000, 96_000, 192_000)


def tone(rate, hertz, seconds=0.5):
    return np.sin(2 * np.pi * hertz * np.arange(round(rate * seconds)) / rate)


def resampled(sound, rate, cuts=()):
    made = Resampler(rate)
    parts = np.split(sound, sorted(min(one, len(sound)) for one in cuts))
    return np.concatenate([*(made.push(part) for part in parts), made.finish()])


@pytest.mark.parametrize("rate", RATES)
def test_tones_keep_their_pitch_place_and_level(rate):
    for hertz in (100, 1000, 3300):
        made, wanted = resampled(tone(rate, hertz), rate), tone(16_000, hertz)
        assert len(made) == len(wanted)
        assert np.abs(made - wanted)[200:-200].max() < 0.02


@pytest.mark.parametrize("rate", [44_100, 48_000])
def test_tones_that_speech_does_not_have_vanish(rate):
    assert np.abs(resampled(tone(rate, 10_000), rate))[200:-200].max() < 0.02


@given(st.sampled_from(RATES), st.lists(st.integers(0, 5000), max_size=12))
def test_parts_do_not_matter(rate, cuts):
    sound = np.random.default_rng(0).normal(0, 1, 5000)
    assert np.array_equal(resampled(sound, rate, cuts), resampled(sound, rate))


@pytest.mark.parametrize("rate", RATES)
def test_little_is_awaited_and_little_is_kept(rate):
    made = Resampler(rate)
    heard = given_ = 0
    for _ in range(50):
        heard += rate // 100
        given_ += len(made.push(np.zeros(rate // 100)))
        assert heard / rate - given_ / 16_000 < 0.002
        assert len(made._sound) / rate < 0.004  # noqa: SLF001
