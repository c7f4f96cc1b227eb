"""Mirrored poses in the studio's timeline: one row for both, opened, and bent as one."""

from pathlib import Path

import pytest
from lanes import full
from test_consumers import chromium, found, run
from test_line_page import schedule

pytest.importorskip("starlette", reason="the studio needs Starlette")
pytest.importorskip("uvicorn", reason="the studio needs uvicorn")

from test_bigrams_browser import served

from lipsync_lang.studio.spoken_line import SpokenLine
from lipsync_lang.studio.workshop import Workshop

pytestmark = full

HERE = Path(__file__).parent
LEFT, RIGHT = "mouthPressLeft", "mouthPressRight"
PAIR = "mouthPress"


def test_mirrored_poses_are_one_row_that_opens_and_bends(tmp_path):
    node, modules = found("playwright-core")
    workshop = Workshop(tmp_path, engine="none")
    workshop.open("english", "arkit")
    workshop.line = SpokenLine(schedule("pie", "boof"))
    with served(workshop) as address:
        picture = tmp_path / "mirrored.png"
        used = run(node, HERE / "mirrored.mjs", modules, chromium(), address, PAIR, LEFT, picture)
    assert (used["said"], used["asked"]) == ([], [])
    assert PAIR in used["closed"]
    assert not {LEFT, RIGHT} & set(used["closed"])
    at = used["closed"].index(PAIR)
    assert used["opened"] == [*used["closed"][:at], LEFT, RIGHT, *used["closed"][at + 1 :]]
    assert (used["focused"], used["again"]) == (PAIR, used["closed"])
    assert used["both"][LEFT] == used["both"][RIGHT], "an edit of the pair reaches both"
    assert used["one"][LEFT] != used["one"][RIGHT] == used["both"][RIGHT]
    assert used["apart"] == used["opened"], "poses that differ are never hidden"
