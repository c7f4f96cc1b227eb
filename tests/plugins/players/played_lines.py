"""Lines that every player plays, and the comparison of their weights."""

import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
from file_bytes import bytes_of
from places import ROOT, TESTS

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.plugins.players.takes import Archive, Player, TakesError

PLAYERS = ROOT / "lipsync_lang/plugins/players"
HERE = TESTS / "plugins/players"
POSES = ("open", "wide", "mündchen", "nod", "jaw", "still")
RANGES = {"nod": 40}
"""Ranges of channels that are not 1, in degrees."""
SANITIZED = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-O1")


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
    return bytes_of("player", animation)


def played(steps):
    """Return a row for each step: 1 if an archive opens, or weights, time, and 1 if it plays."""
    rows, player = [], None
    for verb, what, *value in map(str.split, steps):
        if verb == "open":
            try:
                player = Player(Archive(Path(what)))
            except TakesError:
                player = None
            rows.append([float(player is not None)])
        elif player is not None:
            shown = player.weights
            if verb in ("play", "switch"):
                getattr(player, verb)(what, float(value[0]))
            elif verb == "blend":
                region, shown = [n % 2 for n in range(len(shown))], [0.0] * len(shown)
                player.blend([0.3] * len(shown), what, region, shown)
            else:
                getattr(player, verb)(float(what))
            rows.append([*shown, player.sound_time, float(player.playing)])
    return rows


def alike(text, truth):
    """Compare in shares of the largest number of an archive: Godot prints single precision."""
    rows = [[*map(float, line.removeprefix("SAID ").split())] for line in text.splitlines()]
    assert [*map(len, rows)] == [*map(len, truth)]
    opened = [n for n, row in enumerate(truth) if len(row) == 1]
    for first, end in pairwise([*opened, len(truth)]):
        assert rows[first] == truth[first]
        if end > first + 1:
            expected = np.array(truth[first + 1 : end])
            least = np.maximum(np.abs(expected).max(axis=0), 1)
            assert np.abs((np.array(rows[first + 1 : end]) - expected) / least).max() < 1e-4


def ran(*command, **options):
    done = subprocess.run(
        command, capture_output=True, encoding="utf-8", timeout=120, check=False, **options
    )
    assert done.returncode == 0, done.stderr + done.stdout[-2000:]
    return done.stdout


def block(path, language):
    """Write the page's block of code in a language to a file."""
    page = (ROOT / "docs/how-to/play-takes.md").read_text("utf-8")
    path.write_text(page.partition(f"```{language}\n")[2].partition("```")[0], "utf-8")
    return path


def shows(text, archive, name):
    """Compare what a component showed in each frame: "open", "jaw", and whether the sound plays."""
    frames = np.array([line.split() for line in text.splitlines()], float)
    with Archive(archive) as opened:
        player = Player(opened)
        player.play(name)
        columns = [opened.poses.index("open"), opened.poses.index("jaw")]
        for *shapes, sounds in frames:
            player.advance(1 / 60)
            far = np.subtract(shapes, [player.weights[one] for one in columns])
            assert np.abs(far).max() < 1e-4
            assert sounds == (player.sound_time >= 0)
        assert player.time > player.end - 1e-3
    assert len(frames) > 30
    assert frames[:, 0].max() > 0.1
