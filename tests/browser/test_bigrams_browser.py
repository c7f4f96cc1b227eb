"""The studio's bigrams in a browser: from the matrix to a drawn bigram, undone, and saved."""

import threading
from contextlib import contextmanager
from pathlib import Path
from socket import create_server

import pytest
from lanes import full
from test_consumers import chromium, found, run
from test_line_page import schedule

from lipsync_lang.packs.yaml.events import load_yaml

pytest.importorskip("starlette", reason="the studio needs Starlette")
pytest.importorskip("uvicorn", reason="the studio needs uvicorn")

import uvicorn
from studio_calls import TOKEN

from lipsync_lang.studio.server import app
from lipsync_lang.studio.spoken_line import SpokenLine
from lipsync_lang.studio.workshop import Workshop

pytestmark = full

HERE = Path(__file__).parent
PAIR = "bmp-ay"


@contextmanager
def served(workshop):
    """Serve a workshop, and yield its address."""
    with create_server(("127.0.0.1", 0)) as listener:
        host = f"127.0.0.1:{listener.getsockname()[1]}"
        config = uvicorn.Config(
            app(workshop, TOKEN, [host]), log_level="warning", lifespan="off", ws="none"
        )
        server = uvicorn.Server(config)
        thread = threading.Thread(target=server.run, args=([listener],))
        thread.start()
        try:
            yield f"http://{host}/{TOKEN}/"
        finally:
            server.should_exit = True
            thread.join()


def test_a_bigram_is_drawn_undone_and_saved(tmp_path):
    node, modules = found("playwright-core")
    workshop = Workshop(tmp_path, engine="none")
    workshop.open("english", "crab")
    workshop.line = SpokenLine(schedule("pie", "boof"))
    with served(workshop) as address:
        used = run(node, HERE / "bigrams.mjs", modules, chromium(), address, PAIR)
    assert (used["said"], used["asked"]) == ([], [])
    assert set(used["needs"]) == {"bmp-ay", "ay-bmp", "bmp-f", "f-w", "w-bmp"}
    assert used["title"] == "bmp → ay"
    assert used["ghosts"] == ["draft", "targets", "_-bmp", "ay-bmp"]
    assert used["draft"]["status"] == "drafted"
    assert used["draft"]["origin"] == "draft; edits go into posesets/crab/banks/common.yaml"
    assert used["playhead"] == "visible", "the line goes to the bigram"
    assert used["moved"]
    assert used["word"] == "pie", "the word of the line is the bigram's, until another is typed"
    assert (used["edited"]["status"], used["approved"]) == ("edited", "approved")
    assert used["undone"] == {key: used["draft"][key] for key in ("status", "points")}
    assert used["again"] == used["edited"] | {"status": "approved"}
    assert used["kept"] == used["edited"]["points"]
    assert used["cell"].startswith("bmp-ay, approved, by shared, as in aloud")
    assert (used["overflow"], used["narrow"]) == (0, 0)
    assert used["styles"][:2] == ["Style: neutral", "Style: angry"]
    assert used["styled"].endswith("banks/angry.yaml")
    angry = load_yaml((tmp_path / "posesets/crab/banks/angry.yaml").read_text("utf-8"))
    assert (angry["style"], list(angry["bigrams"])) == ("angry", ["bmp-ay"])
    bank = load_yaml((tmp_path / "posesets/crab/banks/common.yaml").read_text("utf-8"))
    drawn = bank["bigrams"]["bmp-ay"]
    assert (drawn["status"], drawn["word"]) == ("approved", "aloud")
    shown = [point.split("time ")[1] for point in used["kept"]]
    pose = used["kept"][0].partition(",")[0]
    assert shown == [f"{time:.2f}, value {value:.2f}" for time, value in drawn["curves"][pose]]
    assert list(bank["bigrams"]) == ["bmp-ay"]
