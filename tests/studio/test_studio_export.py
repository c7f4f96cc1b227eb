"""Export from the studio: files of a line in every format, and of all lines of a script."""

import json

import pytest

pytest.importorskip("starlette", reason="the studio needs Starlette")

from studio_calls import Caller, unpacked
from test_studio_script import PROJECT, folder, workshop_of

from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.performing.resolving import resolve
from lipsync_lang.schedules.timing_readers import read_timings

__all__ = ["folder"]  # a fixture

TIMED = b"""{"notation": "arpabet", "phonemes": [{"label": "M", "start": 0, "end": 0.1},
    {"label": "AA", "start": 0.1, "end": 0.3}]}"""
FILMS = {"mp4", "webm"}
"""Formats of seconds of work, which the browser's test writes."""


@pytest.fixture
def caller(tmp_path):
    made = Caller(workshop_of(tmp_path, "english", "facefx"))
    assert made.post("timings", TIMED, query={"name": "line.json"}).status == 200
    return made


def exported(caller, **asked):
    """Return the answer, and the content of each file."""
    answer = caller.post("export", asked)
    assert answer.status == 200, answer.content
    document, _ = unpacked(answer)
    length = int.from_bytes(answer.content[:4], "little")
    block, files = answer.content[4 + length :], {}
    for row, (_, size) in zip(document.get("files", ()), document["arrays"], strict=True):
        files[row["name"]], block = block[:size], block[size:]
    return document, files


def test_every_format_is_listed_and_written(caller):
    rows = caller.api("export").json["formats"]
    assert [(row["name"], row["title"]) for row in rows] == [(n, WRITERS[n].title) for n in WRITERS]
    asked = [row["name"] for row in rows if not row["refused"] and row["name"] not in FILMS]
    document, files = exported(caller, formats=asked)
    made = {f"line{WRITERS[name].suffix}" for name in asked}
    told = {one.partition(":")[0] for one in document["failed"]}
    assert {*files} == made - {f"line{WRITERS[name].suffix}" for name in told}
    assert {"line.csv", "line.html", "line.glb"} <= {*files}
    assert all(files.values())


def test_files_are_those_of_the_command_line(caller, tmp_path):
    _, files = exported(caller, formats=["csv", "html"])
    (tmp_path / "line.json").write_bytes(TIMED)
    performer = resolve("english", "facefx")
    said = performer.perform(read_timings(tmp_path / "line.json"), 60)
    WRITERS["csv"].write(performer.rigged(said), out := (tmp_path / "own.csv").open("wb"))
    out.close()
    assert files["line.csv"] == (tmp_path / "own.csv").read_bytes()
    blinks = performer.gesture_set.poses[0]
    assert blinks.encode() in files["line.html"]  # people watch a page
    assert blinks.encode() not in files["line.csv"]


def test_the_delivery_of_a_line_is_in_its_files(caller):
    _, before = exported(caller, formats=["csv"])
    caller.post("take", {"settings": {"fps": 60, "dials": {"jaw": 0.2}}})
    _, after = exported(caller, formats=["csv"])
    assert before != after


def test_all_lines_of_a_script_go_into_a_folder_with_their_edits(folder):
    caller = Caller(workshop_of(folder, "english", "facefx"))
    caller.api("script")
    unpacked(caller.post("script", {"name": "intro"}))
    lines = caller.api("export").json["lines"]
    assert [(one["name"], one["character"]) for one in lines] == [
        ("intro", "facefx"), ("reply", "crab"), ("last", "facefx"),
    ]  # fmt: skip
    place = {"formats": ["csv"], "folder": "exports/a"}
    written = [
        exported(caller, line=one["name"], character=one["character"], **place)[0]["written"]
        for one in lines
    ]
    assert written == [[f"exports/a/{name}.csv"] for name in ("intro", "reply", "last")]
    assert "mouthOO" in (folder / "exports/a/reply.csv").read_text("utf-8")
    assert caller.api("state").json["name"] == "intro"  # stays open
    refused = caller.post("export", {"line": "last", "character": "facefx", **place})
    assert refused.json["error"].startswith("exports/a/last.csv: exists")
    exported(caller, line="last", character="facefx", replace=True, **place)


def test_gestures_and_the_start_of_a_project_hold(folder):
    (folder / "lipsync.yaml").write_text(f"{PROJECT}offset: 10\ngestures: all\n", "utf-8")
    caller = Caller(workshop_of(folder, "english", "facefx"))
    caller.post("timings", TIMED, query={"name": "line.json"})
    rows = exported(caller, formats=["csv"])[1]["line.csv"].decode().splitlines()
    assert resolve("english", "facefx").gesture_set.poses[0] in rows[0]
    assert 9 < float(rows[1].split(",")[0]) < 11


@pytest.mark.parametrize("place", ["", "..", "a/../../b", "/", "a\nb"])
def test_files_stay_in_the_project(caller, place):
    answer = caller.post("export", {"formats": ["csv"], "folder": place})
    assert "name a folder of the project" in answer.json["error"]


def test_a_link_out_of_the_project_is_not_followed(folder, tmp_path_factory):
    caller = Caller(workshop_of(folder, "english", "facefx"))
    caller.post("timings", TIMED, query={"name": "line.json"})
    (folder / "exports").symlink_to(tmp_path_factory.mktemp("other"), target_is_directory=True)
    answer = caller.post("export", {"formats": ["csv"], "folder": "exports"})
    assert "leads outside" in answer.json["error"]


def test_what_cannot_be_exported_is_told(caller, tmp_path):
    assert "unknown" in caller.post("export", {"formats": ["cvs"]}).json["error"]
    answer = caller.post("export", {"formats": ["csv"], "line": "x", "character": "facefx"})
    assert "no line 'x'" in json.loads(answer.content)["error"]
    other = Caller(workshop_of(tmp_path, "english", "facefx"))
    assert "there is no line" in other.post("export", {"formats": ["csv"]}).json["error"]
