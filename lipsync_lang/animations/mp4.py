"""A video, for those who want to see and hear the line without a 3D program."""

from typing import BinaryIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.glb import unplaced
from lipsync_lang.animations.registry import binary_writer


@binary_writer("mp4", suffix=".mp4", remarks=unplaced)
def write_mp4(animation: Animation, out: BinaryIO) -> None:
    """A video of the character's 3D model speaking, with the sound (H.264 and AAC)."""
    from lipsync_lang.render.video import film

    film(animation, out, "mp4")
