"""A project's `lipsync.yaml`: its fields, its place, and its limits."""

import json
from pathlib import Path

import pytest
from lanes import full, needs_plug_ins

from lipsync_lang.commands.parser import parser
from lipsync_lang.commands.registry import leaves
from lipsync_lang.packs.describe import schema
from lipsync_lang.packs.project import find_project

LINE = '[{"label": "HH", "start": 0, "end": 0.1}, {"label": "AY", "start": 0.1, "end": 0.3}]'
PROJECT = """\
kind: project
format: 1
language: english
character: FaceFX
fps: 30
outputs: ["takes/{line}.csv", "json:takes/{line}.data"]
"""


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A repository with a project, and a folder below it with a schedule."""
    (tmp_path / ".git").mkdir()
    (tmp_path / "lipsync.yaml").write_text(PROJECT)
    (tmp_path / "below").mkdir()
    (tmp_path / "below/hello.json").write_text(LINE)
    monkeypatch.chdir(tmp_path / "below")
    return tmp_path


def state(project, **changed):
    """Change fields of the project."""
    lines = dict(line.split(": ", 1) for line in PROJECT.splitlines()) | changed
    (project / "lipsync.yaml").write_text("".join(f"{k}: {v}\n" for k, v in lines.items()))


def test_a_line_is_enough_in_a_project(cli, project):
    ended = cli("run", "--schedule", "hello.json")
    assert (ended.code, ended.out) == (0, "")
    assert "at 30 fps" in ended.err
    assert f"wrote {Path('../takes/hello.csv')}" in ended.err
    assert json.loads((project / "takes/hello.data").read_text())["fps"] == 30


@needs_plug_ins
def test_the_sound_begins_at_the_projects_offset(cli, project):
    state(project, offset="0.75")
    for own, start in [((), "0.75"), (("--offset", "0.5"), "0.5")]:
        assert cli("run", "--schedule", "hello.json", "-o", "hello.tres", *own).code == 0
        text = Path("hello.tres").read_text(encoding="utf-8")
        assert f"metadata/audio_start = {start}\n" in text


@full
def test_the_command_line_wins(cli, project):
    given = ("-l", "finnish", "-c", "oculus", "--fps", "24", "-o", "own.csv")
    assert cli("run", "--schedule", "hello.json", *given, "--notation", "arpabet").code == 2
    ended = cli("run", "--schedule", "hello.json", *given[2:])
    assert "at 24 fps" in ended.err
    assert (project / "below/own.csv").is_file()
    assert not (project / "takes").exists()


@full
def test_motion_is_the_projects_unless_the_command_line_says_otherwise(cli, project):
    def curves(*more):
        return cli("run", "--schedule", "hello.json", "-o", "csv:-", *more).out

    plain = curves()
    state(project, motion="{speed_limit: 8}")
    slow = curves()
    assert slow != plain
    assert slow == curves("--set", "motion.speed_limit=8")
    assert curves("--set", "motion.speed_limit=9") != slow
    state(project, motion="paper")
    paper = curves()
    state(project, motion="{preset: paper, speed_limit: 8}")
    assert curves("--set", "motion=paper") == paper


@full
def test_an_output_is_called_by_the_words_of_its_line(cli, project):
    ended = cli("run", "Hi, you / there!", "--tts", "none")
    assert ended.code == 0
    assert (project / "takes/Hi-you-there.csv").is_file()


@full
def test_packs_of_the_project_are_found_below_it(cli, project):
    (project / "more/characters").mkdir(parents=True)
    (project / "characters").mkdir()
    for folder, name in (("characters", "ann"), ("more/characters", "bob")):
        text = f"kind: character\nformat: 1\nname: {name}\nposeset: facefx\n"
        (project / folder / f"{name}.yaml").write_text(text)
    state(project, character="ann", paths="more")
    assert cli("resolve").out.startswith("english on ann ")
    assert cli("resolve", "-c", "bob").out.startswith("english on bob ")


def test_it_is_found_up_to_the_root_of_the_repository_only(project, tmp_path):
    assert find_project() == project / "lipsync.yaml"
    (project / "below/.git").mkdir()
    assert find_project() is None
    (project / "below/.git").rmdir()
    (project / ".git").rmdir()
    assert find_project() is None, "without a repository, only the folder itself counts"
    assert find_project(tmp_path) == project / "lipsync.yaml"


def test_every_fault_is_told_where_it_is(cli, project, monkeypatch):
    monkeypatch.chdir(project)
    state(project, language="englsh", character="facfx", fps="fast", outputs='["../a.csv"]')
    with (project / "lipsync.yaml").open("a") as out:
        out.write("outptus: x\n")
    ended = cli("validate", "--no-tests", "lipsync.yaml")
    assert ended.code == 1
    places = [line.split(" ")[:2] for line in ended.out.splitlines() if line.startswith("lipsync")]
    assert places == [
        ["lipsync.yaml:3:11:", "P210"],
        ["lipsync.yaml:4:12:", "P203"],
        ["lipsync.yaml:5:6:", "P106"],
        ["lipsync.yaml:6:11:", "P106"],
        ["lipsync.yaml:7:1:", "P101"],
    ]
    assert "23.976" in ended.out
    assert cli("run", "hi").code == 1


@pytest.mark.parametrize("output", ["../a.csv", "/a.csv", "csv:../a", "a/../../b.csv", "C:\\a.csv"])
def test_outputs_lie_in_the_project(cli, project, output):
    state(project, outputs=json.dumps(output))
    ended = cli("run", "--schedule", "hello.json")
    assert ended.code == 1
    assert "is outside the project's folder" in ended.err


@pytest.mark.parametrize("output", ["csv:csv:/tmp/a.csv", "csv:csv:takes/{id}.csv", "csv:ab:c.csv"])
def test_an_output_names_its_format_once(cli, project, output):
    state(project, outputs=json.dumps(output))
    ended = cli("run", "--schedule", "hello.json")
    assert ended.code == 1
    assert "has a ':', which Windows does not allow" in ended.err
    assert not [path for path in project.iterdir() if ":" in path.name]


def test_outputs_do_not_leave_the_project_by_a_link(cli, project, tmp_path_factory):
    elsewhere = tmp_path_factory.mktemp("elsewhere")
    (project / "takes").symlink_to(elsewhere)
    ended = cli("run", "--schedule", "hello.json")
    assert ended.code == 2
    assert "leads outside" in ended.err
    assert not list(elsewhere.iterdir())


@pytest.mark.parametrize(
    "command", [("run", "hi"), ("resolve",), ("transcribe", "hi"), ("coverage", "hello.json")]
)
def test_without_a_project_what_is_missing_is_said(cli, project, command):
    (project / "lipsync.yaml").unlink()
    ended = cli(*command)
    assert ended.code == 2
    assert ended.err == (
        "lipsync-lang: a language is missing: give -l LANGUAGE, or state `language: ...` in "
        "lipsync.yaml\n"
    )


@full
def test_commands_that_count_and_explain_take_it_too(cli, project):
    assert "english on facefx" in cli("coverage", "hello.json").out
    assert cli("explain", "--schedule", "hello.json", "--at", "0.1").code == 0
    assert project


def test_every_command_that_finds_packs_looks_for_the_project():
    for path, made in leaves(parser()):
        finds = "--path" in made._option_string_actions  # noqa: SLF001
        assert (made.get_default("in_project") is not None) == finds, path


def test_editors_may_write_every_form():
    fields = schema("project")["properties"]
    assert {"type": "number", "minimum": 1} in fields["fps"]["anyOf"]
    assert {"type": "string"} in fields["motion"]["anyOf"]


@pytest.mark.parametrize("field", ["scheduler", "to"])
def test_a_project_names_no_machine(cli, tmp_path, monkeypatch, field):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lipsync.yaml").write_text(f"{PROJECT}{field}: tcp://10.0.0.5:8786\n", "utf-8")
    ended = cli("validate", "lipsync.yaml")
    assert ended.code == 1
    assert f"P101 unknown field `{field}`" in ended.out
