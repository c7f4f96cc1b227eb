"""Curve edits of a character, addressed by words and phonemes."""

import numpy as np
import pytest
from lanes import full

from lipsync_lang import LipsyncError, Schedule, Word, resolve

LABELS = ["HH", "AH", "L", "OW", "_", "L", "OW"]


def schedule(stretch: float = 1.0, pause: float = 0.3) -> Schedule:
    lengths = np.array([0.08, 0.1, 0.09, 0.2, pause / stretch, 0.1, 0.25]) * stretch
    words = (Word("Hello", 0, 4), Word("low", 5, 7))
    return Schedule(tuple(LABELS), np.concatenate(([0.0], lengths.cumsum())), words, "arpabet")


@pytest.fixture
def anna(tmp_path):
    folder = tmp_path / "characters"
    folder.mkdir()
    (folder / "anna.yaml").write_text(
        "kind: character\nformat: 1\nname: anna\nposeset: facefx\n"
        "words: {hello: {curves: {wide: [[0, 0.6], [0.5, 0.6], [1, 0.6]]}}}\n"
        "lines:\n"
        "  intro: {edits: [{word: 1, phoneme: 0, curves: {FV: [[0, 0.5], [1, 0.5]]}}]}\n"
        "  whole: {edits: [{phoneme: 4, curves: {FV: [[0, 0.5], [1, 0.5]]}}]}\n"
        "  wrong: {edits: [{word: 2, curves: {FV: [[0, 0.5], [1, 0.5]]}}]}\n"
    )
    return lambda **more: resolve("english", "anna", paths=[tmp_path], cache=False, **more)


@full
def test_a_word_is_said_in_the_characters_own_way_and_others_are_not(anna):
    ours = anna().perform(schedule())
    plain = resolve("english", "facefx", cache=False).perform(schedule())
    middle = (ours.times > 0.1) & (ours.times < 0.4)
    assert ours["wide"][middle].min() > 0.55
    later = ours.times > 0.65
    np.testing.assert_allclose(ours.weights[later], plain.weights[later], atol=1e-9)


@full
@pytest.mark.parametrize("stretch", [1.0, 1.7])
@pytest.mark.parametrize("pause", [0.1, 0.6])
@pytest.mark.parametrize("line", ["intro", "whole"])
def test_an_edit_of_a_line_survives_another_recording(anna, line, stretch, pause):
    spoken = schedule(stretch, pause)
    animation = anna().perform(spoken, line=line)
    lifted = animation.times[animation["FV"] > 0.45]
    assert lifted.min() >= spoken.times[5] - 0.1
    assert lifted.max() <= spoken.times[6] + 0.1
    assert not anna().perform(spoken)["FV"].any()


def test_an_edit_explains_itself(anna):
    animation = anna().perform(schedule(), line="intro")
    text = str(animation.explain(0.82))
    assert "overlay" in text
    assert "the character's own curve" in text


def test_edits_keep_the_speed_limit(anna):
    weights = anna().perform(schedule(), fps=120, line="intro").weights
    assert np.abs(np.diff(weights, axis=0)).max() <= 15 / 120 + 1e-9


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("intor", "no edits for line 'intor'; did you mean 'intro'"),
        ("wrong", "edit 0 of line 'wrong' is for word 2, counted from 0, but the line has 2 words"),
    ],
)
def test_what_is_not_there_is_named(anna, line, message):
    with pytest.raises(LipsyncError, match=message):
        anna().perform(schedule(), line=line)


@pytest.mark.usefixtures("anna")
def test_edits_come_back_from_the_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("LIPSYNC_LANG_CACHE", str(tmp_path / "cache"))
    cold, warm = (
        resolve("english", "anna", paths=[tmp_path]).perform(schedule(), line="intro")
        for _ in range(2)
    )
    assert any((tmp_path / "cache").iterdir())
    np.testing.assert_array_equal(cold.weights, warm.weights)
