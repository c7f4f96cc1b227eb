"""The example of an archive: ten lines in three languages, in a browser and in Godot."""

import importlib.util
import os
import re
import shutil
from pathlib import Path

import pytest
from lanes import full
from places import ROOT
from played_lines import PLAYERS, ran
from test_consumers import chromium, found, run

from lipsync_lang.cli import main
from lipsync_lang.plugins.players.takes import Archive, Player

pytestmark = [full, pytest.mark.xdist_group("takes_page")]

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def beach(tmp_path_factory):
    """Return a copy of the example, built, with the players and the model beside it."""
    if importlib.util.find_spec("espeakng_loader") is None:
        pytest.skip("nothing speaks: espeakng_loader is an extra")
    folder = tmp_path_factory.mktemp("beach") / "takes"
    shutil.copytree(ROOT / "docs/examples/takes", folder)
    for path in (PLAYERS / "takes.mjs", PLAYERS / "takes.gd", ROOT / "posesets/crab/model.glb"):
        shutil.copy(path, folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        assert main(["build", "-q"]) == 0
    return folder


def test_the_crab_plays_switches_and_skips_on_a_page(beach):
    node, modules = found("three", "playwright-core")
    told = run(node, HERE / "takes.mjs", modules, chromium(), beach)
    assert told["said"] == []
    assert told["sounds"] == ["english/beach_02.wav", "spanish/beach_02.wav"]
    (before, _), (within, _) = told["starts"]
    assert before < 0 < within  # after the movement before it; in the middle of the line
    for sound, face in told["starts"]:
        assert sound == pytest.approx(face, abs=0.03)
    with Archive(beach / "crab.takes") as archive:
        player = Player(archive)
        for what, language in (("played", "english"), ("switched", "spanish")):
            assert player.play(f"{language}/beach_02")
            player.seek(told[what]["time"])
            shown = [told[what]["shapes"][pose] for pose in archive.poses]
            assert shown == pytest.approx(player.weights, abs=1e-4)
    assert told["played"]["lines"] == 10
    assert set(told["skipped"]["shapes"].values()) == {0}


def test_the_crab_plays_switches_and_skips_in_godot(beach):
    program = shutil.which("godot3-server") or pytest.skip("no godot3-server")
    (beach / "project.godot").write_text("config_version=4\n")
    environment = {**os.environ, "HOME": str(beach), "LC_ALL": "en_GB.UTF-8"}
    told = ran(program, "--path", str(beach), "--script", "beach.gd", env=environment)
    widest = [float(one) for one in re.findall(r"^SAID beach_\d\d (\S+)$", told, re.MULTILINE)]
    assert len(widest) == 10
    assert min(widest) > 0.3
    assert "REST 0\n" in told
