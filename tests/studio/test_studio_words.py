"""The routes of words and lines: curve edits, pronunciations and deliveries."""

import pytest

pytest.importorskip("starlette", reason="the studio needs Starlette")

from studio_calls import TOKEN, Caller
from test_studio_language import PACK

from lipsync_lang.studio.workshop import Workshop

CURVE = [[0, 0], [0.5, 0.8], [1, 0]]


@pytest.fixture
def workshop(tmp_path):
    (tmp_path / "languages").mkdir()
    pack = PACK.format(name="toy").replace("p: d", "p: bmp")
    (tmp_path / "languages" / "toy.yaml").write_text(pack, "utf-8")
    made = Workshop(tmp_path, engine="none")
    made.open("toy", "crab")
    return made


@pytest.fixture
def caller(workshop):
    return Caller(workshop)


def edit(caller, at, value, title="An edit"):
    change = {"file": "character", "at": at, "value": value}
    return caller.post("edit", {"edits": [change], "title": title})


def start(caller, **query):
    return caller.ask("GET", f"/{TOKEN}/api/words/start", query=query)


def test_an_installed_character_has_nothing_of_its_own(caller):
    told = caller.api("words").json
    assert (told["words"], told["pronunciations"], told["lines"]) == ([], [], [])
    assert (told["file"], told["lineage"], told["sounds"]) == ("", ["toy"], [])


def test_edits_make_a_pack_of_the_project(workshop, caller):
    assert edit(caller, ["words", "<script>"], {"curves": {"mouthOpen": CURVE}}).status == 200
    assert edit(caller, ["pronunciations", "toy", "may"], ["bmp", "ih"]).status == 200
    line = {"edits": [{"word": 1, "curves": {"mouthOpen": CURVE}}], "dials": {"jaw": 0.5}}
    assert edit(caller, ["lines", "hello"], line).status == 200
    told = caller.api("words").json
    assert told["file"] == "characters/crab.yaml"
    assert told["words"] == [{"word": "<script>", "curves": {"mouthOpen": CURVE}}]
    said = {"language": "toy", "word": "may", "phonemes": ["bmp", "ih"]}
    assert told["pronunciations"] == [said]
    assert told["lines"][0] == {
        "name": "hello", "styles": {}, "dials": {"jaw": [[0, 0.5]]},
        "edits": [{"word": 1, "phoneme": None, "curves": {"mouthOpen": CURVE}}],
    }  # fmt: skip
    assert caller.api("state").json["lines"] == ["hello"]
    assert caller.post("save").json["saved"] == ["characters/crab.yaml"]
    assert "<script>" in (workshop.project / "characters" / "crab.yaml").read_text("utf-8")


def test_a_language_without_a_pack_has_its_words_and_tells_how_it_is_edited(workshop, caller):
    workshop.open("ipa:sw", "crab")
    assert caller.api("words").json["lineage"] == ["ipa:sw"]
    assert edit(caller, ["words", "a"], {"curves": {"mouthOpen": CURVE}}).status == 200
    change = {"file": "language", "at": ["notations", "ipa", "a"], "value": "aa"}
    refused = caller.post("edit", {"edits": [change], "title": "Map a"})
    assert (refused.status, "extends: ipa:sw" in refused.json["error"]) == (422, True)


def test_an_edit_of_a_line_is_changed_in_place_and_heard(workshop, caller):
    caller.post("line", {"text": "ma pa"})
    line = {"edits": [{"word": 1, "curves": {"mouthOpen": CURVE}}]}
    edit(caller, ["lines", "hello"], line)
    flat = [[0, 0], [0.5, 0.1], [1, 0]]
    at = ["lines", "hello", "edits", 0, "curves", "mouthOpen"]
    assert edit(caller, at, flat).status == 200
    assert caller.api("words").json["lines"][0]["edits"][0]["curves"] == {"mouthOpen": flat}
    plain = workshop.perform()["mouthOpen"].max()
    told = caller.post("take", {"settings": {"line": "hello"}})
    assert told.status == 200
    assert workshop.perform()["mouthOpen"][-30:].max() < plain


def test_a_pronunciation_changes_what_is_said(caller):
    caller.post("line", {"text": "may"})
    assert caller.api("words").json["sounds"] == [["bmp"], ["aa"], ["ih"]]
    edit(caller, ["pronunciations", "toy", "may"], ["bmp", "ih"])
    caller.post("line", {"text": "may"})
    assert [one for said in caller.api("words").json["sounds"] for one in said] == ["bmp", "ih"]


def test_curves_start_as_they_are_performed_without_the_edits(caller):
    caller.post("line", {"text": "ma pa"})
    found = start(caller, word="0").json["curves"]
    assert found["mouthOpen"][0][0] == 0
    assert found["mouthOpen"][-1][0] == 1
    assert max(value for _, value in found["mouthOpen"]) > 0.2
    edit(caller, ["words", "ma"], {"curves": {"mouthOpen": [[0, 0], [1, 0]]}})
    assert start(caller, word="0").json["curves"] == found
    sound = start(caller, word="1", phoneme="1").json["curves"]
    assert sound == start(caller, phoneme="3").json["curves"] != found


def test_curves_of_a_word_have_nothing_of_its_neighbours(caller):
    def curves(text, word):
        caller.post("line", {"text": text})
        return start(caller, word=word, alone="1").json["curves"]

    for other in ("pa ma", "pa ma pa"):
        assert curves(other, "1").keys() == curves("ma", "0").keys()
    caller.post("line", {"text": "ma"})
    assert start(caller, word="0", alone="1").json == start(caller, word="0").json


def test_curves_that_start_as_performed_change_little(workshop, caller):
    caller.post("line", {"text": "ma pa"})
    before = workshop.perform()["mouthOpen"]
    found = start(caller, word="0").json["curves"]
    edit(caller, ["words", "ma"], {"curves": found})
    assert abs(workshop.perform()["mouthOpen"] - before).max() < 0.1


@pytest.mark.parametrize(
    "query",
    [{"word": "2"}, {"word": "-1"}, {"word": "x"}, {"phoneme": "9"}, {"word": "0", "phoneme": "2"},
     {"word": "9" * 50}, {"phoneme": "../1"}],
)  # fmt: skip
def test_words_and_phonemes_that_the_line_has_not_are_refused(caller, query):
    caller.post("line", {"text": "ma pa"})
    found = start(caller, **query)
    assert (found.status, bool(found.json["error"])) == (422, True)


def test_without_a_line_there_is_no_start(caller):
    assert start(caller, word="0").status == 422


@pytest.mark.parametrize(
    ("at", "value"),
    [
        (["words", "ma"], {"curves": {"nothing": CURVE}}),
        (["words", "ma"], {"curves": {"mouthOpen": [[0, 0], [2, 0]]}}),
        (["pronunciations", "toy", "ma"], ["<script>"]),
        (["pronunciations", "toy", "ma"], []),
        (["lines", "x"], {"dials": {"nothing": 1}}),
        (["lines", "x"], {"edits": [{"word": -1, "curves": {}}]}),
    ],
)
def test_faulty_edits_are_refused_and_nothing_changes(caller, at, value):
    assert edit(caller, at, value).status == 422
    told = caller.api("words").json
    assert (told["words"], told["pronunciations"], told["lines"]) == ([], [], [])
