"""Godot: the form of .tres, and the import of .tres and GLB files by a real Godot 3."""

import importlib.util
import json
import os
import re
import shutil
import subprocess
import time
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from face_models import face
from file_bytes import bytes_of
from lanes import full
from pages import follow_here
from places import ROOT, TESTS
from small_models import glb

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.animations.keys import ERROR
from lipsync_lang.base.errors import OutputError
from lipsync_lang.faces.rigs.channel import Channel
from lipsync_lang.faces.rigs.container import binary_of
from lipsync_lang.faces.rigs.model import read_model

SCRIPT = TESTS / "consumers" / "godot.gd"
PAGE_SCRIPT = SCRIPT.with_name("page.gd")
PAGE = ROOT / "docs" / "how-to" / "godot.md"
PATIENCE = 120
"""Time limit for Godot in seconds."""

MIX_SECONDS = 0.1
"""Tolerance of a sound's position, since Godot mixes in blocks."""

ODD = ('a "quoted" one', "back\\slash", "a:colon", "ein Mündchen", "]]>", "a/b", "{}", "100%")


def performed(character="facefx", fps=60, **rest):
    schedule = ll.Schedule(
        ("HH", "AH0", "L", "OW1", "_", "P", "AA1", "F"),
        np.cumsum([0, 0.1, 0.08, 0.12, 0.2, 0.1, 0.05, 0.2, 0.07]),
        notation="arpabet",
    )
    animation = ll.resolve("english", character).perform(schedule, fps=fps)
    return replace(animation, **rest, export=ExportSettings(key_error=0.0, key_lines=True))


def noise(names, **rest):
    weights = np.random.default_rng(0).random((20, len(names)))
    times = np.arange(20) / 30
    return Animation(times, tuple(names), weights, 30, ll.Schedule(("_",), (0, 0.5)), **rest)


# Reading it back: seconds of the sound, and values, of each property

TRACK = re.compile(
    r'tracks/(\d+)/path = NodePath\("((?:[^"\\]|\\.)*)"\)\n.*?'
    r'"times": PoolRealArray\( (.*?) \),\n'
    r'"transitions": PoolRealArray\( (.*?) \),\n'
    r'"update": 0,\n"values": \[ (.*?) \]\n\}\n',
    re.DOTALL,
)


def from_tres(content, animation):
    text = content.decode("utf-8")
    assert text.startswith('[gd_resource type="Animation" format=2]\n\n[resource]\n')
    found = {}
    for number, (own, path, times, once, values) in enumerate(TRACK.findall(text)):
        assert int(own) == number
        seconds, levels = (np.array(row.split(", "), float) for row in (times, values))
        assert len(seconds) == len(levels) == len(once.split(", "))
        assert (np.diff(seconds) > 0).all()
        found[re.sub(r"\\(.)", r"\1", path)] = seconds - animation.begins, levels
    return found


def holds(content, animation):
    """Shapes of the only mesh of the model, if there is a model."""
    curves = from_tres(content, animation)
    assert curves
    for path, (times, values) in curves.items():
        pose = path.removeprefix(".:blend_shapes/")
        strays = np.interp(animation.times, times, values) - animation[pose]
        assert np.abs(strays).max() <= ERROR + 1e-6


READ_BACK = {"godot": holds}


def test_a_tres_has_its_form():
    weights = np.array([[0.0], [0.5], [1.0], [1.0]])
    schedule = ll.Schedule(("_",), (0, 0.2))
    animation = Animation(np.arange(-1, 3) / 10, ("open",), weights, 10, schedule)
    assert bytes_of("godot", animation).decode() == (
        '[gd_resource type="Animation" format=2]\n'
        "\n"
        "[resource]\n"
        "length = 0.3\n"
        "step = 0.1\n"
        'tracks/0/type = "value"\n'
        'tracks/0/path = NodePath(".:blend_shapes/open")\n'
        "tracks/0/interp = 1\n"
        "tracks/0/loop_wrap = true\n"
        "tracks/0/imported = false\n"
        "tracks/0/enabled = true\n"
        "tracks/0/keys = {\n"
        '"times": PoolRealArray( 0.0, 0.2, 0.3 ),\n'
        '"transitions": PoolRealArray( 1, 1, 1 ),\n'
        '"update": 0,\n'
        '"values": [ 0.0, 1.0, 1.0 ]\n'
        "}\n"
        "metadata/audio_start = 0.1\n"
    )


