"""The coverage view's routes: the project's script, its count, and the bigrams to draw."""

import json
from time import sleep

import pytest

pytest.importorskip("starlette", reason="the studio needs Starlette")

from studio_calls import Caller
from test_studio_language import PACK

from lipsync_lang.studio.script_count import script_needs, script_of
from lipsync_lang.studio.workshop import Workshop


@pytest.fixture
def workshop(tmp_path):
    project = tmp_path / "project"
    (project / "languages").mkdir(parents=True)
    pack = PACK.format(name="toy").replace("p: d", "p: bmp")
    (project / "languages" / "toy.yaml").write_text(pack, "utf-8")
    (project / "texts").mkdir()
    (project / "texts" / "act.txt").write_text("ma pa\nay ma\n", "utf-8")
    (project / "table.csv").write_text("id,text,note\n1,pay,x\n", "utf-8")
    (project / ".hidden.txt").write_text("secret", "utf-8")
    (tmp_path / "outside.txt").write_text("outside", "utf-8")
    made = Workshop(project, engine="none")
    made.open("toy", "crab")
    return made


@pytest.fixture
def caller(workshop):
    return Caller(workshop)


def counted(workshop, caller):
    caller.api("coverage")
    while script_of(workshop).progress["state"] == "counting":
        sleep(0.01)
    return caller.api("coverage").json


def test_scripts_of_the_project_are_offered_without_its_packs(caller):
    told = caller.api("coverage").json
    assert told["offered"] == ["table.csv", "texts/act.txt"]
    assert (told["state"], told["report"]) == ("none", None)


def test_the_page_offers_files_of_the_formats_that_are_read(workshop, caller):
    known = caller.api("coverage").json["suffixes"]
    assert ".txt" in known
    for suffix in known:
        (workshop.project / f"a{suffix}").write_text("ma", "utf-8")
    (workshop.project / "a.unknown").write_text("ma", "utf-8")
    offered = caller.api("coverage").json["offered"]
    assert {one for one in offered if one.startswith("a.")} == {f"a{suffix}" for suffix in known}


def test_a_script_of_the_project_is_counted(workshop, caller):
    assert caller.post("coverage", {"name": "texts/act.txt"}).status == 200
    told = counted(workshop, caller)
    assert (told["state"], told["script"]["name"]) == ("ready", "texts/act.txt")
    report = told["report"]
    assert (report["lines"], report["words"], report["occurrences"]) == (2, 4, 6)
    assert report["plan"][0] == {
        "bigram": "bmp-aa", "count": 3, "percent": 50.0,
        "layer": "draft", "status": "drafted", "example": "ma",
        "places": ["act.txt:1", "act.txt:2"],
    }  # fmt: skip
    assert report["left"] == {"bigrams": 4, "hours": pytest.approx(4 * 5 / 60, abs=0.01)}
    assert script_needs(workshop)["bmp-aa"] == (3, "ma")
    assert caller.api("matrix").json["wanted"][0]["pair"] == "bmp-aa"


def test_an_edit_of_a_bank_needs_no_count_and_one_of_the_language_does(workshop, caller):
    caller.post("coverage", {"name": "texts/act.txt"})
    counted(workshop, caller)
    value = {"status": "approved", "curves": {"open": [[0, 0], [1, 0]]}}
    edit = {"file": "bank", "at": ["bigrams", "bmp-aa"], "value": value}
    poses = [pose["name"] for pose in caller.api("state").json["poses"]]
    edit["value"]["curves"] = {poses[0]: [[0, 0], [0.5, 0.4], [1, 0]]}
    assert caller.post("edit", {"edits": [edit], "title": "Draw"}).status == 200
    told = caller.api("coverage").json
    assert (told["state"], told["report"]["authored"]["bigrams"]) == ("ready", 1)
    assert told["report"]["status"]["approved"] == [1, 3]
    edit = {"file": "language", "at": ["notations", "ipa", "p"], "value": "f"}
    assert caller.post("edit", {"edits": [edit], "title": "Map p"}).status == 200
    told = counted(workshop, caller)
    assert "f-aa" in [row["bigram"] for row in told["report"]["plan"]]


