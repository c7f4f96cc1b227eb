"""The smooth curve of a bank: derived values, golden values, and properties of B-splines.

`bspline.json` fixes the curve for every implementation, in whatever language. Written by this
file's own de Boor, not by the code under test: ``python tests/pipeline/test_curve.py`` writes it
anew.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lanes import full

from lipsync_lang.pipeline.curve import bspline, polyline, span_basis

GOLDEN = Path(__file__).with_name("bspline.json")
SAME = 1e-9


def smooth(points, *times):
    return bspline(np.array([points], float), np.array(times, float))[0]


# An evaluation of its own: de Boor's recurrence, and bisection to find u


def de_boor(controls, u):
    """Evaluate a clamped uniform B-spline of degree min(3, n - 1) at u in [0, S]."""
    degree = min(3, len(controls) - 1)
    spans = len(controls) - degree
    knots = [min(max(i - degree, 0), spans) for i in range(len(controls) + degree + 1)]
    k = degree + min(int(u), spans - 1)
    d = [controls[k - degree + j] for j in range(degree + 1)]
    for r in range(1, degree + 1):
        for j in range(degree, r - 1, -1):
            i = k - degree + j
            a = (u - knots[i]) / (knots[i + degree + 1 - r] - knots[i])
            d[j] = (1 - a) * d[j - 1] + a * d[j]
    return d[degree]


def slow(points, x):
    """Evaluate (t(u), v(u)) where t(u) = x."""
    times, values = [p[0] for p in points], [p[1] for p in points]
    if not times[0] <= x <= times[-1]:
        return 0.0
    low, high = 0.0, float(len(points) - min(3, len(points) - 1))
    if x == times[-1]:
        low = high
    while high - low > 1e-15 * max(1.0, high):
        u = (low + high) / 2
        if u in (low, high):
            break
        low, high = (u, high) if de_boor(times, u) < x else (low, u)
    return de_boor(values, high)


def cases():
    """Control points whose t(u) rises everywhere, so that rounding does not matter."""
    rng = np.random.default_rng(2013)
    for count in range(2, 10):
        even = np.linspace(0, 1, count)
        peak = np.zeros(count)
        peak[count // 2] = 1
        yield "a lone peak", np.column_stack((even, peak))
        times = np.sort(rng.random(count).round(3))
        yield "inside", np.column_stack((times, rng.random(count).round(3)))
        times[0], times[-1] = 0, 1
        yield "uneven", np.column_stack((times, rng.random(count).round(3)))
    yield "a step up and down", np.array([[0, 0], [0.3, 0], [0.3, 1], [0.6, 1], [0.6, 0], [1, 0]])
    yield "steps at the ends", np.array([[0, 0], [0, 1], [0.5, 1], [1, 1], [1, 0]])
    yield "three at once", np.array([[0, 0], [0.4, 0], [0.4, 0.5], [0.4, 1], [1, 1]])
    yield "two", np.array([[0.25, 1], [0.75, 0.5]])


def golden():
    asked = [k / 16 for k in range(17)] + [-0.5, 0.123456789, 0.987654321, 1.5]
    found = []
    for name, points in cases():
        steps = points[1:, 0][np.diff(points[:, 0]) == 0]  # in a step rounding chooses the value
        times = [x for x in asked if x not in steps]
        values = [float(f"{slow(points.tolist(), x):.12g}") for x in times]
        found.append({"name": name, "points": points.tolist(), "times": times, "values": values})
    return found


def golden_text():
    """Text with a case on each line, for readable differences."""
    about = (
        "Clamped uniform B-spline of degree min(3, n - 1) in (t(u), v(u)): v where t(u) is the "
        "time, 0 outside the points. To be met within 1e-9."
    )
    lines = ",\n".join(json.dumps(case) for case in golden())
    return f'{{"about": {json.dumps(about)},\n"curves": [\n{lines}\n]}}\n'


WRITTEN = json.loads(GOLDEN.read_text("utf-8"))["curves"] if GOLDEN.exists() else []


@pytest.mark.parametrize("case", WRITTEN, ids=lambda case: f"{case['name']}-{len(case['points'])}")
def test_the_curve_meets_its_golden_values(case):
    assert smooth(case["points"], *case["times"]) == pytest.approx(case["values"], abs=SAME)


@full
def test_the_golden_values_are_those_of_de_boor():
    assert len(WRITTEN) > 24, "a sweep over nothing passes"
    assert {len(case["points"]) for case in WRITTEN} == set(range(2, 10))
    for written, made in zip(WRITTEN, golden(), strict=True):
        assert written["points"] == made["points"]
        assert written["times"] == made["times"]
        assert written["values"] == pytest.approx(made["values"], abs=1e-11)


@pytest.mark.parametrize("case", WRITTEN, ids=lambda case: f"{case['name']}-{len(case['points'])}")
def test_the_golden_values_are_those_of_scipy(case):
    from scipy.interpolate import BSpline
    from scipy.optimize import brentq

    points = np.array(case["points"])
    degree = min(3, len(points) - 1)
    spans = len(points) - degree
    knots = np.clip(np.arange(len(points) + degree + 1) - degree, 0, spans).astype(float)
    t, v = BSpline(knots, points[:, 0], degree), BSpline(knots, points[:, 1], degree)
    for x, value in zip(case["times"], case["values"], strict=True):
        if points[0, 0] < x < points[-1, 0]:
            u = brentq(lambda u, x=x: t(u) - x, 0, spans, xtol=1e-15, rtol=1e-15)
            assert v(u) == pytest.approx(value, abs=1e-9)


LITERAL = {
    "a line": ([[0, 0], [1, 1]], {0: 0, 0.25: 0.25, 0.5: 0.5, 1: 1}),
    # degree 2, t(u) = u: v = 2 u (1 - u)
    "a parabola": ([[0, 0], [0.5, 1], [1, 0]], {0.25: 0.375, 0.5: 0.5, 0.75: 0.375}),
    # degree 3, t(u) = u: v = 3 u (1 - u)
    "a cubic": ([[0, 0], [1 / 3, 1], [2 / 3, 1], [1, 0]], {0.25: 0.5625, 0.5: 0.75}),
    # t(u) = u squared, v = 2 u (1 - u): at 0.01 u is 0.1, at 0.25 it is 0.5
    "a step at 0": ([[0, 0], [0, 1], [1, 0]], {0: 0, 0.01: 0.18, 0.25: 0.5, 0.81: 0.18, 1: 0}),
    # t(u) = u cubed, v = 3 u (1 - u)
    "a tall step": ([[0, 0], [0, 1], [0, 1], [1, 0]], {0.001: 0.27, 0.125: 0.75, 0.729: 0.27}),
    # two spans; where they meet the middle point weighs 1/2, its neighbours 1/4
    "five": ([[0, 0], [0.25, 0], [0.5, 1], [0.75, 0], [1, 0]], {0.5: 0.5, 1: 0}),
    # four spans; in the middle the point weighs 2/3, its neighbours 1/6
    "seven": ([[k / 6, float(k == 3)] for k in range(7)], {0.5: 2 / 3}),
    "seven wide": ([[k / 6, float(k in (2, 3))] for k in range(7)], {0.5: 5 / 6}),
}


@pytest.mark.parametrize("name", LITERAL)
def test_curves_by_hand(name):
    points, values = LITERAL[name]
    assert smooth(points, *values) == pytest.approx(list(values.values()), abs=1e-12)


def test_the_weights_of_five_points_where_two_spans_meet():
    assert span_basis(5)[1, 0] == pytest.approx([0.25, 0.5, 0.25, 0])
    assert span_basis(7)[2, 0] == pytest.approx([1 / 6, 2 / 3, 1 / 6, 0])


def test_a_vertical_step_jumps_where_four_points_stand_at_one_time():
    points = [[0, 0.2], [0.5, 0.2], [0.5, 0.2], [0.5, 0.8], [0.5, 0.8], [1, 0.8]]
    before, after = smooth(points, 0.5 - 1e-9, 0.5 + 1e-9)
    assert before < 0.5 < after
    assert smooth(points, 0.25)[0] < 0.25
    assert smooth(points, 0.75)[0] > 0.75


def test_a_straight_curve_is_what_was_drawn():
    points = np.array([[[0, 0], [0.2, 1], [0.6, 0.5], [0.6, 0]]])
    at = np.array([-0.1, 0, 0.1, 0.2, 0.4, 0.599, 0.601, 1])
    wanted = [0, 0, 0.5, 1, 0.75, 0.50125, 0, 0]
    assert polyline(points, at)[0] == pytest.approx(wanted)


@st.composite
def curves(draw):
    count = draw(st.integers(2, 12))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    times = np.sort(rng.random((3, count)), axis=1)
    if draw(st.booleans()):
        times = times.round(1)  # some repeated
    if draw(st.booleans()):
        times[:, 0], times[:, -1] = 0, 1
    return np.stack((times, rng.random((3, count))), axis=-1)


AT = np.linspace(-0.1, 1.1, 241)


@given(curves())
def test_a_curve_stays_among_its_control_points_and_is_0_outside_them(points):
    for draw in (bspline, polyline):
        values = draw(points, AT)
        for line, curve in zip(points, values, strict=True):
            inside = (line[0, 0] <= AT) & (line[-1, 0] >= AT)
            assert (curve[~inside] == 0).all()
            assert (curve[inside] >= line[:, 1].min() - SAME).all()
            assert (curve[inside] <= line[:, 1].max() + SAME).all()


@given(curves())
def test_a_curve_begins_and_ends_with_its_first_and_last_point(points):
    times = points[0, :, 0]
    if times[0] < times[1] and times[-2] < times[-1]:
        first, last = bspline(points[:1], times[[0, -1]])[0]
        assert first == pytest.approx(points[0, 0, 1], abs=SAME)
        assert last == pytest.approx(points[0, -1, 1], abs=SAME)


def test_no_times_give_no_values():
    points = np.array([[[0.0, 0.2], [0.5, 0.6], [1.0, 0.1]]])
    assert bspline(points, np.zeros(0)).shape == (1, 0)


@given(curves())
def test_rising_points_make_a_rising_curve(points):
    points[..., 1].sort(axis=1)
    for line in points:
        inside = AT[(line[0, 0] <= AT) & (line[-1, 0] >= AT)]
        assert (np.diff(bspline(line[None], inside)[0]) >= -1e-7).all()


@given(curves())
def test_points_on_a_line_make_that_line(points):
    points[..., 1] = 0.1 + 0.7 * points[..., 0]
    values = bspline(points, AT)
    for line, curve in zip(points, values, strict=True):
        inside = (line[0, 0] <= AT) & (line[-1, 0] >= AT)
        assert curve[inside] == pytest.approx(0.1 + 0.7 * AT[inside], abs=1e-7)


@given(curves(), st.integers(0, 11))
def test_a_point_moves_the_curve_by_no_more_than_itself(points, at):
    moved = points.copy()
    moved[:, at % points.shape[1], 1] += 0.1
    change = bspline(moved, AT) - bspline(points, AT)
    assert change.min() >= -SAME
    assert change.max() <= 0.1 + SAME


if __name__ == "__main__":
    GOLDEN.parent.mkdir(exist_ok=True)
    GOLDEN.write_text(golden_text(), "utf-8")


@given(st.integers(2, 9), st.integers(1, 80), st.integers(0, 2**32 - 1))
def test_no_curve_depends_on_the_others_that_are_evaluated(count, curves, seed):
    rng = np.random.default_rng(seed)
    times = np.sort(rng.random((curves, count)).round(1), axis=1)
    points = np.stack((times, rng.random((curves, count))), axis=-1)
    at = np.linspace(0, 1, 33)
    together = bspline(points, at)
    some = int(rng.integers(curves))
    alone = bspline(points[some:], at)
    assert together[some:].tobytes() == alone.tobytes()
    assert together[some].tobytes() == bspline(points[[some]], at).tobytes()
