"""Formats of timings that a project states by paths and names of fields."""

import json
import pickle

import pytest

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.production.builds.making import LineBatch, LineMaker
from lipsync_lang.production.builds.needs import BuildSettings
from lipsync_lang.production.builds.timing_formats import (
    open_project,
    plain_formats,
    use_timing_formats,
)
from lipsync_lang.schedules.timing_readers import TIMING_READERS, read_timings

PROJECT = """format: 1
kind: project
timing_formats:
  our-service:
    phonemes: {records: "result[0].phones", text: symbol, start: from, end: to}
    words: {records: result.said, text: word, start: from, duration: long}
    unit: ms
    notation: arpabet
"""


@pytest.fixture(autouse=True)
def _forget():
    yield
    TIMING_READERS.drop("lipsync.yaml")


@pytest.fixture
def read(tmp_path):
    """State a project, and read a JSON file in its format."""

    def run(document, project=PROJECT, **options):
        (tmp_path / "lipsync.yaml").write_text(project)
        open_project(tmp_path / "lipsync.yaml")
        (tmp_path / "a.json").write_text(json.dumps(document))
        return read_timings(tmp_path / "a.json", **options)

    return run


def phone(label, start, end):
    return {"symbol": label, "from": start, "to": end}


PHONES = {"phones": [phone("M", 0, 90), phone("AE1", 90, 240)]}
WORDS = {"said": [{"word": "ma", "from": 0, "long": 240}]}


def test_a_format_of_a_project_is_recognised_by_its_fields(read):
    schedule = read({"result": [{**PHONES, **WORDS}, {"phones": [phone("P", 300, 400)]}]})
    assert schedule.labels == ("M", "AE1")
    assert schedule.times.tolist() == [0, 0.09, 0.24]
    assert schedule.notation == "arpabet"
    assert [word.text for word in schedule.words] == ["ma"]


def test_words_alone_and_another_rate(read):
    timed = read({"result": WORDS}, PROJECT.replace("unit: ms", "rate: 100"))
    assert [(word.text, word.end) for word in timed.words] == [("ma", 2.4)]


def test_columns_and_fields_within_fields(read):
    project = PROJECT.replace("end: to}", "end: to, columns: true}")
    columns = {"symbol": ["M", "AE1"], "from": [0, 90], "to": [90, 240]}
    assert read({"result": {"phones": columns}}, project).labels == ("M", "AE1")
    project = PROJECT.replace("text: word, ", 'text: "ways[0].word", untimed: true, ')
    said = [{"ways": [{"word": "ma"}], "from": 0, "long": 240}, {"ways": [{"word": "."}]}]
    assert [word.text for word in read({"result": {"said": said}}, project).words] == ["ma"]


def test_outermost_objects_are_records_without_a_path(read):
    project = PROJECT.replace('records: "result[0].phones", ', "").replace("records: result.", "#")
    project = "\n".join(line for line in project.splitlines() if "#" not in line)
    assert read(PHONES["phones"], project).labels == ("M", "AE1")


@pytest.mark.parametrize(
    ("document", "message"),
    [
        ({"result": {"phones": [phone("M", 0, 90), {"symbol": "P", "to": 1}]}}, "record 2 has no"),
        ({"result": {"phones": [{"from": 0, "to": 90}]}}, "record 1 has no 'symbol'"),
        ({"result": {"phones": 5}}, "`phones` must be a list of objects"),
        ({"result": {"phones": [phone("M", [], 90)]}}, "list is not a time"),
        ({}, "no records of our-service at `result[0].phones` or `result.said`"),
    ],
)
def test_a_file_that_does_not_fit_is_refused(read, document, message):
    with pytest.raises(LipsyncError, match=r"a\.json") as refused:
        read(document, read_as="our-service")
    assert message in str(refused.value)


def test_a_file_of_no_format_is_told_those_of_the_project(read):
    with pytest.raises(LipsyncError, match=r"end in '.json':(.|\n)*\n  our-service: Timings of"):
        read({"result": {}})


