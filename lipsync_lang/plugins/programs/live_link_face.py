"""CSV recordings of Live Link Face, the face capture app for Unreal Engine.

One row per frame, in the column order of the app: a timecode `HH:MM:SS:FF.mmm` with thousandths of
a frame, the number of values, the 52 ARKit shapes, and the rotations of head and eyes in radians,
of which those of the head follow gestures. Weights are clipped to 0 to 1. Timecode counts whole
frames, so one timecode second at 23.976 fps lasts 1.001 s.
"""

from functools import partial
from pathlib import Path
from typing import TextIO

from lipsync_lang.animations.fixed import FixedColumns, doubts, names
from lipsync_lang.animations.rates import timecode
from lipsync_lang.animations.writers import Animation, writer

LIVE_LINK_FACE = "Live Link Face"
LIVE_LINK_NAMES = Path(__file__).with_name("live-link-face-names.txt")
THOUSAND = 1000


@writer(
    "live-link-face",
    suffix=".live-link.csv",
    remarks=partial(doubts, file=LIVE_LINK_NAMES, program=LIVE_LINK_FACE),
    refuse=lambda one: FixedColumns(one.columns, names(LIVE_LINK_NAMES), LIVE_LINK_FACE),
)
def write_live_link_face(animation: Animation, out: TextIO) -> None:
    """A take of Live Link Face: a timecode and 61 values per frame."""
    held = names(LIVE_LINK_NAMES)
    table = FixedColumns(animation.columns, held, LIVE_LINK_FACE)(animation.weights)
    columns = [*held.shapes, *held.turns]
    out.write(",".join(["Timecode", "BlendShapeCount", *columns]) + "\n")
    row = ",".join(["%s", str(len(columns)), *["%.6f"] * len(columns)]) + "\n"
    for time, weights in zip(animation.timeline.tolist(), table.tolist(), strict=True):
        # Rounded as a whole: the thousandths alone could be rounded up to 1000.
        frame, part = divmod(round(time * animation.fps * THOUSAND), THOUSAND)
        out.write(row % (f"{timecode(frame, animation.fps)}.{part:03d}", *weights))
