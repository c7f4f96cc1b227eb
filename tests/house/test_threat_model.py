"""The threat model: each row of its table names an existing test."""

import ast
import os
import re
import socket
import sys
import tracemalloc
from pathlib import Path

import pytest
from lanes import full, needs_plug_ins, swept
from places import TESTS

import lipsync_lang as ll
from lipsync_lang.base.errors import LipsyncError, SpeechError
from lipsync_lang.packs.finding import beside
from lipsync_lang.pipeline.motion import LEAST_SPEED
from lipsync_lang.schedules.timing_file import ROOT_TAG, TimingFile
from lipsync_lang.sound.speech.hearing.sphinx.folder import find_models, project_models
from lipsync_lang.text.lines.markup import spoken
from lipsync_lang.text.phonology.labels import looser

PAGE = TESTS.parent / "docs" / "explanation" / "threat-model.md"
ROW = re.compile(r"`(tests/[\w/]+\.py)::(\w+)` \|$", re.MULTILINE)

CHARACTER = "kind: character\nformat: 1\nname: mine\nposeset: facefx\nmodel: {model}\n"


@pytest.fixture
def project(tmp_path, monkeypatch):
    """A project below a folder with a secret, without a cache."""
    (tmp_path / "secret.glb").write_bytes(b"secret")
    folder = tmp_path / "project"
    (folder / "characters").mkdir(parents=True)
    monkeypatch.chdir(folder)
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", "off")
    return folder


@needs_plug_ins
def test_every_row_of_the_table_names_a_test_that_exists():
    rows = ROW.findall(PAGE.read_text(encoding="utf-8"))
    body = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    assert len(rows) == len(body) - 1, "a row without a test"
    for file, name in rows:
        tree = ast.parse((TESTS.parent / file).read_text(encoding="utf-8"))
        names = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
        assert name in names, f"{file} has no {name}"
    own = {name for name in globals() if name.startswith("test_")}
    listed = {name for file, name in rows if file.endswith(Path(__file__).name)}
    assert own - listed == {"test_every_row_of_the_table_names_a_test_that_exists"}


@pytest.mark.parametrize("way", ["parents", "absolute", "link", "link to a folder"])
def test_a_pack_reaches_no_file_outside_its_folder(project, cli, way):
    secret = project.parent / "secret.glb"
    model = "../../secret.glb"
    if way == "absolute":
        model = str(secret)
    elif way == "link":
        (project / "characters" / "face.glb").symlink_to(secret)
        model = "face.glb"
    elif way == "link to a folder":
        (project / "characters" / "up").symlink_to(project.parent)
        model = "up/secret.glb"
    pack = project / "characters" / "mine.yaml"
    pack.write_text(CHARACTER.format(model=model))
    assert beside(pack, model) is None
    (project / "characters" / "own.glb").write_bytes(b"own")
    assert beside(pack, "own.glb") is not None, "its own files it reaches"
    ended = cli("validate", "characters/mine.yaml")
    assert ended.code == 1
    assert "mine.yaml:5:8: P213" in ended.out


SPEECH = """kind: language
format: 1
name: kin
tag: en-x-kin
extends: english
audio: {{{audio}}}
"""

MODELS = {
    "above": "model: ../../outside",
    "absolute": "model: {outside}",
    "home": "model: ~/outside",
    "linked folder": "model: ../models/linked",
    "linked file": "model: ../models/holey",
    "aligner": "align: ['pocketsphinx:../../outside', warp]",
    "recogniser": "recognise: 'pocketsphinx:../../outside'",
}


