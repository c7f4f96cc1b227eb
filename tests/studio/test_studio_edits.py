"""Edits in the studio: undo, saving, merging, and restoring after a crash."""

import json

import pytest

pytest.importorskip("starlette", reason="the studio needs Starlette")

from studio_calls import Caller, unpacked

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.studio.desk import Desk
from lipsync_lang.studio.workshop import Workshop

TIMES = b"""{"notation": "arpabet", "phonemes": [{"label": "AA", "start": 0, "end": 0.2},
    {"label": "M", "start": 0.2, "end": 0.3}, {"label": "AA", "start": 0.3, "end": 0.5}]}"""
BANK = "posesets/crab/banks/common.yaml"
CURVES = {"mouthOpen": [[0, 0.9], [0.4, 0.3], [1, 0]]}


def opened(folder, journal=None):
    workshop = Workshop(folder, desk=Desk(journal), engine="none")
    workshop.open("english", "crab")
    return Caller(workshop)


@pytest.fixture
def caller(tmp_path):
    return opened(tmp_path)


def edit(caller, value, title="Draw", at=("bigrams", "aa-bmp"), file="bank", **more):
    one = {"file": file, "at": list(at)} | ({} if value is None else {"value": value})
    return caller.post("edit", {"title": title, "edits": [one], **more})


def openings(caller):
    """Return the numbers of the line's take as sent."""
    return caller.post("take").content


def test_an_edit_is_seen_in_the_line_and_taken_back(caller, tmp_path):
    caller.post("timings", TIMES, {"name": "line.json"})
    before = openings(caller)
    state = edit(caller, {"curves": CURVES}).json
    assert (state["undo"], len(state["unsaved"])) == ("Draw", 1)
    edited = openings(caller)
    assert edited != before
    assert list(tmp_path.iterdir()) == []
    state = caller.post("undo").json
    assert (state["undo"], state["redo"], state["unsaved"]) == (None, "Draw", [])
    assert len(openings(caller)) == len(before)
    caller.post("redo")
    compared, _ = unpacked(caller.post("take", {"against": "saved"}))
    assert [take["name"] for take in compared["takes"]] == ["", "saved"]


def test_saving_writes_the_bank_that_the_command_line_performs(caller, tmp_path):
    edit(caller, {"status": "approved", "curves": CURVES})
    told = caller.post("save").json
    assert told["saved"] == [BANK]
    assert told["state"]["unsaved"] == []
    performer = resolve("english", "crab", paths=[tmp_path], cache=False)
    row = performer.compiled.tables.pairs[
        performer.compiled.phonemes.index("aa"), performer.compiled.phonemes.index("bmp")
    ]
    assert performer.compiled.origins[row].status == "approved"
    assert performer.compiled.tables.curves[row, 0, 0] == pytest.approx(0.9)


def test_untouched_lines_stay_as_they_are(caller, tmp_path):
    file = tmp_path / BANK
    file.parent.mkdir(parents=True)
    file.write_text(
        "# mine\nkind: bank\nformat: 1\nname: common\nposeset: crab   # the crab\nbigrams:\n"
        "  aa-bmp:   # as in bomb\n    status: edited\n    curves:\n"
        "      mouthOpen: [[0, 0.75], [1, 0]]   # wide\n      smile:     [[0, 0], [1, 0.1]]\n"
        "  l-ow:\n    curves: {mouthOpen: [[0, 0.1], [1, 0.6]]}\n",
        "utf-8",
    )
    before = file.read_text("utf-8").splitlines()
    caller = opened(tmp_path)
    edit(caller, [[0, 0.5], [1, 0]], at=("bigrams", "aa-bmp", "curves", "mouthOpen"))
    caller.post("save")
    after = file.read_text("utf-8").splitlines()
    changed = [new for old, new in zip(before, after, strict=True) if old != new]
    assert changed == ["      mouthOpen: [[0, 0.5], [1, 0]]   # wide"]


def test_an_edit_that_a_pack_may_not_hold_changes_nothing(caller):
    found = edit(caller, {"curves": {"noSuchPose": [[0, 0], [1, 1]]}})
    assert found.status == 422
    assert "noSuchPose" in found.json["faults"][0]["what"]
    state = caller.api("state").json
    assert (state["unsaved"], state["undo"], state["redo"]) == ([], None, None)


@pytest.mark.parametrize(
    "edits",
    [None, [], [1], [{}], [{"file": "bank"}], [{"file": "bank", "at": [None], "value": 1}],
     [{"file": "../../etc/passwd", "at": ["a"], "value": 1}],
     [{"file": "poseset", "at": ["title"], "value": "x"}],
     [{"file": "bank", "at": ["bigrams", "x" * 10000], "value": {}}]],
)  # fmt: skip
def test_edits_of_no_form_are_told(caller, edits):
    found = caller.post("edit", {"title": "x", "edits": edits})
    assert found.status == 422
    assert found.json["error"]


def test_a_pack_of_the_project_extends_an_installed_language(caller, tmp_path):
    assert edit(caller, ["aa"], at=("words", "crab"), file="language").status == 200
    caller.post("save")
    written = (tmp_path / "languages" / "english.yaml").read_text("utf-8")
    assert "extends: english" in written
    assert resolve("english", "crab", paths=[tmp_path]).compiled.words["crab"] == ("aa",)


