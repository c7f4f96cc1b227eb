"""Lines of a project's script in the studio: listed, searched, and opened as a build makes them."""

import time
import wave
from pathlib import Path

import pytest

pytest.importorskip("starlette", reason="the studio needs Starlette")

from lanes import swept
from places import TESTS
from studio_calls import Caller, unpacked

from lipsync_lang.packs.project import FILE
from lipsync_lang.studio import project_lines
from lipsync_lang.studio.project_lines import ProjectLines
from lipsync_lang.studio.workshop import Workshop

TIMED = """{"notation": "arpabet", "phonemes": [
    {"label": "M", "start": 0, "end": 0.1}, {"label": "AA", "start": 0.1, "end": 0.3}]}"""

SCRIPT = """id,speaker,english,finnish
intro,Anna,Please buy five maps.,Osta viisi karttaa.
reply,Bob,We should go.,Lähdetään nyt.
last,Anna,Good night.,Hyvää yötä.
"""

PROJECT = """kind: project
format: 1
languages: [english, finnish]
cast: {Bob: crab, "*": facefx}
lines: script.csv
audio: "vo/{language}/{id}.wav"
outputs: "takes/{language}/{character}/{id}.csv"
"""


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "script.csv").write_text(SCRIPT, "utf-8")
    (tmp_path / FILE).write_text(PROJECT, "utf-8")
    return tmp_path


def workshop_of(folder, *pair):
    made = Workshop(folder, engine="none", script=ProjectLines(folder / FILE))
    if pair:
        made.open(*pair)
    return made


def listed(caller, query=""):
    answer = caller.ask("GET", "/a-token-for-tests/api/script", query=query)
    assert answer.status == 200, answer.content
    return answer.json


def names(found):
    return [(one["name"], one["language"], one["character"]) for one in found["lines"]]


def test_the_lines_of_the_open_language_are_listed_with_their_characters(folder):
    caller = Caller(workshop_of(folder, "finnish", "facefx"))
    found = listed(caller)
    assert names(found) == [
        ("intro", "finnish", "facefx"), ("reply", "finnish", "crab"), ("last", "finnish", "facefx"),
    ]  # fmt: skip
    assert [one["text"] for one in found["lines"]][2] == "Hyvää yötä."
    assert (found["count"], found["found"], found["several"]) == (3, 3, True)


def test_without_an_open_pair_the_first_language_is_listed(folder):
    assert names(listed(Caller(workshop_of(folder))))[0] == ("intro", "english", "facefx")


def test_a_character_that_the_script_does_not_use_stays_open(folder):
    found = listed(Caller(workshop_of(folder, "english", "arkit")))
    assert {character for *_, character in names(found)} == {"arkit"}


@pytest.mark.parametrize(
    ("query", "found"),
    [
        ({"sought": "anna"}, ["intro", "last"]),
        ({"sought": "GOOD anna"}, ["last"]),
        ({"sought": "repl"}, ["reply"]),
        ({"sought": "nobody"}, []),
        ({"first": "1"}, ["reply", "last"]),
        ({"sought": "anna", "first": "1"}, ["last"]),
    ],
)
def test_lines_are_searched(folder, query, found):
    caller = Caller(workshop_of(folder, "english", "facefx"))
    listed(caller)
    (folder / "script.csv").unlink()  # a search reads nothing
    assert [one["name"] for one in listed(caller, query)["lines"]] == found


@pytest.mark.parametrize("first", ["-1", "x", "9" * 10, "٣"])
def test_a_number_that_is_none_is_refused(folder, first):
    caller = Caller(workshop_of(folder, "english", "facefx"))
    answer = caller.ask("GET", "/a-token-for-tests/api/script", query={"first": first})
    assert answer.status == 422


def test_a_long_script_is_listed_in_parts(folder, monkeypatch):
    monkeypatch.setattr(project_lines, "MAX_LISTED", 2)
    caller = Caller(workshop_of(folder, "english", "facefx"))
    assert [len(listed(caller, q)["lines"]) for q in ({}, {"first": "2"})] == [2, 1]