@pytest.mark.parametrize("stated", MODELS.values(), ids=MODELS)
def test_a_pack_names_no_model_outside_its_folder(project, cli, stated):
    outside = project.parent / "outside"
    outside.mkdir()
    (outside / "means").write_bytes(b"s3\n")
    (project / "models" / "holey").mkdir(parents=True)
    (project / "models" / "linked").symlink_to(outside)
    (project / "models" / "holey" / "means").symlink_to(outside / "means")
    (project / "languages").mkdir(exist_ok=True)
    pack = project / "languages" / "kin.yaml"
    pack.write_text(SPEECH.format(audio=stated.format(outside=outside)))
    ended = cli("validate", "languages/kin.yaml")
    assert ended.code == 1
    assert "kin.yaml:6:" in ended.out
    assert "P213 the model" in ended.out
    assert "leads outside" in ended.out
    ended = cli("transcribe", "hello", "-l", "kin")
    assert ended.code == 2
    assert "leads outside" in ended.err
    if "~" not in stated:
        assert cli("validate", "languages/kin.yaml", "--path", str(outside)).code == 0


@pytest.mark.parametrize("name", ["linked", "holey", ".", ".."])
def test_a_model_of_a_project_leads_nowhere_else(project, name):
    outside = project.parent / "outside"
    outside.mkdir()
    (outside / "means").write_bytes(b"s3\n")
    (project / "models" / "holey").mkdir(parents=True)
    (project / "models" / "linked").symlink_to(outside)
    (project / "models" / "holey" / "means").symlink_to(outside / "means")
    (project / "models" / "own").mkdir()
    with pytest.raises(SpeechError, match=r"leads outside the project|has no model"):
        find_models(name)
    assert [path.name for path in project_models()] == ["own"]


PRIVATE = "my own words"

GAME = """kind: project
format: 1
language: english
character: facefx
lines: {lines}
audio: "vo/{{id}}.wav"
outputs: takes/{{id}}.csv
reports: {reports}
"""

RUN = ("run", "hello", "--tts", "none", "-o", "a.csv")
BUILD = ("build", "--tts", "none")
STUDY = (
    "study",
    "new",
    "script.csv",
    "-l",
    "english",
    "-c",
    "facefx",
    "--method",
    "ours",
    "--method",
    "held",
    "-o",
    "study",
)
LINKS = {
    "lipsync.yaml": RUN,
    "languages/mine.yaml": ("languages",),
    "languages/sub/mine.yaml": ("validate",),
    "languages": ("languages",),
    "posesets/mine": ("posesets",),
    "posesets/facefx/banks": ("resolve",),
    "characters": RUN,
    "characters/mine.yaml": RUN,
    "script.csv": BUILD,
    "script": BUILD,
    "vo": BUILD,
    "vo/a.TextGrid": BUILD,
    "vo/a.wav": BUILD,
    "coverage.csv": ("coverage", "--json"),
    "takes": BUILD,
    ".lipsync_lang": BUILD,
    ".lipsync_lang/build.sqlite": BUILD,
    "build": BUILD,
    "build/report.html": BUILD,
    "build/report-lines": BUILD,
    "study": STUDY,
    "study/clips": STUDY,
}
"""Links of a project, and a command that meets each."""


@pytest.fixture
def game(project):
    """A project with a script, below a folder of secrets that look like its own files."""
    outside = project.parent / "outside"
    outside.mkdir()
    for name in ("mine.yaml", "poseset.yaml", "common.yaml", "a.TextGrid", "a.wav", "script.csv"):
        (outside / name).write_text(f"{PRIVATE}: {PRIVATE}\n")
    (project / "characters").rmdir()
    (project / "script.csv").write_text("id,text\na,hello\n")
    (project / "lipsync.yaml").write_text(
        GAME.format(lines="script.csv", reports="build/report.html")
    )
    return project


