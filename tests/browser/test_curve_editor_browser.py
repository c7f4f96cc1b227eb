"""The curve editor and the matrix of bigrams in a browser: their events."""

from pathlib import Path

import pytest
from lanes import full
from test_consumers import chromium, found, run
from test_line_page import STATIC

pytestmark = [full, pytest.mark.xdist_group("curve_editor")]

HERE = Path(__file__).parent
WHOLE = [-0.02, 1.02, -0.04, 1.06]


@pytest.fixture(scope="module")
def used():
    node, modules = found("playwright-core")
    used = run(node, HERE / "curve_editor.mjs", modules, chromium(), STATIC)
    assert used["said"] == []
    return used


def steps(changes):
    """Return the names of the steps, and the changes that end one."""
    return len({change["merge"] for change in changes}), [change["done"] for change in changes]


def test_a_drag_is_one_step_and_keeps_to_hundredths(used):
    assert steps(used["dragged"]) == (1, [False, False, True])
    assert used["dragged"][-1]["curves"]["open"] == [[0, 0], [0.4, 0.55], [0.7, 0.6], [1, 0]]
    assert used["dragged"][-1]["title"] == "Move open point 2"
    assert used["snapped"]["curves"]["open"][1] == [0.45, 0.6], "with Shift, on the grid"


def test_keys_move_the_point_that_has_the_focus(used):
    assert used["focused"] == "open, point 2 of 4: time 0.45, value 0.60"
    assert steps(used["nudged"]) == (1, [True] * 4)
    moved = [change["curves"]["open"][1] for change in used["nudged"]]
    assert moved == [[0.45, 0.61], [0.46, 0.61], [0.461, 0.61], [0.461, 0.56]]
    assert used["tabbed"] == "open, point 3 of 4: time 0.70, value 0.60"


def test_points_are_added_and_deleted(used):
    added = used["added"]["curves"]["open"]
    assert [time for time, _ in added] == [0, 0.461, 0.7, 0.85, 1]
    assert 0 < added[3][1] < 0.6, "on the curve"
    assert used["deleted"]["curves"]["open"] == added[:3] + added[4:]
    assert used["clicked"]["curves"]["open"][3] == [0.85, 0.9]


def test_the_boundary_moves_by_hand_and_by_keys(used):
    assert steps(used["boundary"]) == (1, [False, False, True])
    assert used["boundary"][-1]["boundary"] == 0.62
    assert [change["boundary"] for change in used["walked"]] == [0.61, 0.6]


def test_several_points_are_chosen_and_typed(used):
    assert used["swept"] == [["open", [1, 2]], ["<b>round</b>", [1]]]
    curves = used["typed"]["curves"]
    assert [value for _, value in curves["open"]] == [0, 0.28, 0.3, 0.9, 0]
    assert [value for _, value in curves["<b>round</b>"]] == [0.2, 0.45, 0.2]
    assert used["whole"] == [["open", [0, 1, 2, 3, 4]]]


def test_curves_are_copied_deleted_and_pasted(used):
    assert list(used["copied"]) == ["open"]
    assert list(used["gone"]["change"]["curves"]) == ["<b>round</b>"]
    assert "two points, so open is removed" in used["gone"]["tells"][-1]
    assert used["pasted"]["curves"]["open"] == used["copied"]["open"]


def test_a_drag_is_given_up_and_no_answer_disturbs_it(used):
    assert used["held"] == 5
    assert used["escaped"]["end"]["curves"] == used["escaped"]["start"]
    assert used["escaped"]["end"]["done"]


def test_a_pose_is_found_added_and_seen_alone(used):
    assert used["found"] == ["pose31"]
    assert used["more"]["title"] == "Add pose31"
    assert [value for _, value in used["more"]["curves"]["pose31"]] == [0] * 5
    assert used["alone"] == ["pose31"]
    assert used["started"]["curves"] == {"open": [[0, 0], [1, 0.3]]}
    assert used["started"]["boundary"] == 0.4


def test_the_plot_is_zoomed_and_fits_a_phone(used):
    assert used["zoomed"][1] - used["zoomed"][0] < 0.6
    assert used["fitted"] == WHOLE
    assert (used["nameless"], used["markup"]) == ([], 0)
    assert used["overflow"] <= 0
    assert used["tapped"] == [["open", [1]]]


def test_a_finger_drags_a_point_and_two_zoom(used):
    assert steps(used["touched"]) == (1, [False, False, True])
    time, value = used["touched"][-1]["curves"]["open"][1]
    assert (time, value > 0.5) == (0.3, True)
    assert used["pinched"]["wide"] == pytest.approx((WHOLE[1] - WHOLE[0]) / 3, rel=0.01)
    assert (used["pinched"]["changes"], used["pinched"]["marquee"]) == (0, None)


def test_the_matrix_is_walked_and_opens_bigrams(used):
    matrix = used["matrix"]
    assert matrix["cells"] == [
        ["_-_", "none", ""], ["_-a", "drafted", "·"], ["_-m", "none", ""],
        ["a-_", "gap", "×"], ["a-a", "none", ""], ["a-m", "drafted need", "·"],
        ["m-_", "none", ""], ["m-a", "approved need", "✓"], ["m-m", "edited", "●"],
    ]  # fmt: skip
    needed = "a-m, drafted, as in am, the script needs it 2 times"
    assert matrix["told"][0] == needed
    assert [told.split(",")[0] for told in matrix["told"]] == ["a-m", "a-a", "m-a", "m-a", "m-a"]
    assert matrix["opened"] == ["m-a", "m-m", "a-m"]
    assert matrix["wanted"] == ["a-mam2×"]
    assert matrix["changed"] == ["a-m", "edited need", "●"]
    assert matrix["none"], "nothing is wanted any more"
