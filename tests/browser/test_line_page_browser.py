"""The page of a line in a browser, opened from its file."""

import os
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from lanes import full
from test_consumers import chromium, found, run
from test_line_page import NASTY, schedule

import lipsync_lang as ll
from lipsync_lang.animations.animation import ExportSettings
from lipsync_lang.render.model.camera import framed
from lipsync_lang.render.model.picture import Artist
from lipsync_lang.render.staging import staged, sweep
from lipsync_lang.reports.quality.baselines import keyframes

pytestmark = full

HERE = Path(__file__).parent


@pytest.fixture
def show(tmp_path):
    """Use the page of an animation in a browser, and return the results."""

    def show(animation, closed, opened):
        node, modules = found("playwright-core")
        path = tmp_path / "line.html"
        animation.save(path)
        shown = run(node, HERE / "line.mjs", modules, chromium(), path, str(closed), str(opened))
        assert (shown["said"], shown["asked"]) == ([], [])
        assert shown["overflow"] <= 0
        assert shown["nameless"] == []
        (text, plot), (printed_text, printed_plot), after = shown["inks"]
        assert printed_text != text
        assert printed_plot > plot
        assert after == [text, pytest.approx(plot, rel=0.1)]
        return shown

    return show


def performed(character, *texts):
    return ll.resolve("english", character).perform(schedule(*texts))


def moments(animation, measure="aperture"):
    """Return the times at which the mouth is most closed and most open."""
    gains = animation.source.performer.compiled.measures[measure]
    opening = np.sum([gain * animation[pose] for pose, gain in gains.items()], axis=0)
    return [round(float(animation.times[at]), 2) for at in (opening.argmin(), opening.argmax())]


def test_the_types_of_the_scripts_hold():
    node, modules = found("typescript")
    compiler = Path(modules) / "typescript" / "bin" / "tsc"
    done = subprocess.run(
        [node, compiler, "-p", HERE / "tsconfig.json"], capture_output=True, encoding="utf-8",
        check=False,
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, "")


def test_the_scripts_keep_to_the_rules():
    node, modules = found("eslint")
    linter = Path(modules) / "eslint" / "bin" / "eslint.js"
    package = HERE.parents[1] / "lipsync_lang"
    scripts = [package / "studio/static", *package.glob("plugins/*/static")]
    scripts.append(package.parent / "docs/site")
    done = subprocess.run(
        [node, linter, "--max-warnings", "0", "-c", HERE / "eslint.config.mjs", *scripts],
        capture_output=True, encoding="utf-8", check=False,
        env=os.environ | {"LIPSYNC_LANG_NODE_MODULES": modules},
    )  # fmt: skip
    assert (done.returncode, done.stdout) == (0, "")


def assert_alike(pixels, animation, seconds):
    """Compare the pixels of a page's face with the picture of the same moment."""
    swept, side = staged(sweep(animation)), 64
    artist = Artist(staged(animation), 4 * side, framed(swept), swept)
    begins = float(animation.times[0]) - float(animation.timeline[0])
    fine = artist.draw(seconds - begins).astype(float)
    drawn = fine.reshape(side, 4, side, 4, 3).mean(axis=(1, 3))
    shown = np.reshape(pixels, (side, side, 4))
    face = shown[..., 3] == 255
    assert 0.2 < face.mean() < 0.8
    apart = np.abs(shown[..., :3] - drawn)[face]
    assert apart.mean() < 6
    assert np.percentile(apart, 95) < 25


@pytest.mark.parametrize("character", ["facefx", "rhubarb"])
def test_a_viewer_sees_the_mouth_move_and_its_reasons(show, character):
    animation = performed(character, "pie", "boof")
    plain = keyframes(animation.source.performer, animation.schedule, animation.fps)
    plain = replace(plain, channels=animation.channels, model=animation.model)
    closed, opened = moments(animation)
    shown = show(
        replace(animation, export=ExportSettings(against={"plain": plain})), closed, opened
    )
    assert shown["title"] == "pie boof"
    assert shown["at"] == pytest.approx([closed, opened], abs=1.1 / animation.fps)
    assert shown["moved"] > 20
    assert shown["still"] == 0
    assert shown["closer"] > 100
    assert shown["stepped"] == pytest.approx(2 / animation.fps, abs=0.011)
    assert shown["moment"].endswith("in pie")
    assert shown["poses"][0] in animation.poses
    assert shown["reasons"]
    assert (shown["help"], shown["helped"]) == (True, False)
    assert 0.1 < shown["tapped"] < 0.5
    assert (shown["paused"], shown["pitch"]) == ("Play", True)
    assert shown["looped"]["turns"] == 2, "it goes on playing after the sound's end"
    assert shown["looped"]["long"] <= 0.21
    assert shown["looped"]["before"] <= 0.01
    if animation.model is not None:
        assert_alike(shown["picture"], animation, opened)
    assert shown["swapped"] == [f"english on {character}", "plain"]


def test_no_text_of_a_schedule_runs(show):
    text = NASTY.replace("\ud800", "")
    shown = show(performed("rhubarb", text), 0, 0.2)
    assert text.split()[0] in shown["title"]
