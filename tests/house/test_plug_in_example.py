"""The example distribution, after installation: a writer, a reader, an engine and a command."""

import json
import os
import shutil
import sys

import pytest
from lanes import full
from test_sharing import run

pytestmark = full

NAME = "lipsync-lang-xsheet"
TRACK = "track 24\n1\t-\n3\tHH\n5\tEH\n8\tL\n10\tOW\n16\t-\n20\n"
LANGUAGE = """\
kind: language
format: 1
name: letters
tag: x-letters
notations: {letters: {m: bmp, a: aa}}
tts: {engine: metronome, voice: "600"}
"""


@pytest.fixture(scope="module")
def site(root, tmp_path_factory):
    """Build the example without a network, and install it into a separate folder."""
    pytest.importorskip("hatchling", reason="the dev extra is not installed")
    folder = tmp_path_factory.mktemp("plug-in")
    shutil.copytree(root / "docs/examples" / NAME, folder / NAME)
    options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--no-index"]
    options += ["--no-build-isolation", "--target", folder / "site"]
    done = run(sys.executable, "-m", "pip", "install", *options, folder / NAME)
    assert done.code == 0, done.err
    return folder / "site"


@pytest.fixture
def start(site, tmp_path, monkeypatch):
    """Run a command in an empty folder, with the example installed."""
    path = [str(site), os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, path)))
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / ".cache"))
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: run(sys.executable, "-m", "lipsync_lang", *arguments)


def test_formats_lists_what_it_brings(start):
    done = start("formats", "--json")
    assert (done.code, done.err) == (0, "")
    rows = {(row["direction"], row["name"]): row["suffix"] for row in json.loads(done.out)}
    assert rows["write", "exposure-sheet"] == ".xsheet"
    assert rows["read", "track-sheet"] == ".track"
    assert rows["write", "mp4"] == ".mp4"


def test_its_formats_are_read_and_written(start, tmp_path):
    (tmp_path / "line.track").write_text(TRACK)
    pair = ("-l", "english", "-c", "facefx", "--fps", "24")
    done = start("run", "--schedule", "line.track", *pair, "-o", "line.xsheet", "-o", "line.csv")
    assert done.code == 0, done.err
    head, *rows = (tmp_path / "line.xsheet").read_text().splitlines()
    assert head == "xsheet 24"
    frames = [int(row.split("\t")[0]) for row in rows]
    assert frames[0] == 1
    assert frames == sorted(set(frames))


def test_a_fault_in_its_file_is_a_message(start, tmp_path):
    (tmp_path / "line.track").write_text("track 24\n1\tHH\nlate\tEH\n9\n")
    done = start("run", "--schedule", "line.track", "-l", "english", "-c", "facefx")
    assert done.code == 2
    assert done.err.startswith("lipsync-lang: line.track:3: ")


def test_its_engine_speaks_the_languages_that_name_it(start, tmp_path):
    assert "600" in json.loads(start("voices", "metronome", "--json").out)
    (tmp_path / "languages").mkdir()
    (tmp_path / "languages/letters.yaml").write_text(LANGUAGE)
    done = start("run", "mama ma", "-l", "letters", "-c", "facefx", "-o", "line.csv")
    assert done.code == 0, done.err
    assert "7 phonemes" in done.err
    done = start("run", "mama", "-l", "letters", "-c", "facefx", "--tts", "metronom")
    assert (done.code, "did you mean 'metronome'" in done.err) == (2, True)


def test_its_command_is_listed_and_runs(start, tmp_path):
    (tmp_path / "line.track").write_text(TRACK)
    assert "xsheet" in start("--help").out
    done = start("xsheet", "line.track")
    assert (done.code, done.err) == (0, "")
    rows = dict(row.split("\t") for row in done.out.splitlines())
    assert list(rows) == [str(frame) for frame in range(1, 20)]
    assert [rows[frame] for frame in ("2", "3", "4", "5", "16")] == ["-", "HH", "HH", "EH", "-"]
    assert start("xsheet", "none.track").code == 2
