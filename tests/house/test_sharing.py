"""The example distribution with a language, after installation."""

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import NamedTuple

import pytest
from lanes import full

NAME = "lipsync-lang-hawaiian"
PACK = Path("lipsync_lang_hawaiian/languages/hawaiian.yaml")
OWN = """\
kind: language
format: 1
name: hawaiian
tag: haw
extends: hawaiian
words: {kai: [kg, ay]}
"""
"""A project's pack of the same name, with a word of its own."""


class Done(NamedTuple):
    """Result of a command."""

    code: int
    out: str
    err: str


def run(*command, **rest):
    rest = {"capture_output": True, "encoding": "utf-8", "timeout": 300} | rest
    done = subprocess.run([str(part) for part in command], check=False, **rest)
    return Done(done.returncode, done.stdout, done.stderr)


@pytest.fixture(scope="module")
def example(root):
    return root / "docs/examples" / NAME


@pytest.fixture(scope="module")
def wheel(example, tmp_path_factory):
    """Build the example without a network, outside the checkout."""
    pytest.importorskip("build", reason="the dev extra is not installed")
    pytest.importorskip("hatchling", reason="the dev extra is not installed")
    folder = tmp_path_factory.mktemp("sharing")
    shutil.copytree(example, folder / NAME)
    built = run(sys.executable, "-m", "build", "--wheel", "--no-isolation", cwd=folder / NAME)
    assert built.code == 0, built.out + built.err
    (made,) = (folder / NAME / "dist").glob("*.whl")
    return made


@pytest.fixture(scope="module")
def site(wheel, tmp_path_factory):
    """Install the wheel into a separate folder."""
    folder = tmp_path_factory.mktemp("site")
    options = ["--quiet", "--disable-pip-version-check", "--no-deps", "--no-index"]
    done = run(sys.executable, "-m", "pip", "install", *options, "--target", folder, wheel)
    assert done.code == 0, done.err
    return folder


@pytest.fixture
def start(site, tmp_path, monkeypatch):
    """Run a command in an empty folder, with the example installed."""
    monkeypatch.delenv("LIPSYNC_LANG_PATH", raising=False)
    monkeypatch.setenv("PYTHONPATH", str(site))
    monkeypatch.setenv("PYTHONUTF8", "1")
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / ".cache"))
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: run(sys.executable, "-m", "lipsync_lang", *arguments)


def listed(start):
    """Hawaiian packs in `languages list`, in order."""
    done = start("languages", "list", "--json")
    assert (done.code, done.err) == (0, "")
    return [row for row in json.loads(done.out) if row["name"] == "hawaiian"]


@full
def test_the_wheel_holds_the_pack_and_says_so(wheel):
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (points,) = (name for name in names if name.endswith(".dist-info/entry_points.txt"))
        assert "[lipsync_lang.packs]" in archive.read(points).decode()
    assert PACK.as_posix() in names
    assert any(name.endswith("/licenses/LICENSE") for name in names)


@full
def test_an_installed_language_is_found_and_says_where_it_is_from(start, site):
    (row,) = listed(start)
    assert row["origin"] == f"installed: {NAME}"
    assert Path(row["path"]) == site / PACK
    for name in ("hawaiian", "haw", "HAW", "haw-US"):
        told = json.loads(start("languages", "show", name, "--json").out)
        assert (told["name"], told["tests"]["failed"]) == ("hawaiian", 0)
        assert not any(told["tests"]["untested"].values())


@full
def test_an_installed_language_has_no_faults(start, site):
    assert start("validate", site / PACK) == (0, "", "0 faults, 0 warnings\n")


@full
def test_an_installed_language_speaks_without_a_voice(start, tmp_path):
    done = start(
        "run", "Aloha kākou", "-l", "haw", "-c", "facefx", "--tts", "none", "-o", "aloha.csv"
    )
    assert done.code == 0, done.err
    assert done.out == ""
    assert "times are estimated" in done.err
    assert (tmp_path / "aloha.csv").read_text().startswith("time_s,open,")


@full
def test_a_project_stands_in_front_of_it_and_may_extend_it(start, tmp_path):
    said = json.loads(start("transcribe", "kai", "-l", "haw", "--json").out)
    assert said[0]["phonemes"] == ["kg", "aa", "iy"]
    (tmp_path / "languages").mkdir()
    (tmp_path / "languages/hawaiian.yaml").write_text(OWN, "utf-8")
    rows = listed(start)
    assert [row["origin"] for row in rows] == ["project", f"installed: {NAME}"]
    assert rows[1]["shadowed_by"] == str(Path("languages/hawaiian.yaml"))
    said = json.loads(start("transcribe", "kai maikaʻi", "-l", "haw", "--json").out)
    assert said[0]["phonemes"] == ["kg", "ay", "bmp", "aa", "iy", "kg", "aa", "h", "iy"]
    assert start("validate", "languages") == (0, "", "0 faults, 0 warnings\n")


@full
def test_without_it_the_language_is_unknown(start, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", os.devnull)
    done = start("languages", "show", "hawaiian")
    assert done.code == 2
    assert "no pack has the language 'hawaiian'" in done.err


def test_the_pack_of_the_tutorial_is_the_one_of_the_example(root, example):
    page = (root / "docs/tutorial/add-a-language.md").read_text("utf-8")
    assert (
        f'```yaml title="languages/hawaiian.yaml"\n{(example / PACK).read_text("utf-8")}```' in page
    )
