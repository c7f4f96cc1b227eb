"""One line on several faces, in one picture."""

import io

import pytest
from lanes import full
from strategies import real

from lipsync_lang import Schedule, resolve
from lipsync_lang.base.errors import LipsyncError
from lipsync_lang.render.beside import plot_beside

LINE = Schedule(("M", "AA", "P"), (0.0, 0.1, 0.3, 0.4), notation="arpabet")


def drawn(animations, kind="svg"):
    pytest.importorskip("matplotlib", reason="the extra `plot` is not installed")
    out = io.BytesIO()
    plot_beside(animations, out, kind)
    return out.getvalue()


@full
def test_every_face_and_every_pose_that_moves_is_there():
    other = resolve("english", "oculus", cache=False)
    text = drawn([real().perform(LINE), other.perform(LINE)]).decode()
    for name in ("facefx", "oculus", "PBM", "open", "PP", "aa", "AA"):
        assert f">{name}</text>" in text
    for name in ("tTeeth", "FF"):
        assert f">{name}</text>" not in text


@full
def test_a_picture_is_drawn_alike_each_time():
    assert drawn([real().perform(LINE)], "png") == drawn([real().perform(LINE)], "png")


def test_different_lines_are_refused():
    longer = Schedule(("M", "AA", "P"), (0.0, 0.1, 0.3, 0.5), notation="arpabet")
    with pytest.raises(LipsyncError, match="different lines"):
        drawn([real().perform(LINE), real().perform(longer)])
    other = Schedule(("M", "IY", "P"), LINE.times, notation="arpabet")
    with pytest.raises(LipsyncError, match="different lines"):
        drawn([real().perform(LINE), real().perform(other)])
    with pytest.raises(LipsyncError, match="no animation"):
        drawn([])


def test_the_command_line_draws_them(cli, tmp_path):
    pytest.importorskip("matplotlib", reason="the extra `plot` is not installed")
    asked = ("run", "pop", "-l", "english", "--tts", "none", "-c", "facefx", "--beside", "oculus")
    picture = tmp_path / "two.png"
    assert cli(*asked, "--plot", picture).code == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert "--beside draws a picture; name it with --plot FILE" in cli(*asked).err