def test_a_line_is_opened_with_its_neighbours(folder):
    caller = Caller(workshop_of(folder, "english", "facefx"))
    document, _ = unpacked(caller.post("script", {"name": "last"}))
    assert document["text"] == "Good night."
    place = document["script"]
    assert (place["name"], place["number"], place["count"]) == ("last", 3, 3)
    before, after = place["beside"]
    assert (before["name"], before["character"], after) == ("reply", "crab", None)
    assert unpacked(caller.api("line"))[0]["script"] == place
    typed, _ = unpacked(caller.post("line", {"text": "Hello"}))
    assert typed["script"] is None


def test_an_unknown_line_is_refused(folder):
    answer = Caller(workshop_of(folder, "english", "crab")).post("script", {"name": "intor"})
    assert answer.status == 422
    assert all(word in answer.json["error"] for word in ("'intor'", "english", "'intro'"))


def test_files_that_come_later_are_found_when_the_line_is_opened(folder):
    caller = Caller(workshop_of(folder, "english", "facefx"))
    listed(caller)
    vo = folder / "vo/english"
    vo.mkdir(parents=True)
    (vo / "intro.json").write_text(TIMED, "utf-8")
    with wave.open(str(vo / "intro.wav"), "wb") as sound:
        sound.setparams((1, 2, 16000, 0, "NONE", ""))
        sound.writeframes(bytes(2 * 16000))
    document, _ = unpacked(caller.post("script", {"name": "intro"}))
    assert document["takes"][0]["spoken"]["labels"] == ["M", "AA"]
    assert document["sound"]["rate"] == 16000
    first = listed(caller)["lines"][0]
    assert (first["recording"], first["timings"]) == (True, True)


def test_a_very_long_script_is_not_read_for_each_line(folder, monkeypatch):
    monkeypatch.setattr(project_lines, "MAX_READ_AGAIN", 2)
    caller = Caller(workshop_of(folder, "english", "facefx"))
    listed(caller)
    (folder / "script.csv").unlink()
    assert caller.post("script", {"name": "intro"}).status == 200


def test_edits_of_a_line_are_performed_as_in_a_build(folder):
    home = folder / "characters"
    home.mkdir()
    edits = "{edits: [{word: 1, curves: {open: [[0, 0], [0.5, 1], [1, 0]]}}]}"
    (home / "facefx.yaml").write_text(
        f"kind: character\nformat: 1\nname: facefx\nposeset: facefx\nlines: {{intro: {edits}}}\n"
    )
    workshop = workshop_of(folder, "english", "facefx")
    for name, line in (("intro", "intro"), ("last", None)):
        workshop.open_script_line(name)
        assert workshop.settings.line == line


def times(document):
    return document["takes"][0]["spoken"]["times"]


def test_corrected_boundaries_stay_with_their_line(folder):
    caller = Caller(workshop_of(folder, "english", "facefx"))

    def opened(name):
        return times(unpacked(caller.post("script", {"name": name}))[0])

    first = opened("intro")
    caller.post("boundary/2", {"seconds": first[2] + 0.01})
    other = opened("last")
    caller.post("script", {"name": "intro"})
    caller.post("boundary/2", {"seconds": first[2] + 0.02})
    moved = opened("intro")
    assert moved[2] == pytest.approx(first[2] + 0.02)
    assert (moved[:2], moved[3:]) == (first[:2], first[3:])
    assert opened("last") == other
    assert opened("intro") == moved
    assert opened("last") == other
    later, _ = unpacked(caller.post("boundary/3", {"seconds": other[3] + 0.01}))
    caller.post("open", {"language": "finnish", "character": "facefx"})
    caller.post("script", {"name": "last"})
    caller.post("open", {"language": "english", "character": "facefx"})
    assert opened("last") == times(later)
    assert opened("intro") == moved
    original, _ = unpacked(caller.post("original"))
    assert times(original) == first
    (folder / "script.csv").write_text(SCRIPT.replace("five", "six"), "utf-8")
    caller.post("boundary/2", {"seconds": first[2] + 0.02})
    fresh, _ = unpacked(caller.post("script", {"name": "intro"}))
    assert fresh["text"] == "Please buy six maps."
    assert len(times(fresh)) != len(first)


