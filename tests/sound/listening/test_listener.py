"""Listener: what it promises for every sound, however the sound arrives."""

import numpy as np
import pytest
from lanes import full
from shipped import LIBRARY

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
    from lipsync_lang.sound.speech.sound import resampled

    return resampled(ll.speak(SPOKEN, "english").audio, 16_000).samples


def test_pushes_in_any_parts_agree(performer, sound):
    times, weights = heard(performer.listen(), sound)
    for parts in (7, 100):
        again, others = heard(performer.listen(), sound, parts)
        assert np.array_equal(times, again)
        np.testing.assert_allclose(weights, others, atol=1e-5)


def test_voices_pushed_together_are_those_pushed_alone(performer, sound):
    rates, cut = (16_000, 48_000, 16_000), len(sound) // 2
    alone = [performer.listen(rate) for rate in rates]
    many = [performer.listen(rate) for rate in rates]
    for sounds in ([sound[:cut], sound, []], [sound[cut:], [], sound / 2**15]):
        given = [np.asarray(one) for one in sounds]
        found = many[0].push_together(many, given)
        for one, own, part in zip(alone, found, given, strict=True):
            for column, expected in zip(own, one.push(part), strict=True):
                np.testing.assert_allclose(column, expected, atol=1e-5)
    assert many[0].push_together([], []) == []


def test_a_wrong_sound_among_many_changes_no_voice(performer, sound):
    voices = [performer.listen() for _ in range(2)]
    with pytest.raises(ll.LipsyncError, match="one channel"):
        voices[0].push_together(voices, [sound, np.zeros((10, 2))])
    times, _ = voices[0].push(sound)
    assert np.array_equal(times, performer.listen().push(sound)[0])


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
    for wrong in (np.zeros(10, np.uint8), np.array([0.0, np.nan])):
        with pytest.raises(ll.LipsyncError, match="floats from -1 to 1"):
            performer.listen().push(wrong)


def test_floats_and_integers_are_one_sound(performer, sound):
    _, whole = heard(performer.listen(), sound)
    _, parts = heard(performer.listen(), sound / 2**15)
    np.testing.assert_allclose(whole, parts, atol=1e-5)


def unspoken():
    chance = np.random.default_rng(1)
    seconds = np.arange(3 * 16_000) / 16_000
    return {
        "hiss": 3000 * chance.normal(size=len(seconds)),
        "a tone": 8000 * np.sin(2 * np.pi * 440 * seconds),
        "hum": 3000 * np.sign(np.sin(2 * np.pi * 50 * seconds)),
    }


@pytest.mark.parametrize("name", unspoken())
def test_the_mouth_rests_while_nobody_speaks(performer, name):
    _, weights = heard(performer.listen(), unspoken()[name].astype(np.int16))
    assert weights.max() < 0.1


@full
@pytest.mark.parametrize("one", LIBRARY.names("poseset"), ids=lambda one: one.name)
@pytest.mark.parametrize("fps", [24, 60, 120])
def test_every_pose_set_keeps_its_promises(one, fps, sound):
    performer = ll.resolve("german", one.name)
    _, weights = heard(performer.listen(fps=fps), sound)
    assert weights.min() >= 0
    assert weights.max() <= 1
    assert np.abs(np.diff(weights, axis=0)).max() <= performer.motion.speed_limit / fps + 1e-9
    for low, high, threshold in performer.compiled.tables.caps:
        both = np.minimum(weights[:, low], weights[:, high]) > 1e-9
        assert (weights[both][:, [low, high]].sum(axis=1) <= threshold + 1e-9).all()


@full
@pytest.mark.parametrize("name", [one.name for one in LIBRARY.names("language")])
def test_every_language_has_a_mouth_for_most_phones(name):
    from lipsync_lang.resolver.nearest_phonemes import model_phones
    from lipsync_lang.sound.listening.mouth import heard_values

    known = model_phones()
    values = heard_values(known, ll.resolve(name, "facefx").labels.notations["ipa"])
    assert set(values) == set(known.nearest.candidates)
    assert sum(map(bool, values.values())) >= 0.9 * len(values)


def test_belief_names_each_phone(performer, sound):
    listener = performer.listen()
    listener.push(sound)
    assert listener.belief.shape == (len(listener.phones),)
    assert listener.belief.sum() == pytest.approx(1)


def test_columns_of_a_stream_stand_still_in_a_voice(performer, sound):
    poses = (*performer.poses, "grin")
    times, weights = heard(performer.listen(poses=poses), sound)
    assert np.array_equal(weights[:, :-1], heard(performer.listen(), sound)[1])
    assert weights.shape == (len(times), len(poses))
    assert not weights[:, -1].any()