def test_an_offset_is_where_the_sound_begins():
    animation = noise(("open",), export=ExportSettings(offset=2.5))
    text = bytes_of("godot", animation).decode()
    assert "\nmetadata/audio_start = 2.5\n" in text
    assert f"\nlength = {2.5 + 19 / 30:.6f}\n" in text


def test_shapes_of_several_meshes_are_under_their_nodes(tmp_path):
    model = glb(tmp_path / "face.glb", Head=("Open", "Wide"), **{"Teeth.001": ("Open",)})
    animation = noise(("open", "wide"), model=model)
    paths = ["Head:blend_shapes/Open", "Head:blend_shapes/Wide", "Teeth001:blend_shapes/Open"]
    assert sorted(from_tres(bytes_of("godot", animation), animation)) == paths


def test_tracks_name_nodes_not_meshes(tmp_path):
    animation = noise(("open",), model=apart(tmp_path / "face.glb"))
    paths = ["Face:blend_shapes/Open", "Teeth2:blend_shapes/Open", "Teeth:blend_shapes/Open"]
    assert sorted(from_tres(bytes_of("godot", animation), animation)) == paths


def apart(path):
    """A model whose nodes and meshes have different names; two nodes show one mesh."""
    nodes = [
        {"name": "Fa.ce", "mesh": 0}, {"name": "Teeth", "mesh": 1}, {"name": "Teeth2", "mesh": 1},
    ]  # fmt: skip
    scenes = [{"nodes": [0, 1, 2]}]
    return face(path, "Open", meshes=("Tête Head", "Mesh.001"), nodes=nodes, scenes=scenes)


def test_what_a_tres_cannot_hold_is_told():
    def remarks(animation):
        return list(WRITERS["godot"].remarks(animation))

    late = performed(model=None)
    assert any(f"sound begins {late.begins:.3f} s" in told for told in remarks(late))
    assert not remarks(replace(late, export=ExportSettings(offset=1.0)))
    columns = (Channel("open"), Channel("nod", node="neck", rotation=(1, 0, 0)))
    mixed = noise(("open", "nod"), channels=columns)
    assert remarks(mixed) == ["Godot has nothing for nod"]
    assert list(from_tres(bytes_of("godot", mixed), mixed)) == [".:blend_shapes/open"]
    alone = replace(mixed, poses=("nod",), weights=mixed.weights[:, 1:], channels=columns[1:])
    with pytest.raises(OutputError, match="only bones move"):
        bytes_of("godot", alone)


# A real Godot


@pytest.fixture
def engine(tmp_path):
    """Run a test script in Godot, in a project with files, and return its output."""
    program = shutil.which("godot3-server")
    if program is None:
        pytest.skip("no godot3-server: nothing plays what we write for Godot")
    home = tmp_path / "home"
    home.mkdir()
    environment = {**os.environ, "HOME": str(home), "LC_ALL": "en_GB.UTF-8"}
    for variable in [name for name in environment if name.startswith("XDG_")]:
        del environment[variable]

    def said(script, project, scenes, **asked):
        (project / "project.godot").write_text('config_version=4\n[application]\nconfig/name="x"\n')
        shutil.copy(script, project)
        if scenes:
            imported(program, project, scenes, environment)
        ended = subprocess.run(
            [program, "--path", project, "--script", script.name],
            env=environment | asked,
            capture_output=True,
            text=True,
            stdin=subprocess.DEVNULL,
            timeout=PATIENCE,
            check=False,
        )
        told = re.search(r"^SAID (.*)$", ended.stdout, re.MULTILINE)
        assert told, ended.stdout + ended.stderr
        assert "rror" not in ended.stderr.replace("ocale", ""), ended.stderr
        return json.loads(told[1])

    return said


@pytest.fixture
def godot(tmp_path, engine):
    """Play animations in Godot, and return the values of each track at some times."""

    def played(times, files, beside={}):  # noqa: B006 not changed
        project = tmp_path / "project"
        project.mkdir()
        for name, content in beside.items():
            (project / name).write_bytes(content)
        for name, animation in files.items():
            animation.save(project / name)
        scenes = [name for name in files if name.endswith(".glb")]
        asked = json.dumps({"files": list(files), "times": list(times)})
        return engine(SCRIPT, project, scenes, ASKED=asked)

    return played


