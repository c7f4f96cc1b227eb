"""The studio's bigrams: the matrix, a bigram with its layers, and the file of its edits."""

import pytest

pytest.importorskip("starlette", reason="the studio needs Starlette")

from packs_tree import TREE, plant, put
from studio_calls import TOKEN, Caller, unpacked

import lipsync_lang as ll
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.resolver.layers import PairPacks
from lipsync_lang.studio.bigram_home import bigram_home
from lipsync_lang.studio.spoken_line import SpokenLine
from lipsync_lang.studio.workshop import Workshop

LINE = ll.Schedule(
    ("P", "2", "P", "2"), [0, 0.1, 0.2, 0.3, 0.4],
    words=(ll.Word("ma", 0, 2), ll.Word("pa", 2, 4)), notation="first",
)  # fmt: skip


@pytest.fixture
def workshop(tmp_path):
    made = Workshop(plant(tmp_path), engine="none")
    made.open("parent", "anna")
    return made


@pytest.fixture
def told(workshop):
    """Ask for a path of the server."""

    def told(path, status=200, **query):
        found = Caller(workshop).ask("GET", f"/{TOKEN}/api/{path}", query=query)
        assert found.status == status, found.content
        return found.json

    return told


def test_the_matrix_tells_the_status_of_every_pair(told):
    matrix = told("matrix")
    assert matrix["phonemes"] == ["_", "p", "f", "a", "yu"]
    assert len(matrix["pairs"]) == 24, "all but silence with itself"
    assert matrix["pairs"]["f-a"] == {"status": "edited", "layer": "character"}
    assert matrix["pairs"]["p-yu"] == {"status": "approved", "layer": "shared"}
    assert matrix["pairs"]["a-p"] == {"status": "drafted", "layer": "draft"}
    assert matrix["wanted"] == []


def test_the_matrix_tells_what_the_line_needs(told, workshop):
    workshop.line = SpokenLine(LINE)
    matrix = told("matrix")
    assert matrix["pairs"]["p-a"] == {
        "status": "drafted",
        "layer": "draft",
        "need": 2,
        "word": "ma",
    }
    assert matrix["pairs"]["a-p"]["need"] == 1
    assert matrix["source"] == "line"
    assert "word" not in matrix["pairs"]["a-p"], "between two words"
    assert matrix["wanted"][0]["pair"] == "p-a"
    assert {"pair": "a-p", "count": 1, "word": ""} in matrix["wanted"]


def test_a_bigram_has_its_curves_and_those_to_compare_with(told):
    bigram = told("bigram/p-yu", before="a-p", after="a-f")
    fields = ("status", "contact", "layer", "stated", "file", "place", "curves", "locked")
    assert [bigram[field] for field in fields] == [
        "approved", "free", "shared", True, "posesets/face/banks/common.yaml",
        "posesets/face/banks/common.yaml:8", {}, "",
    ]  # fmt: skip
    kinds = {ghost["kind"]: ghost for ghost in bigram["ghosts"]}
    assert set(kinds) == {"draft", "targets"}
    assert kinds["draft"]["curves"]["PBM"][0] == [0, 0]
    assert kinds["targets"]["curves"]["PBM"][1] == [0.25, 1]
    assert bigram["before"]["curves"]["PBM"]
    assert bigram["after"]["curves"] == {"FV": [[0, 0], [1, 1]]}


def test_neighbours_that_this_language_lacks_are_left_out(told):
    bigram = told("bigram/p-a", before="x-p", after="a-_")
    assert "before" not in bigram
    assert bigram["after"]["pair"] == "a-_"


def test_what_lies_beneath_is_shown(told):
    bigram = told("bigram/f-a")
    assert (bigram["layer"], bigram["file"]) == ("character", "characters/anna.yaml")
    beneath = next(ghost for ghost in bigram["ghosts"] if ghost["kind"] == "beneath")
    assert (beneath["name"], beneath["boundary"]) == ("beneath", 0.4)
    assert beneath["curves"]["open"] == [[0.2, 0], [1, 0]]


def test_a_bigram_drawn_as_another_has_fields_of_its_own_to_come(told):
    bigram = told("bigram/f-yu")
    assert (bigram["drawn_as"], bigram["stated"], bigram["why"]) == ("f-a", False, "")


