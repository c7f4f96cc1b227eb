"""Pictures of a speaking model: videos with sound, and a sheet of stills."""

from typing import BinaryIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import binary_writer
from lipsync_lang.animations.writers.glb import animated_model, unplaced


@binary_writer("mp4", suffix=".mp4", remarks=unplaced, shows=True, refuse=animated_model)
def write_mp4(animation: Animation, out: BinaryIO) -> None:
    """A video of the character's 3D model speaking, with the sound (H.264 and AAC)."""
    from lipsync_lang.render.video import film

    film(animation, out, "mp4")


@binary_writer("webm", suffix=".webm", remarks=unplaced, shows=True, refuse=animated_model)
def write_webm(animation: Animation, out: BinaryIO) -> None:
    """A video of the character's 3D model speaking, with the sound (VP9 and Opus)."""
    from lipsync_lang.render.video import film

    film(animation, out, "webm")


@binary_writer("png", suffix=".png", remarks=unplaced, refuse=animated_model)
def write_png(animation: Animation, out: BinaryIO) -> None:
    """A sheet of stills of the character's 3D model: its most different moments."""
    from lipsync_lang.render.sheet import sheet

    sheet(animation, out)
