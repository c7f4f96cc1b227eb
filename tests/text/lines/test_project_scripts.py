"""Formats of scripts that a project states by paths."""

import pytest

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.production.builds.timing_formats import open_project
from lipsync_lang.text.lines import read_lines

PROJECT = """format: 1
kind: project
script_formats:
  talk:
    suffix: .json
    text: line.say
    id: key
    speaker: who
    note: hint
    state: state
    unready: [todo]
  scene:
    suffix: .scene
    entries: say|shout
    root: scene
    id: "@id"
    text: words|text
    speaker: "@who"
"""

JSON = """{"scenes": [{"lines": [
  {"key": "a", "who": "Anna", "line": {"say": "Hello."}},
  {"key": "b", "hint": "Speaker: Bo", "line": {"say": "Bye."}},
  {"key": "c", "state": "todo", "line": {"say": "Later."}}
]}]}
"""
XML = """<scene>
<say id="a" who="Anna"><words>Hello, <b>you</b>.</words></say>
<shout id="b"><text>Bye.</text></shout>
</scene>
"""


@pytest.fixture
def state(tmp_path):
    """State a project."""

    def run(project=PROJECT):
        (tmp_path / "lipsync.yaml").write_text(project)
        return open_project(tmp_path / "lipsync.yaml")

    yield run
    run("format: 1\nkind: project\n")


def told(path, **options):
    lines = read_lines(path, remark=lambda _: None, **options)
    return [(line.place.rpartition(":")[2], line.name, line.speaker, line.text) for line in lines]


def test_json_and_xml_are_read_by_their_paths(state, tmp_path):
    state()
    (tmp_path / "a.json").write_text(JSON)
    (tmp_path / "a.scene").write_text(XML)
    assert told(tmp_path / "a.json") == [("2", "a", "Anna", "Hello."), ("3", "b", "Bo", "Bye.")]
    assert told(tmp_path / "a.scene") == [
        ("2", "a", "Anna", "Hello, you."),
        ("3", "b", "", "Bye."),
    ]


def test_a_later_project_forgets_them(state, tmp_path):
    state()
    state("format: 1\nkind: project\n")
    (tmp_path / "a.scene").write_text(XML)
    with pytest.raises(LipsyncError, match=r"no reader of lines for '\.scene'"):
        told(tmp_path / "a.scene")


def test_formats_lists_them_and_faults_have_their_places(state, cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    state()
    assert "talk" in cli("formats").out
    (tmp_path / "lipsync.yaml").write_text(PROJECT + "  xliff: {suffix: .x, text: a}\n")
    assert "lipsync.yaml:19:3: P106 there is a format 'xliff' already" in cli("validate").out
    (tmp_path / "lipsync.yaml").write_text(PROJECT + "  b: {suffix: .y, entries: a, text: b}\n")
    assert "lipsync.yaml:19:28: P115 `entries` of XML need an `id`" in cli("validate").out


def test_validate_says_which_path_finds_nothing_in_a_file(state, cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    state()
    (tmp_path / "a.json").write_text(JSON)
    (tmp_path / "a.scene").write_text(XML)
    assert cli("validate", "a.json", "a.scene").code == 0
    (tmp_path / "a.json").write_text(JSON.replace('"say"', '"said"'))
    (tmp_path / "a.scene").write_text("<scene><line/></scene>")
    told = cli("validate", "a.json", "a.scene").out.splitlines()
    assert [one.partition("; ")[0].partition(": P409 does not fit ")[::2] for one in told] == [
        (
            "lipsync.yaml:4:3",
            "a.json: has no object with a text at `line.say`, so it is not talk",
        ),
        ("lipsync.yaml:12:3", "a.scene: has no <say> or <shout>, so it is not scene"),
    ]
