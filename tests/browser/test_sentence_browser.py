"""The studio's sentence in a browser: corrected, delivered, explained, saved and opened."""

from pathlib import Path

import pytest
from lanes import full
from test_bigrams_browser import served
from test_consumers import chromium, found, run
from test_line_page import schedule

import lipsync_lang as ll
from lipsync_lang.studio.spoken_line import SpokenLine
from lipsync_lang.studio.workshop import Workshop

pytestmark = [full, pytest.mark.xdist_group("sentence")]

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def used(tmp_path_factory):
    node, modules = found("playwright-core")
    recording = tmp_path_factory.mktemp("recorded") / "bob.wav"
    performer = ll.resolve("english", "crab")
    performer.perform(ll.speak("Bob may buy a map", "english")).save(recording)
    workshop = Workshop(tmp_path_factory.mktemp("project"), engine="none")
    workshop.open("english", "crab")
    workshop.line = SpokenLine(schedule("pie", "boof"))
    with served(workshop) as address:
        used = run(node, HERE / "sentence.mjs", modules, chromium(), address, recording)
    assert (used["said"], used["asked"]) == ([], [])
    return used


def test_a_boundary_is_dragged_undone_and_nudged(used):
    assert [bool(by) for by in used["moved"]].count(True) == 1
    assert max(used["moved"]) > 0.005
    assert used["redrawn"]
    assert used["followed"] == [True, True], "the face follows the drag, and goes back"
    assert set(used["undone"]) == set(used["original"]) == {0}
    assert used["alike"], "what is undone is drawn as before"
    assert sorted(used["nudged"])[-2:] == [0, 0.025]


def test_a_moment_says_why_and_leads_to_its_bigram(used):
    assert used["reasons"][0].startswith("stitched")
    address, title = used["entered"]
    assert address == used["clicked"]
    pair = address.removeprefix("#bigrams/")
    assert f"Open bigram {pair}" in used["pairs"]
    assert title == pair.replace("-", " → ")


def test_a_word_and_a_region_are_delivered_otherwise(used):
    assert used["word"] == "pie"
    assert used["emphasis"] == [1, 0]
    levels = next(iter(used["dials"].values()))
    assert max(value for _, value in levels) == 1.5
    assert used["lanes"] == list(used["dials"])
    assert used["points"][0] == len(levels)
    assert used["points"][1:] == [len(levels) + 1, len(levels)]
    assert used["without"] == {}


def test_takes_are_compared_and_stages_hidden(used):
    assert used["swapped"] == "true"
    assert used["hidden"]


def test_timings_are_saved_and_opened(used):
    assert used["saved"] == ["line.TextGrid", 'Object class = "TextGrid"']
    assert used["opened"] == [0, 0.2, 0.5]
    assert used["steps"].endswith("(line)"), "changes of the line before can be undone"


def test_the_phonemes_of_a_recording_are_found_by_its_words(used):
    assert used["untold"] == ["<b>ma</b>"], "without words the line stays"
    assert used["heard"] == ["Bob", "may", "buy", "a", "map"]


def test_everything_has_a_name_and_fits_a_phone(used):
    assert used["nameless"] == []
    assert used["overflow"] <= 0
