"""Switch data for Moho; OpenToonz and Papagayo use the same format.

The first line is `MohoSwitch1`. Each other line is a frame number, counted from 1, and the name of
the drawing from that frame on. The last line shows the neutral face at the end of the sound. The
file does not store the frame rate: it is 24 a second, as in those programs, unless somebody asks
for another. Based on the exporters of Rhubarb Lip Sync (github.com/DanielSWolf/rhubarb-lip-sync)
and Papagayo (github.com/morevnaproject-org/papagayo-ng).
"""

from collections.abc import Iterator
from typing import TextIO

from lipsync_lang.animations.held import NEUTRAL_DRAWING, held
from lipsync_lang.animations.rates import USUAL_FPS
from lipsync_lang.animations.writers import Animation, writer

SWITCH_FPS = 24.0
"""Default frame rate of the programs that read the format."""


def unstated_rate(animation: Animation) -> Iterator[str]:
    """Yield a remark on the rate of a file, if nobody has asked for it."""
    if _stated_rate(animation) is None:
        yield (
            f"switch data counts {SWITCH_FPS:g} frames a second; if your project in Moho has "
            "another rate, state that (`fps=30`)"
        )


@writer("moho", suffix=".dat", remarks=unstated_rate)
def write_moho(animation: Animation, out: TextIO) -> None:
    """Switch data for Moho and OpenToonz: the frame at which each drawing is shown."""
    rate = _stated_rate(animation) or SWITCH_FPS
    shapes = held(animation)
    drawings = {1 + round(shape.start * rate): shape.name for shape in shapes}
    # The last drawing stays for one frame at least, even if the sound ends with it.
    last = max(1 + round(shapes[-1].end * rate), max(drawings) + 1)
    drawings[last] = animation.neutral or NEUTRAL_DRAWING
    out.write("MohoSwitch1\n")
    out.writelines(f"{frame} {' '.join(name.split())}\n" for frame, name in drawings.items())


def _stated_rate(animation: Animation) -> float | None:
    """Return the rate that somebody has asked for; None for the usual one, asked for by nobody."""
    usual = animation.fps == USUAL_FPS
    return animation.export.frame_rate or (None if usual else animation.fps)
