"""The language view's routes: the table of sounds, its tests, and single sounds."""

import pytest

pytest.importorskip("starlette", reason="the studio needs Starlette")

from studio_calls import Caller, unpacked

from lipsync_lang.studio.workshop import Workshop

PACK = """
kind: language
format: 1
name: {name}
tag: en
title: "<script>alert(1)</script>"
g2p:
  engine: rules
  notation: ipa
  rules:
    - {{from: m, to: m}}
    - {{from: p, to: p}}
    - {{from: a, to: a}}
    - {{from: y, to: y}}
notations:
  ipa:
    m: bmp
    p: d
    a: aa
    y: ih
    b̪: f
    t: h
reasons: {{t: "a pretence: <b>bold</b>"}}
inventory: {{source: nobody, segments: [m, p, a, q]}}
tests:
  - {{text: ma, ipa: m a, phonemes: [bmp, aa]}}
  - {{text: pa, ipa: p a, phonemes: [bmp, aa]}}
"""
CHILD = """
kind: language
format: 1
name: {name}
tag: en
extends: parent
notations: {{ipa: {{p: bmp}}}}
"""


@pytest.fixture(scope="module")
def workshop(tmp_path_factory):
    project = tmp_path_factory.mktemp("project")
    (project / "languages").mkdir()
    for name, text in (("parent", PACK), ("child", CHILD)):
        (project / "languages" / f"{name}.yaml").write_text(text.format(name=name), "utf-8")
    return Workshop(project, engine="none")


@pytest.fixture
def caller(workshop):
    workshop.open("parent", "crab")
    workshop.line = None
    return Caller(workshop)


def rows(caller):
    return {row["label"]: row for row in caller.api("language").json["rows"]}


def test_rows_that_need_a_look_come_first(caller):
    told = caller.api("language").json["rows"]
    needs = [row["need"] for row in told]
    assert needs == sorted(needs, key=["unmapped", "doubtful", "automatic", "loses", ""].index)
    found = rows(caller)
    assert (found["q"]["need"], found["q"]["to"]) == ("unmapped", [])
    assert found["p"]["need"] == "doubtful"
    assert "closure" in found["p"]["says"]
    assert (found["m"]["need"], found["m"]["words"]) == ("", ["ma"])


def test_a_stated_reason_settles_a_doubt(caller):
    found = rows(caller)["t"]
    assert (found["need"], found["reason"]) == ("", "a pretence: <b>bold</b>")


def test_tests_of_a_parent_are_run_with_the_maps_of_the_child(workshop, caller):
    assert [one["passed"] for one in caller.api("language").json["tests"]] == [True, False]
    failed = caller.api("language").json["tests"][1]
    assert (failed["said"], failed["expected"]) == (["d", "aa"], ["bmp", "aa"])
    workshop.open("child", "crab")
    told = caller.api("language").json
    assert [one["passed"] for one in told["tests"]] == [True, True]
    by_label = {row["label"]: row for row in told["rows"]}
    assert [by_label[one]["own"] for one in "pm"] == [True, False]
    assert told["title"] == "<script>alert(1)</script>"


def test_a_test_of_the_pack_fails_after_an_edit_until_it_is_undone(caller):
    edit = {"file": "language", "at": ["notations", "ipa", "m"], "value": "ih"}
    assert caller.post("edit", {"edits": [edit], "title": "Map m"}).status == 200
    told = caller.api("language").json
    assert [one["passed"] for one in told["tests"]] == [False, False]
    assert (told["tests"][0]["said"], told["tests"][0]["claimed"]) == (["ih", "aa"], ["ih", "aa"])
    assert caller.post("language/transcript", {"text": "m"}).json["phonemes"] == ["ih"]
    assert rows(caller)["m"]["need"] == "doubtful"
    assert caller.post("undo").status == 200
    assert [one["passed"] for one in caller.api("language").json["tests"]] == [True, False]


def test_an_edit_to_an_unknown_mouth_is_refused(caller):
    edit = {"file": "language", "at": ["notations", "ipa", "m"], "value": "<script>"}
    refused = caller.post("edit", {"edits": [edit], "title": "Map m"})
    assert (refused.status, rows(caller)["m"]["to"]) == (422, ["bmp"])


def test_labels_of_the_line_that_nothing_maps_are_rows(workshop, caller):
    workshop.speak("ma")
    assert rows(caller)["m"]["words"] == ["ma"]


def test_a_word_is_tried(caller):
    told = caller.post("language/transcript", {"text": " pam "}).json
    assert told["phonemes"] == ["d", "aa", "bmp"]
    assert [one["label"] for one in told["words"][0]["labels"]] == ["p", "a", "m"]


