"""Switch data of Moho, which OpenToonz reads as lip sync data and Papagayo writes too.

The first line is `MohoSwitch1`; each other is a number of a frame, from 1, and the name of the
drawing that is shown from there on. The last line shows the face at rest, at the end of the sound.
The file does not say how many frames a second has: they are the animation's, and the project in
Moho must have as many. After the exporters of Rhubarb Lip Sync (github.com/DanielSWolf/
rhubarb-lip-sync) and Papagayo (github.com/morevnaproject-org/papagayo-ng).
"""

from typing import TextIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import writer
from lipsync_lang.animations.held import held

REST = "rest"
"""What the face at rest is called where its character has no name for it."""


@writer("moho", suffix=".dat")
def write_moho(animation: Animation, out: TextIO) -> None:
    """Switch data for Moho and OpenToonz: the frame at which each drawing is shown."""
    shapes = held(animation, REST)
    drawings = {1 + round(shape.start * animation.fps): shape.name for shape in shapes}
    last = max(1 + round(shapes[-1].end * animation.fps), max(drawings) + 1)
    drawings[last] = animation.neutral or REST
    out.write("MohoSwitch1\n")
    out.writelines(f"{frame} {' '.join(name.split())}\n" for frame, name in drawings.items())
