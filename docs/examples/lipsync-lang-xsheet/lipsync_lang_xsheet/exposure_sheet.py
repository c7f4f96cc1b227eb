"""A writer: the drawing of the mouth to show from each frame on."""

from typing import TextIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import writer
from lipsync_lang.animations.held import held


@writer("exposure-sheet", suffix=".xsheet")
def write_exposure_sheet(animation: Animation, out: TextIO) -> None:
    """Exposure sheets of drawn animation: a frame and the mouth it shows."""
    out.write(f"xsheet {animation.fps:g}\n")
    rows = [
        (1 + round(shape.start * animation.fps), shape.name) for shape in held(animation, "rest")
    ]
    out.writelines(f"{frame}\t{name}\n" for frame, name in rows)
