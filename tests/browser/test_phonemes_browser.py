"""Phonemes of a line in a browser: relabelled, split, joined and moved, by mouse and by keys."""

from pathlib import Path

import pytest
from lanes import full
from test_bigrams_browser import served
from test_consumers import chromium, found, run
from test_line_page import schedule

from lipsync_lang.studio.spoken_line import SpokenLine
from lipsync_lang.studio.workshop import Workshop

pytestmark = [full, pytest.mark.xdist_group("phonemes")]

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def used(tmp_path_factory):
    node, modules = found("playwright-core")
    workshop = Workshop(tmp_path_factory.mktemp("project"), engine="none")
    workshop.open("english", "crab")
    workshop.line = SpokenLine(schedule("pie", "boof"))
    with served(workshop) as address:
        used = run(node, HERE / "phonemes.mjs", modules, chromium(), address)
    assert used["asked"] == []
    assert len(used["said"]) == 1, used["said"]
    assert "422" in used["said"][0], "the refused label is a refused request"
    return used


def test_phonemes_words_and_the_playhead_are_heard(used):
    (phoneme,), (word,) = used["heard"]
    assert phoneme == [0.2, 0.1]
    assert word == [0, 0.2]
    assert len(used["scrubbed"]) >= 2
    assert {round(length, 2) for _, length in used["scrubbed"]} == {0.09}


def test_the_sound_is_seen_as_a_spectrogram(used):
    assert used["spectrogram"]
    assert used["both"] == ["true", True]
    assert used["wave"] == "true", "the wave comes back, as high as before"


def test_a_phoneme_is_relabelled_with_a_label_of_the_language(used):
    labels = used["start"]
    assert used["chosen"] == labels[1]
    assert used["offered"] > 30
    assert "'AEE' is no label of english; did you mean 'AE'" in used["refused"]
    assert used["relabelled"] == [labels[0], "AE", *labels[2:]]


def test_phonemes_are_split_inserted_joined_deleted_and_undone(used):
    labels = used["start"]
    assert used["split"] == [labels[0], "AE", "AE", *labels[2:]]
    assert used["deleted"] == used["joined"] == used["relabelled"]
    assert used["inserted"] == [labels[0], "AE", "T", *labels[2:]]
    assert used["undone"] == [labels, True]


def test_a_boundary_rolls_ripples_and_a_word_moves(used):
    rolled, rippled, carried = used["rolled"], used["rippled"], used["carried"]
    assert [by > 0 for by in rolled].count(True) == 1
    by = [one for one in rippled if one]
    assert len(by) > 2
    assert len(set(by)) == 1
    before, after = used["top"]
    assert before == after, "a longer line leaves the timeline under the hand"
    assert [one < 0 for one in carried].count(True) > 2
    assert used["original"]


def test_a_pose_is_bent_on_its_curve(used):
    ((_, amount),) = used["lowered"]
    assert amount < -0.05
    assert any("bent" in reason for reason in used["reasons"])
    ((_, amount),) = used["dragged"]
    assert 0 < amount <= 1
