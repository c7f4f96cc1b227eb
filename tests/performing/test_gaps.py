"""Gaps: a pose set drawn for one sentence says that sentence (paper, 5.3)."""

import pytest

import lipsync_lang as ll

POSESET = """\
kind: poseset
format: 1
name: claw
poses: {shut: {}, hinge: {}}
"""

BANK = """\
kind: bank
format: 1
name: common
poseset: claw
bigrams:
  bmp-aa:
    curves: {shut: [[0, 0], [0.2, 1], [0.5, 0]], hinge: [[0.3, 0], [0.7, 1], [1, 0]]}
  aa-bmp:
    curves: {hinge: [[0, 0], [0.4, 1], [0.8, 0]], shut: [[0.6, 0], [0.9, 1], [1, 0]]}
"""

MAMA = ll.Schedule(("M", "AA", "M", "AA"), [0, 0.1, 0.3, 0.4, 0.7], notation="arpabet")
MAP = ll.Schedule(("M", "AA", "T"), [0, 0.1, 0.3, 0.4], notation="arpabet")


@pytest.fixture
def claw(folder):
    home = folder / "posesets/claw"
    (home / "banks").mkdir(parents=True)
    (home / "poseset.yaml").write_text(POSESET)
    (home / "banks/common.yaml").write_text(BANK)
    return lambda **how: ll.resolve("english", "claw", cache=False, **how)


def test_a_line_whose_bigrams_are_drawn_is_performed(claw):
    animation = claw().perform(MAMA)
    assert animation.weights.max(axis=0).min() > 0.4
    assert not animation.schedule.remarks


def test_a_line_that_needs_others_names_them_alone(claw):
    with pytest.raises(ll.PackError, match=r"no curves for 1 bigram of this line: aa-d\. Draw"):
        claw().perform(MAP)
    with pytest.raises(ll.PackError, match="no curves for 439 bigrams of english"):
        claw().stream()


def test_bigrams_left_at_rest_are_named(claw):
    animation = claw(gaps="rest").perform(MAP)
    assert animation.schedule.remarks == ("1 bigram without curves at rest: aa-d",)
    claw(gaps="rest").stream()


def test_other_treatments_are_refused(claw):
    with pytest.raises(ll.LipsyncError, match="gaps"):
        claw(gaps="skip")
