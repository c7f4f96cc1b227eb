"""The page of a voice in a browser, with a recording in place of the microphone."""

import asyncio
from pathlib import Path

import numpy as np
import pytest
from lanes import full
from test_consumers import chromium, found, run
from test_studio_browser import Studio

import lipsync_lang as ll

pytest.importorskip("uvicorn", reason="the page needs uvicorn")
pytest.importorskip("pocketsphinx", reason="the ear needs a model")
pytestmark = [full, pytest.mark.xdist_group("voice_page")]

HERE = Path(__file__).parent


RIGGED = "kind: character\nformat: 1\nname: face\nposeset: facefx\nrig: facefx-to-arkit\n"


class VoicePage(Studio):
    command = ("live", "--page")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("voice") / "project"
    folder.mkdir()
    made = VoicePage(folder, "-c", "crab")
    made.start()
    yield made
    made.kill()


def test_the_head_moves_with_the_voice(page, tmp_path):
    node, modules = found("playwright-core")
    recording = tmp_path / "voice.wav"
    performer = ll.resolve("english", "crab")
    performer.perform(ll.speak("Bob may buy a map of Mali by now", "english")).save(recording)
    told = run(node, HERE / "voice.mjs", modules, chromium(), page.address, recording)
    assert (told["said"], told["asked"]) == ([], [])
    assert told["states"] == ["Listening: talk", "The microphone is off"]
    assert len(told["phones"]) == 4
    assert told["delay"] == "200 ms"
    assert told["named"]
    every, count = np.array(told["frames"]), len(performer.poses)
    weights, gestures = every[:, :count], every[:, count:]
    assert gestures.shape[1] == len(performer.gesture_set.poses)
    assert gestures.any(), "the page has gestures by default"
    assert weights.min() >= 0
    assert weights.max() > 0.3, "somebody talks"
    assert weights.max() <= 1


def test_other_sites_and_guessed_addresses_hear_nothing(page):
    websockets = pytest.importorskip("websockets.asyncio.client")
    closed = pytest.importorskip("websockets.exceptions").InvalidStatus
    address = page.address.replace("http:", "ws:") + "sound"
    foreign = {"Origin": "https://example.com"}

    async def meet(where, headers):
        async with websockets.connect(where, additional_headers=headers) as socket:
            return await socket.recv()

    assert "poses" in asyncio.run(meet(address, {}))
    for where, headers in ((address, foreign), (address.replace("a-token", "my-token"), {})):
        with pytest.raises(closed, match="403"):
            asyncio.run(meet(where, headers))


def test_a_rig_and_other_sources_are_refused(cli, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = cli("live", "--page", "Hello", "-c", "crab")
    assert said.code == 2
    assert "leave it out with --page" in said.err
    path = Path("characters/face.yaml")
    path.parent.mkdir()
    path.write_text(RIGGED, "utf-8")
    said = cli("live", "--page", "-c", "face", "--no-browser")
    assert said.code == 2
    assert "face drives a rig; name another character" in said.err
