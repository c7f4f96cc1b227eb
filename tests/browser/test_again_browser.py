"""Words aligned again, and a language begun, in the studio in a browser."""

from pathlib import Path

import pytest
from lanes import full
from test_bigrams_browser import served
from test_consumers import chromium, found, run

from lipsync_lang.studio.workshop import Workshop

pytestmark = full

HERE = Path(__file__).parent


def test_words_are_aligned_again_and_a_language_is_begun(tmp_path):
    node, modules = found("playwright-core")
    workshop = Workshop(tmp_path)
    workshop.open("english", "crab")
    workshop.speak("Please buy five maps")
    if workshop.schedule.audio is None:
        pytest.skip("needs eSpeak NG, whose voice is aligned again")
    with served(workshop) as address:
        used = run(node, HERE / "again.mjs", modules, chromium(), address)
    assert used["asked"] == []
    assert len(used["said"]) == 1, used["said"]
    assert "422" in used["said"][0], "the refused name is a refused request"
    before, after = used["before"], used["after"]
    assert [one["label"] for one in after] == [one["label"] for one in before]
    assert after[1:4] != before[1:4], "the first of the chosen words is aligned too"
    assert after[7:] == before[7:], "the words outside the choice stay"
    assert used["undone"] == before
    assert "there is a language 'english' already" in used["refused"]
    assert used["title"].startswith("Elvish")
    assert used["open"] == "elvish"
    assert used["told"].startswith("Began elvish: its pack is languages/elvish.yaml")
    assert (tmp_path / "languages/elvish.yaml").is_file()
