"""Location of a text in a recording with other sounds."""

import numpy as np
import pytest

from lipsync_lang.schedules import Audio, Schedule
from lipsync_lang.sound.speech.hearing.align.bending import SpokenVoice
from lipsync_lang.sound.speech.hearing.align.spectrum import HOP, mel_power
from lipsync_lang.sound.speech.hearing.align.warping import relative_costs, spans, subsequences
from lipsync_lang.sound.speech.sound import SPEECH_RATE

PHONES = 24
SECONDS = 0.08


def babble(seed):
    """Sounds of three resonances each over a buzz, which resemble speech in a spectrum."""
    random = np.random.default_rng(seed)
    time = np.arange(int(SECONDS * SPEECH_RATE)) / SPEECH_RATE
    parts = []
    for _ in range(PHONES):
        tones = random.uniform([250, 900, 2200], [800, 2100, 3600])
        loud = random.uniform(0.3, 1, 3)
        parts.append(loud @ np.sin(2 * np.pi * tones[:, None] * time) * (1 + np.sin(700 * time)))
    sound = np.concatenate(parts) + random.normal(0, 0.02, PHONES * len(time))
    return sound * 3000


def voice_of(sound):
    times = np.arange(PHONES + 1) * SECONDS
    audio = Audio(sound.astype(np.int16), SPEECH_RATE)
    return SpokenVoice.of(Schedule(tuple("a" * PHONES), times, audio=audio))


def music(seconds):
    """Chords with harmonics, and drums."""
    random = np.random.default_rng(5)
    time = np.arange(SPEECH_RATE // 2) / SPEECH_RATE
    out = []
    for beat in range(max(1, int(seconds * 2))):
        root = 220 * 2 ** (random.choice([0, 2, 4, 5, 7, 9]) / 12)
        chord = sum(
            np.sin(2 * np.pi * root * third * order * time) / order
            for third in (1, 1.26, 1.5)
            for order in range(1, 8)
        )
        drum = random.standard_normal(len(time)) * np.exp(-time * (40 if beat % 2 else 15)) * 3
        out.append(chord * np.exp(-2 * time) + drum)
    return np.concatenate(out)[: int(seconds * SPEECH_RATE)] * 2000


def noise(seconds):
    return np.random.default_rng(6).normal(0, 3000, int(seconds * SPEECH_RATE))


def another_voice(seconds):
    return np.concatenate([babble(70), babble(71), babble(72)])[: int(seconds * SPEECH_RATE)]


@pytest.mark.parametrize("other", [music, noise, another_voice])
@pytest.mark.parametrize(("before", "after"), [(5, 0), (0, 5), (5, 5)])
def test_a_text_is_found_among_other_sound(other, before, after):
    said = babble(1)
    hiss = np.random.default_rng(2).normal(0, 20, SPEECH_RATE // 4)
    parts = [other(before), hiss, said, hiss, other(after)]
    starts = np.cumsum([0, *map(len, parts)]) / SPEECH_RATE / HOP
    (power,) = mel_power(np.concatenate(parts) / 32768)
    first, last = next(spans(power, voice_of(said)))
    assert first == pytest.approx(starts[2], abs=25)
    assert last == pytest.approx(starts[3], abs=25)


def test_the_place_of_a_sequence_is_found_at_another_tempo():
    random = np.random.default_rng(1)
    said = random.normal(size=(30, 8))
    slow = np.repeat(said, [1, 2] * 15, axis=0)
    recorded = np.concatenate([random.normal(size=(50, 8)), slow, random.normal(size=(40, 8))])
    ((cost, first, last),) = subsequences([relative_costs(recorded, said)])
    assert (first, last) == (50, 50 + len(slow) - 1)
    assert cost < -0.5


def test_a_sequence_that_is_not_there_costs_more():
    random = np.random.default_rng(1)
    said, other = random.normal(size=(30, 8)), random.normal(size=(30, 8))
    recorded = np.concatenate([random.normal(size=(50, 8)), said])
    right, wrong = (subsequences([relative_costs(recorded, one)])[0][0] for one in (said, other))
    assert right < wrong - 0.5


def test_stretches_of_different_length_are_searched_together():
    random = np.random.default_rng(3)
    said = random.normal(size=(12, 8))
    short, long = random.normal(size=(5, 8)), random.normal(size=(60, 8))
    long[20:32] = said
    found = subsequences([relative_costs(short, said), relative_costs(long, said)])
    assert found[1][1:] == (20, 31)
    assert found[0][0] > found[1][0]
