"""Any delivery of a line, with all that a pose set has, is performed, explained and judged."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import costly, swept
from shipped import LIBRARY

import lipsync_lang as ll
from lipsync_lang.schedules.schedule import Word

LINE = ll.Schedule(
    ("_", "M", "AA", "P", "_", "F", "IY", "_", "W", "UW"),
    np.cumsum([0, 0.2, 0.1, 0.2, 0.08, 0.3, 0.1, 0.2, 1.5, 0.1, 0.3]),
    words=(Word("map", 1, 4), Word("fee", 5, 7), Word("woo", 8, 10)),
    notation="arpabet",
)
POSESETS = [one.name for one in LIBRARY.names("poseset")]
LEVELS = st.floats(0, 1) | st.just([(0, 0.2), (0.7, 1)])


@cache
def resolved(poseset):
    return ll.resolve("english", poseset)


@st.composite
def deliveries(draw, performer):
    """Styles, dials, gestures and bends that the pose set of a performer has."""

    def some(names, values):
        return draw(st.dictionaries(st.sampled_from(names), values, max_size=2)) if names else {}

    gestures = [one.name for one in performer.gesture_set.shapes]
    return {
        "styles": some(performer.compiled.style_names, LEVELS),
        "dials": some([*performer.compiled.regions], LEVELS),
        "gestures": some(gestures, st.floats(0, 2)) or None,
        "bends": some(performer.poses, st.just([(0, 0.5), (2, -0.3)])),
    }


@pytest.mark.parametrize("poseset", swept(POSESETS, quick=["arkit", "crab"]))
@costly()
@given(st.data())
def test_any_delivery_is_performed_explained_and_judged(poseset, data):
    performer = resolved(poseset)
    delivery = data.draw(deliveries(performer))
    made = performer.perform(LINE, 30, **delivery)
    (alike,) = performer.perform_many([LINE], 30, **delivery)
    assert made.poses == alike.poses
    assert np.array_equal(made.weights, alike.weights)
    frame = data.draw(st.integers(0, len(made.times) - 1))
    told = {one.pose: one.weight for one in made.explain(float(made.times[frame])).poses}
    for pose in performer.poses:
        assert told[pose] == pytest.approx(made[pose][frame], abs=1e-6)
    assert ll.check(made, performer=performer).figures
    assert np.isfinite(performer.rigged(made).weights).all()
