"""Belief: probabilities add up, and every way of looking ahead agrees with the whole."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from lipsync_lang.sound.listening.belief import PhoneLoop, Smoother, smoothed, thirds

GROUPS, PHONES = 3, 7
LOOP = PhoneLoop(np.arange(PHONES) % GROUPS, np.arange(PHONES) == 0)


def scores(seed, count):
    chance = np.random.default_rng(seed)
    return chance.normal(0, 8, (count, PHONES, 2 * GROUPS + 1)).astype(np.float32)


def pushed(smoother, heard, cut):
    return np.concatenate(
        [smoother.push(heard[:cut]), smoother.push(heard[cut:]), smoother.finish()]
    )


@given(st.integers(0, 99), st.integers(1, 30), st.integers(0, 30), st.integers(0, 5))
def test_belief_adds_up_whatever_the_parts(seed, count, cut, lag):
    heard = scores(seed, count)
    found = pushed(Smoother(LOOP, lag), heard, cut)
    np.testing.assert_allclose(found.sum(axis=(1, 2)), 1)
    np.testing.assert_allclose(found, pushed(Smoother(LOOP, lag), heard, 0), atol=1e-12)


@given(st.integers(0, 99), st.integers(1, 30))
def test_a_look_ahead_to_the_end_is_that_of_the_whole_sound(seed, count):
    heard = scores(seed, count)
    np.testing.assert_allclose(
        pushed(Smoother(LOOP, count), heard, 0), smoothed(LOOP, heard), atol=1e-12
    )


def test_forward_and_backward_are_one_chain():
    """The probability of a sound is the same wherever the two directions meet."""
    likely = LOOP.likelihoods(scores(3, 2))
    count, states = PHONES, 2 * GROUPS + 1
    moves = np.stack(
        [
            LOOP.forward(unit.reshape(count, states), np.ones((count, states))).ravel()
            for unit in np.eye(count * states)
        ]
    )
    np.testing.assert_allclose(moves.sum(axis=1), 1)
    back = LOOP.backward(np.ones((count, states)), likely[1]).ravel()
    true = moves @ likely[1].ravel()
    np.testing.assert_allclose(back, true / true.sum())


def test_thirds_keep_the_belief_of_each_phone():
    found = smoothed(LOOP, scores(1, 5))
    np.testing.assert_allclose(thirds(found).sum(axis=-1), found.sum(axis=-1))
    assert thirds(found).shape == (5, PHONES, 3)
