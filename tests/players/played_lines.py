"""Lines that every player plays, and the comparison of their weights."""

import subprocess
from io import BytesIO

import numpy as np
from places import ROOT, TESTS

import lipsync_lang as ll
from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.animations.animation_writers import WRITERS
from lipsync_lang.players.takes import Archive, Player

PLAYERS = ROOT / "lipsync_lang" / "players"
HERE = TESTS / "players"
POSES = ("open", "wide", "mündchen", "nod", "jaw", "still")
RANGES = {"nod": 40}
"""Ranges of channels that are not 1, in degrees."""


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
