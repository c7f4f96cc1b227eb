"""An animator's hour: a line of a project is mended, styled, exported and saved, and no other."""

import csv
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from lanes import full
from test_consumers import chromium, found
from test_studio_browser import Studio

from lipsync_lang.packs.yaml.events import load_yaml

pytestmark = [full, pytest.mark.xdist_group("hour")]

HERE = Path(__file__).parent
LINES = (
    "Bob bumps my blue boat.", "Please buy five maps.", "The crab walks sideways.",
    "Nobody minds the wind.", "My boat goes home.", "Bring me the bucket.",
    "We sail before noon.", "Five more, please.", "Who moved the map?", "Good night, Bob.",
)  # fmt: skip
PROJECT = """kind: project
format: 1
languages: [english]
lines: lines.csv
cast: {"*": crab}
outputs: ["takes/{id}.csv", "takes/{id}.timings.json"]
"""


def files(folder):
    """Return the text of each file of a project, except what a build makes."""
    own = (path for end in ("yaml", "csv") for path in folder.rglob(f"*.{end}"))
    named = {path.relative_to(folder).as_posix(): path.read_text("utf-8") for path in own}
    return {name: text for name, text in named.items() if not name.startswith("takes/")}


def built(folder):
    """Build the lines of a project, and return the frames of each."""
    command = [sys.executable, "-m", "lipsync_lang", "build", "--tts", "none", "--workers", "1"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return {path.stem: path.read_bytes() for path in (folder / "takes").glob("*.csv")}


@pytest.fixture(scope="module")
def hour(tmp_path_factory):
    node, modules = found("playwright-core")
    folder = tmp_path_factory.mktemp("hour") / "game"
    folder.mkdir()
    with (folder / "lines.csv").open("w", encoding="utf-8", newline="") as stream:
        rows = [(f"line_{n:02}", "Bob", text) for n, text in enumerate(LINES, 1)]
        csv.writer(stream).writerows([("id", "speaker", "english"), *rows])
    (folder / "lipsync.yaml").write_text(PROJECT, "utf-8")
    before, takes = files(folder), built(folder)
    studio = Studio(folder, "--tts", "none")
    studio.start()
    pictures = os.environ.get("LIPSYNC_LANG_STUDIO_PICTURES", "")
    process = subprocess.Popen(
        [node, HERE / "hour.mjs", modules, chromium(), studio.address, pictures],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, encoding="utf-8",
    )  # fmt: skip
    try:
        assert process.stdout.readline().strip() == "kill"
        studio.kill()
        unsaved = files(folder)
        studio.start()
        out, _ = process.communicate("\n", timeout=300)
        assert process.returncode == 0
    finally:
        process.kill()
        process.communicate()
        studio.kill()
    told = json.loads(out)
    assert (told["said"], told["asked"]) == ([], [])
    return told | {
        "before": before, "unsaved_files": unsaved, "after": files(folder), "takes": takes,
        "again": built(folder), "folder": folder,
    }  # fmt: skip


def test_a_line_is_mended_styled_and_drawn(hour):
    first, after = hour["labels"]
    assert [n for n, pair in enumerate(zip(first, after, strict=True)) if len({*pair}) > 1] == [1]
    assert after[1] == "æ"
    assert hour["settings"]["bends"]
    assert max(level for _, level in hour["settings"]["styles"]["shout"]) == 1
    assert "unsaved" in hour["unsaved"] or any(one.isdigit() for one in hour["unsaved"])


def test_the_model_and_the_page_are_exported(hour):
    assert hour["exported"] == "Exported line_01.glb, line_01.html"
    assert hour["files"] == ["line_01.glb", "line_01.html"]


def test_a_killed_server_loses_nothing(hour):
    labels, settings = hour["mended"]
    assert labels == hour["labels"][1]
    assert settings == hour["settings"]
    assert hour["unsaved_files"] == hour["before"], "nothing is written before it is saved"


def test_the_saved_files_state_what_was_done_and_no_more(hour):
    before, after = hour["before"], hour["after"]
    assert {name for name in before if before[name] != after[name]} == set()
    new = sorted(after.keys() - before.keys())
    assert new == ["characters/crab.yaml", "posesets/crab/banks/common.yaml"]
    character, bank = (load_yaml(after[name]) for name in new)
    assert [*character["lines"]] == ["line_01"]
    line = character["lines"]["line_01"]
    assert {"bends", "emphasis", "phonemes", "styles", "times"} <= line.keys()
    assert [*bank["bigrams"]] == ["bmp-aa"]


def test_a_build_uses_it_and_the_next_line_is_untouched(hour):
    name, settings = hour["next"]
    assert name.startswith("line_02")
    assert [settings[kind] for kind in ("styles", "bends", "dials")] == [{}, {}, {}]
    assert hour["again"]["line_01"] != hour["takes"]["line_01"]
    timings = json.loads((hour["folder"] / "takes/line_01.timings.json").read_text("utf-8"))
    assert timings["phonemes"][1]["label"] == "æ"
    bigram = ("b", "m", "p")
    for name, frames in hour["takes"].items():
        text = LINES[int(name[-2:]) - 1].casefold()
        if name != "line_01" and not any(one in text for one in bigram):
            assert hour["again"][name] == frames, name