def test_a_changed_script_is_counted_anew(workshop, caller):
    caller.post("coverage", {"name": "texts/act.txt"})
    counted(workshop, caller)
    (workshop.project / "texts" / "act.txt").write_text("ma\n", "utf-8")
    assert counted(workshop, caller)["report"]["lines"] == 1


def test_a_script_is_sent_and_dropped(workshop, caller):
    sent = caller.post("coverage/script", b"pay\nqq\n", {"name": "../../<script>.txt"})
    assert (sent.status, sent.json["script"]["name"]) == (200, "<script>.txt")
    told = counted(workshop, caller)
    assert told["report"]["lines"] == 2
    assert [one["what"] for one in told["report"]["unread"]] == ["qq"]
    sentences = caller.api("coverage/sentences").json
    assert sentences["sentences"][0]["place"] == "<script>.txt:1"
    assert caller.post("coverage", {"name": ""}).json["state"] == "none"
    assert script_needs(workshop) == {}


def test_a_column_is_chosen(workshop, caller):
    caller.post("coverage", {"name": "table.csv", "column": "text"})
    assert counted(workshop, caller)["report"]["words"] == 1
    caller.post("coverage", {"name": "table.csv", "column": "nothing"})
    told = counted(workshop, caller)
    assert told["state"] == "failed"
    assert "nothing" in told["fault"]
    assert str(workshop.project) not in told["fault"]


@pytest.mark.parametrize(
    "name",
    ["../outside.txt", "texts/../../outside.txt", "/etc/passwd", "missing.txt", "languages",
     "languages/toy.bin", ".", "a\0b", "link.txt", "<script>"],
)  # fmt: skip
def test_files_outside_the_project_are_refused(workshop, caller, name):
    link = workshop.project / "link.txt"
    if not link.exists():
        link.symlink_to(workshop.project.parent / "outside.txt")
    found = caller.post("coverage", {"name": name})
    assert found.status == 422
    assert caller.api("coverage").json["state"] == "none"


@pytest.mark.parametrize("minutes", ["0", "-1", "nan", "inf", "x", "601"])
def test_minutes_are_a_number(caller, minutes):
    found = caller.ask("GET", "/a-token-for-tests/api/coverage", query={"minutes": minutes})
    assert found.status == 422


def test_minutes_change_the_hours(workshop, caller):
    caller.post("coverage", {"name": "texts/act.txt"})
    counted(workshop, caller)
    found = caller.ask("GET", "/a-token-for-tests/api/coverage", query={"minutes": "30"})
    assert found.json["report"]["left"]["hours"] == 2.0


def test_an_empty_script_is_no_crash(workshop, caller):
    caller.post("coverage/script", b"\n\n", {"name": "empty.txt"})
    told = counted(workshop, caller)
    assert (told["state"], told["fault"]) == ("failed", "empty.txt has no lines to count")
    assert caller.api("coverage/sentences").status == 422


# The same script in the project's commands

GAME = """kind: project
format: 1
name: game
languages: {toy: klingt, other: andere}
lines: script.csv
columns: {text: "{language}", speaker: wer}
cast: {Anna: facefx, Ben: [facefx, crab], "*": crab}
"""

SCRIPT = """id,wer,klingt,andere
1,Anna,ma pa,am
2,anna,ay ma,pam
3,Ben,pa pa ay,ma
4,Cleo,am am,ay
5,,may,pay
"""

FIGURES = ("lines", "words", "occurrences", "authored", "left", "needed", "unread", "unmapped")


@pytest.fixture
def game(workshop, monkeypatch):
    """The project of a game, with its folder as the current one."""
    folder = workshop.project
    other = PACK.format(name="other").replace("p: d", "p: bmp")
    (folder / "languages" / "other.yaml").write_text(other, "utf-8")
    (folder / "lipsync.yaml").write_text(GAME, "utf-8")
    (folder / "script.csv").write_text(SCRIPT, "utf-8")
    monkeypatch.chdir(folder)
    return folder


