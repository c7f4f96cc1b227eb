"""Live Link Face, the capture app of Unreal Engine: what its importers take for a recorded face.

A row per frame, and the columns of the app's own recordings in their order: a timecode
`HH:MM:SS:FF.mmm`, whose last part is thousandths of a frame; how many values follow; the 52 shapes
of ARKit; turns of the head and the eyes. Weights are clipped to 0 to 1. A timecode counts whole
frames, so at 23.976 frames a second its seconds are 1.001 s long.
"""

from collections.abc import Iterator
from typing import TextIO

from lipsync_lang.animations.animation import Animation
from lipsync_lang.animations.animation_writers import writer
from lipsync_lang.animations.fixed import doubts, laid_out, names
from lipsync_lang.animations.rates import timecode

PROGRAM = "Live Link Face"
HELD = "live-link-face.txt"
THOUSAND = 1000


def remarks(animation: Animation) -> Iterator[str]:
    """Yield, in words, what the file does not hold, and when the sound begins."""
    return doubts(animation, names(HELD), PROGRAM)


@writer("live-link-face", suffix=".live-link.csv", remarks=remarks)
def write_live_link_face(animation: Animation, out: TextIO) -> None:
    """A take of Live Link Face: a timecode and 61 values per frame."""
    held = names(HELD)
    table = laid_out(animation, held, PROGRAM)
    columns = [*held.shapes, *held.turns]
    out.write(",".join(["Timecode", "BlendShapeCount", *columns]) + "\n")
    row = ",".join(["%s", str(len(columns)), *["%.6f"] * len(columns)]) + "\n"
    for time, weights in zip(animation.timeline.tolist(), table.tolist(), strict=True):
        frame, part = divmod(round(time * animation.fps * THOUSAND), THOUSAND)
        out.write(row % (f"{timecode(frame, animation.fps)}.{part:03d}", *weights))
