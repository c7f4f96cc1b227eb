"""Lips and teeth of a person at rest, on a few points: people differ, and their heads do not."""

import numpy as np
import pytest

from lipsync_lang.plugins.heads.made_head import _set_teeth, _shut

REST = {"upper": [0], "lower": [1], "by": "shut", "overlap": 0.03}


@pytest.mark.parametrize("gap", [-0.1, 0.0, 0.1])
def test_lips_overlap_alike_whether_they_part_or_not(gap):
    points = np.array([[0.0, gap, 0], [0, 0, 0]])
    shapes = {"shut": np.array([[0.0, -0.2, 0], [0, 0.8, 0]])}
    points += _shut(points, shapes, REST)
    assert points[0, 1] - points[1, 1] == pytest.approx(-0.03)


@pytest.mark.parametrize("higher", [-0.2, 0.3])
def test_the_edges_of_both_rows_keep_their_heights_below_the_upper_lip(higher):
    # two points of the lips, a front tooth of each row, and three at the back
    points = np.array(
        [[0, 1.0, 2], [0, 1, 2], [0, higher, 1.5], [0, -higher, 1.5]] + 3 * [[0, 0, 0]]
    )
    on = {"teeth": np.arange(7) >= 2, "gums": np.zeros(7, bool)}
    shapes = {"jaw": np.zeros((7, 3))}
    shapes["jaw"][3, 1] = -1
    row = {"lower_moved_by": "jaw", "upper": 0.2, "lower": -0.05, "aside": 0.8}
    _set_teeth(points, shapes, on, {"rest": REST, "teeth": row})
    assert points[2, 1] == pytest.approx(1 - 0.2)
    assert points[3, 1] == pytest.approx(1 + 0.05)
