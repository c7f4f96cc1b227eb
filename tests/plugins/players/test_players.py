"""Players of archives: they play alike, seeks included, and damaged archives are refused."""

import re
import shutil

import numpy as np
import pytest
from gdtoolkit.parser import parser as godot_4
from lanes import full
from places import ROOT
from played_lines import (
    HERE,
    PLAYERS,
    POSES,
    RANGES,
    SANITIZED,
    alike,
    played,
    ran,
    shows,
    speech,
    take,
)

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation
from lipsync_lang.base.errors import OutputError
from lipsync_lang.plugins.players.takes import MOST_WEIGHT, Archive, Player, TakesError
from lipsync_lang.production.builds import takes as archives
from lipsync_lang.production.builds.takes import encoded, read_takes, write_takes

ERROR = 1 / 512


def test_weights_are_those_of_the_line(said, archive):
    with Archive(archive) as opened:
        player = Player(opened)
        assert opened.is_whole()
        for name, animation in said.items():
            assert player.play(name)
            assert player.delay == pytest.approx(animation.offset)
            moving = [n for n in range(len(POSES)) if animation.weights[:, n].any()]
            order = [opened.poses.index(POSES[n]) for n in moving]
            spans = [RANGES.get(POSES[n], 1) for n in moving]
            for frame in (*range(len(animation.times)), 0):
                player.seek(float(animation.times[frame]) + animation.offset)
                found = np.array([player.weights[n] for n in order])
                far = np.abs(found - animation.weights[frame, moving]) / spans
                assert far.max(initial=0) < ERROR


def test_a_second_of_speech_and_pose_is_small():
    said = ll.speak("The depth of a well is easy to tell.", "english", engine="none")
    line = ll.resolve("english", "facefx").perform(said)
    moving = sum(bool(one.any()) for one in line.weights.T)
    seconds = line.times[-1] - line.times[0]
    assert len(take(line)) / seconds / moving < 90


@full
def test_players_play_alike(play, steps):
    alike(play(steps), played(steps))


@full
def test_players_agree_on_damaged_archives(play, wreck_steps):
    truth = played(wreck_steps)
    opened = [row == [1] for row in truth if len(row) == 1]
    assert 50 < opened.count(False) < 250
    weights = np.array([one for row in truth if len(row) > 1 for one in row[:-2]])
    assert np.abs(weights).max() < 3 * MOST_WEIGHT  # so it is finite, too
    assert np.count_nonzero(np.abs(weights) > 100) > 100
    alike(play(wreck_steps), truth)


@full
def test_the_component_for_unreal_shows_the_weights_and_starts_the_sound(archive, tmp_path):
    compiler = shutil.which("g++") or pytest.skip("no C++ compiler")
    sources = [PLAYERS / "TakesComponent.h", PLAYERS / "TakesComponent.cpp"]
    code = sources[0].read_text("utf-8") + sources[1].read_text("utf-8")
    for included in re.findall(r'#include "(.+)"', code):
        if not (PLAYERS / included).exists():
            (tmp_path / included).parent.mkdir(exist_ok=True)
            (tmp_path / included).write_text('#include "unreal.h"\n')
    flags = ("-std=c++20", "-Wall", "-Wextra", "-Werror", *SANITIZED)
    folders = (f"-I{PLAYERS}", f"-I{tmp_path}", f"-I{HERE}")
    made = tmp_path / "unreal"
    ran(compiler, *flags, *folders, *map(str, [sources[1], HERE / "unreal.cpp"]), "-o", str(made))
    shows(ran(str(made), str(archive), "en/line-1"), archive, "en/line-1")


@full
def test_javascript_makes_no_objects_while_it_plays(archive):
    node = shutil.which("node") or pytest.skip("no node")
    module = str(PLAYERS / "takes.mjs")
    command = (node, "--expose-gc", str(HERE / "frames.mjs"), module, str(archive), "en/line-1")
    assert float(ran(*command)) < 16  # bytes a frame: less than one object


@full
def test_damaged_archives_never_crash_the_c_player(compiled, tmp_path):
    random = np.random.default_rng(1)
    names = [f"en/{n}" for n in range(6)]
    path = tmp_path / "small.takes"
    write_takes(path, {name: take(speech(random, 90)) for name in names})
    opened, played = map(int, ran(compiled("fuzz"), str(path), "20000", *names).split())
    assert opened > 4000
    assert played > 10_000


def damaged(content):
    yield content[:40], "header ends early|damaged"
    yield content[:-8], "bytes of"
    yield b"PK" + content[2:], "not an archive"
    yield content[:8] + b"\2" + content[9:], "version 2"
    yield content[:70] + b"\xff" + content[71:], "checksum"
    yield b"", "empty"


def test_damaged_archives_are_refused_in_words(archive):
    content = archive.read_bytes()
    for number, (bad, why) in enumerate(damaged(content)):
        path = archive.with_name(f"bad-{number}.takes")
        path.write_bytes(bad)
        with pytest.raises(OutputError, match=why):
            read_takes(path)
        with pytest.raises((TakesError, ValueError), match=f"{why}|buffer"):
            Archive(path)
    last = content[:-9] + bytes([content[-9] ^ 255]) + content[-8:]
    path.write_bytes(last)
    with pytest.raises(OutputError, match="checksum of its takes"):
        read_takes(path)
    with Archive(path) as opened:
        assert not opened.is_whole()


def test_an_archive_is_read_as_it_was_written(archive, said):
    found = read_takes(archive)
    assert found.takes == {name: take(one) for name, one in sorted(said.items())}
    assert encoded(dict(reversed(found.takes.items()))) == archive.read_bytes()


def test_too_many_poses_are_named(monkeypatch):
    assert archives.MAX_POSES == 2**16 - 1, "numbers of poses are two bytes"
    monkeypatch.setattr(archives, "MAX_POSES", 65)
    schedule = ll.Schedule(("_",), (0, 1))
    takes = {}
    for part in range(2):
        poses = tuple(f"p{part}-{n}" for n in range(33))
        line = Animation(np.arange(2.0), poses, np.ones((2, len(poses))), 1.0, schedule)
        takes[f"en/{part}"] = take(line)
    with pytest.raises(OutputError, match="66 poses are too many"):
        encoded(takes)


@pytest.mark.parametrize(
    "name", ["lipsync_lang/plugins/players/takes.gd", "docs/examples/takes/beach.gd"]
)
def test_scripts_for_godot_are_scripts_of_godot_4_too(name):
    parsed = godot_4.parse((ROOT / name).read_text("utf-8"))
    assert any(one.data == "func_def" for one in parsed.iter_subtrees())
