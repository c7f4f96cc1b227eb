"""The mouth that follows a belief: sure contacts close, and doubt leaves the mouth half open."""

import numpy as np
import pytest
from lanes import swept
from shipped import LIBRARY

import lipsync_lang as ll
from lipsync_lang.sound.listening.mouth import CLOSES, HELD_FRAMES, OPENS, Mouth, state_targets

SETS = [one.name for one in LIBRARY.names("poseset")]


def listened(poseset, *shares):
    """Return the tables, and the curves for the share of an "m" beside an "a" in each frame."""
    performer = ll.resolve("english", poseset)
    tables, labels = performer.compiled.tables, performer.labels
    values = [labels.notations["arpabet"].find(label) for label in ("M", "AA")]
    numbers = performer.compiled.numbers(shades=True)
    mouth = Mouth(tables, performer.motion, *state_targets(tables, values, numbers))
    belief = np.zeros((len(shares), 2, 3))
    belief[:, 0, 1] = shares
    belief[:, 1, 1] = 1 - np.array(shares)
    lips = next(one for one in tables.contacts if one.phonemes[numbers["bmp"]])
    return lips, mouth.push(belief)


def closed(lips, curves):
    """Return how many frames keep to the floors and ceilings of a contact."""
    return int(((curves >= lips.floor - 1e-9) & (curves <= lips.ceiling + 1e-9)).all(axis=1).sum())


@pytest.mark.parametrize("poseset", swept(SETS, quick=SETS[::3]))
def test_a_sure_contact_closes_for_some_frames_at_least(poseset):
    sure = CLOSES + 0.01
    lips, curves = listened(poseset, *[0] * 40, sure, *[0] * 40)
    assert closed(lips, curves[40:]) >= HELD_FRAMES
    assert not closed(lips, curves[30:40])


def test_an_unsure_contact_never_closes_and_a_closed_one_lasts_while_it_is_likely():
    lips, unsure = listened("facefx", *[0] * 40, *[CLOSES - 0.01] * 40)
    assert not closed(lips, unsure[30:])
    lips, lasting = listened("facefx", *[0] * 40, 1, *[OPENS + 0.01] * 40)
    assert closed(lips, lasting[60:]) == len(lasting[60:])


def test_lips_close_for_a_sound_that_is_twice_as_likely_as_all_others():
    lips, sure = listened("facefx", *[0] * 40, *[2 / 3] * 40)
    assert closed(lips, sure[60:]) == len(sure[60:])
    lips, unsure = listened("facefx", *[0] * 40, *[3 / 5] * 40)
    assert not closed(lips, unsure)


def test_a_target_counts_for_a_tenth_of_a_second():
    _, curves = listened("facefx", *[0] * 40, *[0.1] * 40)
    still = np.flatnonzero(np.abs(np.diff(curves, axis=0)).max(axis=1) > 1e-9)
    assert still[still > 30].max() - 39 == 10
