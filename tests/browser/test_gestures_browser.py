"""The lane of gestures in a browser: dragged, scaled, deleted, added, undone and kept."""

from pathlib import Path

import pytest
from lanes import full
from test_bigrams_browser import served
from test_consumers import chromium, found, run
from test_studio_gestures import line

import lipsync_lang as ll
from lipsync_lang.packs.yaml.events import load_yaml
from lipsync_lang.studio.workshop import Workshop

pytestmark = [full, pytest.mark.xdist_group("gestures")]

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("project")


@pytest.fixture(scope="module")
def used(home):
    node, modules = found("playwright-core")
    found("axe-core")
    workshop = Workshop(home, engine="none")
    workshop.open("english", "facefx")
    workshop.take_up(line(), "mama tea")
    with served(workshop) as address:
        return run(node, HERE / "gestures.mjs", modules, chromium(), address)


@pytest.fixture(scope="module")
def nod(used):
    return next(one for one in used["first"] if one["name"] == "nod")


def taken_away(placed, nod):
    """Return the seconds of the nod that came by rule and was taken away."""
    one = placed[0]
    assert (one["gesture"], one["scale"]) == ("nod", 0)
    assert line().words[one["word"]].start + one.get("after", 0) == pytest.approx(nod["at"])
    return placed[1:]


def test_each_gesture_is_drawn_at_its_time_with_its_reason(used, nod):
    assert (used["said"], used["asked"]) == ([], [])
    performer = ll.resolve("english", "facefx")
    said = performer.perform(line(), gestures="all").explain(nod["at"] + 0.1)
    (stage,) = next(pose for pose in said.poses if pose.pose == "nod").stages
    assert nod["told"].endswith(stage.why)
    assert {one["as"] for one in used["first"]} == {"ruled"}
    assert not any("nod" in row for row in used["rows"]), "gestures have a lane, and no rows"


def test_a_dragged_gesture_snaps_to_a_word_and_leaves_its_place(used, nod):
    assert taken_away(used["moved"]["placed"], nod) == [{"gesture": "nod", "word": used["word"]}]
    (own,) = [one for one in used["moved"]["bars"] if one["as"] == "hand"]
    assert own["chosen"]
    assert "by hand" in used["panel"]


def test_keys_move_scale_and_delete(used, nod):
    by_keys = {"gesture": "nod", "word": used["word"], "after": 0.01, "scale": 1.1}
    assert taken_away(used["keyed"], nod) == [by_keys]
    assert taken_away(used["deleted"], nod) == []
    assert used["restored"] == []


def test_a_gesture_is_added_at_a_word_undone_and_kept(used, nod, home):
    assert taken_away(used["added"]["placed"], nod) == [{"gesture": "blink", "word": 1}]
    placed = used["scaled"]
    assert taken_away(placed, nod) == [{"gesture": "blink", "word": 1, "scale": 0.5}]
    assert used["undone"] == []
    assert sorted(used["again"]) == ["blink", "nod"]
    kept = load_yaml((home / "characters/facefx.yaml").read_text("utf-8"))["lines"]
    assert kept["mama-tea"]["placed"] == placed
    built = ll.resolve("english", "facefx", paths=[home]).perform(
        line(), line="mama-tea", gestures="all"
    )
    assert not built["nod"].any()


def test_axe_finds_nothing_and_nothing_overflows(used):
    assert (used["axe"], used["overflow"]) == ([], 0)