def test_two_tabs_on_one_bigram(caller):
    seen = caller.api("state").json["revision"]
    assert edit(caller, {"curves": CURVES}, seen=seen, tab="a").status == 200
    found = edit(caller, {"curves": {}}, seen=seen, tab="b")
    assert found.status == 409
    now = caller.api("state").json["revision"]
    assert edit(caller, {"curves": {}}, seen=now, tab="b").status == 200


def test_a_bank_that_changed_on_the_disk_is_merged_or_asked_about(caller, tmp_path):
    edit(caller, {"curves": CURVES})
    caller.post("save")
    edit(caller, {"curves": {"mouthOpen": [[0, 0.1], [1, 0]]}})
    file = tmp_path / BANK
    text = file.read_text("utf-8")
    file.write_text(text + "  l-ow:\n    curves: {mouthOpen: [[0, 0], [1, 0.5]]}\n", "utf-8")
    assert caller.post("save").status == 200
    assert "l-ow" in file.read_text("utf-8")
    edit(caller, {"curves": {"mouthOpen": [[0, 0.2], [1, 0]]}})
    file.write_text(file.read_text("utf-8").replace("0.1]", "0.7]"), "utf-8")
    found = caller.post("save")
    assert found.status == 409
    (row,) = found.json["conflict"]
    assert "aa-bmp" in row["what"]
    assert "0.2" in row["mine"]
    assert "0.7" in row["theirs"]
    assert caller.post("save", {"keep": {row["key"]: "mine"}}).status == 200
    assert "0.2]" in file.read_text("utf-8")


@pytest.mark.parametrize(
    "keep", [[], {"x": "mine"}, {'["x"]': "mine"}, {"[]": "both"}, {"1": "mine"}, {"x": ["mine"]}]
)
def test_choices_of_no_form_are_told(caller, keep):
    edit(caller, {"curves": CURVES})
    assert caller.post("save", {"keep": keep or [1]}).status == 422


def test_unsaved_edits_survive_a_kill(tmp_path):
    journal = tmp_path / "journal.jsonl"
    folder = tmp_path / "project"
    folder.mkdir()
    edit(opened(folder, journal), {"curves": CURVES})
    state = opened(folder, journal).api("state").json
    assert state["restored"] == 1
    assert state["unsaved"]
    assert list(folder.iterdir()) == []


def test_restored_edits_that_no_longer_fit_are_undone_and_told(tmp_path):
    journal, folder = tmp_path / "journal.jsonl", tmp_path / "project"
    folder.mkdir()
    edit(opened(folder, journal), {"curves": CURVES})
    text = journal.read_text("utf-8")
    journal.write_text(text.replace("mouthOpen", "noSuchPose"), "utf-8")
    workshop = Workshop(folder, desk=Desk(journal), engine="none")
    with pytest.raises(LipsyncError, match="noSuchPose"):
        workshop.open("english", "crab")
    workshop.open_restored("english", "crab")
    state = workshop.state()
    assert (state["unsaved"], state["redo"]) == ([], "Draw")
    assert "noSuchPose" in state["notes"][-1]
    with pytest.raises(LipsyncError, match="klingon"):
        Workshop(folder).open_restored("klingon", "crab")


def test_every_tour_has_steps_and_a_line(caller):
    tours = caller.api("project").json["tours"]
    assert tours
    for name in tours:
        told = caller.api(f"tour/{name}").json
        assert told["language"]
        assert told["line"]
        assert all({*step} == {"view", "at", "title", "text"} for step in told["steps"])
        caller.post("open", {"language": told["language"], "character": name})
        views = [step["view"].partition("/") for step in told["steps"]]
        pairs = [pair for view, _, pair in views if view == "bigrams"]
        assert all(caller.api(f"bigram/{pair}").status == 200 for pair in pairs)
    assert caller.api("tour/facefx").status == 422
    assert caller.api("tour/../crab").status in {404, 422}


def test_a_pack_named_like_markup_stays_text(tmp_path):
    name = "<script>alert(1)</script>"
    folder = tmp_path / "characters"
    folder.mkdir()
    (folder / "ann.yaml").write_text(
        f"kind: character\nformat: 1\nname: ann\nposeset: crab\ntitle: {json.dumps(name)}\n",
        "utf-8",
    )
    caller = Caller(Workshop(tmp_path, engine="none"))
    found = caller.post("open", {"language": "english", "character": "ann"})
    assert found.status == 200
    assert found.headers["content-type"] == "application/json"


def test_a_bank_is_edited_by_its_number_among_the_banks_of_the_pose_set(caller, tmp_path):
    edit(caller, {"curves": CURVES})
    caller.post("save")
    place = ("bigrams", "aa-bmp", "status")
    assert edit(caller, "approved", at=place, file="bank-0").json["undo"] == "Draw"
    assert "belongs to the installed packs" in edit(caller, 1, file="bank-1").json["error"]
    assert edit(caller, 1, file="bank-2").json["error"].endswith("language, bank-0, bank-1")
    caller.post("save")
    assert "status: approved" in (tmp_path / BANK).read_text("utf-8")
