"""GLB files in other programs: the Khronos validator, and three.js in a browser."""

import json
import os
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from glb_files import FACE, JAW, SLIDE, model_of, with_jaw
from lanes import full

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.container import binary_of
from lipsync_lang.faces.rigs.model import read_model

pytestmark = full

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
MODULES = "LIPSYNC_LANG_NODE_MODULES"
"""Environment variable: a folder of npm packages."""

WARNING = 1
"""The severity of a warning; errors are below, remarks above."""

QUARTER = [0, 0, 0.5**0.5, 0.5**0.5]
MADE = {
    "face": (FACE, ()),
    "jaw": (with_jaw(rotation=QUARTER, translation=[1, 2, 3]), (*JAW, *SLIDE)),
}
SHIPPED = {path.parent.name: path for path in sorted(ROOT.glob("posesets/*/model.glb"))}
HEAD = "rigs/head_arkit52_oculus15.glb"
every_model = pytest.mark.parametrize("name", [*MADE, *SHIPPED, HEAD])


def found(*packages):
    """Return node and the folder of packages, or skip the test and name the missing part."""
    node, folder = shutil.which("node"), os.environ.get(MODULES)
    if node is None:
        pytest.skip("node is not installed")
    if folder is None:
        pytest.skip(f"{MODULES} names no node_modules folder with {' and '.join(packages)}")
    missing = [package for package in packages if not (Path(folder) / package).is_dir()]
    if missing:
        pytest.skip(f"{folder} has no {' and no '.join(missing)}")
    return node, str(Path(folder).resolve())


WHOLE = ("chromium", "chromium-browser", "google-chrome")


def chromium(*names):
    """Return the path of a Chromium: the one without windows takes a third less of a processor."""
    path = next(filter(None, map(shutil.which, names or ("chromium-headless-shell", *WHOLE))), None)
    return path or pytest.skip("chromium is not installed")


def whole_chromium():
    """Return one with windows: the lighter one searched the site in vain twice."""
    return chromium(*WHOLE, "chromium-headless-shell")


def run(*command):
    """Return the JSON output of a script, or fail with its error output."""
    done = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=900, check=False)
    if done.returncode or done.stderr:
        pytest.fail(f"exit code {done.returncode}: {done.stderr}", pytrace=False)
    return json.loads(done.stdout)


@pytest.fixture
def written(tmp_path, request):
    """Return an animation of slow noise on one of the models, and its file."""

    def write(name):
        channels, model = (), SHIPPED.get(name)
        if name in MADE:
            document, channels = MADE[name]
            model = tmp_path / "model.glb"
            model.write_bytes(model_of(document))
        elif model is None:
            model = request.getfixturevalue("data") / HEAD
            if not model.is_file():
                pytest.skip(f"there is no {model}")
        shapes = read_model(model).meshes[0].shapes[:52]
        channels = channels or tuple(map(Channel, shapes))
        animation = replace(noise(channels), model=model)
        path = tmp_path / "line.glb"
        animation.save(path)
        return animation, path

    return write


def noise(channels):
    """Return an animation of a second in which every channel moves."""
    times = np.arange(-0.2, 0.8, 1 / 60)
    phase = np.arange(len(channels))
    weights = 0.5 + 0.5 * np.sin(9 * times[:, None] + phase)
    schedule = ll.Schedule(("P",), (0, 0.6), words=(ll.Word("hello", 0, 1),))
    named = tuple(f"{n} {channel.name}" for n, channel in enumerate(channels))
    return Animation(times, named, weights, 60, schedule, channels=channels)


def faults(path):
    """Return the errors and warnings of the Khronos validator, as (code, place)."""
    node, modules = found("gltf-validator")
    issues = run(node, HERE / "validate.mjs", modules, path)
    assert not issues["truncated"]
    return {(m["code"], m["pointer"]) for m in issues["messages"] if m["severity"] <= WARNING}


@every_model
def test_the_khronos_validator_finds_no_fault_in_what_we_add(name, written):
    animation, path = written(name)
    there_before = faults(animation.model)
    assert faults(path) == there_before


@pytest.mark.parametrize("name", [*MADE, *SHIPPED])
def test_the_khronos_validator_finds_no_fault_in_our_models(name, written):
    _, path = written(name)
    assert not faults(path)


@every_model
def test_a_browser_plays_what_we_wrote(name, written):
    node, modules = found("three", "playwright-core")
    animation, path = written(name)
    times = np.linspace(0, animation.times[-1] - animation.times[0], 10)
    shown = run(node, HERE / "play.mjs", modules, chromium(), path, json.dumps(times.tolist()))
    assert len(shown) == len(times)
    ours = np.array([np.interp(times - 0.2, animation.times, w) for w in animation.weights.T]).T
    for state, row in zip(shown, ours, strict=True):
        compare(animation.channels, state, row)


@pytest.mark.parametrize("name", [*MADE, *SHIPPED])
def test_lines_that_share_their_face_are_played_too(name, written, tmp_path):
    animation, path = written(name)
    model = read_model(animation.model)
    content = binary_of(model.path, model.document, model.chunks)
    (tmp_path / "my face.bin").write_bytes(content)
    replace(animation, export=ExportSettings(face="my face.bin")).save(path)
    assert path.stat().st_size < animation.model.stat().st_size + 50_000 - len(content)
    assert not faults(path)
    node, modules = found("three", "playwright-core")
    times = [0.3, 0.6]
    shown = run(node, HERE / "play.mjs", modules, chromium(), path, json.dumps(times))
    ours = [np.interp(np.array(times) - 0.2, animation.times, w) for w in animation.weights.T]
    for state, row in zip(shown, np.array(ours).T, strict=True):
        compare(animation.channels, state, row)


def compare(channels, state, row):
    """Compare the shapes in the browser at one time with the written weights."""
    compared = 0
    for channel, value in zip(channels, row, strict=True):
        if channel.translation is not None:
            moved = [1, 2, 3] + value * np.array(channel.translation)
            np.testing.assert_allclose(state[channel.node]["place"], moved, atol=1e-4)
            compared += 1
        elif channel.rotation is not None:
            half = np.radians(value) / 2  # about x, as a quarter turn about z has left it
            turn = 0.5**0.5 * np.array([np.sin(half), np.sin(half), np.cos(half), np.cos(half)])
            np.testing.assert_allclose(state[channel.node]["turn"], turn, atol=1e-4)
            compared += 1
        else:
            seen = [one["weights"] for one in state.values() if channel.name in one["weights"]]
            np.testing.assert_allclose([one[channel.name] for one in seen], value, atol=1e-4)
            compared += bool(seen)
    assert compared == len(channels)
