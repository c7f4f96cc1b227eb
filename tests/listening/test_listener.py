"""Listener: what it promises for every sound, however the sound arrives."""

import numpy as np
import pytest

import lipsync_lang as ll

pytest.importorskip("pocketsphinx")
SPOKEN = "Please buy five maps of the moon."


def heard(listener, sound, parts=1):
    found = [listener.push(part) for part in np.array_split(sound, parts)]
    found.append(listener.finish())
    return tuple(np.concatenate(column) for column in zip(*found, strict=True))


@pytest.fixture(scope="module")
def performer():
    return ll.resolve("english", "facefx")


@pytest.fixture(scope="module")
def sound():
    from lipsync_lang.speech.sound import resampled

    return resampled(ll.speak(SPOKEN, "english").audio, 16_000).samples


def test_pushes_in_any_parts_agree(performer, sound):
    times, weights = heard(performer.listen(), sound)
    for parts in (7, 100):
        again, others = heard(performer.listen(), sound, parts)
        assert np.array_equal(times, again)
        np.testing.assert_allclose(weights, others, atol=1e-5)


def test_bounds_speed_and_constraints_hold(performer, sound):
    fps = 60
    _, weights = heard(performer.listen(fps=fps), sound)
    tables = performer.compiled.tables
    assert weights.min() >= 0
    assert weights.max() <= 1
    assert weights.max() > 0.5
    assert np.abs(np.diff(weights, axis=0)).max() <= performer.motion.speed_limit / fps + 1e-9
    for low, high, threshold in tables.caps:
        both = np.minimum(weights[:, low], weights[:, high]) > 0
        assert (weights[both][:, [low, high]].sum(axis=1) <= max(threshold, 0) + 1e-9).all()


def test_the_mouth_rests_in_silence(performer):
    _, weights = heard(performer.listen(), np.zeros(16_000, np.int16))
    assert weights.max() < 0.1


def test_a_frame_is_final_after_the_delay(performer, sound):
    listener = performer.listen(delay=0.08)
    times, _ = listener.push(sound[:8000])
    assert 0.5 - 0.08 - 1 / 60 <= times[-1] <= 0.5 - 0.08 + 1e-9
    assert listener.delay == pytest.approx(0.08)


def test_a_wrong_delay_or_form_is_told(performer):
    with pytest.raises(ll.LipsyncError, match="out of range"):
        performer.listen(delay=0.01)
    with pytest.raises(ll.LipsyncError, match="one channel"):
        performer.listen().push(np.zeros((10, 2)))