def test_a_mark_and_times_stay_when_the_line_is_changed_in_another_language(folder):
    made = workshop_of(folder, "english", "facefx")
    caller = Caller(made)

    def opened(language, name="intro"):
        caller.post("open", {"language": language, "character": "facefx"})
        return times(unpacked(caller.post("script", {"name": name}))[0])

    moved, marked = {}, {"english": "Please buy *five* maps.", "finnish": "Osta *viisi* karttaa."}
    for language, text in marked.items():
        first = opened(language)
        made.text = text
        moved[language] = times(
            unpacked(caller.post("boundary/2", {"seconds": first[2] + 0.01}))[0]
        )
        assert moved[language] != first
    made.save()
    for language, text in marked.items():
        assert (opened(language), made.text) == (moved[language], text)
    stated = made.library().character("facefx").model.lines["intro"]
    assert (stated.language, stated.text) == ("english", marked["english"])
    assert stated.languages["finnish"].text == marked["finnish"]
    opened("finnish")
    caller.post("original")
    made.save()
    assert (opened("english"), made.text) == (moved["english"], marked["english"])


def test_a_text_of_no_stated_language_stays_with_its_own(folder):
    home = folder / "characters"
    home.mkdir()
    stated = "{intro: {text: Please buy *five* maps.}}"
    (home / "facefx.yaml").write_text(
        f"kind: character\nformat: 1\nname: facefx\nposeset: facefx\nlines: {stated}\n"
    )
    made = workshop_of(folder, "finnish", "facefx")
    made.open_script_line("intro")
    assert made.text == "Osta viisi karttaa."
    made.text = "Osta *viisi* karttaa."
    made.keep("Mark")
    made.save()
    for language, text in (("english", "Please buy *five* maps."), ("finnish", made.text)):
        made.open(language, "facefx")
        made.open_script_line("intro")
        assert made.text == text


def test_saved_timings_are_named_like_their_line(folder):
    caller = Caller(workshop_of(folder, "english", "facefx"))
    caller.post("script", {"name": "intro"})
    assert caller.api("timings/TextGrid").json["name"] == "intro.TextGrid"
    caller.post("line", {"text": "Hello"})
    assert caller.api("timings/TextGrid").json["name"] == "line.TextGrid"


def test_a_faulty_script_is_told_and_the_studio_goes_on(folder):
    (folder / "script.csv").write_text(SCRIPT.replace("reply", "intro"), "utf-8")
    caller = Caller(workshop_of(folder, "english", "facefx"))
    answer = caller.api("script")
    assert answer.status == 422
    assert "'intro'" in answer.json["error"]
    assert caller.post("line", {"text": "Hello"}).status == 200


def test_a_line_that_cannot_be_timed_is_told_with_its_place(folder):
    vo = folder / "vo/english"
    vo.mkdir(parents=True)
    (vo / "intro.TextGrid").write_text("no TextGrid", "utf-8")
    caller = Caller(workshop_of(folder, "english", "facefx"))
    answer = caller.post("script", {"name": "intro"})
    assert answer.status == 422
    assert "script.csv:2: " in answer.json["error"]


@pytest.mark.parametrize("text", [None, "kind: project\nformat: 1\n"])
def test_a_folder_without_a_script_has_no_lines(tmp_path, text):
    if text:
        Path(tmp_path, FILE).write_text(text)
    script = ProjectLines(tmp_path / FILE if text else None)
    made = Workshop(tmp_path, engine="none", script=script)
    made.open("english", "crab")
    assert listed(Caller(made))["count"] == 0


SEEDS = sorted(
    path
    for path in TESTS.glob("fuzz/seeds/lines/*/*.*")
    if path.read_bytes() and path.parent.name != "xlsx"
)


@pytest.mark.parametrize("seed", swept(SEEDS, quick=SEEDS[:1]), ids=lambda one: one.parent.name)
def test_lines_of_each_kind_of_script_open_and_are_counted(seed, tmp_path, monkeypatch, cli):
    monkeypatch.chdir(tmp_path)
    (tmp_path / seed.name).write_bytes(seed.read_bytes())
    made = cli("new", "--from", seed.name)
    assert made.code == 0, made.err
    caller = Caller(workshop_of(tmp_path, "english", "facefx"))
    rows = listed(caller)["lines"]
    assert rows
    for row in rows:
        document, _ = unpacked(caller.post("script", {"name": row["name"]}))
        assert (document["text"], document["script"]["name"]) == (row["text"], row["name"])
    assert caller.post("coverage/script", seed.read_bytes(), {"name": seed.name}).status == 200
    while (told := caller.api("coverage").json)["state"] == "counting":
        time.sleep(0.01)
    assert (told["state"], told["lines"]) == ("ready", len(rows)), told
    assert not [one for one in told["remarks"] if "/" in one]
