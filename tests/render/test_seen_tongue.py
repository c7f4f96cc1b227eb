"""The tongue of the shipped head, beside rounded lips."""

import numpy as np
import pytest

import lipsync_lang as ll


@pytest.mark.parametrize(
    "labels", [("L", "UW", "D"), ("NG", "UW", "L"), ("D", "OW", "NG"), ("K", "UH", "K")]
)
def test_the_tongue_leaves_the_hole_of_rounded_lips(labels):
    animation = ll.resolve("english", "facefx").perform(
        ll.Schedule(labels, [0, 0.1, 0.3, 0.4], notation="arpabet"), fps=100
    )
    late = np.abs(animation.times - 0.2 - 0.05 * (labels[1] == "OW")).argmin()
    tongue = [animation.poses.index(name) for name in ("tBack", "tRoof")]
    assert animation.weights[late, tongue].max() < 0.2
