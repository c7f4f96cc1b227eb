"""Projects in the cache: they serve as validated ones do, and none is trusted without a look."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass

import pytest

from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.packs.models import Project
from lipsync_lang.packs.project import load_project
from lipsync_lang.packs.yaml.faults import PackFaults
from lipsync_lang.production.builds.known_projects import MARK, KnownFields, known_project
from lipsync_lang.production.builds.timing_formats import plain_formats
from lipsync_lang.resolver.cache import sealed

PROJECT = """\
kind: project
format: 1
name: game
language: english
character: facefx
fps: 24000/1001
motion: {preset: paper}
outputs: "csv/{id}.csv"
glb: {face: once}
paths: packs
lines: [script.csv, "{language}.csv"]
languages: {english: en, german: }
columns: {text: Line, header_row: 2}
timing_formats:
  vendor: {phonemes: {text: p, start: from, end: to}, mentions: [from, to]}
script_formats:
  quests: {suffix: .quests, text: words}
cast: {"*": crab, Bob: [facefx, arkit]}
values: {player: Robin}
limits: {jerk: 30000, confidence: 0.5}
reports: report.html
"""


@dataclass
class Folder:
    """A folder with a project file, and the one with the cache."""

    file: object
    cache: object

    @property
    def kept(self):
        """The project in the cache."""
        return next(self.cache.glob("*.project"))


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / "cache"))
    file = tmp_path / "game/lipsync.yaml"
    file.parent.mkdir()
    file.write_text(PROJECT, "utf-8")
    return Folder(file, tmp_path / "cache")


def plain(value):
    """Return the fields of a model, and of models inside, with the names of the stated ones."""
    if isinstance(value, dict):
        return {name: plain(one) for name, one in value.items()}
    if not hasattr(value, "model_fields_set"):
        return value
    fields = getattr(value, "_fields", None) or vars(value)
    return plain({**fields, "model_fields_set": value.model_fields_set})


def test_a_known_project_is_as_the_validated_one(folder):
    validated = load_project(folder.file).model
    first, known = known_project(folder.file).model, known_project(folder.file).model
    assert isinstance(first, Project)
    assert isinstance(known, KnownFields)
    assert plain(known) == plain(first) == plain(validated)
    assert known.motion.model_dump(exclude_none=True) == {"preset": "paper"}
    for name in ("timing_formats", "script_formats"):
        stated = getattr(validated, name)
        assert plain_formats(getattr(known, name)) == plain_formats(stated)


def test_a_changed_project_is_read_again(folder):
    assert known_project(folder.file).model.name == "game"
    folder.file.write_text(PROJECT.replace("name: game", "name: film"), "utf-8")
    assert known_project(folder.file).model.name == "film"


def test_a_fault_of_a_known_project_has_its_place(folder):
    known_project(folder.file)
    told = known_project(folder.file).fault(("limits", "jerk"), "P106", "is too low")
    assert (told.line, told.column) == (20, 16)
    (folder.file.parent / "packs").write_text("no folder", "utf-8")
    with pytest.raises(PackFaults, match="'packs' is not a folder"):
        known_project(folder.file)


def test_a_link_out_of_the_folder_is_refused_before_it_is_read(folder, tmp_path):
    known_project(folder.file)
    folder.file.rename(tmp_path / "other.yaml")
    try:
        folder.file.symlink_to(tmp_path / "other.yaml")
    except OSError:
        pytest.skip("this system makes no links")
    with pytest.raises(LipsyncError, match="outside"):
        known_project(folder.file)


@pytest.mark.parametrize(
    "content",
    [b"", b"{}", b"".join(sealed(MARK, [b"[1"])), b"".join(sealed(b"other", [b"{}"]))],
    ids=["empty", "without a mark", "no JSON", "of another"],
)
def test_a_damaged_file_is_made_again(folder, content):
    known_project(folder.file)
    kept = folder.kept
    kept.write_bytes(content)
    assert known_project(folder.file).model.fps == "24000/1001"
    assert isinstance(known_project(folder.file).model, KnownFields)


def test_nothing_is_kept_without_a_cache(folder, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", "off")
    assert isinstance(known_project(folder.file).model, Project)
    assert isinstance(known_project(folder.file).model, Project)


LOADED = """\
import sys
from lipsync_lang.cli import main
code = main(["build", "--workers", "1", "--report", "report.html"])
print([code, "pydantic" in sys.modules])
"""


def test_a_second_build_loads_no_models_of_packs(tmp_path):
    (tmp_path / "lipsync.yaml").write_text(
        "kind: project\nformat: 1\nlanguage: english\ncharacter: facefx\nlines: s.csv\n"
        'outputs: "{id}.csv"\ntimings: "{id}.txt"\n',
        "utf-8",
    )
    (tmp_path / "a.txt").write_text("0.0\t0.1\tM\n0.1\t0.3\tAA\n", "utf-8")
    (tmp_path / "s.csv").write_text("id,text\na,ma\n", "utf-8")
    env = {**os.environ, "LIPSYNC_LANG_CACHE": str(tmp_path / "cache")}
    told = []
    for _ in range(2):
        (tmp_path / "a.csv").unlink(missing_ok=True)
        done = subprocess.run(
            [sys.executable, "-c", LOADED], cwd=tmp_path, env=env, check=True, capture_output=True
        )
        told.append(json.loads(done.stdout.decode().lower().replace("'", '"')))
    assert told == [[0, True], [0, False]]
