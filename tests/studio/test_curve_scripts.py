"""Curves in the studio equal the performed curves."""

import json

import numpy as np
import pytest
from places import TESTS
from test_curve import LITERAL, SAME, WRITTEN
from test_line_page import STATIC, node

from lipsync_lang.pipeline.curve import polyline

SCRIPT = TESTS / "browser" / "curves.mjs"


@pytest.fixture
def drawn(tmp_path):
    """Return the values of curves by the studio's scripts."""

    def drawn(cases):
        path = tmp_path / "curves.json"
        asked = [{"points": np.array(points).tolist(), "times": times} for points, times in cases]
        path.write_text(json.dumps(asked), "utf-8")
        return node(SCRIPT, STATIC, path)

    return drawn


def test_the_studio_draws_the_golden_curves(drawn):
    assert len(WRITTEN) > 24, "a sweep over nothing passes"
    found = drawn([(case["points"], case["times"]) for case in WRITTEN])
    for case, smooth, straight in zip(WRITTEN, found["bspline"], found["linear"], strict=True):
        assert smooth == pytest.approx(case["values"], abs=SAME)
        line = polyline(np.array([case["points"]]), np.array(case["times"]))[0]
        assert straight == pytest.approx(line, abs=SAME)


def test_the_studio_draws_curves_by_hand(drawn):
    found = drawn([(points, list(values)) for points, values in LITERAL.values()])
    for (_, values), smooth in zip(LITERAL.values(), found["bspline"], strict=True):
        assert smooth == pytest.approx(list(values.values()), abs=1e-12)
