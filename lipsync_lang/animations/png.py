"""A sheet of stills, to see at a glance how the line looks."""

from typing import BinaryIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.glb import unplaced
from lipsync_lang.animations.registry import binary_writer


@binary_writer("png", suffix=".png", remarks=unplaced)
def write_png(animation: Animation, out: BinaryIO) -> None:
    """A sheet of stills of the character's 3D model: its most different moments."""
    from lipsync_lang.render.sheet import sheet

    sheet(animation, out)
