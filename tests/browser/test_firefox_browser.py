"""The studio and the page of a line in Firefox: every view, an edit, undo, saving and an export."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from lanes import full
from test_consumers import found, run
from test_studio_browser import Studio

from lipsync_lang.packs.yaml.events import load_yaml

pytestmark = full

HERE = Path(__file__).parent
PAIR = "bmp-aa"


def firefox():
    path = shutil.which("firefox-esr") or shutil.which("firefox")
    return path or pytest.skip("firefox is not installed")


def test_the_studio_and_a_page_work_in_firefox(tmp_path):
    node, modules = found("puppeteer-core")
    project, made = tmp_path / "project", tmp_path / "made"
    project.mkdir()
    made.mkdir()
    page = made / "line.html"
    command = [sys.executable, "-m", "lipsync_lang", "run", "Bob bumps", "-l", "english"]
    subprocess.run([*command, "-c", "crab", "--tts", "none", "-q", "-o", page], check=True)
    studio = Studio(project, "-l", "english", "-c", "crab", "--tts", "none")
    studio.start()
    try:
        script = HERE / "firefox.mjs"
        used = run(node, script, modules, firefox(), studio.address, PAIR, page, made)
    finally:
        studio.kill()
    assert used["said"] == []
    assert used["title"] == "Bob bumps"
    assert used["views"] == ["character", "words", "coverage", "language", "sentence"]
    assert used["exported"].startswith("Exported ")
    bank = project / "posesets/crab/banks/common.yaml"
    assert [*load_yaml(bank.read_text("utf-8"))["bigrams"]] == [PAIR]
