"""Conversion of an animation to a drawable scene, through the GLB writer."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.glb import write_glb
from lipsync_lang.render.model.scene import Scene


def staged(animation: Animation) -> Scene:
    """Build the scene of the animation's GLB, without any wait for an offset.

    Raises
    ------
    OutputError
        There is no model, or nothing in it moves.
    ModelError
        The model cannot be read or drawn.
    """
    with TemporaryDirectory(prefix="lipsync-lang-") as folder:
        path = Path(folder) / "line.glb"
        with path.open("wb") as stream:
            write_glb(replace(animation, offset=0.0), stream)
        return Scene(path, animation.model or path)
