"""The add-on of Blender: its commands run, and its messages are those of the program."""

import runpy
import shutil
import sys
from types import ModuleType, SimpleNamespace

import pytest
from lanes import needs_espeak, needs_plug_ins
from places import ROOT

import lipsync_lang as ll
from lipsync_lang.faces.rigs.model import read_model

PANEL = ROOT / "docs/downloads/lipsync_lang_panel.py"


@pytest.fixture
def panel(monkeypatch):
    """Load the add-on without Blender."""
    bpy, props = ModuleType("bpy"), ModuleType("bpy.props")
    bpy.types = SimpleNamespace(
        PropertyGroup=object, AddonPreferences=object, Operator=object, Panel=object
    )
    for name in ("BoolProperty", "IntProperty", "StringProperty"):
        setattr(props, name, dict)
    monkeypatch.setitem(sys.modules, "bpy", bpy)
    monkeypatch.setitem(sys.modules, "bpy.props", props)
    return SimpleNamespace(**runpy.run_path(str(PANEL), run_name="panel"))


@needs_plug_ins
@needs_espeak
def test_its_command_keys_every_shape_of_the_face_and_writes_the_sound(panel, cli, tmp_path):
    face = shutil.copy(ROOT / "posesets/facefx/model.glb", tmp_path / "face.glb")
    told = {"text": "-5 maps", "language": "english", "recording": "", "fps": 23.976, "frame": 25}
    words = panel.command("lipsync-lang", face, tmp_path, told)
    assert cli(*words[1:]).code == 0
    script = (tmp_path / "line.py").read_text("utf-8")
    compile(script, "line.py", "exec")
    assert "The sound begins at frame 25:" in script
    keyed = {name for name in read_model(face).shape_names if f'"{name}"' in script}
    assert keyed >= {"open", "PBM", "wide"}
    assert ll.read_audio(tmp_path / "line.wav").seconds > 0.4
    (out := tmp_path / "again").mkdir()
    again = panel.command("x", face, out, {**told, "recording": str(tmp_path / "line.wav")})
    assert cli(*again[1:]).code == 0


def test_messages_of_the_program_reach_blender(panel, tmp_path):
    run = (sys.executable, "-m", "lipsync_lang", "run", "-l", "klingonn", "-c", "facefx")
    with pytest.raises(RuntimeError, match="unknown language 'klingonn'"):
        panel.ended([*run, "Hello", "-o", str(tmp_path / "line.csv")])
    with pytest.raises(RuntimeError, match=r"does not start .*; state its path in the preferences"):
        panel.ended([str(tmp_path / "none")])
