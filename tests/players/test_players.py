"""Players of archives: the four play alike, seeks included, and damaged archives are refused."""

import os
import shutil
import subprocess
from io import BytesIO

import numpy as np
import pytest
from lanes import full
from places import ROOT, TESTS

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.build.takes import encoded, read_takes, write_takes
from lipsync_lang.errors import OutputError
from lipsync_lang.players.takes import Archive, Player, TakesError

PLAYERS = ROOT / "lipsync_lang" / "players"
HERE = TESTS / "players"
POSES = ("open", "wide", "mündchen", "nod", "jaw", "still")
RANGES = {"nod": 40}
"""Ranges of channels that are not 1, in degrees."""

LINES = 500
SANITIZED = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1")
ERROR = 1 / 512


def speech(random, frames=None):
    """Return an animation of smooth curves, contacts and long rests."""
    frames = frames or int(random.integers(2, 200))
    at = np.arange(frames) / 60.0
    weights = np.zeros((frames, len(POSES)))
    for column in range(len(POSES) - 1):
        curve = np.sin(at * random.uniform(2, 25) + random.uniform(0, 6)) * random.uniform(0.5, 1.5)
        weights[:, column] = np.clip(curve, 0, 1) if random.random() < 0.9 else 0
    weights[:, 3] = weights[:, 3] * 40 - 20  # a channel in degrees
    lead = float(random.uniform(0, 0.3))
    schedule = ll.Schedule(("_",), (0, frames / 60))
    export = ExportSettings(offset=float(random.choice([0.0, 0.5])))
    return Animation(at - lead, POSES, weights, 60.0, schedule, export=export)


def take(animation):
    out = BytesIO()
    WRITERS["player"].write(animation, out)
    return out.getvalue()


@pytest.fixture(scope="module")
def said():
    random = np.random.default_rng(34)
    return {f"{'de' if n % 2 else 'en'}/line-{n // 2}": speech(random) for n in range(LINES)}


@pytest.fixture(scope="module")
def archive(said, tmp_path_factory):
    path = tmp_path_factory.mktemp("takes") / "a.takes"
    write_takes(path, {name: take(one) for name, one in said.items()})
    return path


@pytest.fixture(scope="module")
def steps(said, archive):
    """Return steps of a play on every line, in a file and as a list."""
    random = np.random.default_rng(35)
    told = []
    for name in said:
        told += [f"play {name} {random.choice([0, 0.1, 0.3]):g}", "advance 0.016667"]
        told += [f"advance {random.uniform(0, 0.5):.4f}" for _ in range(2)]
        told += [f"seek {random.uniform(-0.5, 3):.4f}", f"seek {random.uniform(-0.5, 1):.4f}"]
        told += [f"blend {random.choice(['max', 'add', 'replace'])}"]
        other = name.replace("en/", "de/") if name.startswith("en") else name.replace("de/", "en/")
        told += [f"switch {other} 0.2", "advance 0.05"]
        told += ["skip 0.1", "advance 0.04"] if random.random() < 0.5 else []
    told += ["play en/none 0.1"]
    path = archive.with_name("steps.txt")
    path.write_text("\n".join(told) + "\n", "utf-8", newline="\n")
    return path, told


@pytest.fixture(scope="module")
def truth(archive, steps):
    rows = []
    with Archive(archive) as opened:
        player = Player(opened)
        count = len(opened.poses)
        own, region, out = [0.3] * count, [n % 2 for n in range(count)], [0.0] * count
        for step in steps[1]:
            verb, what, *value = step.split()
            if verb in ("play", "switch"):
                getattr(player, verb)(what, float(value[0]))
            elif verb == "blend":
                player.blend(own, what, region, out)
            else:
                getattr(player, verb)(float(what))
            rows.append([*(out if verb == "blend" else player.weights), player.sound_time])
    return np.array(rows)


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


