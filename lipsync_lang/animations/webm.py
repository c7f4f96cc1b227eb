"""The same video, in a form that is free of patents, for web pages and Ren'Py."""

from typing import BinaryIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.glb import unplaced
from lipsync_lang.animations.registry import binary_writer


@binary_writer("webm", suffix=".webm", remarks=unplaced)
def write_webm(animation: Animation, out: BinaryIO) -> None:
    """A video of the character's 3D model speaking, with the sound (VP9 and Opus)."""
    from lipsync_lang.render.video import film

    film(animation, out, "webm")
