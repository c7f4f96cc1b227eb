"""The documentation site in a browser, opened from its files."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from lanes import full
from test_consumers import ROOT, chromium, found, run

pytestmark = full
pytest.importorskip("mkdocs", reason="the site needs mkdocs, which is an extra")

HERE = Path(__file__).parent
SOUGHT = "trigram"


def test_every_page_fits_a_phone_and_can_be_read_and_found(tmp_path):
    node, modules = found("playwright-core")
    browser = chromium()
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", tmp_path]
    environment = os.environ | {"NO_MKDOCS_2_WARNING": "1", "PYTHONPATH": str(ROOT)}
    subprocess.run(command, cwd=ROOT, env=environment, check=True)
    shown = run(node, HERE / "site.mjs", modules, browser, tmp_path, SOUGHT)
    assert (shown["said"], shown["asked"]) == ([], [])
    assert (shown["wide"], shown["faint"]) == ([], [])
    assert shown["read"] == len([p for p in tmp_path.rglob("*.html") if p.name != "404.html"])
    assert any(SOUGHT in title.lower() for title in shown["found"])
