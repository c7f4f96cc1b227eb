"""The gate: what counts as a voice, whatever the parts it arrives in."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang.sound.listening.ear import ToneTrack, VoiceGate

VOWEL, NOISE = 10.0, 4.0
GLIDES, STAYS = 0.0, 0.8


def share(change, tones=GLIDES, contrast=NOISE, gate=None, frames=100):
    measures = (np.full(frames, value) for value in (change, tones, contrast))
    return (gate or VoiceGate()).push(*measures)


@pytest.mark.parametrize(("change", "expected"), [(1.0, 0.0), (6.0, 0.0), (12.0, 1.0)])
def test_a_voice_is_what_changes(change, expected):
    assert share(change)[-1] == expected


def test_notes_that_stay_are_no_voice():
    assert share(12.0, STAYS)[-1] == 0


@pytest.mark.parametrize("tones", [GLIDES, STAYS])
def test_a_vowel_is_held_for_two_seconds_and_not_for_ever(tones):
    gate = VoiceGate()
    share(12.0, contrast=VOWEL, gate=gate)
    held = share(2.0, tones, VOWEL, gate, frames=400)
    assert held[:200].min() == 1
    assert held[300:].max() == 0


def test_a_noise_after_a_voice_is_not_held():
    gate = VoiceGate()
    share(12.0, contrast=VOWEL, gate=gate)
    assert share(2.0, contrast=NOISE, gate=gate)[60:].max() == 0


@given(st.integers(0, 99), st.integers(0, 60))
def test_the_gate_does_not_depend_on_the_parts(seed, cut):
    chance = np.random.default_rng(seed)
    measures = [chance.uniform(*both, 60) for both in ((4, 14), (0, 0.5), (4, 10))]
    gate = VoiceGate()
    parts = [gate.push(*(one[part] for one in measures)) for part in np.s_[:cut, cut:]]
    np.testing.assert_allclose(np.concatenate(parts), VoiceGate().push(*measures), atol=1e-9)


def sounds():
    chance, seconds = np.random.default_rng(3), np.arange(2 * 16_000) / 16_000
    chord = sum(
        np.sin(2 * np.pi * pitch * n * seconds) for pitch in (220, 277, 330) for n in (1, 2, 3)
    )
    turns = np.cumsum(120 * (1 + 0.3 * np.sin(2 * np.pi * seconds))) / 16_000
    return 1000 * chord, 1000 * sum(np.sin(2 * np.pi * n * turns) for n in range(1, 30)), chance


def test_notes_agree_with_those_before_and_a_gliding_pitch_does_not():
    chord, glide, chance = sounds()
    hiss = chance.normal(0, 10, len(chord))
    assert np.median(ToneTrack().push(chord + hiss)) > 0.5
    assert np.median(ToneTrack().push(glide + hiss)) < 0.2
    assert abs(np.median(ToneTrack().push(hiss))) < 0.1


@pytest.mark.parametrize("size", [1, 100, 267, 5000])
def test_tones_do_not_depend_on_the_parts(size):
    sound = sounds()[0][:8000]
    track = ToneTrack()
    parts = [track.push(sound[at : at + size]) for at in range(0, len(sound), size)]
    np.testing.assert_allclose(np.concatenate(parts), ToneTrack().push(sound), atol=1e-9)