def everything(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


QUICK = ("characters/mine.yaml", "script.csv", "vo/a.TextGrid", "coverage.csv", "build/report.html")


@pytest.mark.parametrize("link", swept(LINKS, quick=QUICK))
def test_a_project_reads_and_writes_nothing_outside_by_a_link(game, cli, link):
    outside = game.parent / "outside"
    path = game / link
    target = outside if not path.suffix or path.suffix == ".sqlite" else outside / "mine.yaml"
    lines = {"script": "script", "coverage.csv": "coverage.csv"}.get(link, "script.csv")
    (game / "lipsync.yaml").write_text(GAME.format(lines=lines, reports="build/report.html"))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.unlink(missing_ok=True)
    if link == ".lipsync_lang/build.sqlite":
        target = outside / "a.wav"
    path.symlink_to(target)
    before = everything(outside)
    command = LINKS[link]
    if link.startswith("build/report-lines"):
        limits = "limits: {speed: 0.001}\n"
        (game / "lipsync.yaml").write_text((game / "lipsync.yaml").read_text() + limits)
    ended = cli(*command)
    assert ended.code in {1, 2}
    assert "leads outside" in ended.out + ended.err
    assert PRIVATE not in ended.out + ended.err
    assert everything(outside) == before
    if command[0] != "study":
        assert cli(*command, "--path", str(outside)).err.count("leads outside") == 0
        assert cli(*command).err.count("leads outside") == 0, "named once"


@pytest.mark.parametrize(
    ("stated", "code"),
    [("../outside", 1), ("/etc/passwd", 1), ("//server/share", 1), ("own", 0), ("script.csv", 1)],
)
def test_folders_of_packs_outside_are_named_by_the_user(game, cli, stated, code, monkeypatch):
    (game / "own").mkdir()
    (game.parent / "outside/languages").mkdir()
    text = (game / "lipsync.yaml").read_text()
    (game / "lipsync.yaml").write_text(f"{text}paths: [{stated}]\n")
    seen = []
    looked = os.stat
    monkeypatch.setattr(
        os, "stat", lambda path, *a, **k: seen.append(str(path)) or looked(path, *a, **k)
    )
    ended = cli("validate", "--no-tests")
    assert ended.code == code
    assert ("lipsync.yaml:9:9: P106" in ended.out) == bool(code)
    assert not [path for path in seen if path.endswith(("passwd", "share"))], "not even looked at"
    if stated == "../outside":
        assert cli("run", "hello", "--tts", "none").code == 1
        assert cli("run", "hello", "--tts", "none", "--path", stated).code == 0
        assert cli("validate", "--no-tests").code == 0, "named once"
        (game.parent / "outside").rename(game.parent / "elsewhere")
        (game.parent / "elsewhere/other").mkdir()
        (game / "lipsync.yaml").write_text(f"{text}paths: [../elsewhere]\n")
        assert cli("validate", "--no-tests").code == 1, "another folder is another name"
        monkeypatch.setenv("LIPSYNC_LANG_PATH", str(game.parent / "elsewhere"))
        assert cli("validate", "--no-tests").code == 0


@pytest.mark.parametrize("name", ["../facefx", "/etc/passwd", "..", "a/../../b"])
def test_a_name_of_a_pack_is_no_path(project, cli, name):
    pack = project / "characters" / "mine.yaml"
    pack.write_text(f"kind: character\nformat: 1\nname: mine\nposeset: {name}\n")
    ended = cli("validate", "characters/mine.yaml")
    assert ended.code == 1
    assert "mine.yaml:4:10: P" in ended.out


@pytest.mark.parametrize("tag", ["!!python/object/apply:os.system ['touch ran']", "!include x"])
def test_a_pack_runs_nothing(project, cli, tag):
    pack = project / "characters" / "mine.yaml"
    pack.write_text(f"kind: character\nformat: 1\nname: mine\nposeset: facefx\ntitle: {tag}\n")
    ended = cli("validate", "characters/mine.yaml")
    assert ended.code == 1
    assert "mine.yaml:5:" in ended.out
    assert not (project / "ran").exists()


def test_nothing_opens_a_connection(project, monkeypatch):
    def refused(*_arguments, **_named):
        raise AssertionError("a connection was opened")

    monkeypatch.setattr(socket, "socket", refused)
    monkeypatch.setattr(socket, "create_connection", refused)
    file = project / "line.json"
    file.write_text('{"phonemes": [{"label": "AA", "start": 0, "end": 0.5}]}')
    performer = ll.resolve("english", "facefx")
    assert performer.perform(ll.read_schedule(file)).weights.size


@pytest.mark.parametrize("entity", ["<!DOCTYPE a [<!ENTITY b 'c'>]>", "<!ENTITY a 'b'>"])
def test_xml_reads_no_entities(project, entity):
    file = project / "line.xml"
    file.write_text(f"<?xml version='1.0'?>{entity}<bml/>")
    with pytest.raises(LipsyncError, match="which is never read; remove it"):
        _ = TimingFile.of(file).xml


def test_the_definition_of_an_xml_document_is_not_read(project):
    file = project / "line.xml"
    file.write_text("<!DOCTYPE a SYSTEM 'file:///etc/passwd'><bml>&a;</bml>")
    with pytest.raises(LipsyncError, match="not XML: undefined entity"):
        _ = TimingFile.of(file).xml


def test_remarks_before_xml_are_passed_over_once():
    for remark in ("<??>", "<!---->", "<?a?> "):
        assert ROOT_TAG.match(remark * 200 + "x") is None, "exponential until it was possessive"
        assert ROOT_TAG.match(remark * 200 + "<bml>")[1] == "bml"


def test_the_slowest_speed_keeps_the_lead_in_short(project, cli):
    file = project / "line.json"
    file.write_text('{"phonemes": [{"label": "AA", "start": 0, "end": 0.5}]}')
    slow = ll.resolve("english", "facefx").with_motion({"speed_limit": LEAST_SPEED})
    assert -1.1 <= slow.perform(ll.read_schedule(file), fps=60).times[0] <= 0
    pack = project / "characters" / "mine.yaml"
    pack.write_text(
        "kind: character\nformat: 1\nname: mine\nposeset: facefx\nmotion: {speed_limit: 0.001}\n"
    )
    ended = cli("validate", "characters/mine.yaml")
    assert "mine.yaml:5:23: P104" in ended.out
    assert "hint: write a number that is at least 1" in ended.out


def calls(work, *arguments):
    """Count the functions that are called by an action."""
    count = 0

    def counted(_frame, event, _argument):
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(counted)
    try:
        work(*arguments)
    finally:
        sys.setprofile(None)
    return count


def peak_bytes(work, *arguments):
    tracemalloc.start()
    try:
        work(*arguments)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def written(folder, seconds):
    rows = ",".join(f'{{"label": "AA", "start": {i}, "end": {i + 1}}}' for i in range(seconds))
    file = folder / f"{seconds}.json"
    file.write_text(f'{{"phonemes": [{rows}]}}')
    return file


@full
@pytest.mark.parametrize("measure", [calls, peak_bytes])
def test_timings_cost_in_step_with_their_size(project, measure):
    ll.read_schedule(written(project, 10))  # what is imported and kept is paid once
    # large enough that the buffer of 1 MB is no part of the peak
    short, long = (measure(ll.read_schedule, written(project, n)) for n in (8000, 16000))
    assert 1.5 * short < long < 2.5 * short


@pytest.mark.parametrize(
    "text", ["<rt>", "[a]", "{b}", "a "], ids=["ruby", "brackets", "braces", "words"]
)
def test_lines_cost_in_step_with_their_size(text):
    short, long = (calls(spoken, text * n) for n in (1000, 2000))
    assert long < 2.5 * short


def test_labels_lose_their_tones_in_one_pass():
    assert [*looser("ma35")][2] == "ma"
    assert [*looser("35")][2] == "3", "never the whole label"
    long = "a" + "1" * 100_000 + "b"
    assert {*looser(long)} == {long}


@pytest.mark.skipif(os.name == "nt", reason="POSIX permissions")
def test_the_cache_belongs_to_its_user(project, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(project / "kept"))
    ll.resolve("english", "facefx")
    files = [file for file in (project / "kept").rglob("*") if file.is_file()]
    assert files
    assert not any(file.stat().st_mode & 0o022 for file in files)