@pytest.fixture
def compiled(tmp_path):
    """Compile a program of this folder."""
    compiler = shutil.which("gcc") or shutil.which("clang")
    if compiler is None:
        pytest.skip("no C compiler")

    def build(name, *flags):
        program = tmp_path / name
        given = ["-std=c99", "-Wall", "-Wextra", "-Werror", f"-I{PLAYERS}", *flags]
        command = [compiler, *given, str(HERE / f"{name}.c"), "-o", str(program)]
        made = subprocess.run(command, capture_output=True, text=True, check=False)
        assert made.returncode == 0, made.stderr
        return str(program)

    return build


def alike(text, truth):
    """Compare in shares of a pose's range: Godot's numbers have single precision."""
    rows = [line.removeprefix("SAID ").split() for line in text.splitlines() if line]
    ranges = [RANGES.get(pose, 1) for pose in sorted({*POSES} - {"still"})] + [1]
    assert np.abs((np.array(rows, float) - truth) / ranges).max() < 1e-4


def ran(*command, **options):
    done = subprocess.run(
        command, capture_output=True, encoding="utf-8", timeout=120, check=False, **options
    )
    assert done.returncode == 0, done.stderr + done.stdout[-2000:]
    return done.stdout


@full
def test_c_plays_alike(compiled, archive, steps, truth):
    alike(ran(compiled("player", *SANITIZED), str(archive), str(steps[0])), truth)


@full
def test_the_header_compiles_as_cpp(tmp_path):
    compiler = shutil.which("g++") or pytest.skip("no C++ compiler")
    source = tmp_path / "unit.cpp"
    source.write_text('#include "takes.h"\nint main() { takes_player p; (void)p; }\n')
    ran(compiler, "-Wall", "-Wextra", "-Werror", f"-I{PLAYERS}", "-fsyntax-only", str(source))


@full
def test_javascript_plays_alike(archive, steps, truth):
    node = shutil.which("node") or pytest.skip("no node")
    module = str(PLAYERS / "takes.mjs")
    alike(ran(node, str(HERE / "player.mjs"), module, str(archive), str(steps[0])), truth)


@full
def test_javascript_makes_no_objects_while_it_plays(archive):
    node = shutil.which("node") or pytest.skip("no node")
    module = str(PLAYERS / "takes.mjs")
    command = (node, "--expose-gc", str(HERE / "frames.mjs"), module, str(archive), "en/line-1")
    assert float(ran(*command)) < 16  # bytes a frame: less than one object


@full
def test_godot_plays_alike(archive, steps, truth, tmp_path):
    program = shutil.which("godot3-server") or pytest.skip("no godot3-server")
    for path in (archive, steps[0], PLAYERS / "takes.gd", HERE / "player.gd"):
        shutil.copy(path, tmp_path)
    (tmp_path / "project.godot").write_text("config_version=4\n")
    environment = {**os.environ, "HOME": str(tmp_path), "LC_ALL": "en_GB.UTF-8"}
    told = ran(program, "--path", str(tmp_path), "--script", "player.gd", env=environment)
    alike("\n".join(line for line in told.splitlines() if line.startswith("SAID ")), truth)


@full
def test_damaged_archives_never_crash_the_c_player(compiled, tmp_path):
    random = np.random.default_rng(1)
    names = [f"en/{n}" for n in range(6)]
    path = tmp_path / "small.takes"
    write_takes(path, {name: take(speech(random, 90)) for name in names})
    opened, played = map(int, ran(compiled("fuzz", *SANITIZED), str(path), "20000", *names).split())
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


def test_too_many_poses_are_named():
    schedule = ll.Schedule(("_",), (0, 1))
    takes = {}
    for part in range(2):
        poses = tuple(f"p{part}-{n}" for n in range(33_000))
        line = Animation(np.arange(2.0), poses, np.ones((2, len(poses))), 1.0, schedule)
        takes[f"en/{part}"] = take(line)
    with pytest.raises(OutputError, match="66,000 poses are too many"):
        encoded(takes)