def test_faults_of_rows_have_their_places(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = """  json:
    words: {text: a, start: b, end: c}
  textgrid:
    words: {text: a, start: b, duration: c}
"""
    (tmp_path / "lipsync.yaml").write_text(PROJECT + rows)
    ended = cli("validate")
    assert "lipsync.yaml:9:3: P106 there is a format 'json' already" in ended.out
    assert "lipsync.yaml:11:3: P106 there is a format 'textgrid' already" in ended.out
    rows = """  two:
    words: {text: a, start: b}
  none:
    unit: hours
  both:
    words: {text: a, start: b, end: c}
    unit: ms
    rate: 30
"""
    (tmp_path / "lipsync.yaml").write_text(PROJECT + rows)
    ended = cli("validate")
    assert "lipsync.yaml:10:29: P115 records need `end` or `duration`" in ended.out
    assert "lipsync.yaml:12:11: P107" in ended.out
    assert "lipsync.yaml:16:11: P115 the format has `unit` and `rate`" in ended.out


def test_formats_lists_those_of_the_project(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lipsync.yaml").write_text(PROJECT)
    assert "our-service" in cli("formats").out


def test_formats_lists_the_built_in_ones_beside_an_unsound_project(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lipsync.yaml").write_text(PROJECT + "colour: red\n")
    ended = cli("formats")
    assert "textgrid" in ended.out
    assert ended.code == 0
    assert "lipsync.yaml:9:1" in ended.err


def test_a_later_project_has_no_formats_of_an_earlier_one(read):
    read({"result": [PHONES]})
    with pytest.raises(LipsyncError, match="has none of the formats"):
        read({"result": [PHONES]}, "format: 1\nkind: project\n")


def test_workers_know_the_formats_of_the_project(tmp_path):
    (tmp_path / "lipsync.yaml").write_text(PROJECT)
    stated = plain_formats(open_project(tmp_path / "lipsync.yaml").model.timing_formats)
    use_timing_formats({})
    maker = LineMaker(tmp_path, BuildSettings(60, {}, timing_formats=stated))
    assert "our-service" not in TIMING_READERS
    sent = pickle.loads(pickle.dumps(maker))  # noqa: S301 our own
    sent(LineBatch("none", (), ()), {})
    assert "our-service" in TIMING_READERS


def test_validate_tries_the_formats_on_a_file_and_says_where_they_end(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lipsync.yaml").write_text(PROJECT)
    path = tmp_path / "a.json"
    path.write_text(json.dumps({"result": [{**PHONES, **WORDS}]}))
    assert cli("validate", "a.json").code == 0
    path.write_text(json.dumps({"result": [{"said": [], "sounds": []}]}))
    ended = cli("validate", "a.json")
    assert ended.code == 1
    assert "lipsync.yaml:4:3: P409 does not fit a.json: has no records of our-service" in ended.out
    assert "there is no `phones` among said, sounds" in ended.out
    path.write_text(json.dumps({"result": {"phones": [phone("M", 0, 90), {"symbol": "P"}]}}))
    assert "does not fit a.json: record 2 has no 'from'" in cli("validate", "a.json").out
    path.write_bytes('{"result": "Ä"}'.encode("cp1252"))
    assert cli("validate", "a.json").out.strip().endswith("save it as UTF-8")


def test_validate_tries_the_formats_on_the_timings_of_lines(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rows = "lines: script.csv\nlanguages: [english]\ncharacter: facefx\noutputs: 'out/{id}.csv'\n"
    (tmp_path / "lipsync.yaml").write_text(f"{PROJECT}{rows}timings: '{{id}}.json'\n")
    (tmp_path / "script.csv").write_text("id,text\na,Ma.\nb,Pa.\n")
    (tmp_path / "a.json").write_text(json.dumps({"result": [{**PHONES, **WORDS}]}))
    (tmp_path / "b.json").write_text(json.dumps({"result": [{"phones": [phone("M", "x", 90)]}]}))
    (fault,) = cli("validate", "--no-tests").out.strip().splitlines()
    assert fault.startswith("lipsync.yaml:4:3: P409 does not fit ")
    assert "b.json: 'x' is not a time" in fault


def test_a_file_needs_formats_to_be_tried(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.json").write_text("{}")
    assert "a.json: no pack, and the project here has no" in cli("validate", "a.json").err
    (tmp_path / "a.bin").write_text("x")
    (tmp_path / "lipsync.yaml").write_text(PROJECT)
    assert "a.bin: no pack, and the project here has no" in cli("validate", "a.bin").err
