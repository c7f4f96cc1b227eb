"""The page of the how-to for the web, played in a browser: the face keeps time with its sound."""

import importlib.util
import json
from pathlib import Path

import numpy as np
import pytest
from lanes import full
from pages import follow_here
from test_consumers import chromium, found, run

import lipsync_lang as ll

pytestmark = full

HERE = Path(__file__).parent
PAGE = HERE.parents[1] / "docs" / "how-to" / "web.md"

ASKED = (-5.0, -0.1, 0.0, 0.123, 0.5, 5.0)
"""Seconds of the sound, before and after the line as well."""

APART_SECONDS = 0.02
"""Difference of two readings of the audio clock in one frame."""


@pytest.fixture
def played(tmp_path, monkeypatch):
    """Return the state of the page in a browser over time."""
    node, modules = found("three", "playwright-core")
    if importlib.util.find_spec("espeakng_loader") is None:
        pytest.skip("nothing speaks: espeakng_loader is an extra")
    monkeypatch.chdir(tmp_path)
    follow_here(PAGE)
    return run(node, HERE / "web.mjs", modules, chromium(), tmp_path, json.dumps(ASKED))


def performed(fps):
    schedule = ll.speak("Hello, people", "english")
    return ll.resolve("english", "facefx").perform(schedule, fps=fps)


def held(animation, seconds, weights):
    """Compare the weights of shapes with an animation at a time of its sound."""
    wanted = [np.interp(seconds, animation.times, animation[pose]) for pose in animation.poses]
    np.testing.assert_allclose([weights[pose] for pose in animation.poses], wanted, atol=1e-4)


def test_the_face_keeps_time_with_the_sound(played):
    animation = performed(60)
    assert played["soundStart"] == pytest.approx(-animation.times[0], abs=1e-6)
    assert len(played["frames"]) > 1
    for frame in played["frames"]:
        assert frame["parts"] > 1  # the mesh has several primitives
        assert not frame["apart"]
        shown = frame["at"] - played["soundStart"]
        held(animation, shown, frame["weights"])
        before = max(frame["heard"], animation.times[0])
        assert min(before, animation.times[-1]) == pytest.approx(shown, abs=APART_SECONDS)
    moved = np.array([list(frame["weights"].values()) for frame in played["frames"]])
    assert np.ptp(moved, axis=0).max() > 0.5


def test_the_script_weighs_a_line_between_its_frames(played):
    animation = performed(30)
    for seconds, weights in zip(ASKED, played["weighed"], strict=True):
        held(animation, seconds, weights)