def agrees(workshop, caller, report):
    """Check that the view tells the figures of a report."""
    caller.post("coverage", {"name": "script.csv"})
    told = counted(workshop, caller)
    assert told["state"] == "ready", told["fault"]
    shown = told["report"]
    assert {one: shown[one] for one in FIGURES} == {one: report[one] for one in FIGURES}
    assert shown["next_hour"]["percent"] == report["next_hour"]["percent"]
    rows = {row["bigram"]: row for row in report["bigrams"]}
    assert shown["kinds"] == len(rows)
    for need in shown["plan"]:
        row = rows.pop(need["bigram"])
        assert need == {key: row[key] for key in need}
    assert all(row["status"] in {"edited", "approved"} for row in rows.values())
    return told


@pytest.mark.usefixtures("game")
def test_the_view_counts_what_the_command_counts(workshop, caller, cli):
    reports = json.loads(cli("coverage", "--format", "json").out)["reports"]
    pairs = [(one["language"], one["character"], one["lines"]) for one in reports]
    assert pairs == [
        ("toy", "facefx", 3), ("toy", "crab", 3), ("other", "facefx", 3), ("other", "crab", 3)
    ]  # fmt: skip
    for report, (language, character, _) in zip(reports, pairs, strict=True):
        workshop.open(language, character)
        told = agrees(workshop, caller, report)
        assert told["remarks"] == [f"counts the lines that `cast` gives to {character}"]


@pytest.mark.usefixtures("game")
def test_a_face_without_a_role_speaks_every_line_as_a_stated_one_does(workshop, caller, cli):
    options = ("-l", "toy", "-c", "arkit", "--format", "json")
    (report,) = json.loads(cli("coverage", *options).out)["reports"]
    assert report["lines"] == 5
    workshop.open("toy", "arkit")
    assert agrees(workshop, caller, report)["remarks"] == []


def test_another_face_or_cast_is_a_count_of_its_own(game, workshop, caller):
    workshop.open("toy", "facefx")
    caller.post("coverage", {"name": "script.csv"})
    assert counted(workshop, caller)["report"]["lines"] == 3
    workshop.open("toy", "crab")
    assert counted(workshop, caller)["report"]["occurrences"] == 10
    (game / "lipsync.yaml").write_text(GAME.replace("Ben: [facefx, crab]", "Ben: facefx"), "utf-8")
    assert counted(workshop, caller)["report"]["lines"] == 2


def test_a_speaker_without_a_face_is_the_fault_of_the_command(game, workshop, caller, cli):
    (game / "lipsync.yaml").write_text(GAME.replace(', "*": crab', ""), "utf-8")
    workshop.open("toy", "facefx")
    caller.post("coverage", {"name": "script.csv"})
    fault = counted(workshop, caller)["fault"]
    assert "script.csv:5: no character for 'Cleo'" in fault
    assert fault in cli("coverage", "-l", "toy").err


def test_a_sent_script_has_no_columns_of_the_project(game, workshop, caller):
    assert game
    workshop.open("toy", "crab")
    caller.post(
        "coverage/script", b"speaker,Toy,other\nAnna,ma,pa\nCleo,ay,am\n", {"name": "a.csv"}
    )
    told = counted(workshop, caller)
    assert (told["fault"], told["report"]["lines"]) == ("", 1)


def test_the_column_of_the_open_language_is_found(game, workshop, caller):
    (game / "lipsync.yaml").unlink()
    (game / "table.csv").write_text("id,other,Toy\n1,pay,ma\n2,pay,ma\n", "utf-8")
    for language, occurrences in (("toy", 2), ("other", 4)):
        workshop.open(language, "crab")
        caller.post("coverage", {"name": "table.csv"})
        assert counted(workshop, caller)["report"]["occurrences"] == occurrences