@pytest.mark.parametrize("name", ["", "x", "a-x", "a-a-a", "_-_", "..", "a-%2e", "<script>-a"])
def test_an_unknown_bigram_is_refused(told, name):
    assert "unknown bigram" in told(f"bigram/{name or '-'}", 422)["error"]


# The file of an edit


def home(root, pair, *own, project=None):
    from lipsync_lang.packs.library import Library

    shelf = PairPacks.open(Library([root], project=None), "parent", "anna")
    path, here = bigram_home(shelf, pair, project or root, lambda path: path.name in own)
    return path.relative_to(project or root).as_posix(), here


def test_an_edit_goes_to_the_users_file_that_has_the_bigram(tmp_path):
    plant(tmp_path)
    mine = ("anna.yaml", "anna-bank.yaml", "common.yaml")
    assert home(tmp_path, ("f", "a"), *mine) == ("characters/anna.yaml", True)
    assert home(tmp_path, ("a", "f"), *mine) == ("characters/anna-bank.yaml", True)
    assert home(tmp_path, ("p", "yu"), *mine) == ("posesets/face/banks/common.yaml", True)
    assert home(tmp_path, ("a", "p"), *mine) == ("posesets/face/banks/common.yaml", False)


def test_an_edit_of_an_installed_bank_goes_to_one_of_the_project(tmp_path):
    plant(tmp_path / "installed")
    project = tmp_path / "project"
    found = home(tmp_path / "installed", ("p", "yu"), project=project)
    assert found == ("posesets/face/banks/common.yaml", False)


def test_a_bank_of_the_user_by_another_name_is_used(tmp_path):
    plant(tmp_path)
    bank = TREE["posesets/face/banks/common.yaml"].partition("bigrams:")[0]
    for name, more in (("drawn", ""), ("sad", "style: sad\n"), ("german", "language: parent\n")):
        text = bank.replace("common", name).replace("language: null\n", "") + more
        put(tmp_path, f"posesets/face/banks/{name}.yaml", f"{text}bigrams: {{}}\n")
    mine = ("drawn.yaml", "sad.yaml", "german.yaml")
    assert home(tmp_path, ("a", "p"), *mine) == ("posesets/face/banks/drawn.yaml", False)


def test_what_would_lie_beneath_an_installed_character_is_refused(tmp_path):
    plant(tmp_path)
    with pytest.raises(LipsyncError, match="copy it into the project"):
        home(tmp_path, ("f", "a"), "common.yaml")


def test_a_bigram_that_cannot_be_edited_says_why(told, monkeypatch):
    monkeypatch.setattr(Workshop, "own", lambda _, path: path.name == "common.yaml")
    assert "copy it into the project" in told("bigram/f-a")["locked"]


def edit(workshop, *edits, path="edit"):
    stated = [{"file": file, "at": ["bigrams", *at], "value": value} for file, at, value in edits]
    found = Caller(workshop).post(path, {"title": "Draw", "edits": stated})
    assert found.status == 200, found.content


def homes(workshop):
    """Return the files with a drawn bigram, with unsaved edits."""
    return {path.name: b"a-p" in content for path, content in workshop.desk.contents.items()}


def test_an_edit_is_of_the_bank_or_of_the_character_alone(told, workshop):
    assert told("bigram/a-p")["character"] == "characters/anna.yaml"
    drawn = {"curves": {"open": [[0, 0], [1, 1]]}}
    edit(workshop, ("bank", ["a-p"], drawn))
    assert told("bigram/a-p")["file"] == "posesets/face/banks/common.yaml"
    edit(workshop, ("character", ["a-p"], drawn))
    assert told("bigram/a-p")["file"] == "characters/anna.yaml", "it comes before the bank"
    edit(workshop, ("bank", ["a-p", "why"], "wide"))
    assert homes(workshop) == {"common.yaml": True, "anna.yaml": True}
    assert told("bigram/a-p")["why"] == "wide"
    for _ in range(2):
        edit(workshop, path="undo")
    assert told("bigram/a-p")["stated"]
    edit(workshop, ("bank", ["a-p", "why"], "round"))
    assert homes(workshop) == {"common.yaml": True}
    assert told("bigram/a-p")["why"] == "round"