@pytest.mark.parametrize("text", ["", "  ", "m" * 3000, 7, None])
def test_no_word_is_refused(caller, text):
    found = caller.post("language/transcript", {"text": text})
    assert found.status == 422
    assert found.json["error"]


def test_a_sound_alone_is_performed_without_a_voice(caller):
    found = caller.post("language/sound", {"notation": "ipa", "label": "m"})
    document, size = unpacked(found)
    assert document["takes"][0]["spoken"]["labels"] == ["_", "m", "_"]
    assert document["sound"] is None
    assert size > 0


@pytest.mark.parametrize(
    ("notation", "label"),
    [("ipa", "<script>"), ("<script>", "m"), ("../ipa", "m"), ("ipa", 3)],
)
def test_sounds_of_no_notation_are_refused(workshop, caller, notation, label):
    found = caller.post("language/sound", {"notation": notation, "label": label})
    assert found.status == 422
    assert workshop.line is None


def test_the_face_holds_the_target_of_a_phoneme(workshop, caller):
    pressed = caller.api("language/mouth/bmp").json["steps"]
    rest = caller.api("language/mouth/_").json["steps"]
    channels = workshop.performer.rigged(_line(workshop)).poses
    assert len(pressed) == len(rest) == 1
    assert len(pressed[0]) == len(channels)
    assert pressed != rest
    assert caller.api("language/mouth/ae").json["phoneme"] == "ae"


def _line(workshop):
    workshop.speak("ma")
    return workshop.perform()


@pytest.mark.parametrize("name", ["nothing", "../aa", "%3Cscript%3E", "aa/ih"])
def test_targets_of_no_phoneme_are_refused(caller, name):
    assert caller.api(f"language/mouth/{name}").status == 422


def test_the_text_of_a_pack_is_data(caller):
    told = caller.api("language")
    assert told.json["title"] == "<script>alert(1)</script>"
    assert told.headers["content-type"] == "application/json"


def test_a_language_is_begun_from_another_and_opens(tmp_path):
    made = Workshop(tmp_path, engine="none")
    made.open("english", "crab")
    caller = Caller(made)
    asked = {"name": "elvish", "base": "english", "tag": "qya"}
    begun = {"name": "elvish", "file": "languages/elvish.yaml"}
    assert caller.post("language", asked).json == begun
    text = (tmp_path / "languages/elvish.yaml").read_text("utf-8")
    assert text == (
        "kind: language\nformat: 1\nname: elvish\ntag: qya\ntitle: Elvish\nextends: english\n"
    )
    assert "elvish" in caller.api("project").json["languages"]
    assert caller.post("open", {"language": "elvish", "character": "crab"}).status == 200
    told = caller.api("language").json
    assert (told["title"], told["tag"], told["extends"]) == ("Elvish", "qya", "english")
    assert caller.post("language", {**asked, "name": "orcish", "tag": ""}).status == 200
    assert "tag: en\n" in (tmp_path / "languages/orcish.yaml").read_text("utf-8")


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"name": "../elvish"}, "'../elvish' cannot be a pack's name; write letters, digits"),
        ({"name": ""}, "cannot be a pack's name"),
        ({"name": "english"}, "there is a language 'english' already; choose another name"),
        ({"base": "englsh"}, "did you mean 'english'"),
        ({"tag": "en: [x"}, "'en: [x' is no language code; write one such as"),
    ],
)
def test_a_language_that_cannot_begin_is_told_and_not_written(tmp_path, asked, told):
    made = Workshop(tmp_path, engine="none")
    made.open("english", "crab")
    found = Caller(made).post(
        "language", {"name": "elvish", "base": "english", "tag": "qya"} | asked
    )
    assert found.status == 422
    assert told in found.json["error"]
    assert not (tmp_path / "languages").exists()


def test_a_relabelled_word_is_read_from_its_labels(tmp_path):
    (tmp_path / "languages").mkdir()
    pack = PACK.format(name="parent") + "words: {mama: [f, l, f, l]}\n"
    (tmp_path / "languages/parent.yaml").write_text(pack, "utf-8")
    made = Workshop(tmp_path, engine="none")
    made.open("parent", "crab")
    caller = Caller(made)

    def mouths():
        numbers = made.performer.common_phonemes(made.schedule)[0]
        return [made.performer.compiled.phonemes[number] for number in numbers]

    caller.post("line", {"text": "mama ma"})
    assert [one for one in mouths() if one != "_"] == ["f", "l", "f", "l", "bmp", "aa"]
    first = made.schedule.words[0].first
    assert caller.post(f"phonemes/{first}", {"labels": ["y"]}).status == 200
    assert [one for one in mouths() if one != "_"][:1] == ["ih"]
    assert not {"f", "l"} & {*mouths()}
    caller.post("undo")
    made.state()
    assert [one for one in mouths() if one != "_"][:4] == ["f", "l", "f", "l"]
