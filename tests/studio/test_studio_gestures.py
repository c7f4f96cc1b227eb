"""Gestures of the studio: shown, placed by hand, undone, kept and performed as in a build."""

import numpy as np
import pytest

from lipsync_lang.packs.yaml.events import load_yaml

pytest.importorskip("starlette", reason="the studio needs Starlette")

from studio_calls import Caller, unpacked

import lipsync_lang as ll
from lipsync_lang.schedules.schedule import Schedule, Word
from lipsync_lang.studio.take_data import gesture_data
from lipsync_lang.studio.workshop import Workshop

SOUNDS = [("M AA1 M AH0", "mama"), ("T IY1", "tea"), ("S OW1 D AH0", "soda"), ("K AA1 R", "car")]


def line(words=SOUNDS * 3, seconds=0.12):
    labels, spans = ["_"] * 3, []
    for sounds, text in words:
        spans.append(Word(text, len(labels), len(labels) + len(sounds.split())))
        labels += sounds.split()
    labels += ["_"] * 3
    return Schedule(labels, np.arange(len(labels) + 1) * seconds, spans, notation="arpabet")


@pytest.fixture(scope="module")
def home(tmp_path_factory):
    return tmp_path_factory.mktemp("project")


@pytest.fixture(scope="module")
def workshop(home):
    made = Workshop(home, engine="none")
    made.open("english", "arkit")
    return made


@pytest.fixture
def caller(workshop):
    while workshop.desk.undo_title:
        workshop.desk.undo()
    workshop.take_up(line(), "mama tea")
    return Caller(workshop)


def shown(caller, placed=None, **more):
    settings = {} if placed is None else {"settings": {"placed": placed}}
    found = caller.post("take", settings | more)
    assert found.status == 200, found.json
    return unpacked(found)[0]


def rows(caller, placed=None, **more):
    return shown(caller, placed, **more)["takes"][0]["gestures"]["rows"]


def key(row):
    return row["name"], row["at"]


def test_a_take_has_its_gestures_with_their_reasons(caller, workshop):
    found = shown(caller)["takes"][0]
    told = found["gestures"]
    performer = workshop.performer
    assert [kind["name"] for kind in told["kinds"]] == [
        s.name for s in performer.gesture_set.shapes
    ]
    assert found["poses"][-len(told["poses"]) :] == told["poses"]
    nod = next(row for row in told["rows"] if row["name"] == "nod")
    assert (nod["hand"], nod["why"].split(":")[0]) == (-1, "nod")
    assert nod["why"] in str(workshop.perform_shown().explain(nod["begin"] + 0.1))


def test_the_face_has_the_columns_of_the_take(caller):
    (rest,) = [unpacked(caller.get("api/face"))[0]["take"]]
    assert rest["poses"] == shown(caller)["takes"][0]["poses"]


def test_a_gesture_by_hand_is_a_step_that_is_undone_kept_and_performed(caller, workshop, home):
    before = rows(caller)
    gone = next(row for row in before if row["name"] == "nod")
    placed = [
        {"gesture": "nod", "at": gone["at"], "scale": 0},
        {"gesture": "accent", "word": 6, "after": 0.05, "scale": 0.5},
    ]
    found = shown(caller, placed, title="Delete nod")
    assert found["state"]["undo"] == "Delete nod (mama-tea)"
    now = found["takes"][0]["gestures"]["rows"]
    assert key(gone) not in map(key, now)
    (own,) = [row for row in now if row["hand"] >= 0]
    at = workshop.schedule.words[6].start + 0.05
    assert (own["hand"], own["name"], own["scale"]) == (1, "accent", 0.5)
    assert own["at"] == pytest.approx(at)
    assert "by hand at 'soda'" in own["why"]
    caller.post("undo")
    assert rows(caller) == before
    caller.post("redo")
    assert rows(caller) == now
    seen = workshop.perform_shown()
    caller.post("save")
    kept = load_yaml((home / "characters/arkit.yaml").read_text("utf-8"))["lines"]["mama-tea"]
    assert kept["placed"] == placed
    performer = ll.resolve("english", "arkit", paths=[home])
    built = performer.perform(line(), line="mama-tea", gestures="all")
    assert built.weights.tobytes() == seen.weights.tobytes()
    caller.post("undo")
    caller.post("save")


