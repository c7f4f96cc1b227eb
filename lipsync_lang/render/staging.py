"""Conversion of an animation to a drawable scene, through the GLB writer."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from lipsync_lang.animations.animation import Animation, ExportSettings
from lipsync_lang.animations.writers.glb import write_glb
from lipsync_lang.render.model.scene import Scene


def staged(animation: Animation) -> Scene:
    """Build the scene of the animation's GLB, without the silence of an offset."""
    with TemporaryDirectory(prefix="lipsync-lang-") as folder:
        path = Path(folder) / "line.glb"
        with path.open("wb") as stream:
            write_glb(replace(animation, export=replace(animation.export, offset=0.0)), stream)
        return Scene(path, animation.model or path)


def sweep(animation: Animation) -> Animation:
    """Return a movement of each column to its largest value, one after the other.

    Frame 0 is at rest, and frame c + 1 moves column c: its weight is 1, or as large as it becomes
    in the animation.
    """
    count = len(animation.poses)
    most = np.abs(animation.weights).max(axis=0, initial=0.0)
    bones = np.array([channel.node is not None for channel in animation.columns])
    # Shapes are drawn at their full weight, and bones only as far as they turn: a channel is in
    # degrees, and 1 would be no movement that anybody sees.
    levels = np.where(bones & (most > 0), most, 1.0)
    times, weights = np.arange(count + 1.0), np.vstack([np.zeros(count), np.diag(levels)])
    return replace(animation, times=times, weights=weights, fps=1.0, export=ExportSettings())
