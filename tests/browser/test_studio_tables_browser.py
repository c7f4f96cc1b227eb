"""The studio's tables in a browser: sounds of a language, coverage, words and lines."""

import socket
from pathlib import Path
from threading import Thread

import pytest
from lanes import full
from test_consumers import chromium, found, run

pytest.importorskip("starlette", reason="the studio needs Starlette")
pytest.importorskip("uvicorn", reason="the studio needs uvicorn")

import uvicorn
from studio_calls import TOKEN
from test_studio_language import PACK

from lipsync_lang.packs.yaml.building import read_yaml
from lipsync_lang.studio.server import app
from lipsync_lang.studio.workshop import Workshop
from lipsync_lang.text.lines.line_readers import by_suffix

pytestmark = full

HERE = Path(__file__).parent


@pytest.fixture
def story(tmp_path):
    """Run a script of `studio_tables.mjs` in a project, and return the results."""
    node, modules = found("playwright-core")
    (tmp_path / "languages").mkdir()
    pack = PACK.format(name="toy").replace("p: d", "p: bmp")
    (tmp_path / "languages" / "toy.yaml").write_text(pack, "utf-8")
    workshop = Workshop(tmp_path, engine="none")
    workshop.open("toy", "crab")
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    host = f"127.0.0.1:{port}"
    config = uvicorn.Config(app(workshop, TOKEN, [host]), port=port, log_level="error")
    server = uvicorn.Server(config)
    thread = Thread(target=server.run, daemon=True)
    thread.start()

    def tell(name):
        address = f"http://{host}/{TOKEN}/"
        told = run(node, HERE / "studio_tables.mjs", modules, chromium(), address, name)
        assert (told["said"], told["asked"]) == ([], [])
        assert told["unnamed"] == []
        return told

    yield tell
    server.should_exit = True
    thread.join(timeout=60)


def test_a_sound_is_mapped_anew_and_the_tests_of_the_pack_follow(story):
    told = story("language")
    assert told["rows"][0] == "ipa q", "the unmapped one comes first"
    assert told["title"].startswith("<script>alert(1)</script>")
    assert (told["before"], told["after"]) == ("pbmpaaambmp", "pbmpaaamaa")
    assert told["marked"] == ["aa"]
    assert told["first"] == "ipa q"
    assert told["reasons"] == "open back vowel · only for <b>this</b> test"


def test_a_script_shows_what_to_draw_next_and_leads_there(story):
    told = story("coverage")
    assert told["script"] == "<b>script.txt"
    assert told["plan"][0] == "bmp-aa"
    assert len(told["plan"]) == 4
    assert told["accepted"].split(",") == sorted(by_suffix())
    assert "0 of 4" in told["facts"]
    assert told["sentence"].startswith(("ma pa", "ay ma"))
    assert (told["opened"], told["wanted"]) == ("#bigrams/bmp-aa", "bmp-aa")


def test_a_word_and_a_line_of_the_character_are_edited_and_saved(story, tmp_path):
    told = story("words")
    assert told["opened"] == "#words/word%3Apa"
    assert told["sounds"] == ["p", "a"]
    assert told["items"] == ["pa", "ma-pa-may"]
    assert told["typed"] == "three", (
        "an answer of the server leaves a field alone that somebody types in"
    )
    assert "from 0 to 2" in told["refused"]
    saved = read_yaml(tmp_path / "characters" / "crab.yaml").data
    assert set(saved["words"]) == {"pa"}
    line = {"text": "ma pa may", "edits": (), "dials": {"jaw": 0.5}}
    assert saved["lines"] == {"ma-pa-may": line}