def imported(program, project, scenes, environment):
    """Import scenes in Godot's editor, and end it, since it may not end by itself."""
    editor = subprocess.Popen(
        [program, "--path", project, "--editor", "--quit"],
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        waited = 0.0
        while len(list(project.glob(".import/*.md5"))) < len(scenes):
            assert waited < PATIENCE, "Godot imports no scene"
            waited += 0.1
            time.sleep(0.1)
    finally:
        editor.terminate()
        editor.wait()


@full
def test_godot_shows_what_was_performed(godot):
    animation = performed(fps=60)
    times = np.linspace(0, animation.timeline[-1], 10)
    shared = replace(animation, export=ExportSettings(face="shared.face.bin"))
    files = {"line.tres": replace(animation, model=None), "face.glb": animation, "s.glb": shared}
    model = read_model(animation.model)
    content = binary_of(model.path, model.document, model.chunks)
    said = godot(times, files, {"shared.face.bin": content})
    for told in said.values():
        assert told["length"] == pytest.approx(animation.timeline[-1], abs=1e-5)
        # a mesh has one track of all its shapes: those of lids and brows rest
        others = told["tracks"].keys() - {f"blend_shapes/{pose}" for pose in animation.poses}
        assert len(told["tracks"]) - len(others) == len(animation.poses)
        assert not any(map(any, (told["tracks"][name] for name in others)))
        for pose in animation.poses:
            wanted = np.interp(times, animation.timeline, animation[pose])
            np.testing.assert_allclose(told["tracks"][f"blend_shapes/{pose}"], wanted, atol=1e-4)
    assert len(said["line.tres"]["tracks"]) == len(animation.poses)
    assert said["line.tres"]["step"] == pytest.approx(1 / 60, abs=1e-6)


def test_godot_finds_shapes_of_any_name(godot):
    animation = noise(ODD, export=ExportSettings(key_error=0.0, key_lines=True))
    times = np.linspace(0, animation.timeline[-1], 10)
    tracks = godot(times, {"line.tres": animation})["line.tres"]["tracks"]
    for number, name in enumerate(ODD):
        wanted = np.interp(times, animation.timeline, animation.weights[:, number])
        shape = tracks[f"blend_shapes/{name.replace(':', '_')}"]
        np.testing.assert_allclose(shape, wanted, atol=1e-4)


@full
def test_godot_moves_nodes_that_are_named_apart_from_their_meshes(engine, tmp_path):
    project = tmp_path / "project"
    project.mkdir()
    model = apart(project / "face.glb")
    animation = noise(("open",), model=model)
    animation.save(project / "line.tres")
    times = [0.1, 0.3, 0.5]
    asked = json.dumps({"files": ["line.tres"], "times": times})
    said = engine(SCRIPT, project, ["face.glb"], ASKED=asked, SCENE="face.glb")
    wanted = np.interp(times, animation.timeline, animation["open"])
    np.testing.assert_allclose(said["line.tres"]["tracks"]["blend_shapes/Open"], wanted, atol=1e-4)


@full
def test_the_face_keeps_time_with_its_sound(engine, tmp_path, monkeypatch):
    if importlib.util.find_spec("espeakng_loader") is None:
        pytest.skip("nothing speaks: espeakng_loader is an extra")
    monkeypatch.chdir(tmp_path)
    follow_here(PAGE)
    project = tmp_path / "project"
    project.mkdir()
    for name in ("hello.glb", "hello.wav", "speaking.gd"):
        shutil.copy(name, project)
    frames = engine(PAGE_SCRIPT, project, ("hello.glb", "hello.wav"))
    schedule = ll.speak("Hello, people", "english")
    animation = ll.resolve("english", "facefx").perform(schedule, fps=60)
    for frame in frames:
        for pose in animation.poses:
            wanted = np.interp(frame["at"] - 0.5, animation.times, animation[pose])
            assert frame["weights"][pose] == pytest.approx(wanted, abs=1e-3)
    heard = [frame for frame in frames if frame["heard"] >= 0]
    assert heard[-1]["heard"] > 0.5
    for before, frame in pairwise(heard):
        shown = frame["at"] - 0.5
        assert before["heard"] - MIX_SECONDS < shown < frame["heard"] + MIX_SECONDS