def test_an_edit_keeps_the_trigrams_of_its_file_and_the_line_names_them(tmp_path):
    plant(tmp_path)
    drawn = "trigrams:\n  p-a-p: {curves: {FV: [[0, 0], [0.5, 1], [1, 0]]}}  # as in pap\n"
    put(tmp_path, "characters/anna.yaml", TREE["characters/anna.yaml"] + drawn)
    workshop = Workshop(tmp_path, engine="none")
    workshop.open("parent", "anna")
    workshop.line = SpokenLine(LINE)
    for value in (0.5, 0.7):
        edit(workshop, ("character", ["a-p"], {"curves": {"open": [[0, 0], [1, value]]}}))
    assert workshop.pair().compiled.report.trigrams == {"p-a-p": "character"}
    (content,) = workshop.desk.contents.values()
    assert drawn in content.decode()
    document, _ = unpacked(Caller(workshop).post("take"))
    making = document["takes"][0]["making"]
    assert [making["bigrams"][one].get("trigram") for one in making["said"]] == [
        None,
        "p-a-p",
        "p-a-p",
        None,
        None,
    ]
    assert Caller(workshop).post("save").status == 200
    assert drawn in (tmp_path / "characters/anna.yaml").read_text("utf-8")


def test_the_kind_of_curve_is_told_with_that_of_the_bank(told, workshop):
    bank = "posesets/face/banks/common.yaml"
    text = (workshop.project / bank).read_text() + "interpolation: linear\n"
    put(workshop.project, bank, text)
    workshop.open("parent", "anna")
    kinds = ("kind", "bank_kind", "interpolation")
    assert [told("bigram/p-yu")[kind] for kind in kinds] == ["linear", "linear", ""]
    edit(workshop, ("bank", ["p-yu", "interpolation"], "bspline"))
    assert [told("bigram/p-yu")[kind] for kind in kinds] == ["bspline", "linear", "bspline"]
    assert [told("bigram/a-p")[kind] for kind in kinds] == ["bspline", "linear", ""], "a draft"


def test_a_style_is_drawn_in_a_bank_of_its_own(tmp_path):
    workshop = Workshop(tmp_path, engine="none")
    workshop.open("english", "facefx")
    server = Caller(workshop)

    def told(style):
        return server.ask("GET", f"/{TOKEN}/api/bigram/bmp-aa", query={"style": style}).json

    angry = told("angry")
    file = "posesets/facefx/banks/angry.yaml"
    assert (angry["file"], angry["stated"]) == (file, False)
    draft = workshop.performer.compiled.style_drafts["angry"]
    for number, pose in enumerate(workshop.performer.poses):
        for one, plain in zip(
            *(told(s)["curves"].get(pose, []) for s in ("angry", "")), strict=False
        ):
            wanted = plain[1] * draft["scale"][number] + draft["offset"][number]
            assert one[1] == pytest.approx(min(max(wanted, 0), 1), abs=1e-3)
    curves = {"open": [[0, 0], [0.5, 0.9], [1, 0]]}
    edit = {"file": "bank:angry", "at": ["bigrams", "bmp-aa"], "value": {"curves": curves}}
    sent = server.post("edit", {"title": "Draw", "edits": [edit]})
    assert sent.status == 200, sent.content
    angry = told("angry")
    assert (angry["file"], angry["stated"]) == (file, True)
    assert angry["curves"]["open"][1] == [0.5, 0.9]
    assert "open" not in told("")["curves"] or told("")["curves"]["open"] != angry["curves"]["open"]
    text = workshop.desk.contents[tmp_path / file].decode()
    assert "name: angry" in text
    assert "style: angry" in text
    assert server.post("undo", {}).status == 200
    assert told("angry")["stated"] is False


def test_a_style_without_a_file_is_refused(tmp_path):
    workshop = Workshop(tmp_path, engine="none")
    workshop.open("english", "facefx")
    server, edit = (
        Caller(workshop),
        {"file": "bank:angri", "at": ["bigrams", "bmp-aa"], "value": {}},
    )
    sent = server.post("edit", {"title": "Draw", "edits": [edit]})
    assert "did you mean 'angry'" in sent.json["error"]
    taken = tmp_path / "posesets/facefx/banks/sad.yaml"
    taken.parent.mkdir(parents=True)
    taken.write_text("kind: bank\nformat: 1\nname: sad\nposeset: facefx\nbigrams: {}\n", "utf-8")
    workshop.look_again()
    asked = server.ask("GET", f"/{TOKEN}/api/bigram/bmp-aa", query={"style": "sad"}).json
    assert "cannot be the bank of the style sad" in asked["locked"]