def test_gestures_at_words_follow_a_moved_word(caller, workshop):
    shown(caller, [{"gesture": "nod", "word": 1}])
    first = workshop.schedule.words[1].first
    caller.post(f"boundary/{first}", {"seconds": float(workshop.schedule.times[first]) + 0.05})
    (own,) = [row for row in rows(caller) if row["hand"] >= 0]
    assert own["at"] == pytest.approx(workshop.schedule.words[1].start)
    assert workshop.settings.placed == [{"gesture": "nod", "word": 1}]


def test_a_change_of_another_kind_leaves_the_entry_as_it_is(caller, workshop):
    shown(caller, [{"gesture": "nod", "at": 0.5}])
    caller.post("emphasis/0", {"level": 1})
    content = next(iter(workshop.desk.contents.values())).decode()
    entry = load_yaml(content)["lines"]["mama-tea"]
    assert (entry["placed"], entry["emphasis"]) == ([{"gesture": "nod", "at": 0.5}], [[0, 1]])


@pytest.mark.parametrize(
    "placed", [5, ["nod"], [{"gesture": "nodd", "at": 1}], [{"gesture": "nod", "word": 99}]]
)
def test_what_cannot_be_placed_is_refused_and_the_line_stays(caller, workshop, placed):
    assert caller.post("take", {"settings": {"placed": placed}}).status == 422
    assert workshop.settings.placed == []


def test_the_parts_of_a_line_have_the_gestures_of_the_whole(caller, workshop):
    workshop.take_up(line(SOUNDS * 100, 0.2), "long")
    whole = workshop.perform(schedule=workshop.spoken.whole, gestures="all")
    every = [(row["name"], row["at"]) for row in gesture_data(whole)["rows"]]
    parts = shown(caller)["part"]["count"]
    assert parts > 1
    found = []
    for part in range(parts):
        take = unpacked(caller.post(f"part/{part}"))[0]["takes"][0]
        found += map(key, take["gestures"]["rows"])
        assert take["poses"] == list(whole.poses)
        words = workshop.schedule.words
        assert workshop.spoken.whole.words[take["gestures"]["first"]].start == words[0].start
    assert len(found) > 100
    assert set(found) <= set(every)
    assert len(set(every) - set(found)) <= 2 * parts, "only those across a cut are left out"


def test_a_gesture_by_hand_in_a_part_counts_the_words_of_the_line(caller, workshop):
    workshop.take_up(line(SOUNDS * 100, 0.2), "long")
    caller.post("part/1")
    first = shown(caller)["takes"][0]["gestures"]["first"]
    placed = [{"gesture": "nod", "word": first + 3}, {"gesture": "nod", "word": 0}]
    (own,) = [row for row in rows(caller, placed) if row["hand"] >= 0]
    assert (own["hand"], own["at"]) == (0, pytest.approx(workshop.schedule.words[3].start))
    assert "by hand" in str(workshop.perform_shown().explain(own["begin"] + 0.1))


def test_a_face_without_gestures_has_none(caller):
    shown(caller, [{"gesture": "nod", "word": 1}])
    other = unpacked(caller.post("beside", {"character": "oculus", "face": False}))[0]
    assert other["take"]["gestures"] is None


def test_the_scales_of_a_line_and_of_the_project_hold(tmp_path):
    (tmp_path / "characters").mkdir()
    (tmp_path / "characters/ann.yaml").write_text(
        "kind: character\nformat: 1\nname: ann\nposeset: arkit\n"
        "lines: {mama-tea: {text: mama tea, gestures: {nod: 0}}}\n"
    )
    made = Workshop(tmp_path, engine="none", gestures="nod,blink:0.5")
    made.open("english", "ann")
    made.take_up(line(), "mama tea")
    told = shown(Caller(made))["takes"][0]["gestures"]
    assert [kind["name"] for kind in told["kinds"]] == ["blink"]
    assert {row["scale"] for row in told["rows"]} == {1.0}, "against the scale of its kind"
    assert made.perform_shown()["eyeBlinkLeft"].max() == pytest.approx(0.5)
