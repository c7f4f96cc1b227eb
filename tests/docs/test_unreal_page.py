"""The script of the how-to for Unreal Engine, run with a stand-in for Unreal's Python module."""

import sys
from types import ModuleType
from unittest.mock import MagicMock

import numpy as np
import pytest
from pages import blocks
from places import ROOT

import lipsync_lang as ll

PAGE = ROOT / "docs" / "how-to" / "unreal.md"


@pytest.fixture
def unreal(monkeypatch):
    """Replace the editor with a stand-in that records calls."""
    module = MagicMock(spec_set=[
        "AnimSequence", "AnimSequenceFactory", "AnimationLibrary", "AssetToolsHelpers",
        "EditorAssetLibrary", "FrameNumber", "FrameRate", "load_asset", "log",
    ])  # fmt: skip
    module.FrameNumber, module.FrameRate = int, lambda over, under: over / under
    monkeypatch.setitem(sys.modules, "unreal", module)
    monkeypatch.setattr(sys, "argv", ["import_line.py"])
    return module


@pytest.fixture
def script(unreal):
    """Return the page's script as a module."""
    text = next(text for _, told, text in blocks(PAGE) if "import_line.py" in told)
    assert unreal.log.call_args is None
    module = ModuleType("import_line")
    exec(compile(text, "import_line.py", "exec"), vars(module))  # noqa: S102 our own page
    return module


@pytest.fixture
def line(tmp_path):
    """Return an animation and its file."""
    schedule = ll.Schedule(("P", "AA1", "F"), (0, 0.1, 0.4, 0.6), notation="arpabet")
    animation = ll.resolve("english", "arkit").perform(schedule, fps=30)
    path = tmp_path / "line.json"
    animation.save(path)
    return animation, path


def test_every_curve_reaches_the_animation(script, unreal, line):
    animation, path = line
    script.import_line(str(path), "/Game/Head_Skeleton", "/Game/Lines")
    made = unreal.AssetToolsHelpers.get_asset_tools().create_asset
    assert made.call_args.args[:2] == ("line", "/Game/Lines")
    asset, controller = made.return_value, made.return_value.controller
    controller.set_frame_rate.assert_called_once_with(30.0, False)  # noqa: FBT003 as Unreal has it
    controller.set_number_of_frames.assert_called_once_with(len(animation.times) - 1, False)  # noqa: FBT003
    library = unreal.AnimationLibrary
    assert [call.args for call in library.add_curve.call_args_list] == [
        (asset, pose) for pose in animation.poses
    ]
    for pose, call in zip(
        animation.poses, library.add_float_curve_keys.call_args_list, strict=True
    ):
        assert call.args[:2] == (asset, pose)
        np.testing.assert_allclose(call.args[2], animation.times - animation.times[0], atol=1e-6)
        np.testing.assert_allclose(call.args[3], animation[pose], atol=1e-5)
    unreal.EditorAssetLibrary.save_loaded_asset.assert_called_once_with(asset)


def test_the_log_names_the_frame_of_the_sound(script, unreal, line):
    animation, path = line
    script.import_line(str(path), "/Game/Head_Skeleton")
    frame = round(-animation.times[0] * 30)
    assert frame > 0
    assert f"begins at frame {frame} of" in unreal.log.call_args.args[0]
