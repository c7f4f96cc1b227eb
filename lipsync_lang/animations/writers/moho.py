"""Switch data for Moho; OpenToonz and Papagayo use the same format.

The first line is `MohoSwitch1`. Each other line is a frame number, counted from 1, and the name of
the drawing from that frame on. The last line shows the neutral face at the end of the sound. The
file does not store the frame rate, so the Moho project must use the rate of the animation. Based on
the exporters of Rhubarb Lip Sync (github.com/DanielSWolf/rhubarb-lip-sync) and Papagayo
(github.com/morevnaproject-org/papagayo-ng).
"""

from typing import TextIO

from lipsync_lang.animations.held import NEUTRAL_DRAWING, held
from lipsync_lang.animations.writers import Animation, writer


@writer("moho", suffix=".dat")
def write_moho(animation: Animation, out: TextIO) -> None:
    """Switch data for Moho and OpenToonz: the frame at which each drawing is shown."""
    shapes = held(animation)
    drawings = {1 + round(shape.start * animation.fps): shape.name for shape in shapes}
    # The last drawing stays for one frame at least, even if the sound ends with it.
    last = max(1 + round(shapes[-1].end * animation.fps), max(drawings) + 1)
    drawings[last] = animation.neutral or NEUTRAL_DRAWING
    out.write("MohoSwitch1\n")
    out.writelines(f"{frame} {' '.join(name.split())}\n" for frame, name in drawings.items())
